"""A `JointLog`, a mapping and a data frame made by hand: what is refused, naming row and column."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from test_cut_strides import walk
from test_signals import MAP, NAMES

import ggo_factors as ggo

TIMES, VALUES, _ = walk(6)
COLUMNS = dict(zip(NAMES, VALUES.T, strict=True))


def test_times_values_and_names_are_kept():
    log = ggo.JointLog(TIMES, COLUMNS, unit="rad", source="our lab")
    assert log.names == NAMES
    assert np.array_equal(log.values, VALUES)
    assert not log.values.flags.writeable
    assert log.segments == ((0, len(TIMES)),)
    assert ggo.import_base_gait(log, joints=MAP).source == "our lab"


BACK = TIMES.copy()
BACK[57] = BACK[55]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((BACK, COLUMNS), r"JointLog, row 58: time 0.55 s is not after 0.56 s of row 57"),
        ((np.where(np.arange(len(TIMES)) == 3, np.nan, TIMES), COLUMNS), r"times: value nan at \[3\] is not finite"),
        ((TIMES[1:], COLUMNS), r"expected shape \(\d+, 4\) for \d+ times and 4 names"),
        ((TIMES, COLUMNS | {"hip_r": VALUES[1:, 0]}), "columns of different lengths"),
        ((TIMES, COLUMNS | {"hip_r": "degrees"}), "hip_r: expected numbers"),
        ((TIMES, COLUMNS | {"hip_r": VALUES}), r"hip_r: expected numbers of shape \(n,\), got shape"),
        ((TIMES, COLUMNS, NAMES), "names: leave them out"),
        ((TIMES, VALUES), "names: expected a text for each value"),
        ((TIMES, VALUES, ("a", "b", "c", "a")), "two columns are named 'a'"),
        ((TIMES, "x", NAMES), "values: expected numbers, got 'x'"),
        ((TIMES, COLUMNS, (), "gon"), "unit: expected 'rad' or 'deg', got 'gon'"),
    ],
)
def test_what_cannot_be_a_log(arguments, words):
    with pytest.raises(ggo.InputError, match=words):
        ggo.JointLog(*arguments)


@pytest.mark.parametrize(
    ("log", "words"),
    [
        (COLUMNS, "mapping: no time column .*there are hip_r, knee_r"),
        (COLUMNS | {"t": BACK}, "mapping, row 58: time 0.55 s is not after 0.56 s of row 57"),
        (COLUMNS | {"t": TIMES[1:]}, "mapping: columns of different lengths"),
        (COLUMNS | {"t": 1e3 * TIMES}, r"t rises by 10 a row, in seconds 0.1 Hz .*time_ms"),
        ({"t": TIMES}, "mapping: no column but column t"),
        ({"t": TIMES, 3: TIMES}, "expected columns named by texts, got 3"),
        ({name: column[:1] for name, column in (COLUMNS | {"t": TIMES}).items()}, "1 rows; a walk has hundreds"),
        (pd.DataFrame(COLUMNS), "DataFrame: no time column"),
        (pd.DataFrame(COLUMNS | {"time": BACK}), "DataFrame, row 57: time 0.55 s is not after 0.56 s of row 56"),
        (pd.DataFrame(np.column_stack([TIMES, TIMES, VALUES]), columns=["t", "a", "a", *NAMES[1:]]), "two .*'a'"),
        (pd.DataFrame(COLUMNS | {"time": TIMES}).assign(hip_r="bent"), "no value named 'hip_r'"),
    ],
)
def test_what_cannot_be_read(log, words):
    with pytest.raises(ggo.GgoError, match=words) as caught:
        ggo.import_base_gait(log, joints=MAP, unit="rad")
    assert len(str(caught.value)) < 300


def test_gaps_are_missing_values_also_in_nullable_columns():
    values = VALUES.copy()
    values[100:105, 1] = np.nan
    frame = pd.DataFrame(values, columns=NAMES).convert_dtypes().assign(time=TIMES)
    assert frame["knee_r"].isna().sum() == 5
    report = ggo.import_base_gait(frame, joints=MAP, unit="rad")
    assert any("knee_r: 5 of" in note and "missing" in note for note in report.notes)
    want = ggo.import_base_gait(ggo.JointLog(TIMES, values, NAMES, "rad"), joints=MAP)
    assert np.array_equal(report.gait.frames, want.gait.frames)


def test_values_with_units_of_their_own_are_brought_together():
    degrees = {f"{name}_deg": np.degrees(COLUMNS[name]) for name in NAMES[:2]}
    log = {"t": TIMES} | degrees | {name: COLUMNS[name] for name in NAMES[2:]}
    names = [*degrees, *NAMES[2:]]
    joints = ggo.JointMap({angle: {name: 1.0} for angle, name in zip(MAP.terms, names, strict=True)})
    with pytest.raises(ggo.LogError, match="hip_l, knee_l states no unit, hip_r_deg does; give unit="):
        ggo.import_base_gait(log, joints=joints)
    report = ggo.import_base_gait(log, joints=joints, unit="rad")
    assert any("brought to radians" in note for note in report.notes)
    want = ggo.import_base_gait({"t": TIMES} | COLUMNS, joints=MAP, unit="rad").gait
    np.testing.assert_allclose(report.gait.frames, want.frames, rtol=0.0, atol=1e-12)


def test_degrees_that_are_said_to_be_radians_are_refused():
    log = {"t": TIMES} | {f"{name}_rad": np.degrees(column) for name, column in COLUMNS.items()}
    joints = ggo.JointMap({angle: {f"{name}_rad": 1.0} for angle, name in zip(MAP.terms, NAMES, strict=True)})
    with pytest.raises(ggo.LogError, match=r"mapping, row \d+ \(\d.*rad, over a turn \(limit 6.283 rad\).*unit='deg'"):
        ggo.import_base_gait(log, joints=joints)
    # who knows better says so, and a note keeps it
    report = ggo.import_base_gait(log, joints=joints, unit="deg")
    assert any("the source states rad, unit= says deg" in note for note in report.notes)


def test_what_is_no_angle_is_not_taken_for_one():
    log = {"t": TIMES} | COLUMNS | {"knee_l [Nm]": VALUES[:, 3]}
    joints = ggo.JointMap(dict(MAP.terms) | {"beta_left": {"knee_l [Nm]": 1.0}}, "rad")
    with pytest.raises(ggo.LogError, match=r"knee_l \[Nm\] is no angle \(it is in 'nm'\)"):
        ggo.import_base_gait(log, joints=joints)
