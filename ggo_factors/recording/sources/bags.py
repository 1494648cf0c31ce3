"""Bags that are no plain MCAP, written as MCAP into a folder of their own: what is read then is a log like any other.

A ROS 1 bag, an SQLite bag, and one whose messages are compressed are read by `rosbags` (an extra). A log that is
compressed as a file is unpacked, which needs nothing but what MCAP needs anyway.
"""

from __future__ import annotations

import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import zstandard
from mcap.writer import CompressionType, Writer

from ggo_factors.errors import LogError
from ggo_factors.recording.sources.extras import needed, require_content
from ggo_factors.support.files import PathLike

LARGEST_MESSAGE = 2**24
"""Largest message in [byte] that is taken over: joint values take hundreds, a whole gait in one message thousands."""
_PIECE = 2**20
"""Bytes unpacked at once."""
_DISK_SHARE = 0.5
"""Most of the free disk that an unpacked file may take."""
ZSTD = (".zstd", ".zst")
"""Endings of compressed files."""
_MAGIC = ((b"#ROSBAG V2", "rosbags"), (b"SQLite format 3\0", "rosbags"), (b"\x28\xb5\x2f\xfd", "zstd"))
_HEADER = "std_msgs/msg/Header"

Progress = Callable[[float], None] | None


def bag_kind(path: PathLike) -> str:
    """How a path is to be made MCAP: ``"rosbags"``, ``"zstd"``, or ``""`` where it is to be read as it is."""
    root = Path(path)
    try:
        if root.is_dir():
            return _folder_kind(root)
        ending = root.suffix.lower()
        if ending in (".bag", ".db3"):
            return "rosbags"
        if ending in ZSTD:
            return "zstd"
        if ending == ".mcap" or not root.is_file():
            return ""  # the reader of MCAP says what is wrong with it
        return next((kind for magic, kind in _MAGIC if _starts(root, magic)), "")
    except OSError as error:
        raise LogError(f"{path}: cannot be read: {error.strerror or error}") from error


@contextmanager
def as_mcap(path: PathLike, kind: str, progress: Progress = None) -> Iterator[Path]:
    """The MCAP file, or folder of them, that a bag was made into; it is gone when the block ends.

    Args:
        path: the bag.
        kind: what `bag_kind` says of it.
        progress: called with the part that was made, 0 to 1.

    Raises:
        LogError: where it cannot be read, or the extra `rosbags` is needed and not there.
    """
    with tempfile.TemporaryDirectory(prefix="ggo-") as folder:
        made = Path(folder) / (Path(path).stem or "bag")
        if kind == "zstd":
            yield _unpacked(Path(path), made)
        else:
            made = made.with_suffix(".mcap")
            _copied(Path(path), made, progress)
            yield made


def _starts(path: Path, magic: bytes) -> bool:
    with path.open("rb") as file:
        return file.read(len(magic)) == magic


def _folder_kind(root: Path) -> str:
    names = [file.name for file in root.iterdir()]
    if any(name.endswith(".db3") for name in names):
        return "rosbags"
    if any(name.endswith(ZSTD) for name in names):
        return "zstd"
    metadata = root / "metadata.yaml"
    if metadata.is_file() and metadata.stat().st_size < 2**22:
        said = metadata.read_text(encoding="utf-8", errors="replace").lower()
        mode = next((line for line in said.splitlines() if line.strip().startswith("compression_mode")), "")
        return "rosbags" if "message" in mode else ""
    return ""


def _unpacked(path: Path, made: Path) -> Path:
    if not path.is_dir():
        _unpack(path, made)
        return made
    made.mkdir()
    for file in path.iterdir():
        if file.name.endswith(ZSTD):
            _unpack(file, made / file.stem)
    metadata = path / "metadata.yaml"
    if metadata.is_file():
        text = metadata.read_text(encoding="utf-8", errors="replace")
        for ending in ZSTD:
            text = text.replace(f".mcap{ending}", ".mcap")
        (made / "metadata.yaml").write_text(text, encoding="utf-8")
    return made


