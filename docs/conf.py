"""How Sphinx builds these pages: Markdown by MyST, the reference from docstrings, notebooks and examples run anew."""

from __future__ import annotations

import shutil
import subprocess
import sys
from importlib.metadata import version as installed
from pathlib import Path

from sphinx.application import Sphinx

HERE = Path(__file__).parent
MADE = HERE / "_made"
"""What is made before the pages are read: pictures and output of the examples, copies of the notebooks."""

project = "ggo_factors"
author = "the ggo_factors authors"
release = version = installed("ggo-factors")
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_build", "_made/examples", ".jupyter_cache"]
html_theme = "furo"
html_title = f"ggo_factors {release}"
html_copy_source = False

myst_enable_extensions = ["colon_fence", "dollarmath"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 120
nb_merge_streams = True

# A single backtick in a docstring is a name of the library where there is one, else plain code.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Array", "PathLike")}
autodoc_preserve_defaults = True
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88


def make(app: Sphinx) -> None:
    """Run the examples in a folder of the pages, keep what they print, and fetch the notebooks."""
    shutil.rmtree(MADE, ignore_errors=True)
    shutil.copytree(HERE.parent / "notebooks", MADE / "notebooks")
    folder = MADE / "examples"
    folder.mkdir()
    for script in sorted((HERE.parent / "examples").glob("*.py")):
        done = subprocess.run([sys.executable, script], cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{script.name}:\n{done.stderr}")
        (folder / f"{script.stem}.txt").write_text(done.stdout.replace(f"{HERE.parent}/", ""), encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Hook `make` in before the pages are read."""
    app.connect("builder-inited", make)
