"""The report: its numbers are the recording's, and a browser shows what happened, from disk, without network."""

from __future__ import annotations

import base64
import dataclasses
import gzip
import importlib.util
import json
import re
import struct
import zlib
from pathlib import Path

import numpy as np
import pytest
import synthetic_run

from holonom.app.recording import Recorder, read_recording
from holonom.app.report import (
    ComparedRun,
    Comparison,
    Disc,
    LimitUse,
    Outcome,
    Phase,
    Scene,
    arm_shapes,
    gripper_shapes,
    write_report,
)
from holonom.app.report.findings.comparison import phase_errors
from holonom.errors import OutputError, UnknownName
from holonom.signals import Event

PIXELS = np.array([[40.0, 50, 40], [100, 60, 50], [300, 40, 60]])
DONE = Outcome(True, "3 of 3 coins sorted")


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folder with recording and report, the recording, the coins."""
    folder = tmp_path_factory.mktemp("run")
    coins = synthetic_run.coins_from(PIXELS)
    synthetic_run.record(folder / "recording.mcap", coins, leg=0.1)
    recording = read_recording(folder / "recording.mcap")
    write_report(
        folder / "report.html",
        recording,
        synthetic_run.scene(coins, photo=True),
        title="Sort <coins>",
        outcome=DONE,
        facts={"cycle time": "2.4 s"},
        limits=synthetic_run.limits(),
        photograph=synthetic_run.overlay(coins, grey_png(384, 303), 384, 303),
        program="\n".join(f"LINE {i}" for i in range(1, 20)),
    )
    return folder, recording, coins


def grey_png(width: int, height: int) -> bytes:
    """A grey ramp as a PNG file."""

    def chunk(kind: bytes, data: bytes) -> bytes:
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + bytes(x * 255 // width for x in range(width)) for _ in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows)) + chunk(b"IEND", b"")


def embedded(page: str) -> tuple[dict, dict[str, np.ndarray]]:
    """Data of a page, and its arrays (rows, columns)."""
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, re.DOTALL)[1])
    packed = re.search(r'id="blob">(.*?)</script>', page, re.DOTALL)[1]
    numbers = np.frombuffer(gzip.decompress(base64.b64decode(packed)), dtype="<f4")
    arrays = {
        name: numbers[at : at + rows * columns].reshape(columns, rows).T
        for name, (at, rows, columns) in data["index"].items()
    }
    return data, arrays


def test_page_holds_the_numbers_of_the_recording(run):
    folder, recording, _ = run
    data, arrays = embedded((folder / "report.html").read_text())
    assert data["end"] == recording.end()
    assert np.allclose(arrays["curve:position"], np.degrees(recording.joints.position), atol=1e-4)
    error = 1e3 * (recording.reference.position - recording.joints.position)
    assert np.allclose(arrays["curve:error"], error, atol=1e-5)
    assert np.allclose(arrays["curve:voltage"], recording.drives.voltage, atol=1e-5)
    assert np.allclose(arrays["curve:current"], recording.drives.current, atol=1e-5)


def test_replay_poses_are_the_recorded_ones_at_the_replay_rate(run):
    folder, recording, _ = run
    data, arrays = embedded((folder / "report.html").read_text())
    tool, track = arrays["frame:tool"], recording.frames["tool"]
    for k in (0, 31, 77):
        at = np.flatnonzero(track.time <= k / data["scene"]["rate"] + 1e-9)[-1]
        assert np.allclose(tool[k, :3], track.position[at], atol=1e-6)
        assert np.allclose(tool[k, 3:], track.quaternion[at], atol=1e-6)


def test_what_stands_still_is_stored_once(tmp_path, run):
    _, recording, coins = run
    still = Scene((Disc("link1", 0.1, 0.1, "#000"), Disc("coin_01", 0.01, 0.003, "#000")))
    write_report(tmp_path / "r.html", recording, still, title="t", outcome=DONE)
    _, arrays = embedded((tmp_path / "r.html").read_text())
    assert len(arrays["frame:coin_01"]) > 50
    write_report(tmp_path / "r.html", at_rest(tmp_path, coins), still, title="t", outcome=DONE)
    assert len(embedded((tmp_path / "r.html").read_text())[1]["frame:coin_01"]) == 1


def at_rest(folder: Path, coins) -> object:
    """A recording in which only the second coin moves."""
    synthetic_run.record(folder / "r.mcap", coins, leg=0.02)
    full = read_recording(folder / "r.mcap")
    track = full.frames["coin_01"]
    fixed = type(track)(track.time, 0 * track.position, 0 * track.quaternion + [0, 0, 0, 1.0])
    return dataclasses.replace(full, frames={**full.frames, "coin_01": fixed})


def test_same_run_same_page(run, tmp_path):
    _, recording, coins = run
    scene = synthetic_run.scene(coins, photo=False)
    for name in ("a.html", "b.html"):
        write_report(tmp_path / name, recording, scene, title="t", outcome=DONE)
    assert (tmp_path / "a.html").read_bytes() == (tmp_path / "b.html").read_bytes()


def test_text_is_escaped_and_nothing_is_fetched(run):
    page = (run[0] / "report.html").read_text()
    assert "<h1>Sort &lt;coins&gt;</h1>" in page
    assert not re.search(r"""(src|href)=["']?(https?:)?//""", page)
    assert "@import" not in page
    assert "{{" not in page.split("<script", 1)[0]


