"""What a browser makes of reports: of hostile words, without WebGL, in the dark, in a narrow window."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from report_jobs import SLIP_EVENTS, arm_job, arm_records, base_job, base_records, done, job_of, write
from test_report import ask, tool
from test_report_page import HOSTILE, hostile_page

from holonom.app.console.cli import main
from holonom.app.recording import read_recording
from holonom.app.report.reporting import report_html
from holonom.app.report.source import source_of
from holonom.signals import Event, Record

pytestmark = pytest.mark.browser


@pytest.fixture(scope="module")
def helper():
    pytest.importorskip("selenium", reason="selenium is not installed")
    found = tool()
    if found.browser_programs() is None:
        pytest.skip("no chromium and chromedriver on the path: the report is not looked at")
    return found


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Of an arm and a base, with a long log of lines that come again."""
    folder = tmp_path_factory.mktemp("two")
    talk = [Event(0.01 * k, "info", "program", f"step {k // 2}", 1) for k in range(200)]
    records: dict[str, list[Record]] = {
        "puma": [*arm_records(), *talk], "agv": [*base_records(), *SLIP_EVENTS], "": [],
    }  # fmt: skip
    path = write(folder / "recording.mcap", job_of(arm_job("puma"), base_job("agv")), records, done())
    (folder / "report.html").write_text(report_html(source_of(path)), "utf-8")
    return folder / "report.html"


def severe(page) -> list[object]:
    return [entry for entry in page.get_log("browser") if entry["level"] == "SEVERE"]


def test_nothing_in_a_recording_can_be_script(helper, tmp_path: Path) -> None:
    """The page is complete, its title is its own, no dialog came up, and the policy had nothing to stop."""
    path = hostile_page(tmp_path)
    with helper.browser(1280, 900) as page:
        helper.open_report(page, path)
        assert page.title == f"{HOSTILE[0]} · Holonom"
        assert page.find_element("tag name", "h1").text == HOSTILE[0]
        assert page.find_element("css selector", ".outcome").text == HOSTILE[0]
        assert len(page.find_elements("css selector", ".plot .uplot canvas")) >= 3
        labels = [e.text for e in page.find_elements("css selector", ".plot .u-legend .u-label")]
        assert HOSTILE[0] in labels
        words = [e.text for e in page.find_elements("css selector", ".events td:last-child")]
        assert HOSTILE[0] in words
        assert HOSTILE[1] in words
        for time in (0.0, 0.55, 0.65, 2.0):
            page.execute_script("holonom.seek(arguments[0])", time)
        assert ask(page, "document.images.length") == 1  # the photograph
        assert ask(page, "document.querySelectorAll('svg[onload], [onerror], a, iframe, object').length") == 0
        assert page.find_element("tag name", "footer").is_displayed()
        assert ask(page, "document.documentElement.scrollWidth <= window.innerWidth")
        assert severe(page) == []
        page.execute_script(
            "const s = document.createElement('script'); try { s.textContent = 'document.title = \"owned\"'; } catch {}"
            "document.body.append(s)"
        )
        assert page.title == f"{HOSTILE[0]} · Holonom"  # nor could it be, were it markup


def test_without_webgl_the_replay_is_flat(helper, report: Path) -> None:
    recording = read_recording(report.parent / "recording.mcap")
    with helper.browser(1280, 900, webgl=False) as page:
        helper.open_report(page, report)
        assert ask(page, "holonom.flat")
        assert not page.find_element("id", "empty").is_displayed()
        assert "no WebGL" in page.find_element("id", "hint").text
        pictures = []
        for time in (0.0, 1.0):
            page.execute_script("holonom.seek(arguments[0])", time)
            track = recording.frames["agv/base_link"]
            there = track.position[np.flatnonzero(track.time <= time + 1e-9)[-1]]
            assert np.allclose(ask(page, "holonom.position('agv/base_link')"), there, atol=1e-5)
            pictures.append(ask(page, "document.getElementById('view').toDataURL()"))
        assert pictures[0] != pictures[1]
        inked = ask(
            page,
            "(() => { const c = document.getElementById('view'), w = c.width / 2;"
            "const data = (x) => c.getContext('2d').getImageData(x, 0, w, c.height).data;"
            "return [0, w].map(x => data(x).filter(v => v).length) })()",
        )
        assert min(inked) > 2000  # both views show something
        assert len(page.find_elements("css selector", ".plot .uplot canvas")) == 4 + 10
        assert severe(page) == []