def _unpack(path: Path, made: Path) -> None:
    """Unpack a file as far as it is whole: the reader says what is missing of the log in it."""
    require_content(path)
    left = int(_DISK_SHARE * shutil.disk_usage(made.parent).free)
    fault = "cut"
    try:
        with path.open("rb") as packed, made.open("wb") as file:
            for piece in zstandard.ZstdDecompressor().read_to_iter(packed, write_size=_PIECE):
                left -= len(piece)
                if left < 0:
                    raise LogError(f"{path}: unpacks to more than half of the free disk; unpack it with `zstd -d`")
                file.write(piece)
    except zstandard.ZstdError as error:
        fault = str(error)
    except OSError as error:
        raise LogError(f"{path}: cannot be unpacked: {error.strerror or error}") from error
    if not made.stat().st_size:
        raise LogError(f"{path}: not a zstd file, or damaged at its start ({fault})")


def _copied(path: Path, made: Path, progress: Progress) -> None:
    what = "a ROS 1 bag" if path.suffix == ".bag" else "this kind of rosbag2"
    needed("rosbags", "rosbags", path, what)
    require_content(path)
    try:
        _copy(path, made, progress)
    except LogError:
        raise
    except Exception as error:  # rosbags lets through what its parsers of YAML, SQLite and definitions raise
        words = (str(error) or repr(error)).splitlines()[0]
        raise LogError(f"{path}: rosbags cannot read it: {words:.160}") from error


def _copy(path: Path, made: Path, progress: Progress) -> None:
    from rosbags.rosbag1 import Reader as Reader1
    from rosbags.rosbag2 import Reader as Reader2

    one = path.is_file() and not _starts(path, b"SQLite")
    with (Reader1 if one else Reader2)(path) as bag, made.open("wb") as file:
        writer = Writer(file, compression=CompressionType.NONE)
        writer.start("ros2", "rosbags")
        channels = {connection.id: _Channel(connection, one, writer) for connection in bag.connections}
        every = max(1, bag.message_count // 100)
        for number, (connection, time, data) in enumerate(bag.messages(connections=bag.connections)):
            if len(data) <= LARGEST_MESSAGE:
                channel = channels[connection.id]
                writer.add_message(channel.id, int(time), channel.cdr(data), int(time))
            if progress is not None and number % every == 0:
                progress(number / bag.message_count)
        writer.finish()  # type: ignore[no-untyped-call]


class _Channel:
    """A channel of the MCAP for a connection of the bag: its schema, and its messages in CDR."""

    def __init__(self, connection: Any, one: bool, writer: Writer) -> None:
        self._kind, self._one = connection.msgtype, one
        try:
            self._store, encoding, text = _definition(connection, one)
        except Exception:  # what rosbags makes of a definition that it does not understand; another topic is wanted
            self._store, encoding, text = None, "ros2msg", ""
        schema = writer.register_schema(self._kind, encoding, text.encode())
        self.id = writer.register_channel(connection.topic, "cdr", schema)

    def cdr(self, data: bytes) -> bytes:
        """A message in CDR; empty where it cannot be, which the reader counts among what it could not decode."""
        if not self._one:
            return data
        try:
            return bytes(self._store.ros1_to_cdr(data, self._kind))
        except Exception:  # of one damaged message, whatever it is
            return b""


def _definition(connection: Any, one: bool) -> tuple[Any, str, str]:
    """The types that make CDR of a ROS 1 message, or None; encoding and text of a ROS 2 schema."""
    from rosbags.interfaces import MessageDefinitionFormat as Format
    from rosbags.typesys import Stores, get_types_from_msg, get_typestore

    kind, text = connection.msgtype, connection.msgdef.data
    if one:
        kinds = get_types_from_msg(text, kind)
        if _HEADER in kinds:  # of ROS 2, without `seq`: rosbags leaves it out of the messages
            constants, fields = kinds[_HEADER]
            kinds[_HEADER] = constants, [field for field in fields if field[0] != "seq"]
        store = get_typestore(Stores.EMPTY)
        store.register(kinds)
        return store, "ros2msg", store.generate_msgdef(kind, ros_version=2)[0]
    if connection.msgdef.format == Format.IDL:
        return None, "ros2idl", text
    if connection.msgdef.format == Format.NONE:  # SQLite bags have none before ROS 2 Iron
        known = get_typestore(Stores.LATEST)
        text = known.generate_msgdef(kind, ros_version=2)[0] if kind in known.fielddefs else ""
    return None, "ros2msg", text
