"""image → faces."""
