"""Joint maps for names in wide use, matched to the names of a log."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType

# A term of a preset: its other names in canonical form, its factor, and whether a log may lack it.
Term = tuple[tuple[str, ...], float, bool]


def _sides(build: Callable[[str, str], tuple[tuple[Term, ...], tuple[Term, ...]]]) -> dict[str, tuple[Term, ...]]:
    rows: dict[str, tuple[Term, ...]] = {}
    for side, letter in (("right", "r"), ("left", "l")):
        rows[f"alpha_{side}"], rows[f"beta_{side}"] = build(side, letter)
    return rows


def _direct(sign: float) -> dict[str, tuple[Term, ...]]:
    def build(side: str, letter: str) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
        def other(joint: str, *kinds: str) -> tuple[str, ...]:
            plain = [form for s in (side, letter) for form in (f"{s}{joint}", f"{joint}{s}")]
            return (*plain, *(f"{form}{kind}" for form in plain for kind in kinds))

        hip = other("hip", "fe", "pitch", "flexion", "sagittal")
        return ((hip, 1.0, True),), ((other("knee", "fe", "pitch", "flexion", "sagittal"), sign, True),)

    return _sides(build)


def _opensim(sign: float) -> dict[str, tuple[Term, ...]]:
    def build(_: str, letter: str) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
        hip = (f"hipflexion{letter}", f"jointsethip{letter}hipflexion{letter}")
        angles = (f"knee{letter}", f"kneeangle{letter}")
        # A state's path names the joint first, which newer models call walker_knee_r.
        paths = tuple(f"jointset{joint}knee{letter}{angle}" for joint in ("", "walker") for angle in angles)
        knee = (*angles, *paths)
        tilt = ("pelvistilt", "jointsetgroundpelvispelvistilt")
        return ((hip, 1.0, True), (tilt, 1.0, False)), ((knee, sign, True),)

    return _sides(build)


def _plug_in_gait(_: str, letter: str) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    def other(joint: str, sides: str = letter) -> tuple[str, ...]:
        return tuple(f"{side}{joint}angles{axis}" for side in sides for axis in ("x", "0", ""))

    # Hip flexion is against the pelvis, whose forward tilt counts positive; one pelvis is enough for both legs.
    pelvis = other("pelvis", "lr" if letter == "l" else "rl")
    return ((other("hip"), 1.0, True), (pelvis, -1.0, False)), ((other("knee"), 1.0, True),)


def _segment_pitch(side: str, letter: str) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    def other(segment: str) -> tuple[str, ...]:
        return tuple(
            form
            for s in (letter, side)
            for form in (
                f"{segment}pitch{s}",
                f"{s}{segment}pitch",
                f"{segment}{s}pitch",
                f"{segment}{s}",
                f"{s}{segment}",
            )
        )

    thigh: Term = (other("thigh"), 1.0, True)
    return (thigh,), (thigh, (other("shank"), -1.0, True))


PRESETS: Mapping[str, Mapping[str, tuple[Term, ...]]] = MappingProxyType(
    {
        "direct": _direct(1.0),
        "direct-knee-negative": _direct(-1.0),
        "opensim": _opensim(1.0),
        "opensim-knee-negative": _opensim(-1.0),
        "plug-in-gait": _sides(_plug_in_gait),
        "segment-pitch": _sides(_segment_pitch),
    }
)
"""Maps for names in wide use; ``-knee-negative`` where the log counts knee flexion negative."""

# Words that say nothing of which joint is meant. Not "angles": Plug-in-Gait's names end in it.
_EMPTY_WORDS = {"joint", "joints", "angle", "data", "position", "value", "pos", "state", "exo", "robot"}
_EMPTY_WORDS |= {"deg", "degree", "degrees", "rad", "radian", "radians"}


_CAMEL = re.compile(r"(?<=[a-z0-9])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])")


def words_of(name: str) -> list[str]:
    """The words of a name, however they are joined: ``exo/LeftHipJoint`` is exo, left, hip, joint."""
    return [word for word in re.split(r"[^a-z0-9]+", _CAMEL.sub(" ", name).lower()) if word]


_LEG = re.compile(r"(?:left|right|[lr])?(?:hip|knee|ankle|thigh|shank|shin|femur|tibia|pelvis|joint|leg(?!ac|al|end))")
_OTHERS = frozenset(
    (
        *(
            "temperature",
            "temp",
            "voltage",
            "current",
            "currents",
            "battery",
            "percentage",
            "charge",
            "power",
            "cpu",
            "fan",
        ),
        *(
            "force",
            "forces",
            "torque",
            "torques",
            "effort",
            "efforts",
            "moment",
            "pressure",
            "emg",
            "grf",
            "load",
            "imu",
        ),
        *("velocity", "velocities", "vel", "speed", "acceleration", "accelerations", "accel", "gyro", "magnetic"),
        *("orientation", "quaternion", "latitude", "longitude", "altitude", "frequency", "count", "counter", "seq"),
        *("width", "height", "memory", "status", "error", "errors", "mode", "diagnostics"),
    )
)
"""Words of quantities that are no joint angles."""


def is_leg(name: str) -> bool:
    """Whether a word of a name says a leg or its joints, and none says another quantity than an angle."""
    words = words_of(name)
    return any(_LEG.match(word) for word in words) and not _OTHERS.intersection(words)


def is_other(name: str) -> bool:
    """Whether a word of a name says another quantity than an angle."""
    return bool(_OTHERS.intersection(words_of(name)))


def _canonical(name: str) -> str:
    return "".join(word for word in words_of(name) if word not in _EMPTY_WORDS)


def _without_space(name: str) -> list[str]:
    # a name without the namespaces before it, the shortest last
    parts = re.split(r"/|::|\.", name)
    return [_canonical("/".join(parts[i:])) for i in range(1, len(parts))]


def resolve(preset: str, names: Sequence[str]) -> tuple[dict[str, dict[str, float]], list[str], list[str]]:
    """The terms of a preset in a log's own names, what is missing or ambiguous, and notes."""
    by_form: dict[str, list[str]] = {}
    by_end: dict[str, list[str]] = {}  # for namespaces that are not known
    for name in names:
        by_form.setdefault(_canonical(name), []).append(name)
        for form in _without_space(name):
            by_end.setdefault(form, []).append(name)
    terms: dict[str, dict[str, float]] = {}
    missing: list[str] = []
    notes: list[str] = []
    for angle, row in PRESETS[preset].items():
        terms[angle] = {}
        for forms, factor, needed in row:
            alike = [*forms, *(_canonical(f) for f in forms)]
            found = [name for form in alike for name in by_form.get(form, ())]
            found = list(dict.fromkeys(found or [name for form in alike for name in by_end.get(form, ())]))
            if len(found) == 1 or (found and not needed):
                terms[angle][found[0]] = factor
            elif found:
                missing.append(f"single value for {angle} ({' and '.join(found)} fit)")
            elif needed:
                missing.append(angle)
            else:
                notes.append(
                    f"{angle}: no pelvis tilt in the log, so this is the hip angle and not the thigh from the vertical"
                )
    pelvis = [name for name in names if "pelvis" in name.lower()]
    used = {name for row in terms.values() for name in row}
    if pelvis and not used & set(pelvis):
        notes.append(
            f"{', '.join(pelvis)} is in the log and preset {preset!r} does not use it: if the hips are relative to "
            f"the pelvis, write a joint map that adds its tilt"
        )
    return terms, missing, notes
