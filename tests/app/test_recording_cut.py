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
from pathlib import Path

import numpy as np
import pytest
from mcap.exceptions import McapError
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from holonom.app.recording import COMPLETE, CUT_OFF, EPOCH, Missing, Recorder, read_recording
from holonom.errors import InputError, OutputFault
from holonom.signals import EncoderCounts, Event, JointState

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
