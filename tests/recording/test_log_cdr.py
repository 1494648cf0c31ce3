"""CDR decoding against mcap-ros2-support, message by message, with random schemas and with bulk decoding."""

from __future__ import annotations

import math
import random

import numpy as np
import pytest
from log_files import JOINT_STATE, JOINT_TYPE, NAMES, joint_state, walk_angles, write_messages
from mcap_ros2._dynamic import generate_dynamic, serialize_dynamic

from ggo_factors.recording.log.decode_many import Template
from ggo_factors.recording.log.read_log import read_log
from ggo_factors.recording.log.ros2_definitions import DefinitionError, parse_messages
from ggo_factors.recording.log.walk_cdr import CdrError, Slot, walk

PRIMITIVES = (
    ["bool", "byte", "char", "string"]
    + [f"{sign}int{bits}" for sign in ("", "u") for bits in (8, 16, 32, 64)]
    + ["float32", "float64"] * 3
)


def random_value(rng, kind, messages):
    if kind == "string":
        return rng.choice(["", "a", "left_hip", "äß", "x" * rng.randrange(9)])
    if kind == "bool":
        return rng.random() < 0.5
    if kind.startswith("float"):
        return float(np.float32(rng.uniform(-9, 9)))
    if kind in ("byte", "char") or "int" in kind:
        return rng.randrange(100)
    return {name: random_field(rng, spec, messages) for name, spec in messages[kind]}


def random_field(rng, spec, messages):
    kind, count, bound = spec
    if count is None:
        return random_value(rng, kind, messages)
    many = count if count >= 0 else rng.randrange(bound or 5)
    return [random_value(rng, kind, messages) for _ in range(many)]


def random_schema(rng):
    """Messages by name, and their text: A may hold B and C, B may hold C."""
    messages, parts = {}, []
    for name, inner in (("C", []), ("B", ["pkg/C"]), ("A", ["pkg/B", "pkg/C"])):
        fields, lines = [], []
        for i in range(rng.randrange(1, 7)):
            kind = rng.choice(inner) if inner and rng.random() < 0.35 else rng.choice(PRIMITIVES)
            count, bound, array = rng.choice(
                [(None, 0, ""), (None, 0, ""), (-1, 5, "[]"), (3, 0, "[3]"), (-1, 4, "[<=4]")]
            )
            fields.append((f"f{i}", (kind, count, bound)))
            lines.append(f"{kind}{array} f{i}  # a comment")
            if rng.random() < 0.1:
                lines.append(f"int32 K{i}=7")
        messages[f"pkg/{name}"] = fields
        parts.append(("\n".join(lines), name))
    text = parts[-1][0]
    for body, name in parts[:-1]:
        text += f"\n{'=' * 80}\nMSG: pkg/{name}\n{body}"
    return messages, text + "\n"


def resolved(tree, data):
    """The numbers of a walked tree."""
    if isinstance(tree, Slot):
        return np.frombuffer(data, tree.code, 1, tree.offset)[0].item()
    if isinstance(tree, dict):
        return {key: resolved(value, data) for key, value in tree.items()}
    return [resolved(value, data) for value in tree] if isinstance(tree, list) else tree


def same(mine, oracle):
    if isinstance(mine, dict):
        return all(same(value, getattr(oracle, key)) for key, value in mine.items())
    if isinstance(mine, list):
        return len(mine) == len(oracle) and all(map(same, mine, oracle))
    return mine == oracle


def test_random_schemas_decode_as_the_official_package_does():
    for seed in range(80):
        rng = random.Random(seed)
        messages, text = random_schema(rng)
        encode = serialize_dynamic("pkg/msg/A", text)["pkg/msg/A"]
        decode = generate_dynamic("pkg/msg/A", text)["pkg/msg/A"]
        mine = parse_messages("pkg/msg/A", "ros2msg", text.encode())
        for _ in range(8):
            data = encode(random_value(rng, "pkg/A", messages))
            assert same(resolved(walk(data, "pkg/A", mine).tree, data), decode(data)), (seed, text)


def test_one_template_serves_only_messages_of_its_layout():
    messages = parse_messages(JOINT_TYPE, "ros2msg", JOINT_STATE.encode())
    rows = [joint_state(i, NAMES, row, row) for i, row in enumerate(walk_angles(6).tolist())]
    swapped = joint_state(7, ("hip_r", "knee_r", "hip_l", "knee_l"), (1, 2, 3, 4), (1, 2, 3, 4))
    assert len(swapped) == len(rows[0])
    template = Template(rows[0], "sensor_msgs/JointState", messages, ("knee_r",))
    table = np.frombuffer(b"".join([*rows, swapped]), np.uint8).reshape(7, -1)
    assert template.matches(table).tolist() == [True] * 6 + [False]
    assert template.values(table[:6])[:, 0].tolist() == walk_angles(6)[:, 3].tolist()


def test_padding_may_hold_anything():
    messages = parse_messages("pkg/A", "ros2msg", b"uint8 a\nfloat64 x\n")
    data = bytearray(b"\x00\x01\x00\x00" + bytes(8) + np.float64(1.5).tobytes())
    template = Template(bytes(data), "pkg/A", messages, None)
    data[6:10] = b"junk"
    assert template.matches(np.frombuffer(bytes(data), np.uint8)[None]).all()


@pytest.mark.parametrize(
    ("data", "why"),
    [
        (b"\x00\x01", "bytes long"),
        (b"\x00\x07\x00\x00" + bytes(8), "XCDR2"),
        (b"\x00\x03\x00\x00" + bytes(8), "parameter lists"),
        (b"\x00\x01\x00\x00\xff\xff\xff\xff", "claims 4294967295"),
        (b"\x00\x01\x00\x00\x02\x00\x00\x00" + bytes(11), "inside a field"),
    ],
)
def test_a_message_that_does_not_fit_is_refused(data, why):
    with pytest.raises(CdrError, match=why):
        walk(data, "pkg/A", parse_messages("pkg/A", "ros2msg", b"float64[] x\n"))


@pytest.mark.parametrize("text", [b"\xff\xfe", b"---\n", b"other/Thing x\n", b"wstring x\n", b"{}\n"])
def test_a_schema_that_cannot_be_understood_is_refused(text):
    with pytest.raises(DefinitionError):
        parse_messages("pkg/msg/A", "ros2msg", text)


def test_a_log_of_many_layouts_is_read_in_order(tmp_path):
    # each message has its own frame: beyond a number of layouts each message is decoded by itself
    encode = serialize_dynamic(JOINT_TYPE, JOINT_STATE)[JOINT_TYPE]
    values = walk_angles(600)
    rng = random.Random(2)
    messages = []
    for i, row in enumerate(values.tolist()):
        order = rng.sample(range(4), 4)
        header = {"stamp": {"sec": 10 + i, "nanosec": 5}, "frame_id": f"f{i % 397:03d}"}
        data = encode({"header": header, "name": [NAMES[j] for j in order], "position": [row[j] for j in order]})
        messages.append(("/j", i * 10**9 + 7, i * 10**9 + 7, data))
    path = write_messages(tmp_path / "a.mcap", {"/j": (JOINT_TYPE, JOINT_STATE, "ros2msg", "cdr")}, messages)
    log = read_log(path, names=NAMES)
    assert np.array_equal(log.values, values)
    assert log.messages_read == 600
    assert math.isclose(log.times[-1], 599.0)
