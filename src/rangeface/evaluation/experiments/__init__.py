"""one file a question."""
