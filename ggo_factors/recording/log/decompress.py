"""Decompress one chunk, never more of it than it may hold."""

from __future__ import annotations

import math
from typing import Any

CHUNK_MIB = 64
"""Largest chunk in [MiB] that is read unless more is asked for; writers use 0.75 to 4 MiB."""
CHUNK_LIMIT = CHUNK_MIB * 2**20
"""The same in [byte]."""
_PEEK = 2**16
"""Bytes unpacked first, to see that a chunk which compresses unusually well begins with a record."""
_LARGE, _RATIO = 8 * 2**20, 200
"""A chunk of more bytes that is compressed to less than 1/200 is refused: time stamps do not compress so well."""


class UnpackError(Exception):
    """A chunk cannot be unpacked; the text says why."""


def unpack(data: bytes, compression: str, size: int, limit: int = CHUNK_LIMIT) -> bytes:
    """The records of a chunk.

    Args:
        data: the chunk as it lies in the file.
        compression: "", "lz4" or "zstd".
        size: what the chunk claims to hold, in [byte].
        limit: the most that is unpacked, in [byte].

    Raises:
        UnpackError: where the claim is over the limit or not kept, the data are damaged, or do not begin with a record.
    """
    if size > limit:
        raise UnpackError(f"claims {over(size, limit)}")
    if compression not in ("", "lz4", "zstd"):
        raise UnpackError(f"is compressed with {compression!r}, which this reader does not know (zstd, lz4, none)")
    if compression and size > _LARGE and size > _RATIO * len(data) and limit <= CHUNK_LIMIT:  # not where asked for
        raise UnpackError(f"would unpack {len(data)} bytes to {size / 2**20:.0f} MiB: no log compresses like that")
    if compression and size > 16 * len(data) + 2**20:
        # far more than logs compress: look at the beginning before giving it memory
        _check_start(_decompress(data, compression, _PEEK, whole=False), compression, size, len(data))
    out = data if not compression else _decompress(data, compression, size, whole=True)
    if len(out) != size:
        raise UnpackError(f"holds {len(out)} bytes unpacked and claims {size}")
    return out


def over(size: int, limit: int) -> str:
    """That a chunk of `size` [byte] is over the limit, and what to give to read it."""
    whole = math.ceil(size / 2**20)
    return f"{whole} MiB unpacked (limit {limit / 2**20:.0f} MiB; largest_chunk={whole})"


def _decompress(data: bytes, compression: str, size: int, whole: bool) -> bytes:
    decoder: Any
    try:
        if compression == "zstd":
            import zstandard

            claim = zstandard.frame_content_size(data)
            if whole and claim not in (-1, size):
                raise UnpackError(f"claims {size} bytes unpacked, its zstd frame {claim}")
            decoder = zstandard.ZstdDecompressor(max_window_size=2**27)
            if whole:
                return bytes(decoder.decompress(data, max_output_size=size))
            with decoder.stream_reader(data) as stream:
                return bytes(stream.read(size))
        import lz4.frame  # type: ignore[import-untyped]

        decoder = lz4.frame.LZ4FrameDecompressor()
        return bytes(decoder.decompress(data, max_length=size))
    except UnpackError:
        raise
    except Exception as error:  # the codecs raise what they like: ZstdError, RuntimeError, MemoryError, EOFError
        raise UnpackError(f"cannot be unpacked ({compression}: {error})") from error


def _check_start(start: bytes, compression: str, size: int, packed: int) -> None:
    if len(start) < 9 or start[0] not in (3, 4, 5) or int.from_bytes(start[1:9], "little") > size:
        raise UnpackError(
            f"does not begin with a record, and {packed} bytes of {compression} would unpack to {size / 2**20:.0f} MiB"
        )
