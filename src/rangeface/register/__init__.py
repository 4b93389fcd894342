"""Face → Alignment."""
