"""Messages of recordings, whatever holds them: an MCAP file, a rosbag2 database (.db3), or the folder of a rosbag2.

A database is read by SQLite as rosbag2 lays it out: tables `topics` (id, name, type, serialization_format) and
`messages` (topic_id, timestamp, data).
"""

from __future__ import annotations

import sqlite3
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from mcap.well_known import MessageEncoding

from holonom.app.recording.format.cdr import ENCAPSULATION
from holonom.app.recording.format.pieces import read_pieces
from holonom.app.recording.format.topic_messages import Messages, Stream
from holonom.errors import InputError, LogError

__all__ = ["BAGS", "DAMAGED", "Message", "is_bag", "lost_of", "messages_of"]

BAGS = (".mcap", ".db3")
DAMAGED = (
    struct.error,
    ValueError,
    KeyError,
    IndexError,
    OverflowError,
)  # what broken files raise


class Message(NamedTuple):
    """A message in CDR: its type, such as nav_msgs/Odometry, its topic, its bytes."""

    kind: str
    topic: str
    data: bytes


def is_bag(path: Path) -> bool:
    """Whether a path is a recording by its name: a file of `BAGS`, or a folder with such files."""
    return path.suffix in BAGS or bool(path.is_dir() and _files(path))


def messages_of(path: Path, kinds: tuple[str, ...]) -> Iterator[Message]:
    """Messages of some types, in order of time within each file.

    Raises
    ------
    LogError
        No such file, one that cannot be read, messages in another encoding.
    """
    for file in _files(path) if path.is_dir() else [path]:
        read = _database if file.suffix == ".db3" else _mcap
        try:
            for kind, topic, encoding, data in read(file):
                if kind not in kinds:
                    continue
                if encoding != MessageEncoding.CDR or data[:4] != ENCAPSULATION:
                    raise LogError(f"{file}: {topic} is not in little-endian CDR; record it with ROS 2")
                yield Message(kind, topic, data)
        except FileNotFoundError:
            raise LogError(f"{file}: there is no such file; give the path of a log") from None
        except (OSError, sqlite3.Error, *DAMAGED) as error:
            what = "no rosbag2 database" if file.suffix == ".db3" else "no MCAP file"
            raise LogError(
                f"{file}: {what} that can be read ({error or type(error).__name__}); record it again"
            ) from None


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.iterdir() if path.suffix in BAGS)


Raw = tuple[str, str, str, bytes]


def _mcap(path: Path) -> Iterator[Raw]:
    """Of a damaged or cut file what is sound; `lost_of` says what is not."""
    found: list[Raw] = []

    def take(stream: Stream, messages: Messages) -> None:
        found.extend((stream.type, stream.topic, str(MessageEncoding.CDR), message) for message in messages)

    try:
        read_pieces(path, take)
    except InputError as error:
        raise LogError(str(error)) from None
    yield from found


def lost_of(path: Path) -> list[str]:
    """What of the MCAP files of a recording cannot be read, a sentence each."""
    files = _files(path) if path.is_dir() else [path]
    return [
        f"{file} is damaged or cut off, missing is {missing.text()}"
        for file in files
        if file.suffix == ".mcap"
        for missing in read_pieces(file, lambda stream, messages: None).missing
    ]


def _database(path: Path) -> Iterator[Raw]:
    if not path.is_file():
        raise FileNotFoundError(path)
    database = sqlite3.connect(f"{path.resolve().as_uri()}?mode=ro", uri=True)
    try:
        rows = database.execute(
            "SELECT topics.type, topics.name, topics.serialization_format, messages.data FROM messages "
            "JOIN topics ON messages.topic_id = topics.id ORDER BY messages.timestamp, messages.id"
        )
        for kind, topic, encoding, data in rows:
            yield str(kind).replace("/msg/", "/"), str(topic), str(encoding), bytes(data)
    finally:
        database.close()
