"""What sources need: packages that only some do, and a file that is there."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any

from ggo_factors.errors import LogError
from ggo_factors.support.files import PathLike


def needed(module: str, extra: str, path: PathLike, what: str) -> Any:
    """A module of an optional package.

    Args:
        module: its name.
        extra: the extra of this library that brings it.
        path: the file that needs it.
        what: what that file is, in words.

    Raises:
        LogError: with the command that installs it, where it is missing.
    """
    try:
        return import_module(module)
    except ImportError as error:
        raise LogError(f"{path}: {what} needs the extra {extra}: pip install 'ggo-factors[{extra}]'") from error


def require_content(path: PathLike) -> None:
    """Refuse a file that is missing or empty; other packages say it in many words, or none.

    Raises:
        LogError: where it is.
    """
    try:
        if not Path(path).stat().st_size:
            raise LogError(f"{path}: the file is empty")
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error