def test_photograph_and_program_are_there(run):
    page = (run[0] / "report.html").read_text()
    assert page.count("<circle cx=") == len(PIXELS)
    assert page.count("<li data-line=") == 19
    assert re.findall(r"</i>(\w+) <b>(\d+)</b>", page) == [("small", "1"), ("medium", "1"), ("large", "1")]


def test_limits_that_are_passed_stand_out(run, tmp_path):
    _, recording, coins = run
    use = LimitUse("Torque", "N m", np.array([1.0, 9.5, 11, 0, 0, 0]), np.full(6, 10.0))
    scene = synthetic_run.scene(coins, photo=False)
    write_report(tmp_path / "r.html", recording, scene, title="t", outcome=DONE, limits=[use])
    page = (tmp_path / "r.html").read_text()
    cells = re.findall(r'<td class="(\w+)" title="[^"]*N m">.*?<b>(\d+%)</b>', page)
    assert cells[:3] == [("fine", "10%"), ("near", "95%"), ("over", "110%")]


def test_unknown_frame_is_named(run, tmp_path):
    scene = Scene((Disc("coin_99", 0.01, 0.003, "#000"),))
    with pytest.raises(UnknownName, match="coin_99"):
        write_report(tmp_path / "r.html", run[1], scene, title="t", outcome=DONE)
    assert not (tmp_path / "r.html").exists()


def test_unknown_arm_is_named():
    with pytest.raises(UnknownName, match="did you mean 'puma560'"):
        arm_shapes("puma650")


def test_output_that_cannot_be_written(run, tmp_path):
    scene = synthetic_run.scene(run[2], photo=False)
    with pytest.raises(OutputError, match="cannot write the report"):
        write_report(tmp_path / "none" / "r.html", run[1], scene, title="t", outcome=DONE)


def test_fingers_and_palm_touch():
    """The palm ends where the fingers begin, and the palm's stem reaches the wrist flange at 0.055 m."""
    stem, palm, left, right = gripper_shapes(length=0.12)
    finger_top = left.pose[2, 3] - left.size[2] / 2
    assert palm.pose[2, 3] + palm.size[2] / 2 == pytest.approx(finger_top)
    assert stem.end[2] == pytest.approx(palm.pose[2, 3] - palm.size[2] / 2)
    assert stem.start[2] + 0.12 < 0.055
    assert left.pose[1, 3] - left.size[1] / 2 == right.pose[1, 3] + right.size[1] / 2 == 0


def circle(error: float) -> ComparedRun:
    angle = np.linspace(0, 2 * np.pi, 401)
    desired = np.stack([0.5 + 0 * angle, 0.1 * np.cos(angle), 0.6 + 0.1 * np.sin(angle)], axis=1)
    actual = desired + np.array([0, 0, error])
    phases = (Phase("first half", 0, np.pi), Phase("second half", np.pi, 2 * np.pi))
    return ComparedRun(f"off by {error}", angle, desired, actual, phases)


def test_comparison_states_errors_and_ratios(run, tmp_path):
    one, two = circle(0.002), circle(0.0005)
    assert phase_errors(one, one.phases[0]) == pytest.approx((0.002, 0.002))
    scene = synthetic_run.scene(run[2], photo=False)
    path = tmp_path / "r.html"
    write_report(path, run[1], scene, title="t", outcome=DONE, comparison=Comparison((one, two)))
    page = path.read_text()
    assert page.count("<b>4.0</b>") == 4
    assert page.count("<td>2.000</td>") == page.count("<td>0.500</td>") == 4
    assert page.count("<polyline") == 8
    assert "deviation × 10" in page
    lines = [np.array([p.split(",") for p in points.split()], dtype=float)
             for points in re.findall(r'<polyline[^>]*points="([^"]*)"', page)]  # fmt: skip
    units_per_metre = 0.72 * 300 / 0.2
    for i, error in ((0, 0.002), (2, 0.0005)):
        shift = lines[i + 1] - lines[i]
        assert np.allclose(shift, [0, -10 * error * units_per_metre], atol=0.11)


# ---------------------------------------------------------------- in a browser


