"""Every string of a cell, a program, a recording of others and a robot file in a real browser: none of it runs."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import Writer
from test_report import ask, tool

from holonom.app.console.cli import main
from holonom.app.recording.format.messages import (
    JointMessage,
    joint_layout,
    log_message,
    odometry_layout,
    odometry_values,
    transform_layout,
)
from holonom.app.recording.format.schemas import schema_text
from holonom.mechanics import Arm, load_arm
from holonom.plots import arm_page
from holonom.signals import Event

pytestmark = pytest.mark.browser

BAD = (
    "</SCRIPT><IMG SRC=x ONERROR=window['PWN']=1>",
    "<!--<script>window['PWN']=1</script>",
    "\"'><svg onload=window['PWN']=1>",
    "javascript:window['PWN']=1",
    "${window['PWN']=1}{{title}}{0}&lt;script&gt;\u2028\x1b[31m",
)


@pytest.fixture(scope="module")
def page():
    pytest.importorskip("selenium", reason="selenium is not installed")
    helper = tool()
    if helper.browser_programs() is None:
        pytest.skip("no chromium and chromedriver on the path: nothing is looked at")
    with helper.browser(1280, 900) as found:
        found.helper = helper
        yield found


def check_page(page, path: Path) -> None:
    """Nothing ran, nothing was asked of the network, no element came out of a string, the replay works."""
    page.get_log("browser")
    page.helper.open_report(page, path)
    for time in (0.0, 0.05, 0.5):
        page.execute_script("holonom.seek(arguments[0])", time)
    assert ask(page, "window.PWN === undefined")
    assert ask(page, "document.querySelectorAll('img:not(#photo), svg[onload], [onerror], iframe, object').length") == 0
    assert ask(page, "[...document.querySelectorAll('a')].every(a => !a.href.startsWith('javascript'))")
    assert ask(page, "performance.getEntriesByType('resource').filter(r => !r.name.startsWith('data:')).length") == 0
    assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []
    assert page.find_element("tag name", "footer").is_displayed()


def quoted(text: str) -> str:
    return json.dumps(text)


def test_no_string_of_a_cell_or_program_is_script(page, tmp_path: Path) -> None:
    cell = f"""
[cell]
name = {quoted(BAD[0] + BAD[4])}
description = {quoted(BAD[1] + BAD[2])}
time_limit = "2s"

[[robot]]
name = "arm"
model = "planar2r"
drives = "ideal"
program = {{ file = "p.arps" }}

[[robot]]
name = "base"
model = {{ arrangement = "omni", radius = "100mm", wheel_radius = "30mm", n = 3, mass = "5kg", wheels = {
        json.dumps([*BAD[:3]])
    } }}
pose = {{ position = ["2m", "2m", "0mm"], angle = "0deg" }}
hold = "200ms"

[[surface]]
name = {quoted(BAD[2])}
pose = {{ position = ["400mm", "-300mm", "-2m"], angle = "0deg" }}
size = ["400mm", "600mm"]

[[obstacle]]
name = {quoted(BAD[1])}
pose = {{ position = ["5m", "5m", "0mm"], angle = "0deg" }}
size = ["100mm", "100mm", "100mm"]

