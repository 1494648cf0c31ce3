"""A report's numbers as one HTML page: tables, drawings, the animation's script, and the numbers themselves."""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Sequence
from hashlib import sha256
from html import escape
from importlib.resources import files
from string import Template
from typing import Any

from ggo_factors.page.drawings import angle_charts, leg_parts, scene_parts, strip
from ggo_factors.support.files import printable

NONE = "\u2013"
"""What stands where a number does not apply."""
MOST_ON_A_PAGE = 12
"""A table of more rows may be parted between two pages of print."""
VERDICTS = {True: '<b class="kept">\u2713 kept</b>', False: '<b class="broken">\u2717 BROKEN</b>'}

Numbers = dict[str, Any]


def report_page(numbers: Numbers) -> str:
    """The page of a report's numbers, see `numbers.report_numbers`; all text in it is escaped."""
    script, style = _part("page.js"), _part("page.css")
    digest = b64encode(sha256(script.encode()).digest()).decode()
    return Template(_part("page.html")).substitute(
        policy=f"default-src 'none'; style-src 'unsafe-inline'; img-src data:; script-src 'sha256-{digest}'",
        title=_text(f"Report on {numbers['name']}"),
        kind=_kind(numbers),
        name=_text(numbers["name"]),
        style=style,
        script=script,
        numbers=_as_script(numbers),
        verdict=_verdict(numbers),
        legend=_legend(numbers),
        stage=_stage(numbers),
        last=len(numbers["motion"]["time_s"]) - 1,
        strip=strip(numbers),
        angles=_angles(numbers),
        speeds=_speeds(numbers),
        steps=_steps(numbers),
        balance=_balance(numbers),
        checks=_checks(numbers),
        source=_source(numbers),
    )


def _kind(numbers: Numbers) -> str:
    """A walk or a gait, its steps and its time."""
    count, last = len(numbers["steps"]), len(numbers["motion"]["time_s"]) - 1
    steps = f"{count} step{'s' if count > 1 else ''}"
    return f"{numbers['kind']}: {steps}, {_value(numbers, f'motion/time_s/{last}', 2, 's')}"


def _part(name: str) -> str:
    return files("ggo_factors.page").joinpath(name).read_text(encoding="utf-8")


def _text(text: object) -> str:
    """Text from a file, as HTML that shows it and does not obey it."""
    return escape(printable(str(text)))


def _as_script(numbers: Numbers) -> str:
    """JSON that no text in it can end the script element with."""
    made = json.dumps(numbers, allow_nan=False, separators=(",", ":"))
    for sign in "<>&":
        made = made.replace(sign, f"\\u{ord(sign):04x}")
    return made


def _value(numbers: Numbers, path: str, digits: int, unit: str = "") -> str:
    """A number of the JSON as a reader sees it, with its path there; a dash where there is none."""
    value: Any = numbers
    for key in path.split("/"):
        value = value[int(key) if isinstance(value, list) else key]
    if value is None:
        return NONE
    said = f"{value:.2g}" if digits > 5 and 0.0 < abs(value) < 1e-5 else f"{value:.{digits}f}"
    return f'<data value="{value!r}" data-path="{_text(path)}">{_signed(said)}</data>' + (
        f"&nbsp;{_text(unit)}" if unit else ""
    )


def _signed(said: str) -> str:
    """A number with a minus sign as it is printed; none before a 0."""
    return said.replace("-", "" if float(said) == 0.0 else "\u2212")


