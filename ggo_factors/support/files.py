"""Files written whole or not at all, and text files whose errors name the file."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from ggo_factors.errors import InputError

PathLike = str | os.PathLike[str]


@contextmanager
def replacing(path: PathLike) -> Iterator[Path]:
    """Hand out a temporary path beside `path`, renamed to it when the block ends without an error.

    Raises:
        InputError: where the folder is missing or not writable, or the disk is full.
    """
    target = _checked(path)
    try:
        handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.stem}-", suffix=target.suffix)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror}") from error
    os.close(handle)
    temporary = Path(name)
    try:
        yield temporary
        umask = os.umask(0)
        os.umask(umask)
        temporary.chmod(0o666 & ~umask)
        temporary.replace(target)
    except OSError as error:
        raise InputError(f"{target}: cannot be written: {error.strerror or error}") from error
    finally:
        temporary.unlink(missing_ok=True)


def write_text(path: PathLike, text: str) -> None:
    """Write `text` to `path`, whole or not at all.

    Raises:
        InputError: where the file cannot be written.
    """
    with replacing(path) as temporary:
        try:
            temporary.write_text(text, encoding="utf-8")
        except UnicodeEncodeError as error:
            raise InputError(f"{path}: cannot be written: {error}") from error


def read_text(path: PathLike) -> str:
    """The text of the file at `path`.

    Raises:
        InputError: where the file is missing, a folder, not readable, or not UTF-8 text.
    """
    try:
        return _checked(path).read_text(encoding="utf-8-sig")
    except OSError as error:
        raise InputError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise InputError(f"{path}: is not a text file (byte {error.start} is not UTF-8)") from error


def _checked(path: PathLike) -> Path:
    if not isinstance(path, (str, os.PathLike)) or not str(path) or "\0" in str(path):
        raise InputError(f"path: expected the name of a file, got {path!r:.80}")
    return Path(path)


def printable(text: str) -> str:
    """Text from a file with its control characters escaped, so that a terminal shows them and does not obey."""
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
