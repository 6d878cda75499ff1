"""Sphinx configuration: `make docs`."""

from importlib.metadata import version as installed_version

project = "Holonom"
author = "The Holonom developers"
copyright = "The Holonom developers, Apache-2.0"
version = release = installed_version("holonom")

extensions = ["myst_parser"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
suppress_warnings = ["misc.highlighting_failure"]

html_theme = "alabaster"
html_theme_options = {
    "description": "Robot control system: everything between a joint motor and a robot program",
    "fixed_sidebar": True,
    "page_width": "1280px",
}
