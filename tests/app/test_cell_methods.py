"""Methods in cell files: kind, parameters with units, faults with file, line and key, schema."""

from __future__ import annotations

import math
import re
from typing import Annotated

import pytest
from pydantic import TypeAdapter, ValidationError

from holonom.app.about.tables import TABLES, table_of
from holonom.app.fields.methods import Chosen, OneMethod, params_schema, read_params
from holonom.app.fields.quantities import Section
from holonom.app.fields.toml_faults import parse_toml, worded_faults
from holonom.control import CONTROLLERS
from holonom.control.methods import BASE_CONTROLLERS, CascadeSettings
from holonom.devices import DEVICES, Gyro
from holonom.errors import CellError, UnknownName
from holonom.machine import PATHS
from holonom.mobile import ARRANGEMENTS
from holonom.sim import SENSORS


class Small(Section):
    """A cell of methods."""

    sensors: tuple[Annotated[Chosen, OneMethod(SENSORS)], ...] = ()
    """what it measures"""
    law: Annotated[Chosen | None, OneMethod(CONTROLLERS)] = None
    """its controller"""


TEXT = """
law = { kind = "computed_torque", law_bandwidth = "40rad/s" }
[[sensors]]
kind = "gyro"
noise = "0.1deg/s"
[[sensors]]
kind = "encoder"
counts_per_rev = 1000
"""


def read(text: str) -> Small:
    return Small.model_validate(parse_toml("c.toml", text, CellError))  # type: ignore[arg-type]


def faults(text: str) -> list[str]:
    with pytest.raises(ValidationError) as caught:
        read(text)
    return worded_faults("c.toml", text, Small, caught.value.errors(include_url=False)).splitlines()  # type: ignore[arg-type]


def test_a_cell_chooses_methods() -> None:
    cell = read(TEXT)
    assert cell.sensors[0].params == Gyro(noise=math.radians(0.1))
    assert cell.sensors[0].make() == Gyro(noise=math.radians(0.1))
    assert cell.sensors[1].params.counts_per_rev == 1000
    assert cell.law is not None
    assert (cell.law.name, cell.law.params.law_bandwidth) == ("computed_torque", 40.0)
    assert read('law = "cascade"').law == Chosen(CONTROLLERS, "cascade", CascadeSettings())


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"0.1deg/s"', '"0.1deg"', r"c.toml:5: sensors\[0\].noise: '0.1deg' came, in a unit of angle"),
        ('"0.1deg/s"', "0.1", r"c.toml:5: sensors\[0\].noise: 0.1 came; a quantity of angular speed"),
        ('"0.1deg/s"', '"-1deg/s"', r"c.toml:5: sensors\[0\].noise: noise is -0.0174.*at least 0 rad/s"),
        ("noise", "nois", r"c.toml:5: sensors\[0\].nois: no parameter of sensor 'gyro' 'nois'.*did you mean 'noise'"),
        ("gyro", "gyr", r"c.toml:4: sensors\[0\].kind: no sensor 'gyr'.*did you mean 'gyro'"),
        ("= 1000", "= 1000.5", r"c.toml:8: sensors\[1\].counts_per_rev: .*must be a whole number"),
        ("counts_per_rev = 1000", "", r"c.toml:6: sensors\[1\]: sensor 'encoder': counts_per_rev missing; it needs"),
        ('"40rad/s"', '"400rad/s"', r"c.toml:2: law.law_bandwidth: law_bandwidth is 400.0"),
        ('kind = "computed_torque", ', "", r"c.toml:2: law: .* came; a controller is expected: kind = one of cascade,"),
    ],
)
def test_faults_name_line_and_key(old: str, new: str, said: str) -> None:
    found = faults(TEXT.replace(old, new))
    assert len(found) == 1
    assert re.match(said, found[0]), found


def test_each_wrong_key_is_named() -> None:
    found = faults(TEXT.replace('"0.1deg/s"', '"x"\nbias = "y"'))
    assert [line.split(": ")[1] for line in found] == ["sensors[0].noise", "sensors[0].bias"]


def test_values_without_a_unit_of_cells() -> None:
    assert read_params(BASE_CONTROLLERS, "motor_watch", {"least_part": 0.5}).least_part == 0.5
    assert read_params(PATHS, "waypoints", {"points": [["0m", "1m"], ["20cm", "0m"]]}).points == ((0, 1), (0.2, 0))
    assert read_params(ARRANGEMENTS, "omni", {"radius": "20cm", "wheel_radius": "5cm", "n": 3}).radius == 0.2
    assert read_params(DEVICES, "friction", {"viscous": "2mNms/rad"}).viscous == 2e-3
    with pytest.raises(UnknownName, match="no shape of a path 'spiral'"):
        read_params(PATHS, "spiral", {})


def test_the_schema_is_that_of_the_tables() -> None:
    schema = TypeAdapter(Small).json_schema()["properties"]["sensors"]["items"]["oneOf"]
    assert schema[0]["enum"] == list(SENSORS)
    assert [form["properties"]["kind"]["const"] for form in schema[1:]] == list(SENSORS)
    gyro = schema[1 + list(SENSORS).index("gyro")]
    assert re.fullmatch(gyro["properties"]["noise"]["pattern"], "0.1deg/s")
    assert not re.fullmatch(gyro["properties"]["noise"]["pattern"], "0.1deg")
    assert gyro["required"] == ["kind"]


@pytest.mark.parametrize("kind", [kind for kind in TABLES if kind != "commands"])
def test_every_method_has_a_schema(kind: str) -> None:
    for name in table_of(kind):
        schema = params_schema(table_of(kind)[name])
        assert set(schema["required"]) <= set(schema["properties"])
        assert all("type" in p or "anyOf" in p for p in schema["properties"].values())
