"""What a page shows: one source, one recogniser, and everybody who looks on."""
