"""The `ggo` command."""

from ggo_factors.cli.ggo import main

__all__ = ["main"]
