"""Which MCAP files a path stands for, and what a file is that is none."""

from __future__ import annotations

import re
from pathlib import Path

from ggo_factors.errors import LogError
from ggo_factors.support.files import PathLike

MAGIC = b"\x89MCAP0\r\n"
"""First and last bytes of an MCAP file."""
_OTHERS: tuple[tuple[bytes, str], ...] = (
    (b"SQLite format 3", "a rosbag2 SQLite bag; convert it with `ros2 bag convert` to the mcap storage"),
    (b"#ROSBAG V2", "a ROS 1 bag; convert it with `mcap convert in.bag out.mcap`"),
    (b"version https://git-lfs", "a Git LFS pointer, not the file itself; fetch it with `git lfs pull`"),
    (b"\x1f\x8b", "a gzip file; unpack it first with `gunzip`"),
    (b"\x28\xb5\x2f\xfd", "a zstd file; unpack it first with `zstd -d`"),
    (b"\x04\x22\x4d\x18", "an lz4 file; unpack it first with `lz4 -d`"),
    (b"PK\x03\x04", "a zip file; unpack it first with `unzip`"),
    (b"\x89HDF", "an HDF5 file, not an MCAP log"),
)


def mcap_files(path: PathLike) -> tuple[list[Path], list[str]]:
    """The MCAP files of a log, in order, and the names of those that its metadata.yaml lists but that are missing.

    Args:
        path: a file, or a rosbag2 folder: its files in the order of metadata.yaml, else by name and number.

    Raises:
        LogError: where there is no such path, or no MCAP file in the folder.
    """
    root = Path(path)
    try:
        if not root.is_dir():
            return [root], []
        found = sorted((p for p in root.iterdir() if p.suffix == ".mcap"), key=_by_number)
        others = sorted(p.name for p in root.iterdir() if p.name.endswith((".db3", ".mcap.zstd")))
        listed = _listed(root / "metadata.yaml")
    except (OSError, ValueError) as error:
        raise LogError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}") from error
    missing = [name for name in listed if not (root / name).is_file()]
    files = [
        root / name for name in dict.fromkeys(listed) if (root / name).is_file() and name.endswith(".mcap")
    ] or found
    if files:
        return files, missing
    if others and others[0].endswith(".db3"):
        raise LogError(f"{path}: a rosbag2 SQLite bag ({others[0]}); convert it with `ros2 bag convert` to mcap")
    if others:
        raise LogError(f"{path}: its files are compressed ({others[0]}); unpack them first with `zstd -d`")
    raise LogError(f"{path}: no .mcap file in this folder")


def check_magic(path: Path, start: bytes, size: int) -> None:
    """Check the first bytes of a file.

    Raises:
        LogError: saying what the file is, where it is not an MCAP file that holds anything.
    """
    if size == 0:
        raise LogError(f"{path}: the file is empty (0 bytes)")
    if start.startswith(MAGIC):
        if size == len(MAGIC):
            raise LogError(f"{path}: holds nothing after the MCAP magic (8 bytes)")
        return
    for magic, what in _OTHERS:
        if start.startswith(magic):
            raise LogError(f"{path}: this is {what}")
    if b"MCAP0\r\n" in start[:16] or (len(start) < len(MAGIC) and MAGIC.startswith(start)):
        raise LogError(f"{path}: the MCAP magic at its start is damaged ({start[:8].hex(' ')}); try `mcap recover`")
    if start[:64].isascii() and b"\0" not in start[:64]:
        line = start[:40].decode("ascii").splitlines()[0]
        raise LogError(f"{path}: this is a text file ({line!r}...), not an MCAP log")
    raise LogError(f"{path}: not an MCAP file (its first bytes are {start[:8].hex(' ')})")


def _by_number(path: Path) -> list[tuple[int, str]]:
    # bag_2 before bag_10
    return [(int(part), "") if part.isdigit() else (-1, part) for part in re.split(r"(\d+)", path.name)]


def _listed(metadata: Path) -> list[str]:
    # The plain list under relative_file_paths, as rosbag2 writes it; anything else there is not worth a YAML parser.
    if not metadata.is_file() or metadata.stat().st_size > 2**22:
        return []
    names: list[str] = []
    inside = False
    for line in metadata.read_text(encoding="utf-8").splitlines():
        if inside:
            item = re.fullmatch(r"\s*-\s+[\"']?([^\"'/\\]+?)[\"']?\s*", line)
            if item is None:
                break
            names.append(item.group(1))
        inside = inside or re.fullmatch(r"\s*relative_file_paths:\s*", line) is not None
    return names
