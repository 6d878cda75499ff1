"""What is left of a recording: of a killed run, on a full disk, after damage."""

from __future__ import annotations

import itertools
import os
import random
import re
import signal
import struct
import subprocess
import sys
import time
import zlib
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
import zstandard
from mcap.exceptions import McapError
from mcap.records import Channel, Chunk, Message
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

from holonom.app.recording import COMPLETE, CUT_OFF, EPOCH, Missing, Recorder, read_recording
from holonom.app.recording.format.messages import JointMessage, joint_layout
from holonom.errors import InputError, OutputFault
from holonom.signals import BaseState, EncoderCounts, Event, FramePoses, JointState

FAULTS = Path(os.environ.get("HOLONOM_DATA", "../shared/data")) / "faults"
BOUND = 0.1
"""s of simulated time that a killed run may lose."""

WRITER = """
import os, sys, numpy as np
from holonom.app.recording import Recorder
from holonom.signals import EncoderCounts, JointState

def run(path):
    rng = np.random.default_rng(0)
    with Recorder(path, ("a", "b", "c"), attachments={"cell.json": b"{}"}) as recorder:
        k = 0
        while True:
            t = 0.01 * k
            recorder.put(JointState(t, *rng.normal(size=(3, 3))))
            recorder.put(EncoderCounts(t, np.array([k, k, k])))
            os.write(1, f"{t:.2f}\\n".encode())
            k += 1

for line in sys.stdin:
    child = os.fork()
    if child == 0:
        run(line.strip())
    os.write(1, f"pid {child}\\n".encode())
    os.waitpid(child, 0)
    os.write(1, b"killed\\n")
"""


class Writers:
    """A process that starts runs, one after the other, to be killed."""

    def __init__(self) -> None:
        pipe = subprocess.PIPE
        self.process = subprocess.Popen([sys.executable, "-c", WRITER], stdin=pipe, stdout=pipe, text=True)

    def kill_a_run(self, path: Path, after: float) -> float:
        """Kill a run; return the last simulated time of which both records were taken."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        print(path, file=self.process.stdin, flush=True)
        times, pid = [], None
        while len(times) < 2 or pid is None:
            line = self.process.stdout.readline()
            if line.startswith("pid"):
                pid = int(line.split()[1])
            else:
                times.append(float(line))
        time.sleep(after)
        os.kill(pid, signal.SIGKILL)
        while (line := self.process.stdout.readline()) != "killed\n":
            times.append(float(line))
        return times[-1]


def by_mcap(path: Path) -> dict[str, float]:
    """Last time of each topic, s, by the library's own reader of unfinished files."""
    names, last = {}, {}
    with path.open("rb") as stream:
        try:
            for record in StreamReader(stream).records:
                if isinstance(record, Channel):
                    names[record.id] = record.topic
                elif isinstance(record, Message):
                    last[names[record.channel_id]] = (record.log_time - EPOCH) / 1e9
        except (McapError, struct.error, IndexError):  # as it ends where the kill fell into a write
            pass
    return last


def test_a_killed_run_can_be_read(tmp_path: Path) -> None:
    rng, writers = random.Random(5), Writers()
    for k in range(20):
        path = tmp_path / f"{k}.mcap"
        reached = writers.kill_a_run(path, rng.uniform(0.0, 0.1))
        read = read_recording(path)
        assert read.ended == CUT_OFF
        assert read.end() >= reached - BOUND - 1e-9
        assert read.attachments == {"cell.json": b"{}"}
        counts = read.counts
        if len(counts.time):  # else it was killed between the first two records
            assert counts.count[:, 0].tolist() == list(range(len(counts.time)))
        assert min(by_mcap(path).values(), default=0.0) >= reached - BOUND - 1e-9
    writers.process.communicate()


def write(path: Path, ticks: int = 100) -> Path:
    with Recorder(path, ("a",), attachments={"cell.json": b"[1]"}, metadata={"robot": {"drive": "omni"}}) as recorder:
        for k in range(ticks):
            recorder.put(JointState(0.01 * k, *np.full((3, 1), float(k))))
        recorder.metadata("outcome", {"outcome": "done"})
    return path


def test_attachments_and_metadata_come_back(tmp_path: Path) -> None:
    read = read_recording(write(tmp_path / "r.mcap"))
    assert read.ended == COMPLETE
    assert read.attachments == {"cell.json": b"[1]"}
    assert read.metadata == {"robot": {"drive": "omni"}, "outcome": {"outcome": "done"}}


