"""Speed and memory, each peer in the same run: `make bench`."""
