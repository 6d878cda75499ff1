"""Recordings of strangers: of other tools, with topics like ours, with nonsense that a checksum vouches for."""

from __future__ import annotations

import os
import random
import re
import struct
import time
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.records import Chunk
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from holonom.app.recording import CUT_OFF, EPOCH, Recorder, read_recording
from holonom.app.recording.format.messages import JointMessage, joint_layout
from holonom.errors import InputError
from holonom.signals import BaseState, EncoderCounts, Event, FramePoses, JointState

FAULTS = Path(os.environ.get("HOLONOM_DATA", "../shared/data")) / "faults"


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.LZ4, CompressionType.NONE])
def test_a_cut_recording_of_another_tool_is_read_to_the_cut(compression: CompressionType, tmp_path: Path) -> None:
    """In one chunk of several megabytes, as other tools write them: all messages before the cut."""
    path, layout = tmp_path / "r.mcap", joint_layout(JointMessage(("a",), 3))
    noise = np.random.default_rng(3).normal(size=(20_000, 3))
    with path.open("wb") as stream:
        writer = Writer(stream, compression=compression, chunk_size=2**26)
        writer.start(profile="ros2", library="another")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"")
        channel = writer.register_channel("/joint_states", "cdr", schema)
        for k, values in enumerate(noise):
            writer.add_message(channel, log_time=k * 10**6, publish_time=0, data=layout.pack(k * 10**6, values))
        writer.finish()
    whole = path.read_bytes()
    assert len(read_recording(path).joints.time) == 20_000
    with path.open("rb") as stream:
        (packed,) = (r.data for r in StreamReader(stream, emit_chunks=True).records if isinstance(r, Chunk))
    (tmp_path / "cut.mcap").write_bytes(whole[: whole.index(packed) + int(0.57 * len(packed))])
    read = read_recording(tmp_path / "cut.mcap")
    count = len(read.joints.time)
    assert 0.5 * 20_000 < count < 0.6 * 20_000
    assert np.array_equal(read.joints.position[:, 0], noise[:count, 0])
    assert read.ended == CUT_OFF
    assert read.missing[-1].text() == f"from {1e-3 * (count - 1):g} s on: it ends within a chunk"


def chunk(data: bytes, *, size: int | None = None, compression: str = "", crc: int | None = None) -> bytes:
    """An MCAP file of one chunk, its checksum right unless given."""
    size, crc = len(data) if size is None else size, zlib.crc32(data) if crc is None else crc
    name = compression.encode()
    body = struct.pack("<QQQII", 0, 2**63, size, crc, len(name)) + name + struct.pack("<Q", len(data)) + data
    end = struct.pack("<BQQQI", 2, 20, 0, 0, 0)
    return b"\x89MCAP0\r\n" + struct.pack("<BQ", 6, len(body)) + body + end + b"\x89MCAP0\r\n"


def records(path: Path) -> bytes:
    """What stands in the chunks of a recording, unpacked."""
    with path.open("rb") as stream:
        chunks = [r for r in StreamReader(stream, emit_chunks=True).records if isinstance(r, Chunk)]
    return b"".join(
        zstandard.ZstdDecompressor().decompress(c.data, max_output_size=c.uncompressed_size) for c in chunks
    )


def test_what_a_checksum_vouches_for_may_be_nonsense_too(tmp_path: Path) -> None:
    """Bytes of messages, lengths, channels and counts changed before they were packed: a reading, or a named error."""
    path = tmp_path / "r.mcap"
    with Recorder(path, ("a", "b")) as recorder:
        for k in range(20):
            recorder.put(JointState(0.01 * k, *np.full((3, 2), float(k))))
            recorder.put(EncoderCounts(0.01 * k, np.array([k, k])))
            recorder.put(FramePoses(0.01 * k, ("x", "y"), np.stack([np.eye(4)] * 2)))
            recorder.put(BaseState(0.01 * k, np.zeros(3), np.zeros(3), np.eye(3)))
            recorder.put(Event(0.01 * k, "info", "program", f"step {k}", 1))
    data, rng, partial = records(path), random.Random(4), 0
    assert len(read_recording(write_bytes(path, chunk(data))).joints.time) == 20
    for _ in range(2000):
        broken = bytearray(data)
        for _ in range(rng.choice((1, 1, 1, 4))):
            at = rng.randrange(len(data))
            broken[at : at + 1] = rng.choice((b"\0", b"\xff", b"\x80", rng.randbytes(1)))
        with suppress(InputError):
            partial += bool(read_recording(write_bytes(path, chunk(bytes(broken)))).missing)
    assert partial > 200


