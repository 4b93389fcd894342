"""A process of its own for decoders that are not ours: packed bytes in, expanded bytes out.

Run as a script, ``_worker.py (zstd | lz4) SIZE``. Exit status 3: the decoder is not installed.
"""

from __future__ import annotations

import sys

_MEMORY = 384 << 20


def _limit_memory(size: int) -> None:
    try:
        import resource
    except ImportError:  # no such limit on this system; the size is capped all the same
        return
    resource.setrlimit(resource.RLIMIT_AS, (_MEMORY + 2 * size,) * 2)


def _expand(packing: str, packed: bytes, size: int) -> bytes:
    if packing == "zstd":
        import zstandard

        reader = zstandard.ZstdDecompressor(max_window_size=1 << 27).stream_reader(packed)
        return bytes(reader.read(size + 1))
    if packing == "lz4":
        import lz4.frame

        return bytes(lz4.frame.LZ4FrameDecompressor().decompress(packed, max_length=size + 1))
    raise ImportError(packing)


def main() -> int:
    """Expand standard input to standard output."""
    packing, size = sys.argv[1], int(sys.argv[2])
    _limit_memory(size)
    try:
        sys.stdout.buffer.write(_expand(packing, sys.stdin.buffer.read(), size))
    except ImportError:
        return 3
    except Exception:  # whatever a foreign decoder raises means: not readable
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