def _table(caption: str, heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; in a narrow page each cell stands below the other, with its column's name."""
    # Cells that are set as blocks in a narrow page stay cells to a screen reader by their roles.
    head = "".join(f'<th scope="col" role="columnheader">{name}</th>' for name in heads)
    body = []
    for first, *others in rows:
        cells = "".join(
            f'<td role="cell" data-label="{name}"><span>{cell}</span></td>'
            for name, cell in zip(heads[1:], others, strict=True)
        )
        label = f' data-label="{heads[0]}"' if heads[0] == "Step" else ""
        body.append(f'<tr role="row"><th scope="row" role="rowheader"{label}>{first}</th>{cells}</tr>')
    long = ' class="long"' if len(rows) > MOST_ON_A_PAGE else ""
    return (
        f'<table role="table"{long}><caption>{caption}</caption>'
        f'<thead role="rowgroup"><tr role="row">{head}</tr></thead>'
        f'<tbody role="rowgroup">{"".join(body)}</tbody></table>'
    )


def _verdict(numbers: Numbers) -> str:
    count = len(numbers["steps"])
    looked = (
        f"{_value(numbers, 'instants_checked', 0)} instants of {count} step{'s' if count > 1 else ''} were looked at."
    )
    if numbers["ok"]:
        return f'<div class="verdict kept"><h2>\u2713 Every check is kept</h2><p>{looked}</p></div>'
    faults = []
    for at, fault in enumerate(numbers["violations"]):
        where = f"Step {fault['step']}"
        if fault["time_s"] is not None:
            where += f", at {_value(numbers, f'violations/{at}/time_s', 2, 's')}"
        kind = fault["kind"] + (f" ({fault['note']})" if fault["note"] else "")
        value, limit = (
            f'<data value="{fault[key]!r}" data-path="violations/{at}/{key}">{_signed(f"{fault[key]:.4g}")}</data>'
            for key in ("value", "limit")
        )
        unit = _text(fault["unit"])
        faults.append(f"<li>{where}: {_text(kind)} is {value} {unit}; the limit is {limit} {unit}</li>")
    number = len(faults)
    title = f"\u2717 Not safe: {number} limit{'s are' if number > 1 else ' is'} broken"
    return f'<div class="verdict broken"><h2>{title}</h2><ul>{"".join(faults)}</ul><p>{looked}</p></div>'


def _legend(numbers: Numbers) -> str:
    """The two legs, told apart by colour, width and the shape of their joints."""
    items = []
    for leg in numbers["legs"]:
        mark = (
            '<circle class="joint left" cx="22" cy="8" r="5"/>'
            if leg == "left"
            else '<rect class="joint right" x="17" y="3" width="10" height="10"/>'
        )
        line = f'<path class="own {leg}" d="M2 8h40"/>'
        items.append(
            f'<span><svg aria-hidden="true" viewBox="0 0 44 16">{line}{mark}</svg>{_leg_name(numbers, leg)}</span>'
        )
    scene = numbers["scene"]
    kinds = [
        ("obstacle", "obstacle", bool(scene["boxes"])),
        ("gap", "gap", any(not pit["unknown"] for pit in scene["pits"])),
    ]
    kinds.append(("unknown", "ground that nobody saw", any(pit["unknown"] for pit in scene["pits"])))
    kinds.append(("cautious", "obstacle with room for its error", any("cautious" in box for box in scene["boxes"])))
    for kind, name, there in kinds:
        if there:
            box = f'<rect class="{kind}" x="10" y="2" width="24" height="12"/>'
            items.append(f'<span><svg aria-hidden="true" viewBox="0 0 44 16">{box}</svg>{name}</span>')
    if scene["footholds"]:
        cross = '<path class="foothold" d="M16 2l12 12m0 -12l-12 12"/>'
        items.append(f'<span><svg aria-hidden="true" viewBox="0 0 44 16">{cross}</svg>foothold</span>')
    return "".join(items)


def _stage(numbers: Numbers) -> str:
    motion, model = numbers["motion"], numbers["source"]["model"]
    legs = "".join(leg_parts(motion, 0, leg, model) for leg in ("left", "right"))
    return scene_parts(numbers["scene"]) + legs


def _leg_name(numbers: Numbers, leg: str) -> str:
    return f"{numbers['legs'][leg]} leg"


def _joint_name(numbers: Numbers, joint: str) -> str:
    leg, _, part = joint.partition(" ")
    return f"{numbers['legs'][leg].capitalize()} {part}"


def _angles(numbers: Numbers) -> str:
    names = {joint: _joint_name(numbers, joint) for joint in numbers["angles"]}
    charts = [
        f"<figure><figcaption>{names[joint]} [deg]</figcaption>{chart}</figure>"
        for joint, chart in angle_charts(numbers, names).items()
    ]
    base, any_curves = numbers["source"]["base"], next(iter(numbers["angles"].values()))
    said = "Thigh from the vertical, forward positive; knee flexion positive. "
    if base is None:
        said += "No base gait was given to put beside it."
    else:
        said += f"Dashed: the base gait ({_text('; '.join(base['names']))}) in place of each step"
        banded = "base_sd_deg" in any_curves
        said += ", with a band of one standard deviation of its strides." if banded else "; its spread is not known."
    if len(numbers["steps"]) > 1:
        said += " Thin vertical lines: the legs change roles."
    made = f'<p>{said}</p><div class="charts">{"".join(charts)}</div>'
    return made if base is None else made + _changes(numbers)


def _changes(numbers: Numbers) -> str:
    names = {"alpha1": "Supporting hip", "beta1": "Supporting knee", "alpha2": "Swinging hip", "beta2": "Swinging knee"}
    rows = [
        [f"{at + 1}", *(_value(numbers, f"steps/{at}/change_deg/{key}", 1, "deg") for key in names)]
        for at in range(len(numbers["steps"]))
    ]
    return _table("Mean change of each joint from the base gait", ["Step", *names.values()], rows)


def _speeds(numbers: Numbers) -> str:
    rows, limited = numbers["rates"], numbers["rates"][0]["speed_limit_deg_s"] is not None
    with_base = rows[0]["base_speed_deg_s"] is not None
    heads, made = ["Joint"], [[_joint_name(numbers, row["joint"])] for row in rows]
    for rate, unit, name in (("speed", "deg_s", "Speed"), ("acceleration", "deg_s2", "Acceleration")):
        said = unit.replace("_s2", "/s\u00b2").replace("_s", "/s")
        columns = [(f"Largest {name.lower()}", f"{rate}_{unit}")]
        columns += [("Limit", f"{rate}_limit_{unit}")] if limited else []
        columns += [("Base gait", f"base_{rate}_{unit}")] if with_base else []
        for head, key in columns:
            heads.append(head if head.startswith("Largest") else f"{head}, {name.lower()}")
            for at, cells in enumerate(made):
                cells.append(_value(numbers, f"rates/{at}/{key}", 0, said))
        if limited:
            heads.append(f"{name} as share of the limit")
            for at, cells in enumerate(made):
                cells.append(_share(numbers, at, f"{rate}_share_percent"))
    said = "" if limited else "<p>No limits of a machine were asked for: largest speeds are told without one.</p>"
    return said + _table("Largest speed and acceleration of each joint", heads, made)


def _share(numbers: Numbers, at: int, key: str) -> str:
    share = numbers["rates"][at][key]
    words = " beyond the limit" if share > 100.1 else ""
    bar = f'<span class="bar" aria-hidden="true"><i style="width:{min(share, 100.0):.0f}%"></i></span>'
    return f"{bar}{_value(numbers, f'rates/{at}/{key}', 0, '%')}{words}"


def _steps(numbers: Numbers) -> str:
    heads = ["Step", "Swings", "Begins", "Takes", "Lands ahead", "Lands above", "Foot over obstacle, least"]
    heads += ["Legs from obstacles, least", "Foot comes down at", "Allowed", "Verdict"]
    allowed = next(row for row in numbers["checks"] if row["check"] == "landing_speed")
    at_landing = f"checks/{numbers['checks'].index(allowed)}/allowed"
    broken = {fault["step"] for fault in numbers["violations"]}
    rows, notes = list[list[str]](), list[str]()
    for at, step in enumerate(numbers["steps"]):
        path = f"steps/{at}"
        rows.append(
            [
                f"{at + 1}",
                NONE if numbers["kind"] == "gait" else _leg_name(numbers, step["swings"]),
                _value(numbers, f"{path}/begins_s", 2, "s"),
                _value(numbers, f"{path}/duration_s", 2, "s"),
                _value(numbers, f"{path}/lands_m/0", 3, "m"),
                _value(numbers, f"{path}/lands_m/1", 3, "m"),
                _value(numbers, f"{path}/clearance_mm", 1, "mm"),
                _value(numbers, f"{path}/axis_clearance_mm", 1, "mm"),
                _value(numbers, f"{path}/landing_speed_m_s", 2, "m/s"),
                "any" if allowed["allowed"] is None else _value(numbers, at_landing, 2, "m/s"),
                VERDICTS[at + 1 not in broken],
            ]
        )
        notes += [f"<li>Step {at + 1}: {_text(note)}</li>" for note in step["notes"]]
    listed = f"<ul>{''.join(notes)}</ul>" if notes else ""
    return _table("Each step; lengths from its supporting ankle", heads, rows) + listed


def _balance(numbers: Numbers) -> str:
    said = (
        "<p>Where the ground pushes the supporting foot (zero moment point), ahead of its ankle: furthest back and "
        "furthest forward in each step, of the legs' masses without a trunk. Beyond the sole the legs' motion "
        "alone would tip the walker over: trunk, crutches or a frame must hold it. "
    )
    heads, based = ["Step", "Furthest back", "Furthest forward"], numbers["source"]["base"] is not None
    if based:
        heads += ["From the base gait's, mean", "From the base gait's, largest"]
        allowed = _value(numbers, "balance/0/allowed_mean_off_base_mm", 0, "mm")
        said += f"A step that is made with balance is at most {allowed} from the base gait's on average. "
    rows = []
    for at in range(len(numbers["balance"])):
        keys = ["back_mm", "front_mm", *(["mean_off_base_mm", "largest_off_base_mm"] if based else [])]
        rows.append([f"{at + 1}", *(_value(numbers, f"balance/{at}/{key}", 0, "mm") for key in keys)])
    asked = any(row["check"] == "balance" and row["asked"] for row in numbers["checks"])
    said += "" if asked else "Balance is no part of the check of this file.</p>"
    return said + _table("Balance", heads, rows)


def _checks(numbers: Numbers) -> str:
    rows, others = list[list[str]](), list[str]()
    for at, check in enumerate(numbers["checks"]):
        if not check["asked"]:
            others.append(f"<li>{check['label'].partition(':')[0]}</li>")
            continue
        unit, digits = check["unit"], _digits(check)
        found, allowed = (_value(numbers, f"checks/{at}/{key}", digits, unit) for key in ("found", "allowed"))
        if allowed != NONE:
            allowed = f"at {'least' if check['at_least'] else 'most'} {allowed}"
        steps = check["broken_in_steps"]
        where = f" in step{'s' if len(steps) > 1 else ''} {', '.join(map(str, steps))}" if steps else ""
        rows.append([check["label"], found, allowed, VERDICTS[not steps] + where])
    heads = ["Check", "Found", "Allowed", "Verdict"]
    made = _table("What was looked at, what was found where it has a number, what is allowed", heads, rows)
    return made + (f"<p>Not asked of this file:</p><ul>{''.join(others)}</ul>" if others else "")


def _digits(check: Numbers) -> int:
    """Decimals that show a check's tolerance."""
    allowed = check["allowed"]
    if allowed is None or allowed == 0.0 or abs(allowed) >= 5.0:
        return 1
    return 2 if abs(allowed) >= 0.1 else 6


def _source(numbers: Numbers) -> str:
    source = numbers["source"]
    rows = [["Name", _text(numbers["name"])], *_file_rows(source, "File")]
    rows += [["Made of", _text(origin)] for origin in source["origins"]]
    rows += [["Bent from", _text(_bent(bent))] for bent in source["bent_from"]]
    rows += [["Note", _text(note)] for note in source["notes"]]
    base = source["base"]
    rows += [["Base gait", "none given" if base is None else _text("; ".join(base["names"]))]]
    if base is not None:
        rows += [["Strides in the base gait", _text(f"{name}: {n}")] for name, n in (base["strides"] or {}).items()]
        rows += [*_file_rows(base, "Base gait's file"), *(["Note", _text(note)] for note in base["notes"])]
    lengths = [f"{key} {_value(numbers, f'source/model/{key}_m', 3, 'm')}" for key in ("thigh", "shank", "heel", "toe")]
    rows += [["Legs", ", ".join(lengths)], ["Checked and written by", _text(numbers["library"])]]
    return "".join(f"<div><dt>{name}</dt><dd>{said}</dd></div>" for name, said in rows)


def _bent(bent: Numbers) -> str:
    """What steps were bent from, with the digits by which files tell base gaits and styles apart."""
    style = f", in the style {bent['style']}" if bent.get("style") else ""
    return f"{bent['name']} ({bent['fingerprint']}), for {bent['ground']} ground, {bent['swing']} leg swings{style}"


def _file_rows(file: Numbers, name: str) -> list[list[str]]:
    if file["file"] is None:
        return [[name, "none: part of the library"]]
    return [
        [name, f"{_text(file['file'])} ({_text(file['form'])})"],
        [f"{name}, date", _text(file["written"]).replace("T", " ").replace("+00:00", " UTC")],
        [f"{name}, checksum in it", "none" if file["checksum"] is None else _text(file["checksum"])],
        [f"{name}, SHA-256", f"<code>{_text(file['sha256'])}</code>"],
    ]
