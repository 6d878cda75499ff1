"""`holonom report`: all of a run's report comes from its recording, new or old, whole or cut off."""

from __future__ import annotations

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest
from report_jobs import (
    ARM,
    END,
    HOME,
    SLIP_EVENTS,
    arm_job,
    arm_records,
    base_job,
    base_records,
    coin_records,
    done,
    job_of,
    write,
)
from test_report import ask, embedded, grey_png, tool

from holonom import registry
from holonom.app.console.cli import main
from holonom.app.console.output import RunFolder
from holonom.app.recording import Recorder, read_recording, read_robots
from holonom.app.recording.format import pieces
from holonom.app.report import Detection, Figures, PhotoOverlay, Scene, Table, section_table
from holonom.app.report.attached import cell_of, ending_of, photograph_of, recorded_scene
from holonom.app.report.attachments import attachments_of, cell_facts
from holonom.app.report.drawing.embed import CURVE_SAMPLES
from holonom.app.report.drawing.inferred_scene import inferred_scene
from holonom.app.report.drawing.scene_text import scene_json, scene_of, scene_text
from holonom.app.report.findings.peaks import limit_uses
from holonom.app.report.findings.summary import summary_of
from holonom.app.report.findings.tracking import arm_of
from holonom.app.report.reporting import report_html
from holonom.app.report.section_table import Section
from holonom.app.report.source import source_of
from holonom.errors import InputError
from holonom.mechanics import load_arm
from holonom.registry import OWN, Method
from holonom.signals import Event, FramePoses, JointState
from holonom.sim import BaseFault