def test_with_webgl_it_is_not(helper, report: Path) -> None:
    """Also the log in groups goes along, and what came again has one line."""
    with helper.browser(1280, 900) as page:
        helper.open_report(page, report)
        assert not ask(page, "holonom.flat")
        groups = [e.get_attribute("open") for e in page.find_elements("css selector", "#log details.group")]
        assert groups == ["true", None]
        page.execute_script("holonom.seek(1.005)")
        assert page.find_element("css selector", "#log .current td:last-child").text == "step 50 × 2, to 1.01 s"


BALANCING = """cell = { name = "x", seed = 1, time_limit = "9s" }
[base]
arrangement = "segway"
track = "400mm"
wheel_radius = "100mm"
mass = "10kg"
velocity = [{ at = "0s", vx = "0.3m/s" }, { at = "1s" }]
"""


@pytest.mark.parametrize("webgl", [True, False])
def test_where_a_base_is_is_shown_that_draws_nothing_there(webgl: bool, helper, tmp_path: Path) -> None:
    """A body that balances leans in a frame of its own: base_link is followed and told all the same."""
    (tmp_path / "cell.toml").write_text(BALANCING, "utf-8")
    assert main(["run", str(tmp_path / "cell.toml"), "-o", str(tmp_path / "out"), "--quiet"]) == 0
    with helper.browser(1280, 900, webgl=webgl) as page:
        helper.open_report(page, tmp_path / "out" / "report.html")
        page.execute_script("holonom.seek(1.0)")
        assert "mm" in page.find_element("id", "tool").text
        assert page.find_element("id", "pace").text.endswith("mm/s")
        assert severe(page) == []


@pytest.mark.parametrize("width", [500, 900])
def test_a_narrow_window_does_not_overflow(width: int, helper, report: Path) -> None:
    with helper.browser(width, 900) as page:
        helper.open_report(page, report)
        assert ask(page, "document.documentElement.scrollWidth <= window.innerWidth")
        wide = ask(
            page,
            "[...document.querySelectorAll('main > *')].filter(e => e.getBoundingClientRect().right > innerWidth + 1)"
            ".map(e => e.id)",
        )
        assert wide == []


def test_in_the_dark_the_page_is_dark(helper, report: Path) -> None:
    def brightness(page, selector: str, what: str) -> float:
        style = ask(page, "getComputedStyle(document.querySelector(arguments[0]))[arguments[1]]", selector, what)
        return float(np.mean([float(v) for v in style[style.index("(") + 1 : -1].split(",")[:3]]))

    with helper.browser(1280, 900) as page:
        for scheme, dark in (("light", False), ("dark", True)):
            helper.prefer(page, scheme)
            helper.open_report(page, report)
            for selector in (":root", ".card", ".outcome"):
                assert (brightness(page, selector, "backgroundColor") < 128) is dark, selector
                assert (brightness(page, selector, "color") > 128) is dark, selector


def test_names_on_maps_stand_apart(helper, report: Path) -> None:
    with helper.browser(1280, 900) as page:
        helper.open_report(page, report)
        for figure in ("#path-agv .topview svg", "#base-agv .topview svg", "#polar-agv svg"):
            boxes = ask(
                page,
                "[...document.querySelectorAll(arguments[0] + ' text')].map(e => e.getBoundingClientRect())"
                ".map(r => [r.left, r.top, r.right, r.bottom])",
                figure,
            )
            assert len(boxes) > 6
            for i, a in enumerate(boxes):
                for b in boxes[i + 1 :]:
                    wide, high = min(a[2], b[2]) - max(a[0], b[0]), min(a[3], b[3]) - max(a[1], b[1])
                    assert wide <= 1 or high <= 3, (figure, a, b)
