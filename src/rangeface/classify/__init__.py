"""what learns: feature vectors → scores."""
