"""Which topic of a log holds the joints."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Sequence

from ggo_factors.errors import LogError
from ggo_factors.recording.log.joint_map import listed
from ggo_factors.recording.log.presets import is_leg, is_other, words_of
from ggo_factors.recording.log.topic_streams import Scan, Stream

_RANK = {"state": 6, "list": 6, "dynamic": 4, "controller": 3, "trajectory": 2, "": 0}
"""For each shape of message how likely it holds the joints; `rank` explains the numbers."""
_FEW = 64
"""An array of more numbers does not hold joint angles."""
_TOPIC_WORDS = frozenset(("hip", "knee", "joint", "joints", "angle", "angles", "exo", "gait", "leg", "legs"))
"""Words of a topic whose numbers may be angles."""
_AXES = (["x"], ["y"], ["z"], ["w"])
_ROOM = 160
"""Characters that an error message gives to a list of topics; `ggo inspect` lists all."""
_NAMED = 5
"""Rank of values without a list of names whose fields are named like joints."""
_MEASURED = 3
"""Least rank of what is measured and has a list of names."""


class TopicNeededError(LogError):
    """Several topics may hold the joints.

    Attributes:
        streams: theirs.
    """

    def __init__(self, message: str, streams: Sequence[Stream] = ()) -> None:
        super().__init__(message)
        self.streams = tuple(streams)


def rank(stream: Stream) -> int:
    """How much a stream looks like joint values: 0 not at all, 1 numbers that may be angles, 2 and more joints."""
    names = stream.names
    if stream.shape == "list" and names and all(is_other(name) for name in names):
        return 0
    if stream.shape != "values":
        return 1 if stream.shape == "list" and not has_legs(stream) else _RANK[stream.shape]
    if has_legs(stream):
        return _NAMED
    if is_other(stream.topic) or all(is_other(name) or words_of(name)[-1:] in _AXES for name in names):
        return 0
    array = len(names) > 1 and all(name.endswith("]") for name in names)
    told = array or (stream.encoding == "json" and len(names) > 1) or _TOPIC_WORDS.intersection(words_of(stream.topic))
    return 1 if told and len(names) <= _FEW else 0


def has_legs(stream: Stream) -> bool:
    """Whether any of its values is called like a joint of a leg."""
    return any(is_leg(name) for name in stream.names)


def choose_topic(scan: Scan, source: str, names: Collection[str] | None) -> Stream:
    """The stream that holds `names`, or the one that looks most like joints.

    Raises:
        LogError: where there is none or more than one, listing the topics.
    """
    streams = list(scan.streams.values())
    if names:
        held = {id(s): len(set(names) & set(s.names)) for s in streams}
        most = max(held.values(), default=0)
        if most == 0:
            whys = [f" ({s.topic}: {unread(s)})" for s in streams if s.count and unread(s)]
            raise LogError(
                f"{source}: no topic holds any of {listed(list(names))}{''.join(whys[:1])}; "
                f"{topic_list(scan, names=True)}"
            )
        streams = [s for s in streams if held[id(s)] == most]
    # Legs before arms and grippers; but what was commanded, even to legs, not before what was measured.
    likely = {id(s): (rank(s) >= _MEASURED and has_legs(s), rank(s)) for s in streams}
    first = max(likely.values(), default=(False, 0))
    best = first[1]
    candidates = [s for s in streams if likely[id(s)] == first]
    if best < 2 and not names:
        empty = [s for s in scan.streams.values() if s.count == 0 and "joint" in s.message_type.lower()]
        if empty:
            raise LogError(
                f"{source}: {empty[0].topic} ({empty[0].message_type}) is there but has no message; {topic_list(scan)}"
            )
    if best == 0 and not names:
        streams.sort(key=lambda s: not unread(s))
        why = listed([f"{s.topic}: {_no_joints(s)}" for s in streams if s.count], "; ", 2 * _ROOM)
        force = "; give topic= to take one nonetheless" if any(s.names for s in streams) else ""
        raise LogError(f"{source}: no topic holds joints ({why}){force}")
    if len({s.topic for s in candidates}) > 1:
        which = listed([s.topic for s in candidates])
        value = f"{candidates[0].topic}:{(*candidates[0].names, 'NAME')[0]}"
        raise TopicNeededError(
            f"{source}: {which} may each hold the joints: give the topic (topic=), or, where a leg has its own, a map "
            f'that names each value with its topic ("{value}" = 1.0); ggo inspect shows what each holds',
            candidates,
        )
    return max(candidates, key=lambda s: s.count)


def holders(scan: Scan, source: str, names: Sequence[str]) -> dict[str, Stream]:
    """The stream to take each name from: one for all, or, where each leg has its own, the only one that has it.

    Raises:
        LogError: where none holds any, or it is not clear which, listing the topics.
    """
    held = {name: [s for s in scan.streams.values() if name in s.names] for name in names}
    everywhere = [s for s in scan.streams.values() if set(names) <= set(s.names)]
    if not everywhere and all(len({s.topic for s in streams}) == 1 for streams in held.values()):
        return {name: max(streams, key=rank) for name, streams in held.items()}
    return dict.fromkeys(names, choose_topic(scan, source, names))


def per_joint(scan: Scan) -> list[Stream]:
    """The streams of a log with one topic for each joint: single numbers, and topics that are called like joints."""
    streams = [s for s in scan.streams.values() if s.count]
    if any(rank(s) > 1 for s in streams):
        return []
    single = [s for s in streams if len(s.names) == 1 and is_leg(s.topic) and not is_other(s.names[0])]
    return single if len(single) > 1 else []


def of_topic(scan: Scan, source: str, topic: str) -> Stream:
    """The stream of a topic; where it has messages of two types, the one that looks more like joints.

    Raises:
        LogError: where there is no such topic, or it has no message that can be read, listing the topics.
    """
    streams = [s for s in scan.streams.values() if s.topic == topic]
    if not streams:
        several = topic.split(",")
        if len(several) > 1 and {s.topic for s in scan.streams.values()}.issuperset(several):
            raise LogError(
                f"{source}: {topic} is more than one topic: leave it out, and name each value with its topic in the "
                f'joint map ("{several[0]}:NAME" = 1.0)'
            )
        near = difflib.get_close_matches(topic, [s.topic for s in scan.streams.values()], 1)
        hint = f" (did you mean {near[0]}?)" if near else ""
        raise LogError(f"{source}: no topic {topic}{hint}; {topic_list(scan)}")
    stream = max(streams, key=lambda s: (rank(s), s.read, s.count))
    if stream.count == 0:
        raise LogError(f"{source}: {topic} ({stream.message_type}) is there but has no message; {topic_list(scan)}")
    if stream.problem and not stream.read:
        raise LogError(f"{source}: {topic} ({stream.message_type or 'no type'}) cannot be read: {stream.problem}")
    return stream


def topic_list(scan: Scan, names: bool = False) -> str:
    """The topics in one line, the first of many: type, count and rate, and some names if wanted."""
    likely = sorted(scan.streams.values(), key=lambda s: (not s.count, -rank(s)))
    return f"topics: {listed([_entry(s, names) for s in likely], '; ', _ROOM)} (ggo inspect shows them)"


def unread(stream: Stream) -> str:
    """Why no message of a stream can be read; empty where one can, or where it has none."""
    if stream.problem or stream.read:
        return stream.problem
    fit = "" if stream.encoding == "json" else ", its messages do not fit their schema"
    whys = {
        (f"cannot be decoded{fit}" if reason == "cannot be decoded" else reason)
        + (f" (the first {decoder.example[reason]})" if reason in decoder.example else ""): None
        for decoder in stream.decoders
        for reason in decoder.dropped
    }
    return listed(list(whys), "; ", 2 * _ROOM) if whys else ""


def _no_joints(stream: Stream) -> str:
    names = stream.names
    return unread(stream) or (f"no joint among {listed(names, room=40)}" if names else "no numbers")


def _entry(stream: Stream, names: bool) -> str:
    count = stream.count if stream.expected is None else max(stream.count, stream.expected)
    rate = f", {stream.rate_hz:.4g} Hz" if stream.rate_hz else ""
    held = f": {listed(stream.names, room=60)}" if names and stream.names else ""
    return f"{stream.topic} ({stream.message_type or stream.encoding}, {count} messages{rate}{held})"
