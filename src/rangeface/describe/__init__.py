"""frontal image → feature image or vector."""
