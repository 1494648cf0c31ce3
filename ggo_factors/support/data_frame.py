"""The one way to pandas, which only those need who ask for a data frame."""

from __future__ import annotations

from typing import Any


def pandas() -> Any:
    """The module.

    Raises:
        ImportError: with the command that installs it, where it is missing.
    """
    try:
        import pandas as pd
    except ImportError as error:
        raise ImportError("to_dataframe: needs pandas: pip install 'ggo-factors[pandas]'") from error
    return pd