COUNTED = {"waist": {"peak_speed": 1.5, "peak_torque": 40.0, "peak_error": 0.01, "rms_error": 0.002}}


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An arm and a base in one cell."""
    job = job_of(arm_job("puma"), base_job("agv", [BaseFault(1.5, 0), BaseFault(9.0, "rear right", "blocked")]))
    records = {
        "": list(coin_records()),
        "puma": list(arm_records()),
        "agv": [*base_records(), *SLIP_EVENTS, Event(1.5, "warning", "plant", "the motor of front left dies"),
                Event(1.53, "error", "motor watch", "the motor of front left does not do as told; driving on")],
    }  # fmt: skip
    folder = tmp_path_factory.mktemp("two")
    ending = done(joints={"puma": COUNTED}, numbers={"agv": {"path_driven": 1.0}})
    return write(folder / "recording.mcap", job, records, ending)


def test_what_is_put_into_a_recording_comes_out_of_it(tmp_path: Path) -> None:
    photo = PhotoOverlay(
        grey_png(8, 6), 8, 6, (Detection(1.5, 2, 3, "a", 0.1, 0.2, 0.01, "coin_01"),), {"a": "#123"}, "x"
    )
    job = dataclasses.replace(job_of(arm_job("puma"), base_job("agv", [BaseFault(1.0, 2)])), photograph=photo)
    ending = done(status="failed", reason="it <broke>", joints={"puma": COUNTED}, numbers={"agv": {"path_driven": 0.5}})
    recording = read_recording(write(tmp_path / "r.mcap", job, {"": list(coin_records())}, ending))
    assert cell_of(recording) == cell_facts(job)
    assert ending_of(recording) == ending
    read = photograph_of(recording)
    assert read is not None
    assert dataclasses.asdict(read) == dataclasses.asdict(photo)
    scene = recorded_scene(recording)
    assert scene is not None
    assert scene_json(scene) == scene_json(job.scene)
    assert scene.frames() == job.scene.frames()
    assert recording.attachments["puma/program.arps"].decode() == "\n".join(job.arms[0].program.lines)
    assert attachments_of(job) == attachments_of(job)  # equal runs, equal bytes


def test_the_recorded_arm_is_the_arm() -> None:
    arm = load_arm("puma560").with_tool(np.diag([1.0, 1, 1, 1]) + 0.1 * np.eye(4, k=3))
    facts = cell_facts(job_of(dataclasses.replace(arm_job(), arm=arm))).robots[0].arm
    assert facts is not None
    q = np.random.default_rng(4).uniform(-2, 2, (20, 6))
    assert np.allclose(arm_of(facts).fk(q), arm.fk(q), atol=1e-12)


@pytest.mark.parametrize("name", ["cell.json", "scene.json"])
def test_words_that_cannot_be_read_are_named(name: str, tmp_path: Path) -> None:
    files = attachments_of(job_of(base_job())) | {name: b'{"shapes": 3}'}
    with Recorder(tmp_path / "recording.mcap", attachments=files):
        pass
    source = source_of(tmp_path / "recording.mcap")
    assert re.match(rf"the recording's {re.escape(name)} cannot be read", source.lost[0])
    page = report_html(source)
    assert f"{name} cannot be read" in page[page.index('id="missing"') :]
    assert summary_of(source)["missing"] == list(source.lost)


def test_a_page_has_sections_of_every_robot(two: Path) -> None:
    page = report_html(source_of(two))
    found = re.findall(r'<section id="([^"]*)"', page)
    wanted = {"robots", "path-agv", "faults-agv", "polar-agv", "curves-puma", "curves-agv", "limits-puma", "log"}
    assert wanted < set(found)
    assert len(found) == len(set(found))
    assert "<h1>a &lt;test&gt;</h1>" in page
    assert "The drives are sized." in page
    data, arrays = embedded(page)
    assert len({curve["key"] for curve in data["curves"]}) == len(data["curves"])
    assert np.allclose(arrays["curve:puma:position"][0], np.degrees(HOME + 0.2 * np.sin(0.0)), atol=1e-4)
    assert np.allclose(arrays["curve:agv:path_error"], 10.0, atol=1e-4)
    assert ["rear left slips" in event[3] for event in data["events"]].count(True) == 1  # the truth is no word
    assert [event[4] for event in data["events"] if event[3] == "a swing"] == ["puma"]


def test_every_note_is_a_line(tmp_path: Path) -> None:
    job = dataclasses.replace(job_of(arm_job()), notes=("at most 2 m/s2", "q: its <model>"))
    page = report_html(source_of(write(tmp_path / "recording.mcap", job, {"": list(arm_records())}, done())))
    assert '<ul class="notes"><li>at most 2 m/s2</li><li>q: its &lt;model&gt;</li></ul>' in page


def test_events_say_whose_they_are(two: Path, tmp_path: Path) -> None:
    """Of several robots, in the list and in the replay; one that is alone is not named."""
    page = report_html(source_of(two))
    assert "<th>line</th><th>robot</th><th>source</th>" in page
    assert "<td>puma</td><td>program</td><td>a swing</td>" in page
    assert "<td>agv</td><td>plant</td><td>the motor of front left dies</td>" in page
    whose = {event[3]: event[4] for event in embedded(page)[0]["events"]}
    assert (whose["a swing"], whose["the motor of front left dies"]) == ("puma", "agv")
    alone = report_html(source_of(write(tmp_path / "r.mcap", job_of(arm_job()), {"": list(arm_records())}, done())))
    assert "<th>line</th><th>source</th>" in alone
    assert "<td>2</td><td>program</td><td>a swing</td>" in alone


def test_ideal_drives_have_no_currents(tmp_path: Path) -> None:
    """Their noughts are no measurements: neither limits nor curves show them, and the summary says nothing of them."""
    job = job_of(dataclasses.replace(arm_job(), drives="ideal"))
    still = np.zeros(6)
    records = [JointState(k / 100, HOME, still, still) for k in range(100)]
    nought = {"peak_speed": 0.5, "peak_torque": 0.0, "peak_current": 0.0, "peak_voltage": 0.0}
    ending = done(joints={"": dict.fromkeys(ARM.limits.names, nought)})
    source = source_of(write(tmp_path / "recording.mcap", job, {"": records}, ending))
    page, waist = report_html(source), summary_of(source)["joints"]["waist"]
    assert [use.quantity for use in limit_uses(source.robots[0])] == ["Joint speed"]
    assert not {"current", "voltage", "effort"} & {curve["key"] for curve in embedded(page)[0]["curves"]}
    assert waist["peak_speed_rad_s"] == 0.5
    assert {waist[f"peak_{name}"] for name in ("torque_Nm", "current_A", "voltage_V")} == {None}


def test_the_summary_tells_all(two: Path) -> None:
    said = summary_of(source_of(two))
    json.dumps(said, allow_nan=False)
    agv, puma = said["robots"]["agv"], said["robots"]["puma"]
    assert (said["outcome"], said["failure"], said["placed"]) == ("done", None, {"small": 1})
    assert said["cycle_time_per_part_s"] == END
    (slip,) = agv["slips"]
    assert slip["wheel"] == "rear left"
    assert slip["right"]
    assert slip["delay"] == pytest.approx(0.008)
    assert slip["peak"] == pytest.approx(0.2)
    assert [(motor["wheel"], motor["reached"]) for motor in agv["dead_motors"]] == [
        ("front left", True),
        ("rear right", False),
    ]
    assert agv["dead_motors"][0]["detected"] == pytest.approx(1.53)
    assert agv["false_alarms"] == []
    assert agv["path_errors"][0]["rms_m"] == pytest.approx(0.01)
    assert agv["path_errors"][0]["believed_peak_m"] == pytest.approx(0.002)
    assert puma["joints"]["waist"]["peak_speed_rad_s"] == 1.5  # as counted
    assert puma["joints"]["elbow"]["peak_speed_rad_s"] == pytest.approx(0.2)  # as recorded
    assert puma["joints"]["waist"]["speed_limit_rad_s"] == ARM.limits.speed[0]


def test_limits_that_a_cell_keeps_below_are_those_of_the_model() -> None:
    slow = dataclasses.replace(arm_job(), arm=ARM.with_limits(speed=0.5))
    limits = cell_facts(job_of(slow), rated=[ARM]).robots[0].limits["speed"]
    assert limits == tuple(ARM.limits.speed)


def test_runs_beside_it_are_taken_along_if_they_are_of_the_same_cell(tmp_path: Path) -> None:
    job = job_of(arm_job(controllers=("cascade", "computed_torque")))
    write(tmp_path / "recording_cascade.mcap", job, {"": list(arm_records(lag=0.02))}, done(), 0)
    path = write(tmp_path / "recording.mcap", job, {"": list(arm_records(lag=0.005))}, done())
    other = dataclasses.replace(job, seed=job.seed + 1)
    write(tmp_path / "recording_other.mcap", other, {"": list(arm_records(lag=0.5))}, done(), 0)
    (phase,) = summary_of(source_of(path))["tracking"]
    assert phase["phase"] == "a swing"
    assert set(phase["rms_m"]) == {"cascade", "computed torque"}
    assert phase["ratio"] == pytest.approx(4.0, rel=0.02)
    assert '<section id="comparison"' in report_html(source_of(path))


def test_the_same_run_without_handling_is_beside_that_of_a_base(tmp_path: Path) -> None:
    job = job_of(base_job())
    write(tmp_path / "recording_without_handling.mcap", job, {"": list(base_records(aside=0.3))})
    path = write(tmp_path / "recording.mcap", job, {"": [*base_records(), *SLIP_EVENTS]}, done())
    whole = summary_of(source_of(path))["path_errors"][0]
    assert (whole["peak_m"], whole["peak_without_handling_m"]) == (pytest.approx(0.01), pytest.approx(0.3))
    page = report_html(source_of(path))
    assert "peak without handling" in page
    assert "300.0 mm" in page


@pytest.mark.parametrize("part", [0.02, 0.3, 0.6])
def test_what_is_left_of_a_killed_run_is_reported(part: float, two: Path, tmp_path: Path, capsys) -> None:
    cut = tmp_path / "recording.mcap"
    cut.write_bytes(two.read_bytes()[: int(part * two.stat().st_size)])
    assert main(["report", str(cut), "-o", str(tmp_path / "out"), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["outcome"] == "cut off"
    assert "the run was killed, or is still going" in said["failure"]
    assert 'class="outcome bad">cut off at ' in Path(said["report"]).read_text("utf-8")
    assert not (tmp_path / "out" / "summary.json").exists()


def test_a_report_beside_its_recording_leaves_the_rest(two: Path, capsys) -> None:
    before = two.read_bytes()
    (two.parent / "summary.json").write_text("{}")
    assert main(["report", str(two)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert said[:2] == ["a <test>: all is done after 2.0 s of simulated time", "1 of 1 parts in the tray: 1 small"]
    assert "agv: 0.80 s: rear left slips; found after 8 ms, named after 8 ms" in said
    assert "agv: 1.50 s: motor of front left dead; found after 30 ms" in said
    assert "agv: 9.00 s: motor of rear right blocked; the run ended before" in said
    assert "agv: whole run: path error rms 10.0 mm, peak 10.0 mm" in said
    assert two.read_bytes() == before
    assert (two.parent / "summary.json").read_text() == "{}"
    first = (two.parent / "report.html").read_bytes()
    assert main(["report", str(two)]) == 0
    assert (two.parent / "report.html").read_bytes() == first
    assert str(two.parent / "report.html") in capsys.readouterr().out


def test_a_folder_that_a_run_writes_to_is_refused(two: Path, tmp_path: Path, capsys) -> None:
    with RunFolder(tmp_path):
        assert main(["report", str(two), "-o", str(tmp_path)]) == 2
    assert "writes to the output folder" in capsys.readouterr().err


@pytest.mark.parametrize("how", ["missing", "text"])
def test_what_is_no_recording_is_bad_input(how: str, two: Path, tmp_path: Path, capsys) -> None:
    path = tmp_path / "recording.mcap"
    if how == "text":
        path.write_text("time,position\n")
    assert main(["report", str(path), "-o", str(tmp_path / "out")]) == 2
    assert str(path) in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_damaged_recording_is_reported_as_far_as_it_goes(two: Path, tmp_path: Path, capsys) -> None:
    path, data = tmp_path / "recording.mcap", bytearray(two.read_bytes())
    data[len(data) // 2 : len(data) // 2 + 64] = bytes(64)
    path.write_bytes(data)
    assert main(["report", str(path), "-o", str(tmp_path / "out")]) == 0
    said = re.search(r"missing from the recording: from ([\d.]+) s to ([\d.]+) s: a chunk", capsys.readouterr().out)
    assert 0.0 < float(said[1]) < float(said[2]) < float(said[1]) + 0.3
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert 'id="missing"' in page
    assert 'class="outcome ok">all is done' in page


def test_reading_block_by_block_gives_the_same(two: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = read_robots(two)
    monkeypatch.setattr(pieces, "BLOCK", 3000)
    parts = read_robots(two)
    assert set(whole) == set(parts) == {"", "puma", "agv"}
    for name, recording in whole.items():
        other = parts[name]
        assert recording.events == other.events
        assert recording.signals == other.signals
        assert {*recording.frames} == {*other.frames}
        for frame, track in recording.frames.items():
            assert np.array_equal(track.poses(), other.frames[frame].poses())
        for topic, track in recording.tracks.items():
            assert np.array_equal(track.time, other.tracks[topic].time)
            for field, values in track.fields.items():
                assert np.array_equal(values, other.tracks[topic].fields[field])
    assert np.array_equal(whole["puma"].joints.position, read_recording(two, robot="puma").joints.position)
    assert "agv/base_link" in whole[""].frames
    assert "base_link" in whole["agv"].frames


def test_long_curves_keep_their_peaks_and_long_replays_are_thin(tmp_path: Path) -> None:
    count = 3 * CURVE_SAMPLES + 17
    rng = np.random.default_rng(5)
    values = rng.normal(size=count)
    values[12_345] = 99.0
    with Recorder(tmp_path / "recording.mcap", ("a",)) as out:
        for k, value in enumerate(values):
            out.put(JointState(0.1 * k, np.array([value]), np.zeros(1), np.zeros(1)))
            T = np.eye(4)
            T[0, 3] = np.sin(0.01 * k)
            out.put(FramePoses(0.1 * k, ("tool",), T[None]))
    data, arrays = embedded(report_html(source_of(tmp_path / "recording.mcap")))
    shown = arrays["curve:position"][:, 0]
    assert CURVE_SAMPLES / 2 < len(shown) <= CURVE_SAMPLES
    assert np.max(shown) == pytest.approx(np.degrees(99.0), rel=1e-6)
    assert np.min(shown) == pytest.approx(np.degrees(values.min()), rel=1e-6)
    time = arrays[data["curves"][0]["time"]][:, 0]
    assert time[np.argmax(shown)] == pytest.approx(1234.5, abs=0.1 * 2 * count / len(shown))
    rows, rate = len(arrays["frame:tool"]), data["scene"]["rate"]
    assert rows <= 130_000
    assert rows / rate == pytest.approx(data["end"], abs=2.0 / rate)


def test_a_scene_is_the_same_after_its_file() -> None:
    scene = job_of(arm_job(), base_job("agv")).scene
    assert json.loads(scene_text(scene_of(scene_text(scene)))) == json.loads(scene_text(scene))
    with pytest.raises(InputError, match=r"scene\.json"):
        scene_of(b"[]")
    assert inferred_scene({}) == Scene((), tool="world")


@pytest.mark.browser
def test_browser_shows_two_robots(two: Path, tmp_path: Path) -> None:
    pytest.importorskip("selenium", reason="selenium is not installed")
    helper = tool()
    if helper.browser_programs() is None:
        pytest.skip("no chromium and chromedriver on the path: the report is not looked at")
    (tmp_path / "r.html").write_text(report_html(source_of(two)), "utf-8")
    with helper.browser(1280, 900) as page:
        helper.open_report(page, tmp_path / "r.html")
        page.execute_script("holonom.seek(1.0)")
        assert np.allclose(ask(page, "holonom.position('agv/base_link')"), [1.0, 0.01, 0.0], atol=1e-5)
        assert page.find_element("css selector", ".program .current code").text.strip() == "SIGNAL 1"
        assert len(page.find_elements("css selector", ".plot .uplot canvas")) == 4 + 10
        assert ask(page, "document.documentElement.scrollWidth <= window.innerWidth")
        assert [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"] == []


def test_a_section_more_is_a_function_and_a_line(two: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    table = section_table.REPORT_SECTIONS
    mine = Section(lambda source: source.told, lambda source: [Figures("mine", "Mine", [Table(("a",), [("b",)])])])
    rows = {name: table[name] for name in table} | {"mine": Method("mine", lambda _: mine, OWN)}
    monkeypatch.setattr(section_table, "REPORT_SECTIONS", registry.Table("report_sections", "section", "", rows))
    source = source_of(two)
    assert '<section id="mine"' in report_html(source)
    assert '<section id="mine"' not in report_html(dataclasses.replace(source, told=False))


def test_joints_that_slide_have_lengths(tmp_path: Path) -> None:
    scara = load_arm("scara")
    job = job_of(dataclasses.replace(arm_job(), arm=scara, program=None))
    (facts,) = cell_facts(job).robots
    assert "prismatic" in facts.kinds
    slide = facts.kinds.index("prismatic")
    path = tmp_path / "recording.mcap"
    with Recorder(path, facts.joints, attachments=attachments_of(job)) as out:
        for k in range(3):
            out.put(JointState(0.01 * k, np.full(scara.n, 0.05 * k), np.full(scara.n, 0.5), np.zeros(scara.n)))
    source = source_of(path)
    said = summary_of(source)["joints"][facts.joints[slide]]
    assert said["peak_speed_m_s"] == 0.5
    _, arrays = embedded(report_html(source))
    assert np.allclose(arrays["curve:position_slide"][:, 0], [0.0, 50.0, 100.0])
    assert arrays["curve:position"].shape == (3, scara.n - facts.kinds.count("prismatic"))


def test_a_recording_of_a_century_is_no_page_of_gigabytes(tmp_path: Path) -> None:
    """One stamp far off, as a damaged message without a checksum has it."""
    path = tmp_path / "recording.mcap"
    with Recorder(path) as recorder:
        for time in (0.0, 0.1, 3.0e9):
            recorder.put(FramePoses(time, ("base_link",), np.eye(4)[None] * [[1.0], [1.0], [1.0], [1.0]]))
            recorder.put(FramePoses(time, ("arm",), pose_at(time)[None]))
    assert len(report_html(source_of(path))) < 3_000_000


def pose_at(time: float) -> np.ndarray:
    T = np.eye(4)
    T[0, 3] = time % 7.0
    return T
