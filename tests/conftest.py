"""What several test files share."""

from __future__ import annotations

import gc
import os
from pathlib import Path

import pytest
from hypothesis import settings

# Workers share the cores already: with more threads each, small products of matrices wait for one another, ten times as
# long where all cores are taken. Set before NumPy is loaded; programs that the tests start inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# Machines are shared: how long an example takes says nothing, and a failure must come back.
settings.register_profile("ggo", deadline=None, derandomize=True)
settings.load_profile("ggo")


def pytest_collection_finish() -> None:
    """What is imported and collected by now stays: the garbage collector need not look at it again and again."""
    gc.collect()
    gc.freeze()


@pytest.fixture(scope="session")
def recordings() -> Path:
    """Folder of the real and synthetic logs, which are not part of the project."""
    folder = os.environ.get("GGO_RECORDINGS", "")
    if not folder:
        pytest.skip("GGO_RECORDINGS does not name the folder with the recordings")
    if not Path(folder).is_dir():
        pytest.skip(f"GGO_RECORDINGS: {folder} is not a folder")
    return Path(folder)


@pytest.fixture(autouse=True)
def _no_deadline(monkeypatch: pytest.MonkeyPatch) -> None:
    """A replan that names no deadline gets a long one: machines are shared, answers must not depend on their load."""
    monkeypatch.setattr("ggo_factors.procedures.replan.DEADLINE", 60.0)