def tool():
    path = Path(__file__).parents[2] / "tools" / "screenshot_report.py"
    spec = importlib.util.spec_from_file_location("screenshot_report", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def page(run):
    pytest.importorskip("selenium", reason="selenium is not installed")
    helper = tool()
    if helper.browser_programs() is None:
        pytest.skip("no chromium and chromedriver on the path: the report is not looked at")
    with helper.browser(1280, 900) as driver:
        helper.open_report(driver, run[0] / "report.html")
        yield driver


def ask(driver, script: str, *arguments):
    return driver.execute_script(f"return {script}", *arguments)


@pytest.mark.browser
def test_browser_shows_every_coin_where_it_was(run, page):
    recording = run[1]
    assert ask(page, "holonom.discs") == len(PIXELS)
    assert len(page.find_elements("css selector", ".photo circle")) == len(PIXELS)
    for time in (0.0, 1.0, 2.3):
        page.execute_script("holonom.seek(arguments[0])", time)
        for name in ("coin_01", "coin_02", "coin_03", "tool", "finger_left"):
            track = recording.frames[name]
            expected = track.position[np.flatnonzero(track.time <= time + 1e-9)[-1]]
            assert np.allclose(ask(page, "holonom.position(arguments[0])", name), expected, atol=1e-5)


@pytest.mark.browser
def test_browser_replay_moves_and_draws(page):
    page.execute_script("holonom.seek(0)")
    before = ask(page, "holonom.position('tool')")
    page.execute_script("holonom.state.speed = 0.25")
    page.execute_async_script(
        """const done = arguments[0], button = document.getElementById("play");
        button.click();
        const wait = () => {
            if (holonom.state.time < 0.15) return setTimeout(wait, 20);
            button.click();
            done();
        };
        wait();"""
    )
    assert not ask(page, "holonom.state.playing")
    assert ask(page, "holonom.state.time") < 2.0
    assert np.linalg.norm(np.subtract(ask(page, "holonom.position('tool')"), before)) > 0.01
    assert picture(page, 0.0) != picture(page, 1.2)


def picture(page, time: float) -> int:
    """Number for what the replay shows at `time`; the view must hold more than a few colours."""
    pixels = ask(
        page,
        """(() => {
            holonom.seek(arguments[0]);
            const copy = Object.assign(document.createElement("canvas"), { width: 300, height: 200 });
            const context = copy.getContext("2d");
            context.drawImage(document.getElementById("view"), 0, 0, 300, 200);
            return Array.from(context.getImageData(0, 0, 300, 200).data);
        })()""",
        time,
    )
    colours = np.unique(np.array(pixels, dtype=np.uint8).reshape(-1, 4), axis=0)
    assert len(colours) > 200
    return hash(bytes(pixels))


@pytest.mark.browser
def test_browser_marks_line_and_event(page):
    page.execute_script("holonom.seek(0.15)")
    assert page.find_element("css selector", ".program .current").text == "LINE 9"
    assert page.find_element("css selector", ".events .current").get_attribute("data-time") == "0.100"
    assert page.find_element("id", "event").text == "coin 1: down"


@pytest.mark.browser
def test_browser_draws_curves_of_every_joint(page):
    assert len(page.find_elements("css selector", ".plot .uplot canvas")) == 4
    names = [e.text for e in page.find_elements("css selector", "[data-curve=current] .u-legend .u-label")]
    assert names[1:] == list(synthetic_run.JOINTS)


@pytest.mark.browser
def test_browser_lays_out_without_overlap_or_overflow(page):
    assert ask(page, "document.documentElement.scrollWidth <= window.innerWidth")
    boxes = ask(
        page,
        "[...document.querySelectorAll('main > *')].map(e => e.getBoundingClientRect())"
        ".map(r => [r.left, r.top, r.right, r.bottom])",
    )
    for i, a in enumerate(boxes):
        for b in boxes[i + 1 :]:
            apart = a[2] <= b[0] or b[2] <= a[0] or a[3] <= b[1] or b[3] <= a[1]
            assert apart, (a, b)


@pytest.mark.browser
def test_browser_has_no_error_and_fetches_nothing(page):
    """Runs last: the log covers all that the tests above did."""
    fetched = ask(page, "performance.getEntriesByType('resource').map(entry => entry.name)")
    assert [name for name in fetched if not name.startswith(("data:", "blob:"))] == []
    bad = [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE" or "INVALID" in entry["message"]]
    assert bad == []


@pytest.mark.browser
def test_browser_opens_the_report_of_a_run_that_never_started(page, tmp_path):
    with Recorder(tmp_path / "r.mcap", synthetic_run.JOINTS) as recorder:
        recorder.put(Event(0.0, "error", "sort_coins.arps", "coin 1 is out of reach", 12))
    recording = read_recording(tmp_path / "r.mcap")
    scene = synthetic_run.scene(synthetic_run.coins_from(PIXELS), photo=False)
    outcome = Outcome(False, "stopped at line 12: coin 1 is out of reach")
    write_report(tmp_path / "r.html", recording, scene, title="Sort coins", outcome=outcome)
    tool().open_report(page, tmp_path / "r.html")
    assert page.find_element("id", "empty").is_displayed()
    assert page.find_element("css selector", ".outcome.bad").text == outcome.text
    assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []
