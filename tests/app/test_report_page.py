"""The page as a whole: its badge, its sections by what a recording holds, its escapes, its long tables."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import re
from base64 import b64decode
from collections.abc import Iterator
from html import unescape
from pathlib import Path

import numpy as np
import pytest
import synthetic_run
from report_jobs import SLIP_EVENTS, arm_job, arm_records, base_job, base_records, done, job_of, write
from test_report import embedded, grey_png

from holonom import registry
from holonom.app import report
from holonom.app.recording import Recorder, read_recording
from holonom.app.report import Detection, LimitUse, Outcome, PhotoOverlay, Scene, section_table, write_report
from holonom.app.report.drawing.event_log import event_rows, events_html
from holonom.app.report.drawing.figures import Figures, Table, figures_html
from holonom.app.report.drawing.limit_table import LimitGroups, LimitTable, limit_groups_html
from holonom.app.report.findings import headline
from holonom.app.report.findings.facts import Ending
from holonom.app.report.markup import Html, colour, html, joined, script_json
from holonom.app.report.parts import CurveGroup
from holonom.app.report.reporting import report_html
from holonom.app.report.section import faults, polar
from holonom.app.report.section import path as path_section
from holonom.app.report.section_table import REPORT_SECTIONS, Section
from holonom.app.report.source import source_of
from holonom.registry import OWN, Method
from holonom.signals import Event, Record

HOSTILE = (
    "</SCRIPT><IMG SRC=x ONERROR=document.title='owned'>",
    "<!--<script",
    "javascript:document.title='owned'",
    "\"'><svg onload=document.title='owned'>",
    "line\u2028line\u2029&amp;{0} {{title}} \x1b[31m\x00",
)


def of_arm(folder: Path, ending: Ending | None = None) -> Path:
    return write(folder / "recording.mcap", job_of(arm_job()), {"": list(arm_records())}, ending)


def sections(page: str) -> list[str]:
    return [name for name in re.findall(r'<section id="([^"]*)"', page) if name != "replay"]


# ---------------------------------------------------------------- the badge


@pytest.mark.parametrize(
    ("status", "reason", "tone"),
    [
        ("done", "program ended", "ok"),
        ("paused", "program at PAUSE", "held"),
        ("stopped", "stopped by the operator", "held"),
        ("failed", "elbow: following error 12 deg", "bad"),
        ("failed", "the solver gave up after 100 steps", "bad"),
        ("failed", "agv tips over", "bad"),
        ("failed", "time limit of 60 s reached", "bad"),
        ("time limit", "not done after 60 s", "bad"),
        ("something that no version knows", "", "bad"),
    ],
)
def test_the_badge_says_how_it_ended(status: str, reason: str, tone: str, tmp_path: Path) -> None:
    page = report_html(source_of(of_arm(tmp_path, done(status=status, reason=reason))))
    assert re.findall(r'<p class="outcome (\w+)">([^<]*)</p>', page) == [(tone, reason or status)]


def test_the_badge_of_a_recording_that_says_nothing_is_neither(tmp_path: Path) -> None:
    assert 'class="outcome unsaid">recorded to ' in report_html(source_of(of_arm(tmp_path)))


def test_the_badge_of_an_error_in_the_log_is_red(tmp_path: Path) -> None:
    records = [*arm_records(end=0.1), Event(0.1, "error", "drive", "the elbow's drive failed")]
    path = write(tmp_path / "recording.mcap", job_of(arm_job()), {"": records})
    assert 'class="outcome bad">the elbow&#x27;s drive failed' in report_html(source_of(path))


# ---------------------------------------------------------------- sections


def test_every_section_has_a_file_and_a_line() -> None:
    folder = Path(section_table.__file__).parent / "section"
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == set(REPORT_SECTIONS)


def test_what_writes_the_page_knows_no_kinds() -> None:
    for name in ("page", "parts", "reporting"):
        text = (Path(report.__file__).parent / f"{name}.py").read_text("utf-8")
        assert not re.search(r"\bkind\b|\"arm\"|\"base\"", text), name


def test_a_recording_of_an_arm_has_no_sections_of_bases(tmp_path: Path) -> None:
    assert set(sections(report_html(source_of(of_arm(tmp_path, done()))))) == {"robots", "curves", "limits", "log"}


def test_a_recording_of_a_base_has_no_sections_of_arms(tmp_path: Path) -> None:
    records = [*base_records(), *SLIP_EVENTS]
    page = report_html(source_of(write(tmp_path / "recording.mcap", job_of(base_job()), {"": records}, done())))
    assert set(sections(page)) == {"robots", "path", "faults", "polar", "base", "curves", "limits", "log"}
    assert "Motor current" in page
    assert "Joint" not in "".join(curve["title"] for curve in embedded(page)[0]["curves"])


def test_a_section_without_anything_to_show_is_not_there(tmp_path: Path) -> None:
    path = write(tmp_path / "recording.mcap", job_of(arm_job()), {"": []}, done())
    assert sections(report_html(source_of(path))) == ["robots"]


def broken(*_: object) -> None:
    raise ZeroDivisionError("a <bug> is here\nsecond line")


@pytest.mark.parametrize("how", ["applies", "parts", "make", "drawing"])
def test_a_section_that_fails_leaves_the_others(how: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    mine = {
        "applies": Section(broken, lambda source: ()),
        "parts": Section(lambda source: True, broken),
        "make": None,
        "drawing": Section(lambda source: True, lambda source: [CurveGroup([object()], "mine", "Mine")]),
    }[how]
    make = broken if mine is None else lambda _: mine
    rows = {"mine": Method("mine", make, OWN)} | {name: REPORT_SECTIONS[name] for name in REPORT_SECTIONS}
    monkeypatch.setattr(section_table, "REPORT_SECTIONS", registry.Table("report_sections", "section", "", rows))
    page = report_html(source_of(of_arm(tmp_path, done())))
    assert sections(page) == ["mine", "robots", "curves", "limits", "log"]
    assert embedded(page)[0]["curves"]
    said = re.search(r'<section id="mine" class="card unshown">.*?</section>', page, re.DOTALL)[0]
    assert "could not be made" in said
    if how != "drawing":
        assert "ZeroDivisionError: a &lt;bug&gt; is here" in said
    assert "second line" not in said


def test_a_base_that_cannot_be_judged_still_has_a_page(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Its findings fail in the head and in every section that is made of them; the others are there."""
    source = source_of(write(tmp_path / "recording.mcap", job_of(base_job()), {"": list(base_records())}, done()))
    for module in (headline, path_section, faults, polar):
        monkeypatch.setattr(module, "findings_of", broken)
    page = report_html(source)
    assert re.findall('<section id="([^"]*)" class="card unshown"', page) == ["robots", "path", "faults", "polar"]
    assert {"base", "curves", "limits"} < set(sections(page))


# ---------------------------------------------------------------- text is text


def test_only_markup_is_markup() -> None:
    assert html("<b title='{}'>{}</b>", "\"'", "<i>") == "<b title='&quot;&#x27;'>&lt;i&gt;</b>"
    assert html("{}{:.1f}", Html("<i>"), 2.0) == "<i>2.0"
    assert joined([html("{}", "<"), Html("<br>")], "|") == "&lt;|<br>"
    assert isinstance(joined([]), Html)
    assert html("{}", "a\x1b[31m\x00b") == r"a\x1b[31m\x00b"
    with pytest.raises(AssertionError, match="does not use"):
        html("<p>", "forgotten")


@pytest.mark.parametrize("text", HOSTILE)
def test_data_for_the_script_cannot_end_it(text: str) -> None:
    data = script_json({text: [text]})
    assert not re.search("[<>&\u2028\u2029\x00-\x1f]", data)
    assert json.loads(data) == {text: [text]}


@pytest.mark.parametrize("text", ["red;background:url(//x)", "expression(1)", "#12", "", "var(--ink);x"])
def test_what_is_no_colour_is_none(text: str) -> None:
    assert colour(text) == "#64748b"
    assert colour("#a1B2c3") == "#a1B2c3"
    assert colour("var(--ink)") == "var(--ink)"


def test_text_is_escaped_in_one_place() -> None:
    folder = Path(report.__file__).parent
    texts = {path.name: path.read_text("utf-8") for path in folder.rglob("*.py")}
    assert [name for name, text in texts.items() if "from html import" in text] == ["markup.py"]
    assert not [name for name, text in texts.items() if "Html(f" in text]
    own = "".join(p.read_text() for p in (folder / "assets").glob("*.js") if not p.name.endswith(".min.js"))
    assert not re.search(r"innerHTML|outerHTML|insertAdjacentHTML|document\.write|\beval\(|new Function", own)


def test_the_policy_lets_just_the_scripts_of_the_page_run(tmp_path: Path) -> None:
    page = report_html(source_of(of_arm(tmp_path, done())))
    said = unescape(re.search(r'http-equiv="Content-Security-Policy" content="([^"]*)"', page)[1])
    rules = {rule.split()[0]: rule.split()[1:] for rule in said.split("; ")}
    scripts = re.findall(r"<script>(.*?)</script>", page, re.DOTALL)
    hashes = [hashlib.sha256(script.encode()).digest() for script in scripts]
    assert [b64decode(value.strip("'").removeprefix("sha256-")) for value in rules["script-src"]] == hashes
    assert len(hashes) == 2
    assert rules["default-src"] == ["'none'"]
    assert rules["img-src"] == ["data:", "blob:"]
    assert not re.search(r"<[^>]*\son\w+=", page.split("<script", 1)[0])


def hostile_page(folder: Path) -> Path:
    """A report of which every text that comes from elsewhere would rather be script."""
    bad, comment, link, quote, line = HOSTILE
    records: list[Record] = [
        *arm_records(),
        *(Event(0.5 + k / 10, "info", text, text, 1) for k, text in enumerate(HOSTILE)),
    ]
    photo = PhotoOverlay(
        grey_png(8, 6),
        8,
        6,
        (Detection(1.5, 2, 3, bad, 0.1, 0.2, 0.01, quote),),
        {bad: "red;background:url(//x)"},
        line,
    )
    scene = Scene((report.Label("world", np.eye(4), bad, 0.05), report.Disc("link1", 0.1, 0.1, quote)), tool="link1")
    job = dataclasses.replace(
        job_of(arm_job()), name=bad, description=line, notes=HOSTILE, photograph=photo, scene=scene,
    )  # fmt: skip
    path = write(folder / "recording.mcap", job, {"": records}, done(reason=bad))
    source = source_of(path)
    facts = dataclasses.replace(source.robots[0].facts, model=bad, controller=comment, drives=link)
    robot = dataclasses.replace(source.robots[0], facts=facts, name=bad)
    named = dataclasses.replace(robot.recording, joint_names=(*HOSTILE, "flange"))
    robot = dataclasses.replace(robot, recording=named)
    out = folder / "report.html"
    out.write_text(report_html(dataclasses.replace(source, robots=(robot,))), "utf-8")
    return out


def test_hostile_words_are_words(tmp_path: Path) -> None:
    page = hostile_page(tmp_path).read_text("utf-8")
    body = re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
    assert not re.search(r"<img (?!id=\"photo\")|<svg onload|<!--", body, re.IGNORECASE)
    assert len(re.findall(r"<script", body, re.IGNORECASE)) == 2  # data and blob
    assert "onerror" in body.lower()  # as a word
    assert "{{title}}" in page  # what looks like a place of ours is none


# ---------------------------------------------------------------- long tables


def test_repeated_lines_are_one_with_a_count() -> None:
    events = [Event(0.1 * k, "info", "program", "again", 3) for k in range(5)] + [Event(0.7, "info", "program", "x", 3)]
    rows, numbers = event_rows(events)
    assert [(row.event.text, row.count, row.last) for row in rows] == [("again", 5, 0.4), ("x", 1, 0.7)]
    assert numbers == [0] * 5 + [1]
    page = events_html(events)
    assert page.count("<tr class=") == 2
    assert "× 5, to 0.40 s" in page


