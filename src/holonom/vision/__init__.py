"""Camera and table: from a photograph to parts on the table (specification 08).

- `load_photograph(path)`: grey levels of an image file.
- `find_coins(image)`: round bright things on a dark, uneven ground, as `Disc` records in pixels.
- `fit_homography(pixels, table_m)`: a `TableCamera` from four or more points, with residuals.
- `to_table(camera, pixels)`, `to_pixel(camera, table_m)`: through the camera and back.
- `measure(camera, discs)`: place and size on the table, as `TablePart` records.
- `in_robot_frame(parts, T_wt)`: their centres in the world frame.
- `grasp_angles(centres, diameters)`: closing directions that leave the fingers room.
"""

from holonom.vision.coins import Disc, find_coins
from holonom.vision.grasp import grasp_angles
from holonom.vision.homography import TableCamera, fit_homography, to_pixel, to_table
from holonom.vision.parts import TablePart, in_robot_frame, measure
from holonom.vision.photograph import load_photograph

__all__ = [
    "Disc",
    "TableCamera",
    "TablePart",
    "find_coins",
    "fit_homography",
    "grasp_angles",
    "in_robot_frame",
    "load_photograph",
    "measure",
    "to_pixel",
    "to_table",
]
