"""Takes a picture of a report in a headless Chromium: `screenshot_report.py REPORT OUT.png`.

Needs Chromium, its driver and the Python package selenium. Nothing is fetched from a network.
"""

from __future__ import annotations

import argparse
import base64
import shutil
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from selenium import webdriver

OPTIONS = (
    "--headless=new",
    "--no-sandbox",
    "--no-first-run",
    "--disable-gpu",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-default-apps",
    "--disable-sync",
    "--hide-scrollbars",
    "--host-resolver-rules=MAP * ~NOTFOUND",
)


def browser_programs() -> tuple[str, str] | None:
    """Paths of Chromium and its driver, or None."""
    chromium, driver = shutil.which("chromium"), shutil.which("chromedriver")
    return (chromium, driver) if chromium and driver else None


WEBGL, NO_WEBGL = ("--enable-unsafe-swiftshader", "--use-angle=swiftshader"), ("--disable-3d-apis",)


@contextmanager
def browser(width: int = 1280, height: int = 900, *, webgl: bool = True) -> Iterator[webdriver.Chrome]:
    """A fresh headless Chromium with WebGL in software, or without any, and no way to a network."""
    programs = browser_programs()
    if programs is None:
        raise SystemExit("no chromium and chromedriver on the path; install both")
    with tempfile.TemporaryDirectory() as profile:
        options = webdriver.ChromeOptions()
        options.binary_location = programs[0]
        for option in (
            *OPTIONS,
            *(WEBGL if webgl else NO_WEBGL),
            f"--user-data-dir={profile}",
            f"--window-size={width},{height}",
        ):
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        driver = webdriver.Chrome(options, webdriver.ChromeService(programs[1]))
        try:
            driver.set_script_timeout(60)
            yield driver
        finally:
            driver.quit()


def prefer(driver: webdriver.Chrome, scheme: str) -> None:
    """Ask for "light" or "dark" pages."""
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    driver.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})


def open_report(driver: webdriver.Chrome, report: Path) -> None:
    """Load a report from disk and wait until its replay is ready."""
    driver.get(report.resolve().as_uri())
    driver.execute_async_script("window.holonom.ready.then(arguments[0])")


def screenshot(driver: webdriver.Chrome, out: Path, *, whole: bool) -> None:
    """Write a picture of what is in sight, or of the whole page."""
    time.sleep(0.3)  # the sizes of plots and view settle
    settings = {"format": "png", "captureBeyondViewport": whole}
    if whole:
        size = driver.execute_cdp_cmd("Page.getLayoutMetrics", {})["cssContentSize"]
        settings["clip"] = {**size, "scale": 1}
    out.write_bytes(base64.b64decode(driver.execute_cdp_cmd("Page.captureScreenshot", settings)["data"]))


def main() -> None:
    """Run the command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("report", type=Path)
    parser.add_argument("out", type=Path)
    parser.add_argument("--time", type=float, default=0.4, help="moment of the run, as a part of its length")
    parser.add_argument("--width", type=int, default=1280)
    parser.add_argument("--height", type=int, default=900)
    parser.add_argument("--flat", action="store_true", help="without WebGL")
    parser.add_argument("--dark", action="store_true", help="as who prefers dark pages sees it")
    parser.add_argument("--whole", action="store_true", help="the whole page, not only its top")
    parser.add_argument("--element", default="", help="only the element with this id, for instance 'view'")
    wish = parser.parse_args()
    with browser(wish.width, wish.height, webgl=not wish.flat) as driver:
        prefer(driver, "dark" if wish.dark else "light")
        open_report(driver, wish.report)
        driver.execute_script(f"holonom.seek({wish.time} * holonom.state.end)")
        if wish.element:
            time.sleep(0.3)
            driver.find_element("id", wish.element).screenshot(str(wish.out))
        else:
            screenshot(driver, wish.out, whole=wish.whole)
        for entry in driver.get_log("browser"):
            print(entry["level"], entry["message"])


if __name__ == "__main__":
    main()