def test_what_robots_say_between_does_not_part_repeated_lines() -> None:
    events = [Event(0.1 * k, "info", f"{'ab'[k % 2]}.program", "on", 1) for k in range(6)]
    rows, numbers = event_rows(events, ("a", "b"))
    assert [row.count for row in rows] == [3, 3]
    assert numbers == [0, 1] * 3


def many() -> Iterator[Event]:
    for k in range(200):
        yield Event(0.1 * k, "info", f"{('a', 'b', 'cell')[k % 3]}.program", f"step {k}", k)


def test_a_long_log_of_several_robots_is_grouped() -> None:
    page = events_html(list(many()), ("a", "b"))
    groups = re.findall(r'<details class="group"( open)?><summary>(\w+) <small>(\d+) lines', page)
    assert groups == [(" open", "a", "67"), ("", "b", "67"), ("", "cell", "66")]
    assert sorted(map(int, re.findall(r'data-row="(\d+)"', page))) == list(range(200))
    assert "<details" not in events_html(list(many())[:30], ("a", "b"))


def test_limits_of_several_robots_are_grouped_and_long_tables_scroll() -> None:
    names = [f"joint {k}" for k in range(30)]
    use = LimitUse("speed", "rad/s", np.ones(30), np.full(30, 2.0))
    tables = [(name, LimitTable(names, [use], f"limits-{name}")) for name in ("a", "b")]
    page = limit_groups_html(LimitGroups(tables))
    assert re.findall(r'<details class="group" id="([^"]*)"( open)?>', page) == [
        ("limits-a", " open"),
        ("limits-b", ""),
    ]
    assert page.count("<tr><th>joint") == 60
    assert 'class="plain scroll"' in figures_html(Figures("f", "F", [Table(("a",), [("b",)] * 40)]))


def test_an_outcome_that_is_handed_in_has_its_colour(tmp_path: Path) -> None:
    with Recorder(tmp_path / "r.mcap", synthetic_run.JOINTS):
        pass
    for ok, tone in ((True, "ok"), (False, "bad")):
        write_report(
            tmp_path / "r.html", read_recording(tmp_path / "r.mcap"), Scene(()), title="t", outcome=Outcome(ok, "x")
        )
        assert f'<p class="outcome {tone}">x</p>' in (tmp_path / "r.html").read_text("utf-8")


def test_a_loop_in_a_long_log_is_shown_once() -> None:
    loop = ["MOVE a", "MOVE b", "MOVE b", "CLOSE"]
    texts = ["READY", *loop * 30, "MOVE a", "STOP"]
    events = [Event(0.1 * k, "info", "program", text, 1) for k, text in enumerate(texts)]
    rows, numbers = event_rows(events)
    assert [(row.event.text, row.count) for row in rows] == [
        ("READY", 1), ("MOVE a", 30), ("MOVE b", 60), ("CLOSE", 30), ("MOVE a", 1), ("STOP", 1),
    ]  # fmt: skip
    assert [rows[number].event.text for number in numbers] == texts
    assert rows[3].last == pytest.approx(0.1 * (4 * 30))
    short, _ = event_rows(events[:13])  # as it came: there is no need
    assert len(short) == 1 + 3 * 3


def test_nothing_turns_a_line_around() -> None:
    """Marks of direction (Unicode annex 9) are shown by number, in markup and in what scripts put into the page."""
    for number in (0x61C, 0x200E, 0x200F, *range(0x202A, 0x202F), *range(0x2066, 0x206A), 0x1B, 0x9B, 0x7F):
        mark = chr(number)
        shown = ascii(mark)[1:-1]
        assert html("<h1>{}</h1>", f"a{mark}b") == f"<h1>a{shown}b</h1>"
        if number in (0x1B, 0x9B, 0x7F):  # to a script they are data, and a browser shows none of them
            continue
        read = json.loads(script_json({"name": f"a\\{mark}b"}))
        assert mark not in read["name"]
        assert read["name"].startswith("a\\\\")
        assert read["name"].endswith(f"{number:x}b")
    assert json.loads(script_json("\\u202e \n √")) == "\\u202e \n √"
