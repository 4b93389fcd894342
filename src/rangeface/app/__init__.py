"""what a person runs."""
