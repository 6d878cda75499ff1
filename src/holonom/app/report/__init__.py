"""The report of a run: one HTML file that opens from disk, with no network.

Writing
    `reporting.report_recording`: of any recording, by that alone; `reporting.report_html` of a `source.Source`,
    `summary.summary_of` it in numbers. `write_report`: recording, scene and parts that are handed in.
What a run records for it
    `attachments.attachments_of` its job, at the beginning; `attached.ending_words` of an `Ending`, at the end.
What the replay shows
    `Scene` of shapes fixed in recorded frames: `Tube`, `Box`, `Disc`, `Label`; `View` for its cameras.
    `arm_shapes` gives those of a preset arm, `gripper_shapes` those of a two-finger gripper.
Sections
    `Curve` (lines over time), `Figures` of `TopView`, `Polar` and `Table`, `Outcome` (how the run ended), `LimitUse`
    (peaks against limits), `PhotoOverlay` of `Detection` (what the camera found), `Comparison` of `ComparedRun` in
    `Phase` (two controllers on one path).
Inside
    `facts` (what a recording says of its cell), `source` (a recording, read), `section_table` and `section` (a file for
    each), `base_findings`, `tracking`, `peaks` (what came of it), `embed` (numbers for the page, packed), `parts`,
    `sections`, `comparison`, `polar`, `topview` (their HTML), `page` (the whole), `assets` (script, style, libraries,
    which `tools/bundle_report_assets.sh` bundles).
"""

from holonom.app.report.drawing.arms import arm_shapes, gripper_shapes
from holonom.app.report.drawing.curves import Curve, joint_curves
from holonom.app.report.drawing.figures import Figures, Table
from holonom.app.report.drawing.polar import Polar, PolarLine
from holonom.app.report.drawing.scene import Box, Disc, Label, Scene, Shape, Tube, View
from holonom.app.report.drawing.topview import MapLine, MapMark, MapPatch, TopView
from holonom.app.report.findings.comparison import ComparedRun, Comparison, Phase
from holonom.app.report.page import write_report
from holonom.app.report.sections import Detection, LimitUse, Outcome, PhotoOverlay

__all__ = [
    "Box",
    "ComparedRun",
    "Comparison",
    "Curve",
    "Detection",
    "Disc",
    "Figures",
    "Label",
    "LimitUse",
    "MapLine",
    "MapMark",
    "MapPatch",
    "Outcome",
    "Phase",
    "PhotoOverlay",
    "Polar",
    "PolarLine",
    "Scene",
    "Shape",
    "Table",
    "TopView",
    "Tube",
    "View",
    "arm_shapes",
    "gripper_shapes",
    "joint_curves",
    "write_report",
]