def test_cut_at_every_place(tmp_path: Path) -> None:
    """What is there before the cut comes back; nothing is made up."""
    data = write(tmp_path / "r.mcap").read_bytes()
    before = 0
    for size in range(len(data) - 1, 30, -37):
        (tmp_path / "cut.mcap").write_bytes(data[:size])
        read = read_recording(tmp_path / "cut.mcap")
        assert read.ended == CUT_OFF
        values = read.joints.position.ravel().tolist()
        assert values == [float(k) for k in range(len(values))]
        before = max(before, len(values))
    assert before == 100
    for tail in (b"\0" * 100, b"\xff" * 100, bytes(range(100))):
        (tmp_path / "tail.mcap").write_bytes(data[: len(data) // 2] + tail)
        assert read_recording(tmp_path / "tail.mcap").ended == CUT_OFF


def read_or_said(path: Path) -> tuple[list[float], list[Missing], str]:
    """Positions and what is missing, or the sentence instead."""
    try:
        read = read_recording(path)
    except InputError as error:
        return [], [], str(error)
    return read.joints.position.ravel().tolist(), list(read.missing), ""


def test_a_flipped_bit_is_never_believed(tmp_path: Path) -> None:
    """Any bit: what is read is right, and what is not there is said to be missing, from when to when."""
    data = write(tmp_path / "r.mcap").read_bytes()
    rng, lost, path = random.Random(1), 0, tmp_path / "b.mcap"
    for _ in range(3000):
        broken = bytearray(data)
        broken[rng.randrange(len(data))] ^= 1 << rng.randrange(8)
        path.write_bytes(broken)
        values, missing, said = read_or_said(path)
        assert (str(path) in said) == bool(said)
        gone = sorted({float(k) for k in range(100)} - set(values))
        assert values == [float(k) for k in range(100) if k not in gone]
        for k in gone:
            assert said or any(
                (m.since is None or m.since < 0.01 * k) and (m.until_then is None or 0.01 * k < m.until_then)
                for m in missing
            ), (missing, gone)
        lost += bool(gone)
        assert not gone or said or len(gone) <= 12 or missing[0].since is None  # no more than the chunk it is in
    assert lost > 500


def test_one_damaged_chunk_takes_no_other_with_it(tmp_path: Path) -> None:
    """Whatever is written over a tenth of a second: all the rest is there, with the topics of the file's end."""
    data = write(tmp_path / "r.mcap").read_bytes()
    marks = (m.start() - 37 for m in re.finditer(re.escape(b"\x04\0\0\0zstd"), data))
    starts = [at for at in marks if data[at] == 6][:10]  # the index at the end names the compression, too
    assert len(starts) == 10
    rng = random.Random(2)
    for k in range(10):
        for fill in (b"\0" * 64, b"\xff" * 64, rng.randbytes(64)):
            at = starts[k] + rng.choice((0, 1, 9, 45, 60))
            broken = data[:at] + fill + data[at + 64 :]
            (tmp_path / "b.mcap").write_bytes(broken)
            read = read_recording(tmp_path / "b.mcap")
            values = read.joints.position.ravel().tolist()
            assert len(values) >= 89
            assert len(read.missing) == 1, read.missing
            (missing,) = read.missing
            assert missing.since == (None if k == 0 else pytest.approx(0.1 * k - 0.01 * (k > 0)))
            assert missing.text().startswith("from the beginning to" if k == 0 else "from 0")
            assert read.ended == COMPLETE
            assert read.attachments
            assert read.metadata["outcome"] == {"outcome": "done"}


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


class Full:
    """A device that has room for so many bytes."""

    def __init__(self, file, room: int) -> None:
        self.file, self.room, self.closed = file, room, False

    def write(self, data) -> int:
        if self.room <= 0:
            raise OSError(28, "No space left on device")
        taken = self.file.write(bytes(data[: self.room]))
        self.room -= taken
        return taken

    def fileno(self) -> int:
        return self.file.fileno()

    def close(self) -> None:
        self.closed = True
        self.file.close()


@pytest.mark.parametrize("room", [0, 10, 3000, 9000])
def test_full_disk(tmp_path: Path, room: int) -> None:
    """One sentence at the first record that could not be kept; what was before is whole."""
    path = tmp_path / "r.mcap"
    recorder = Recorder(path, ("a",))
    recorder._stream._file = Full(recorder._stream._file, room)
    faults = []
    for k in itertools.count():
        try:
            recorder.put(JointState(0.01 * k, *np.full((3, 1), float(k))))
        except OutputFault as fault:
            faults.append(str(fault))
        if faults and k > 200:
            break
    recorder.put(Event(3.0, "error", "run", "the disk is full"))
    recorder.metadata("outcome", {"outcome": "failed"})
    recorder.close()
    recorder.close()
    assert len(faults) == 1
    assert "No space left on device" in faults[0]
    assert "is kept" in faults[0]
    read = read_recording(path)
    assert read.ended == CUT_OFF
    values = read.joints.position.ravel().tolist()
    assert values == [float(k) for k in range(len(values))]
    assert len(values) % 10 == 0
    assert bool(values) == (room >= 3000)


def test_full_disk_at_the_start() -> None:
    with pytest.raises(OutputFault, match="No space left"):
        Recorder("/dev/full", ("a",))


def test_full_disk_at_the_end(tmp_path: Path) -> None:
    def run() -> None:
        with Recorder(tmp_path / "r.mcap", ("a",)) as recorder:
            recorder.put(EncoderCounts(0.0, np.array([1])))
            recorder._stream._file = Full(recorder._stream._file, 100)

    with pytest.raises(OutputFault, match="No space left"):
        run()
    assert read_recording(tmp_path / "r.mcap").ended == CUT_OFF


def test_bytes_do_not_depend_on_the_clock(tmp_path: Path) -> None:
    def slow(path: Path) -> bytes:
        with Recorder(path, ("a",)) as recorder:
            for k in range(30):
                recorder.put(JointState(0.01 * k, *np.full((3, 1), float(k))))
                time.sleep(0.002 if k % 7 == 0 else 0.0)
        return path.read_bytes()

    def fast(path: Path) -> bytes:
        with Recorder(path, ("a",)) as recorder:
            for k in range(30):
                recorder.put(JointState(0.01 * k, *np.full((3, 1), float(k))))
        return path.read_bytes()

    assert slow(tmp_path / "a.mcap") == fast(tmp_path / "b.mcap")
