"""The last chapter of the tutorial, `tools/pgo_landing.py`: what it claims, held against its numbers."""

from __future__ import annotations

import numpy as np
import pgo_landing as tool
import pytest
from click.testing import CliRunner
from matplotlib.figure import Figure


@pytest.fixture(scope="module")
def numbers() -> dict[str, float]:
    return tool.run(Figure(figsize=(11.0, 4.8)))


def test_one_fix_brings_the_pose_graph_home(numbers):
    assert numbers["end_alone"] > 1.0
    assert numbers["end_fixed"] < 0.005
    assert numbers["mean_fixed"] < numbers["mean_alone"] / 4.0


def test_without_landing_edges_a_bend_is_carried_on(numbers):
    bent = [numbers[f"bent_{k}"] for k in range(1, tool.STEPS + 1)]
    np.testing.assert_allclose(bent, np.degrees(tool.BENT).mean(), atol=0.2)


def test_with_landing_edges_it_is_gone_within_a_step(numbers):
    assert numbers["home_1"] < 1.0
    for k in range(2, tool.STEPS + 1):
        assert numbers[f"home_{k}"] == pytest.approx(numbers["posture"], abs=0.1)
    assert numbers["missed"] < 1e-3


def test_the_first_step_is_the_closed_form_of_a_chain_with_springs_at_its_end():
    """Where the foothold leaves the last frame free, the chain, of gain 1/n, pulls as hard as the landing posture."""
    start, last = tool.BASE.frames[0] + tool.BENT, len(tool.BASE) - 1
    gait = tool.steps_from(start, landing=True)[0]
    foothold = tool.BASE.legs(None).endpoint_jacobian(gait[-1])
    free = np.linalg.svd(foothold)[2][2:]
    # The last motion's edge is beside the chain's own last one: together of gain 1 + g, in a row with the others.
    chain = 1.0 / (last - 1 + 1.0 / (1.0 + tool.MOTION_GAIN * last))
    back = tool.POSTURE_GAIN / last * (gait[-1] - tool.touchdown())
    away = chain * (gait[-1] - tool.BASE.frames[-1] - tool.BENT)
    assert np.abs(free @ back).max() > 1e-3
    np.testing.assert_allclose(free @ back, -free @ away, atol=1e-6)


def test_it_prints_its_tables_and_saves_one_figure(tmp_path):
    ran = CliRunner().invoke(tool.main, ["--out", str(tmp_path / "new")])
    assert ran.exit_code == 0, ran.output
    assert "(h) " in ran.output
    assert "gait graph" in ran.output
    assert [path.name for path in (tmp_path / "new").iterdir()] == ["pgo_landing.png"]
