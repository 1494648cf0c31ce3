"""Sample data from a source folder and from a wheel, one place of the files; what a wheel says of itself."""

from __future__ import annotations

import email
import subprocess
import sys
import tomllib
import zipfile
from pathlib import Path

import numpy as np
import pytest
import yaml

import ggo_factors as ggo

ROOT = Path(__file__).parents[1]
FILES = ("children_walk.mcap", "children_walk.toml", "course.toml", "paper_base_gait.csv")
NAMES = ("children_walk", "children_walk_joints", "course", "paper_base_gait")
PATHS = f"[getattr(ggo.datasets, name)() for name in {NAMES}]"


def test_the_files_of_the_source_are_in_its_folder():
    found = tuple(getattr(ggo.datasets, name)() for name in NAMES)
    assert found == tuple(ROOT / "datasets" / name for name in FILES)
    assert all(path.is_file() for path in found)


def test_they_can_be_used():
    assert len(ggo.load_gait(ggo.datasets.paper_base_gait())) == 51
    found = ggo.import_base_gait(ggo.datasets.children_walk(), joints=ggo.datasets.children_walk_joints())
    assert found.strides_used["right"] == 24


def test_the_course_has_what_it_says_and_is_walked_from_standing_to_standing():
    course = ggo.load_terrain(ggo.datasets.course())
    assert str(course) == "Terrain('course', 7 m, 4 risers, 1 ramp, 1 box, 1 pit)"
    plan = ggo.plan_walk(ggo.paper_base_gait(), course, goal=6.6, start=ggo.STANDING, to_standing=True)
    assert all(report.ok for report in plan.walk.verify())
    np.testing.assert_allclose(plan.walk.gaits[0].frames[0], ggo.STANDING)
    np.testing.assert_allclose(plan.walk.gaits[-1].frames[-1], ggo.STANDING, atol=1e-9)
    assert plan.footholds[-2:] == (6.6, 6.6)


def test_an_unknown_name_is_told_those_that_there_are():
    with pytest.raises(ggo.InputError, match=r"no sample file 'README.md'; there are .*children_walk\.mcap"):
        ggo.datasets.path("README.md")


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    build = f"import hatchling.build; print(hatchling.build.build_wheel({str(folder)!r}))"
    done = subprocess.run([sys.executable, "-c", build], cwd=ROOT, capture_output=True, text=True, check=True)
    return folder / done.stdout.split()[-1]


def test_the_version_is_in_one_place_and_the_metadata_complete(wheel):
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    with zipfile.ZipFile(wheel) as content:
        (name,) = [name for name in content.namelist() if name.endswith(".dist-info/METADATA")]
        told = email.message_from_bytes(content.read(name))
    assert told["Version"] == project["version"]
    assert wheel.name == f"ggo_factors-{project['version']}-py3-none-any.whl"
    assert told.get_all("Project-URL") == [f"{key}, {url}" for key, url in project["urls"].items()]
    assert {"Summary", "License-Expression", "Keywords", "Author", "Requires-Python"} <= set(told.keys())
    for elsewhere in ("CITATION.cff", "README.md", "ggo_factors/__init__.py"):
        assert project["version"] not in (ROOT / elsewhere).read_text(), elsewhere


def test_the_citation_is_yaml_with_what_the_format_asks_for():
    said = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert {"cff-version", "message", "title", "authors"} <= said.keys()
    assert said["preferred-citation"]["year"] == 2020
    assert said["url"] in tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["urls"].values()


def test_a_wheel_has_each_file_once_and_finds_it(wheel, tmp_path):
    place = tmp_path / "installed"
    with zipfile.ZipFile(wheel) as content:
        names = content.namelist()
        content.extractall(place)
    for item in (ROOT / "datasets").iterdir():
        assert names.count(f"ggo_factors/datasets/{item.name}") == 1
        assert (place / "ggo_factors" / "datasets" / item.name).read_bytes() == item.read_bytes()
    # Another package of the same name stands beside the library in many environments.
    (place / "datasets").mkdir()
    (place / "datasets" / "README.md").write_text("not ours")
    code = f"import sys; sys.path.insert(0, {str(place)!r}); import ggo_factors as ggo; print(*{PATHS}, sep='\\n')"
    done = subprocess.run([sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout.split() == [str(place / "ggo_factors" / "datasets" / name) for name in FILES]


def test_plots_need_no_import_of_their_own_and_matplotlib_only_when_used():
    code = (
        "import sys, ggo_factors as ggo; before = 'matplotlib' in sys.modules; "
        "print(before, callable(ggo.plot.plot_joint_angles), 'matplotlib' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["False", "True", "True"]