[[patch]]
name = {quoted(BAD[3])}
centre = ["4m", "4m"]
radius = "100mm"
friction = 0.1
sliding_friction = 0.05
"""
    (tmp_path / "cell.toml").write_text(cell, "utf-8")
    typed = "\n".join(f'TYPE "{text.replace(chr(34), "")}"   ; {text}' for text in BAD)
    (tmp_path / "p.arps").write_text(f".PROGRAM main()\n{typed}\nSIGNAL 1\n.END\n", "utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    check_page(page, tmp_path / "out" / "report.html")
    words = page.find_element("tag name", "body").text
    assert BAD[0] in words
    assert BAD[2] in words


def test_a_program_that_fails_is_told_in_words(page, tmp_path: Path) -> None:
    (tmp_path / "cell.toml").write_text(
        f'[cell]\nname = {quoted(BAD[0])}\ntime_limit = "2s"\n[[robot]]\nmodel = "planar2r"\ndrives = "ideal"\n'
        f'program = "p.arps"\n',
        "utf-8",
    )
    line = f"x = 1 / 0 ; {BAD[0]} {BAD[1]}"
    (tmp_path / "p.arps").write_text(f".PROGRAM main()\n{line}\n.END\n", "utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 1
    check_page(page, tmp_path / "out" / "report.html")


def test_no_string_of_a_recording_of_others_is_script(page, tmp_path: Path) -> None:
    """Topics, joints, frames, sources and texts of a log, attachments, metadata, and the file's folder."""
    folder = tmp_path / "<img src=x onerror=window['PWN']=1>"
    folder.mkdir()
    path = folder / "recording_<svg onload=window['PWN']=1>.mcap"
    joints = joint_layout(JointMessage((*BAD, "j"), 3, BAD[0]))
    frames = transform_layout([("world", text) for text in BAD] + [(BAD[0], BAD[1])])
    odometry = odometry_layout((BAD[2], BAD[0]))
    kinds = {
        "/joint_states": "sensor_msgs/JointState", "/truth/tf": "tf2_msgs/TFMessage", "/rosout": "rcl_interfaces/Log",
        "/odom": "nav_msgs/Odometry", f"/{BAD[2]}": "sensor_msgs/JointState",
    }  # fmt: skip
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile=BAD[0], library=BAD[1])
        for text in BAD:
            writer.add_attachment(0, 0, text, text, text.encode())
            writer.add_metadata(text, {text: text})
        writer.add_metadata("outcome", {"status": BAD[0], "reason": BAD[2], "simulated_time_s": "1.0"})
        channels = {}
        for topic, kind in kinds.items():
            schema = writer.register_schema(kind.replace("/", "/msg/"), "ros2msg", schema_text(kind).encode())
            words = {"robot": BAD[1], "kind": "measured"} if topic.startswith("/<") else {}
            channels[topic] = writer.register_channel(topic, "cdr", schema, words)
        pose = np.tile([0.0, 0, 0, 0, 0, 0, 1], len(BAD) + 1)
        for k in range(60):
            now = 10**9 * 1_700_000_000 + k * 10**7
            event = Event(now / 1e9, "error", BAD[k % 5], BAD[(k + 1) % 5], k % 3)
            data = {
                "/joint_states": joints.pack(now, np.full(3 * (len(BAD) + 1), 0.01 * k)),
                "/truth/tf": frames.pack(now, pose), "/rosout": log_message(now, event),
                "/odom": odometry.pack(now, odometry_values(np.full(3, 0.1 * k), np.zeros(3), np.eye(3))),
                f"/{BAD[2]}": joints.pack(now, np.full(3 * (len(BAD) + 1), 0.01 * k)),
            }  # fmt: skip
            for topic, message in data.items():
                writer.add_message(channels[topic], log_time=now, publish_time=now, data=message)
        writer.finish()
    assert main(["report", str(path), "-o", str(tmp_path / "out")]) == 0
    check_page(page, tmp_path / "out" / "report.html")
    assert BAD[0] in page.find_element("tag name", "body").text


def test_a_robot_files_name_is_no_script_on_a_page_to_turn(page, tmp_path: Path) -> None:
    pytest.importorskip("plotly", reason="Plotly is not installed; pip install -e '.[plots]'")
    arm = load_arm("planar2r")
    model = dataclasses.replace(arm.model, name=f'{BAD[0]}<a href="{BAD[3]}">here</a>')
    arm_page(Arm(model), np.zeros((2, 2)), save=tmp_path / "arm.html")
    page.get((tmp_path / "arm.html").resolve().as_uri())
    assert ask(page, "window.PWN === undefined")
    assert ask(
        page, "[...document.querySelectorAll('a')].every(a => !(a.getAttribute('xlink:href') || '').includes('PWN'))"
    )
    assert ask(page, "document.querySelectorAll('.gtitle a, .gtitle img').length") == 0
    assert "IMG SRC" in page.find_element("css selector", ".gtitle").get_attribute("textContent")
