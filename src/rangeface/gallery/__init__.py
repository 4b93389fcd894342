"""enrolled templates behind one protocol."""
