"""What a recording lost: the damage found, compared with the message counts in the file's statistics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ggo_factors.recording.log.topic_streams import FileDamage, Scan, Stream


@dataclass(frozen=True)
class Loss:
    """Data that a recording lost, or holds in a form that cannot be used.

    Attributes:
        what: what was lost and why, in words.
        count: number of messages (or values) lost, or None where nothing in the file tells.
        from_s: time of the last sample before the loss in [s] from the first sample, or None.
        to_s: time of the first sample after it in [s], or None.
        where: byte of the file at which the damage begins, or None.
    """

    what: str
    count: int | None = None
    from_s: float | None = None
    to_s: float | None = None
    where: int | None = None

    def __str__(self) -> str:
        many = "an unknown number of messages" if self.count is None else _messages(self.count)
        if self.from_s is not None and self.to_s is not None:
            when = f" between {self.from_s:.2f} s and {self.to_s:.2f} s"
        elif self.from_s is not None:
            when = f" after {self.from_s:.2f} s"
        else:
            when = "" if self.to_s is None else f" before {self.to_s:.2f} s"
        return f"{many} lost{when}: {self.what}"


Around = Callable[[Stream, int, int], tuple[float | None, float | None]]


def find_losses(scan: Scan, streams: Sequence[Stream], around: Around) -> tuple[list[Loss], list[str]]:
    """The losses of some streams, and notes on damage that took nothing from them.

    Args:
        scan: the pass over the files.
        streams: the streams concerned.
        around: for a stream, a file's number and a byte: times of the samples before and after it in [s].
    """
    notes: list[str] = []
    known = all(s.expected is not None for s in streams)
    missing = sum((s.expected or 0) - s.count for s in streams) if known else None
    open_: list[tuple[FileDamage, int | None]] = []
    for found in scan.damages:
        taken = sum(found.lost.get((s.topic, s.message_type, s.encoding), 0) for s in streams)
        if found.damage.harmless or missing == 0:
            notes.append(f"{found.damage.what}; no message was lost by it")
        elif taken == 0 and found.damage.sure and found.lost:
            notes.append(f"{found.damage.what}; no message of this topic was lost by it")
        else:
            open_.append((found, taken if taken and found.damage.sure else None))
    losses = [Loss(problem, None) for problem in scan.unread]
    unknown = [found for found, took in open_ if took is None]
    left = None if missing is None else missing - sum(took or 0 for _, took in open_)
    for found, took in open_:
        alone = took is None and left is not None and len(unknown) == 1 and not scan.unread
        count = max(left or 0, 0) if alone else took
        if count == 0:
            notes.append(f"{found.damage.what}; no message was lost by it")
            continue
        times = [around(s, found.file, found.damage.where) for s in streams]
        before = max((a for a, _ in times if a is not None), default=None)
        after = min((b for _, b in times if b is not None), default=None)
        losses.append(Loss(found.damage.what, count, before, after, found.damage.where))
    if left is not None and left > 0 and (len(unknown) != 1 or scan.unread):
        losses.append(Loss("the file's statistics count them, but the file does not hold them", left))
    elif left is not None and left < 0 and missing is not None and missing < 0:
        notes.append(f"the file holds {-missing} messages more than its statistics count")
    if scan.undeclared:
        losses.append(Loss("they are on channels that the file does not declare", scan.undeclared))
    for stream in streams:
        for decoder in stream.decoders:
            for reason, many in decoder.dropped.items():
                example = f" (the first {decoder.example[reason]})" if reason in decoder.example else ""
                losses.append(Loss(f"{stream.topic}: {reason}{example}", many))
        if unnamed := sum(decoder.unnamed for decoder in stream.decoders):
            notes.append(f"{unnamed} messages of {stream.topic} name no joints: they have the names of those that do")
        extra = sum((decoder.left for decoder in stream.decoders), Counter[int]())
        if extra:
            notes.append(
                f"{extra.total()} messages of {stream.topic} go on for {_range(extra)} bytes behind what their schema "
                "says: not read"
            )
    if not scan.checksums:
        notes.append("this file carries no checksums: damaged values cannot be recognized")
    return losses, notes


def _range(numbers: Counter[int]) -> str:
    low, high = min(numbers), max(numbers)
    return str(low) if low == high else f"{low} to {high}"


def _messages(count: int) -> str:
    return "1 message" if count == 1 else f"{count} messages"
