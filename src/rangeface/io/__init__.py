"""one file per format."""