@pytest.mark.parametrize(
    ("topic", "data", "said"),
    [
        ("/signals/.", b"\0\1\0\0\1", 0),
        ("/signals/", b"\0\1\0\0\1", 0),
        ("/signals/" + 10 * "9", b"\0\1\0\0\1", 0),
        ("/signals/3", b"", 1),
        ("/truth/odom", b"\0\1\0\0\1", 1),
    ],
)
def test_a_topic_that_looks_like_ours_and_is_not(topic: str, data: bytes, said: int, tmp_path: Path) -> None:
    path = tmp_path / "r.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start("ros2")
        for k, (name, body) in enumerate([("/signals/7", b"\0\1\0\0\1"), (topic, data)]):
            channel = writer.register_channel(name, "cdr", 0)
            writer.add_message(channel, EPOCH + k, body, EPOCH + k)
        writer.finish()
    found = read_recording(path)
    assert [(signal.number, signal.on) for signal in found.signals] == [(7, True)]
    assert len(found.missing) == said
    assert topic not in found.tracks


def write_bytes(path: Path, data: bytes) -> Path:
    path.write_bytes(data)
    return path


def test_what_states_more_than_it_holds_is_not_unpacked(tmp_path: Path) -> None:
    """A chunk of zeros by the gigabyte, counts of four thousand million, a time beyond every clock."""
    path = tmp_path / "r.mcap"
    bomb = zstandard.ZstdCompressor(level=19).compress(bytes(2**28))
    assert len(bomb) < 50_000
    for size in (2**28, 2**34, 2**63, 10):
        with pytest.raises(InputError, match="damaged, and nothing in it can be read: a chunk"):
            read_recording(write_bytes(path, chunk(bomb, size=size, compression="zstd")))
    with pytest.raises(InputError, match="compression 'gzip'"):
        read_recording(write_bytes(path, chunk(bomb, compression="gzip")))
    recorder = Recorder(path, ("a",))
    recorder.put(JointState(0.0, *np.zeros((3, 1))))
    recorder.put(FramePoses(0.0, ("x",), np.eye(4)[None]))
    recorder.close()
    data = records(path)
    for old, new in ((b"\x01\0\0\0", b"\xff\xff\xff\xff"), (b"\x02\0\0\0", b"\xff\xff\xff\x7f")):
        for found in re.finditer(re.escape(old), data):
            broken = data[: found.start()] + new + data[found.end() :]
            begin = time.perf_counter()
            with suppress(InputError):
                read_recording(write_bytes(path, chunk(broken)))
            assert time.perf_counter() - begin < 1.0


@pytest.mark.skipif(not FAULTS.exists(), reason="no shared data")
def test_damaged_files_of_users() -> None:
    """Three whose only chunk is broken, and one that ends in a record: by the library's own checksums."""
    for k in range(1, 4):
        with pytest.raises(InputError, match=rf"mcap_{k}.bin is damaged, and nothing in it can be read: a chunk"):
            read_recording(FAULTS / f"mcap_{k}.bin")
    read = read_recording(FAULTS / "mcap_4.bin")
    assert read.ended == CUT_OFF
    assert len(read.joints.time) == 3
    assert read.missing[-1].text() == "from 0.02 s on: it ends within a record"
