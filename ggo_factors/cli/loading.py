"""Gaits and walks as the command line names them, with the legs that its flags give, checked and compared."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

import ggo_factors as ggo
from ggo_factors.evaluate.comfort import Comfort, comfort
from ggo_factors.motion.base_gaits import Kind, Leg, as_leg, both, landing_height, other_leg
from ggo_factors.motion.leg_model import Bones
from ggo_factors.support.csv_table import kind_of
from ggo_factors.support.files import printable
from ggo_factors.walking.step import closes

SEVERAL = "ggo-base-gaits"
"""What the first line of a file of several base gaits says."""


def legs_of(file_model: ggo.LegModel | None, thigh: float | None, shank: float | None) -> ggo.LegModel | None:
    """The legs that the flags and the file give together.

    Raises:
        InputError: where the file states none and one flag is missing.
    """
    if thigh is None and shank is None:
        return file_model
    if file_model is not None:
        return replace(
            file_model,
            thigh=file_model.thigh if thigh is None else thigh,
            shank=file_model.shank if shank is None else shank,
        )
    if thigh is None or shank is None:
        raise ggo.InputError("--thigh and --shank: give both")
    return ggo.LegModel(thigh, shank)


def _with_legs(gait: ggo.Gait, thigh: float | None, shank: float | None, bones: Bones | None) -> ggo.Gait:
    return with_bones(replace(gait, model=legs_of(gait.model, thigh, shank)), bones)


def with_bones(gait: ggo.Gait, bones: Bones | None) -> ggo.Gait:
    """The gait with the bones that a flag names, if it does and the legs are known."""
    if bones is None or gait.model is None:
        return gait
    return replace(gait, model=replace(gait.model, bones=bones))


def _require_table(file: str) -> None:
    if file.lower().endswith(".mcap"):
        raise ggo.InputError(f"{file}: is a log; gaits and walks are CSV files, and `ggo import` makes one of a log")


def require_log(log: str) -> None:
    """Refuse what is no recording though a gait may be called so.

    Raises:
        InputError: where it is the word `paper`.
    """
    if log == "paper" and not Path(log).exists():
        raise ggo.InputError(
            "paper: that is the base gait of the paper, not a recording; LOG is an MCAP file, a bag, .mot, .csv or .c3d"
        )


def _say_notes(loaded: ggo.Gait | ggo.Walk) -> None:
    for note in loaded.notes:
        click.echo("ggo: note: " + printable(note), err=True)


def named_gait(name: str, edited: bool) -> ggo.Gait:
    """The base gait of the paper, or one from a file; what was noticed about the file is said.

    Raises:
        InputError: where the file cannot be used.
    """
    if name == "paper":
        return ggo.paper_base_gait()
    _require_table(name)
    if kind_of(name) == SEVERAL:
        raise ggo.InputError(f"{name}: holds several base gaits, and one gait is expected here")
    gait = ggo.load_gait(name, edited=edited)
    _say_notes(gait)
    return gait


def load_bases(
    name: str,
    thigh: float | None,
    shank: float | None,
    edited: bool,
    bones: Bones | None = None,
    stairs: Mapping[str, str | None] | None = None,
) -> ggo.Gait | ggo.BaseGaits:
    """One base gait, or the several of a file, with others for stairs beside; their legs must be known.

    Args:
        name: the file, or `paper`.
        thigh: thigh length in [m] if a flag gives it.
        shank: shank length in [m] if a flag gives it.
        edited: take files whose numbers were changed after they were written.
        bones: whether thighs and shanks are lines or points, if a flag says it.
        stairs: files of base gaits up and down stairs, by `up` and `down`; None where there are none.

    Raises:
        InputError: where a file cannot be used, or legs are not known.
    """
    return named_bases(name, edited, lambda file, gait: _legged(file, _with_legs(gait, thigh, shank, bones)), stairs)


def named_bases(
    name: str,
    edited: bool,
    change: Callable[[str, ggo.Gait], ggo.Gait],
    stairs: Mapping[str, str | None] | None = None,
) -> ggo.Gait | ggo.BaseGaits:
    """One base gait, or the several of a file, with others for stairs beside; each changed, given its file's name.

    Raises:
        InputError: where a file cannot be used.
    """
    base: ggo.Gait | ggo.BaseGaits
    if Path(name).is_file() and kind_of(name) == SEVERAL:
        several = ggo.load_base_gaits(name, edited=edited)
        _say_notes(several.left)
        base = several.changed(lambda gait: change(name, gait))
    else:
        base = change(name, named_gait(name, edited))
    beside = {kind: named_bases(file, edited, change) for kind, file in (stairs or {}).items() if file}
    if not beside:
        return base
    level = both(base)
    return replace(level, up=beside.get("up", level.up), down=beside.get("down", level.down))


def load_base(
    name: str, thigh: float | None, shank: float | None, edited: bool, bones: Bones | None = None
) -> ggo.Gait:
    """The base gait of the paper, or one from a file; its legs must be known.

    Raises:
        InputError: where the file cannot be used, or neither it nor the flags state the legs.
    """
    return _legged(name, _with_legs(named_gait(name, edited), thigh, shank, bones))


def _legged(name: str, gait: ggo.Gait) -> ggo.Gait:
    if gait.model is None:
        raise ggo.InputError(f"{name}: the file states no leg lengths; give --thigh and --shank")
    return gait


def load(
    file: str, thigh: float | None, shank: float | None, edited: bool, bones: Bones | None = None
) -> ggo.Gait | ggo.Walk:
    """A gait or walk file, by what its first line says."""
    _require_table(file)
    if file == "paper" or kind_of(file) != "ggo-walk":
        return load_base(file, thigh, shank, edited, bones)
    walk = ggo.load_walk(file, edited=edited)
    _say_notes(walk)
    return replace(walk, gaits=tuple(_with_legs(gait, thigh, shank, bones) for gait in walk.gaits))


def steps_of(loaded: ggo.Gait | ggo.Walk) -> tuple[ggo.Gait, ...]:
    """The gait, or each of a walk."""
    return loaded.gaits if isinstance(loaded, ggo.Walk) else (loaded,)


def load_beside(
    base: str | None, loaded: ggo.Gait | ggo.Walk, thigh: float | None, shank: float | None, edited: bool
) -> tuple[ggo.Gait, ...] | None:
    """For each step the base gait that it stands beside, in as many frames; None where there is no base.

    Of several base gaits it is that of the leg that swings, for the ground that the step says it is for, or else where
    it lands. Where steps say that they were bent from another one, that is noted.
    """
    if base is None:
        return None
    bases, chosen, others = both(load_bases(base, thigh, shank, edited)), list[ggo.Gait](), list[str]()
    for number, gait in enumerate(steps_of(loaded)):
        kind, leg = _ground_and_leg(loaded, number, bases)
        # At its own rate, or at that of the step as a walk bends it.
        same = [some for each in (bases, bases.at(gait.dt)) if len(some := each.gait(kind, leg)) == len(gait)]
        bent = gait.bent
        if bent is not None and all(some.fingerprint != bent.fingerprint for some in same):
            others.append(f"{number + 1}")
        chosen.append(same[0].evenly() if same else bases.gait(kind, leg).resampled(len(gait)))
    if others:
        click.echo(f"ggo: note: {base}: bent from other base gaits: step {', '.join(others)}", err=True)
    dt = chosen[0].dt
    return tuple(each if each.dt == dt else replace(each, dt=dt) for each in chosen)


def _ground_and_leg(loaded: ggo.Gait | ggo.Walk, number: int, bases: ggo.BaseGaits) -> tuple[Kind, Leg]:
    """The kind of ground and the swinging leg of a step, by its number from 0."""
    gait, first = steps_of(loaded)[number], "right"
    if isinstance(loaded, ggo.Walk):
        first = loaded.first_swing
    elif gait.bent is not None:
        first = gait.bent.swing
    leg = as_leg(first, "first_swing")
    height, ends = (
        landing_height(gait),
        isinstance(loaded, ggo.Walk) and bool(loaded.plan) and closes(loaded.plan[number]),
    )
    if gait.bent is not None:
        height = {"up": math.inf, "down": -math.inf}.get(gait.bent.ground.removeprefix("first "), 0.0)
        ends = gait.bent.ground.startswith("last ")
    return bases.kind_for(height, gait.legs(), gait.frames[0], ends), other_leg(leg) if number % 2 else leg


def checked(loaded: ggo.Gait | ggo.Walk, **asked: Any) -> tuple[ggo.Report, ...]:
    """The dense check of each step; `asked` is what a single gait must do, a walk knows it itself."""
    if isinstance(loaded, ggo.Walk):
        return loaded.verify(limits=asked.get("limits"))
    return (ggo.verify(loaded, **asked),)


def comforts_of(
    name: str, loaded: ggo.Gait | ggo.Walk, beside: Sequence[ggo.Gait] | None, **asked: Any
) -> list[Comfort]:
    """The comfort of a gait or walk, then that of the base gait in place of its every step, on the same legs."""
    steps = steps_of(loaded)
    made = [comfort(name, steps, checked(loaded, **asked), beside)]
    if beside is not None:
        same = tuple(replace(each, model=steps[0].legs()) for each in beside)
        walked = replace(loaded, gaits=same, steps=()) if isinstance(loaded, ggo.Walk) else same[0]
        made.append(comfort("base gait", steps_of(walked), checked(walked, **asked)))
    return made


def asked_of(
    hard: bool, limits: bool, pace: float | str | None, balance: float | None, style: str | None, first_swing: str
) -> dict[str, Any]:
    """What commands that bend gaits ask of a procedure, by its arguments."""
    return {
        "hard": hard,
        "limits": ggo.JointLimits() if limits else None,
        "pace": pace,
        "balance": balance,
        "style": None if style is None else ggo.load_style(style),
        "first_swing": first_swing,
    }
