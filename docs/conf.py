"""Sphinx configuration: `make docs`."""

import sys
from importlib.metadata import version as installed_version
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "Holonom"
author = "The Holonom developers"
copyright = "The Holonom developers, Apache-2.0"
version = release = installed_version("holonom")

extensions = ["myst_parser", "formulas", "layers", "links", "offline", "reference"]
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build", "_ext"]
suppress_warnings = ["misc.highlighting_failure"]

html_title = f"Holonom {version}"
html_theme = "furo"
html_math_renderer = "mathml"
html_static_path = ["_static"]
html_css_files = ["holonom.css"]
html_copy_source = False

add_module_names = False
toc_object_entries_show_parents = "hide"
python_use_unqualified_type_names = True
