"""image → image, and frames → one image."""
