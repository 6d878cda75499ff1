"""`holonom report` of recordings that say little of themselves: old ones, other tools', empty ones."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import Writer
from report_jobs import SLIP_EVENTS, arm_job, arm_records, base_job, base_records, job_of, write
from test_report import embedded

from holonom.app.recording import Recorder
from holonom.app.recording.format.cdr import CdrWriter
from holonom.app.recording.reader import FORMER
from holonom.app.report.drawing.scene import Tube
from holonom.app.report.findings.base_findings import findings_of
from holonom.app.report.findings.summary import summary_of
from holonom.app.report.reporting import report_html
from holonom.app.report.source import source_of


def test_an_empty_recording_has_a_report(tmp_path: Path) -> None:
    with Recorder(tmp_path / "recording.mcap"):
        pass
    page = report_html(source_of(tmp_path / "recording.mcap"))
    assert re.findall('<section id="([^"]*)"', page) == ["replay"]  # what has nothing to show is not there


def as_old(path: Path, out: Path) -> Path:
    """The recording as it would have been written before topics said what they are."""
    called = {new: old for old, new in FORMER.items()}
    with path.open("rb") as source, out.open("wb") as target:
        writer, channels = Writer(target), {}
        writer.start(profile="ros2", library="holonom")
        for schema, channel, message in make_reader(source).iter_messages():
            name = called.get(channel.topic, channel.topic)
            if name.startswith("/truth/odom"):
                continue
            if name not in channels:
                kind = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[name] = writer.register_channel(name, channel.message_encoding, kind)
            writer.add_message(channels[name], message.log_time, message.data, message.publish_time)
        writer.finish()
    return out


def test_an_old_recording_has_a_report(tmp_path: Path) -> None:
    """Without truth events slip is found in the wheels' true slip; the replay is put together from frames."""
    events = [event for event in SLIP_EVENTS if event.source != "truth"]
    new = write(tmp_path / "new.mcap", job_of(base_job()), {"": [*base_records(), *events]})
    source = source_of(as_old(new, tmp_path / "recording.mcap"))
    assert not source.told
    assert source.scene.tool == "base_link"
    assert {"base_link", "wheel_1", "wheel_4"} <= set(source.scene.frames())
    (slip,) = findings_of(source.whole, source.robots[0].facts).slips
    assert (slip.wheel, slip.named) == ("rear left", ("rear left",))
    assert slip.start == pytest.approx(0.8, abs=0.02)
    assert slip.peak == pytest.approx(0.2)
    assert summary_of(source)["path_errors"][0]["rms_m"] == pytest.approx(0.01)
    page = report_html(source)
    for section in ("path", "faults", "curves", "log"):
        assert f'<section id="{section}"' in page


def test_links_are_joined_by_tubes_that_end_at_the_next_one(tmp_path: Path) -> None:
    new = write(tmp_path / "new.mcap", job_of(arm_job()), {"": list(arm_records())})
    source = source_of(as_old(new, tmp_path / "recording.mcap"))
    frames = source.whole.frames
    tubes = [s for s in source.scene.shapes if isinstance(s, Tube) and s.frame.startswith("link") and s.rounded]
    assert len(tubes) == 3  # the wrist's three frames have one origin, and so do the first two
    origins = np.stack([frames[f"link{k}"].position for k in range(1, 7)])
    for tube in tubes:
        end = frames[tube.frame].poses() @ np.array([*tube.end, 1.0])
        assert np.linalg.norm(origins - end[None, :, :3], axis=2).max(axis=1).min() < 1e-6


def foreign(path: Path, begin: float = 1.7e9) -> Path:
    """Joint states as another tool writes them: dates, a frame in the header, no velocities; and another topic."""
    with path.open("wb") as out:
        writer = Writer(out)
        writer.start(profile="ros2", library="other")
        kind = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", b"std_msgs/Header header")
        joints = writer.register_channel("/joint_states", "cdr", kind)
        text = writer.register_channel("/odom", "json", writer.register_schema("x", "jsonschema", b"{}"))
        for k in range(50):
            now = round((begin + 0.02 * k) * 1e9)
            data = CdrWriter().stamp(now).text("base").uint32(2).text("a").text("b").uint32(2).doubles(2).uint32(0)
            layout = data.uint32(2).doubles(2).layout()
            message = layout.pack(now, np.array([0.1 * k, 1.0, 5.0, 6.0]))
            writer.add_message(joints, now, message, now)
            writer.add_message(text, now, b'{"x": 1}', now)
        writer.finish()
    return path


def test_joint_states_of_another_tool_are_drawn(tmp_path: Path) -> None:
    source = source_of(foreign(tmp_path / "recording.mcap"))
    page = report_html(source)
    data, arrays = embedded(page)
    assert data["end"] == pytest.approx(0.98, abs=1e-6)
    assert [(curve["key"], curve["names"]) for curve in data["curves"]] == [
        ("position", ["a", "b"]),
        ("effort", ["a", "b"]),
    ]
    assert np.allclose(arrays["curve:position"][10], np.degrees([1.0, 1.0]), atol=1e-4)
    assert source.scene.shapes == ()
    json.dumps(summary_of(source), allow_nan=False)
