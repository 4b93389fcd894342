"""face, alignment, frontal image → Assessment."""
