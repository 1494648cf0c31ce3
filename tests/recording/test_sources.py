"""The same walk through every source gives the same base gait."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from table_files import renamed, write_c3d, write_csv, write_mot
from test_cut_strides import walk
from test_import_base_gait import facts_of, map_of
from test_signals import MAP, NAMES

import ggo_factors as ggo
from ggo_factors.recording.log.read_log import read_log

RECORDINGS = [
    *("level_csic_s10", "level_opensim_rajagopal", "level_opensim_subject01"),
    *("level_wpi_s03_slow", "level_exo_march"),
]
LONG = "level_nonan_middle"
"""As long as the others together."""
EPOCH_NS = 1_790_000_000 * 10**9
TIMES, VALUES, _ = walk(6)


class Walk:
    """A walk as it was read: its times, values, names, the map and the unit of its values, and its base gait."""

    def __init__(self, times, values, names, joints, unit, gait):
        self.times, self.values, self.names, self.joints, self.unit = times, values, tuple(names), joints, unit
        self.gait = gait
        self.degrees = values if unit == "deg" else np.degrees(values)
        self.ns = np.rint(times * 1e9).astype(np.int64)

    def same(self, log, joints=None, **options):
        options = {} if joints is not None else {"unit": self.unit}
        gait = ggo.import_base_gait(log, joints=joints or self.joints, min_strides=1, **options).gait
        np.testing.assert_allclose(gait.frames, self.gait.frames, rtol=0.0, atol=1e-9)
        assert gait.dt == pytest.approx(self.gait.dt, abs=1e-9)


def made():
    gait = ggo.import_base_gait(ggo.JointLog(TIMES, VALUES, NAMES, "rad"), joints=MAP, min_strides=1).gait
    return Walk(TIMES, VALUES, NAMES, MAP, "rad", gait)


@pytest.fixture(scope="module", params=["made", *RECORDINGS, pytest.param(LONG, marks=pytest.mark.campaign)])
def walked(request):
    if request.param == "made":
        return made()
    recordings = request.getfixturevalue("recordings")
    facts = facts_of(recordings, request.param)
    path = recordings / f"{request.param}.mcap"
    joints = map_of(facts)
    log = read_log(path, names=joints.names)
    try:
        gait = ggo.import_base_gait(path, joints=joints, min_strides=1).gait
    except ggo.LogError as error:  # what one source refuses, all do
        with pytest.raises(ggo.LogError, match="running"):
            ggo.import_base_gait(ggo.JointLog(log.times, log.values, log.names), joints=joints, min_strides=1)
        pytest.skip(f"{request.param} is refused: {error}")
    return Walk(log.times, log.values, log.names, joints, facts["units"], gait)


def test_arrays(walked):
    walked.same(ggo.JointLog(walked.times, walked.values, walked.names))
    columns = dict(zip(walked.names, walked.values.T, strict=True))
    walked.same(ggo.JointLog(walked.times + 1234.5, columns))
    walked.same({"t": walked.times} | columns)
    walked.same({"time_ms": 1e3 * walked.times} | columns)


def test_data_frames(walked):
    frame = pd.DataFrame(walked.values, columns=walked.names)
    walked.same(frame.assign(time=walked.times, trial="slow"))
    walked.same(frame.set_index(pd.Index(walked.times, name="time")))
    walked.same(frame.set_index(pd.Index(walked.times + 7.0)))
    walked.same(frame.set_index(pd.Index(1000.0 * walked.times, name="time_ms")))
    walked.same(frame.assign(timestamp=pd.to_datetime(EPOCH_NS + walked.ns)))
    walked.same(frame.assign(time=pd.to_datetime(EPOCH_NS + walked.ns, utc=True)))
    for index in (
        pd.to_datetime(EPOCH_NS + walked.ns),
        pd.to_datetime(EPOCH_NS + walked.ns, utc=True),
        pd.to_timedelta(walked.ns),
    ):
        walked.same(frame.set_index(index))


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_csv(walked, tmp_path, separator):
    walked.same(write_csv(tmp_path / "walk.csv", walked.times, walked.values, walked.names, separator))


def test_csv_with_units_in_its_names_or_below_them(walked, tmp_path):
    names = [f"{name}_deg" for name in walked.names]
    path = write_csv(tmp_path / "walk.csv", walked.times, walked.degrees, names, time="time [s]")
    walked.same(path, renamed(walked.joints, lambda name: f"{name}_deg"))
    head, *rows = write_csv(path, walked.times, walked.degrees, walked.names).read_text().splitlines()
    path.write_text("\n".join([head, ",".join(["s"] + ["deg"] * len(names)), *rows]))
    walked.same(path, renamed(walked.joints, str))


@pytest.mark.parametrize(("per_second", "name"), [(1, "timestamp"), (1000, "time_ms"), (10**9, "timestamp_ns")])
def test_csv_by_another_clock(walked, tmp_path, per_second, name):
    """To the digit: a float holds a time since 1970 to 0.2 us only, in which a swinging knee turns by 2e-6 rad."""
    ticks = [EPOCH_NS + int(ns) for ns in walked.ns]
    unit_ns = 10**9 // per_second
    written = [f"{t // unit_ns}.{t % unit_ns * per_second:09d}" for t in ticks]
    rows = [",".join([t, *map(repr, row)]) for t, row in zip(written, walked.values.tolist(), strict=True)]
    path = tmp_path / "walk.csv"
    path.write_text("\n".join([",".join((name, *walked.names)), *rows]))
    walked.same(path)


@pytest.mark.parametrize("zone", ["", "Z", "+01:00"])
def test_csv_with_dates(walked, tmp_path, zone):
    dates = np.datetime_as_string((EPOCH_NS + walked.ns).astype("datetime64[ns]"))
    stamps = [f"{date}{zone}" for date in dates]
    rows = [",".join([t, *map(repr, row)]) for t, row in zip(stamps, walked.values.tolist(), strict=True)]
    path = tmp_path / "walk.csv"
    path.write_text("\n".join([",".join(("time", *walked.names)), *rows]))
    walked.same(path)


def test_opensim_motion_in_either_unit(walked, tmp_path):
    names, joints = walked.names, renamed(walked.joints, str)
    walked.same(write_mot(tmp_path / "walk.mot", walked.times, walked.degrees, names), joints)
    radians = np.radians(walked.degrees)
    walked.same(write_mot(tmp_path / "walk.sto", walked.times, radians, names, ("inDegrees=no",)), joints)
    # The file's own word comes before that of a map that was written for another form of it.
    walked.same(tmp_path / "walk.mot", ggo.JointMap(walked.joints.terms, "rad"))


def test_c3d(walked, tmp_path):
    """A C3D holds single precision, and one rate: it is held against the same numbers, rounded as it does."""
    ezc3d = pytest.importorskip("ezc3d")
    rate = round(1.0 / np.median(np.diff(walked.times)))
    rounded = walked.degrees.astype(np.float32).astype(np.float64)
    log = ggo.JointLog(np.arange(len(rounded)) / rate, rounded, walked.names, "deg")
    joints = renamed(walked.joints, str)
    gait = ggo.import_base_gait(log, joints=joints, min_strides=1).gait
    np.testing.assert_allclose(gait.frames, walked.gait.frames, rtol=0.0, atol=1e-5)
    path = write_c3d(ezc3d, tmp_path / "walk.c3d", rate, walked.degrees, [f"A:{name}Angles" for name in walked.names])
    Walk(log.times, rounded, walked.names, joints, "deg", gait).same(
        path, renamed(walked.joints, lambda name: f"{name}Angles")
    )


def test_convert_and_read_again(walked, tmp_path):
    output = tmp_path / "walk.mcap"
    names = renamed(walked.joints, str)
    sources = (
        write_csv(tmp_path / "walk.csv", walked.times + 5.0, walked.values, walked.names),
        write_mot(tmp_path / "walk.mot", walked.times, walked.degrees, walked.names),
        ggo.JointLog(walked.times, walked.values, walked.names, walked.unit),
    )
    for source in sources:
        written = ggo.convert_log(source, output, unit=walked.unit if source == sources[0] else None)
        walked.same(output, names)
        assert (written.unit, len(written.times)) == ("rad", len(walked.times))


def test_the_report_says_where_it_is_from(tmp_path):
    walked = made()
    report = ggo.import_base_gait(
        write_mot(tmp_path / "walk.mot", TIMES, walked.degrees, NAMES), joints=renamed(MAP, str), min_strides=1
    )
    assert report.source == str(tmp_path / "walk.mot")
    assert (report.unit, report.time_source, report.gait.name) == ("deg", "column time", "walk")
    assert report.encoding == "mot"
    assert report.messages_read == len(TIMES)
    assert "columns (mot)" in report.text()


def test_what_is_no_log():
    for wrong in (None, 7, [1.0, 2.0], object()):
        with pytest.raises(ggo.InputError, match="log: expected a path, a JointLog, a mapping"):
            ggo.import_base_gait(wrong, joints=MAP)
    with pytest.raises(ggo.LogError, match="columns and no topics: leave topic= out"):
        ggo.import_base_gait({"t": TIMES, "hip_r": VALUES[:, 0]}, topic="/joints", joints=MAP)
