"""Campaign: walks planned on what a camera saw, walked on the true ground and on ten thousand drawn for each step."""

from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
from seen_walks import hit_share, seen_walk

from ggo_factors import Tolerances

pytestmark = pytest.mark.campaign

SCENES = 40


def test_walks_on_the_true_ground():
    with ProcessPoolExecutor() as pool:
        walks = list(pool.map(seen_walk, range(SCENES)))
    made = [walk for walk in walks if walk.steps]
    edges = [edge.off / edge.std for walk in walks for edge in walk.judged.edges if edge.off is not None]
    heights = [off / std for walk in walks for off, std in walk.judged.heights]
    rng = np.random.default_rng(0)
    drawn = [
        (hit_share(path, boxes, np.array(edges), np.array(heights), rng), stated)
        for walk in made
        for path, boxes, stated in walk.near
    ]
    often, stated = np.array(drawn).T
    steps = sum(walk.steps for walk in made)
    print(
        f"{len(made)} of {SCENES} walked, {steps} steps, {len(drawn)} of them by uncertain boxes or risers: hit in "
        f"{often.mean():.2e} of 10,000 draws each, at most {often.max():.2e}; stated {stated.mean():.1e} in the mean, "
        f"at most {stated.max():.1e}; edges {np.std(edges):.2f}, heights {np.std(heights):.2f} standard deviations"
    )
    assert len(made) >= 0.8 * SCENES
    assert len(drawn) > 30
    assert not [walk.unseen for walk in made if walk.unseen]
    assert not [walk.struck for walk in made if walk.struck]
    # What is drawn far beyond what is stated does hit.
    path, boxes, _ = next(near for walk in made for near in walk.near)
    assert hit_share(path, boxes, np.array([-20.0, 20.0]), np.array([-20.0, 20.0]), rng) > 0.1
    assert often.mean() <= Tolerances().hit_probability
