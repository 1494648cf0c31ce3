"""What `import ggo_factors` brings, and what it must not."""

import subprocess
import sys

import pytest

import ggo_factors as ggo


def test_import_takes_no_matplotlib_and_no_mcap_with_it():
    code = (
        "import sys, ggo_factors; print([m for m in ('matplotlib', 'mcap', 'mcap_ros2', 'click') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_every_public_name_is_there():
    for name in ggo.__all__:
        assert getattr(ggo, name) is not None
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = ggo.nothing


def test_a_listing_shows_the_public_names_and_nothing_else():
    code = (
        "import ggo_factors as ggo, ggo_factors.plot, ggo_factors.recording.base_gait; "
        "assert ggo.motion and ggo.plot; print(dir(ggo) == sorted(ggo.__all__))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "True"
