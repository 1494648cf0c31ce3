"""What type checkers are told of classes that take lists and arrays, and make tuples of them.

`make lint` runs mypy and pyright over `tests/typed/`.
"""

from __future__ import annotations

import ast
import inspect
import runpy
from dataclasses import MISSING, fields
from pathlib import Path

import pytest

import ggo_factors as ggo

SCRIPT = Path(__file__).parent / "typed" / "user_script.py"
TOLD = [ggo.Gait, ggo.Walk, ggo.Step, ggo.Ground, ggo.JointMap]


@pytest.mark.parametrize("made", TOLD)
def test_type_checkers_are_told_of_every_field(made):
    (tree,) = ast.parse(inspect.getsource(made)).body
    (told,) = [
        node
        for block in tree.body
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in block.body
    ]
    assert told.name == "__init__"
    own = [field for field in fields(made) if field.init]
    names = [argument.arg for argument in told.args.args[1:]]
    assert names == [field.name for field in own if not field.kw_only]
    required = [field.name for field in own if field.default is MISSING and field.default_factory is MISSING]
    assert names[: len(names) - len(told.args.defaults)] == required
    for field, default in zip(own[len(required) :], told.args.defaults, strict=True):
        if field.default is not MISSING and isinstance(default, ast.Constant):
            assert ast.literal_eval(default) == field.default


def test_what_users_write_runs(capsys):
    made = runpy.run_path(str(SCRIPT))
    assert made["one"].ok
    assert made["two"].ok
    assert made["three"].task.step.foothold == (0.44, 0.0)
    assert made["walk"].plan[0].obstacles == tuple(made["boxes"])
    assert made["ground"].heights == (0.0, 0.1)
    assert made["again"].notes == ("put together by hand",)
    assert made["joints"].order[0] == "beta_right"
    assert made["stand"].end_frame == (0.0, 0.0, 0.0, 0.0)
    assert "StepSolution" in capsys.readouterr().out
