"""What `holonom calibrate odometry` prints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from holonom.app.calibrate.sensors import sensor_lines

__all__ = ["LABELS", "text_of"]


def text_of(data: Mapping[str, Any]) -> str:
    """Return the lines of an answer by its JSON values."""
    runs = len(data["runs"])
    lines = [f"{data['drive']} base, {data['method']}, {runs} run{'s' if runs != 1 else ''}:"]
    lines += _table(data["nominal"], data["calibrated"], data["deviations"])
    lines += [f"  {name} {data[name]:.6f}" for name in ("E_b", "E_d") if name in data]
    if data.get("set") == "extended" and "physical" in data:
        plain = data["physical"]
        lines += ["with the physical parameters only:"]
        lines += _table(plain["nominal"], plain["calibrated"], plain["deviations"])
    columns = {"before": data["errors_before"], "after": data["errors_after"]}
    if data.get("set") == "extended" and "physical" in data:
        columns["physical only"] = data["physical"]["errors_after"]
    if "errors_held_out" in data:
        columns["held out"] = data["errors_held_out"]
    lines += ["largest errors over the runs:" + "".join(f"{name:>15}" for name in columns)]
    for key, label in LABELS.items():
        if key in data["errors_before"]:
            lines.append(f"  {label:27}" + "".join(f"{errors[key]:15.6f}" for errors in columns.values()))
    lines += [f"runs as MCAP: {data['recordings']}"] if "recordings" in data else []
    lines += sensor_lines(data)
    left = data["nonsystematic"]
    if left["spread_m"] is not None:
        lines.append(f"ends of repeated runs scatter by {left['spread_m']:.6f} m, which no calibration takes away")
    if left["bump_deg"] is not None:
        lines.append(f"bumps turn it by {left['bump_deg']:.4f} deg")
    for one in data.get("identifiability", {}).get("weak", []):
        lines.append(one["text"])
    return "\n".join([*lines, *(f"note: {note}" for note in data["notes"])])


LABELS = {
    "max_distance_m": "distance on the way, m",
    "max_heading_deg": "heading on the way, deg",
    "max_final_distance_m": "distance at the end, m",
    "max_final_heading_deg": "heading at the end, deg",
    "E_max_m": "E_max of both means, m",
}


def _table(nominal: Mapping[str, float], found: Mapping[str, float], sure: Mapping[str, float | None]) -> list[str]:
    width = max(map(len, nominal))
    lines = [f"  {'':{width}}  {'nominal':>10}  {'calibrated':>10}  {'deviation':>10}"]
    for name, value in nominal.items():
        deviation = sure[name]
        shown = f"{'unknown':>10}" if deviation is None else f"{deviation:10.6f}"
        lines.append(f"  {name:{width}}  {value:10.6f}  {found[name]:10.6f}  {shown}")
    return lines
