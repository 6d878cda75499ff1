"""From a base's cell file to the parts of a simulation: base, drives, floor, path, faults, settings."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from holonom.app.base.cell_model import FAULTS, BaseCell, BaseTable, Patch
from holonom.app.toml_lines import place_of
from holonom.closed_loop import BaseLog, simulate_base
from holonom.devices import DcMotor, Encoder, Friction, Gear
from holonom.errors import CellError, InputError, ModelError, UnknownName
from holonom.machine import PATHS, BaseSettings, PathLimits, ReferencePath, plan_path
from holonom.mobile import WheelBase, mecanum, omni
from holonom.mobile.drive.base_drive import BaseDrive, BaseSensors
from holonom.sim import BaseFault, Floor, Material, RectangularPatch, RoundPatch

__all__ = ["BaseJob", "build_job", "simulate"]


@dataclass(frozen=True, slots=True)
class BaseJob:
    """All that a simulation of a base needs."""

    cell: BaseCell
    base: WheelBase
    drive: BaseDrive
    floor: Floor
    path: ReferencePath
    faults: tuple[BaseFault, ...]


def build_job(cell: BaseCell, path: Path) -> BaseJob:
    """Build what the cell, the file `path`, describes. Nothing is written.

    Raises
    ------
    CellError
        Wheels that cannot move together, a path that cannot be driven or takes longer than the cell's time limit, a
        fault of a wheel that there is not.
    """
    try:
        table = "base"
        base = _base(cell.base)
        table = "drive"
        drive = _drive(cell)
        table = "path"
        reference = _path(cell)
        table = "faults"
        faults = tuple(_fault(fault.time, fault.wheel, fault.kind, base) for fault in cell.faults)
    except InputError as problem:
        raise CellError(f"{place_of(path, table)}: {problem}") from None
    if reference.time[-1] > cell.cell.time_limit:
        raise CellError(
            f"{place_of(path, 'cell', 'time_limit')}: the path takes {reference.time[-1]:.1f} s; "
            f"time_limit is {cell.cell.time_limit:g} s: raise it, or the path's speed and acceleration"
        )
    return BaseJob(cell, base, drive, _floor(cell), reference, faults)


def simulate(job: BaseJob, *, handling: bool = True) -> BaseLog:
    """Run the simulation; without `handling` of slip and dead motors, whatever the cell says."""
    gyro, control = job.cell.gyro, job.cell.control
    settings = BaseSettings(
        sensors=BaseSensors(gyro_noise=gyro.noise, gyro_bias=gyro.bias, accelerometer_noise=gyro.acceleration_noise)
    )
    settings = dataclasses.replace(
        settings,
        slip=settings.slip if handling and control.slip_detection else None,
        traction=settings.traction if handling and control.traction_control else None,
        watch=settings.watch if handling and control.dead_motor_compensation else None,
    )
    rng = np.random.default_rng(job.cell.cell.seed)
    return simulate_base(job.base, job.drive, job.path, floor=job.floor, faults=job.faults, settings=settings, rng=rng)


def _base(table: BaseTable) -> WheelBase:
    if table.arrangement == "omni":
        assert table.angles is not None
        assert table.radius is not None
        found = omni(table.angles, radius=table.radius, wheel_radius=table.wheel_radius)
    else:
        assert table.wheelbase is not None
        assert table.track is not None
        found = mecanum(table.wheelbase, table.track, table.wheel_radius)
    names = table.wheels or found.driven
    wheels = [dataclasses.replace(wheel, name=name) for wheel, name in zip(found.wheels, names, strict=True)]
    base = WheelBase(
        wheels, name=found.name, radius=found.radius, alpha=table.mass_distribution, mass=table.mass,
        com_height=table.height,
    )  # fmt: skip
    if np.linalg.matrix_rank(base.velocity_coupling, tol=1e-6) < 3:
        raise ModelError(
            "the wheels cannot drive this base in all directions and turn it; spread the motor axes' angles"
        )
    return base


def _drive(cell: BaseCell) -> BaseDrive:
    d = cell.drive
    motor = DcMotor(
        resistance=d.resistance,
        inductance=d.inductance,
        torque_constant=d.torque_constant,
        back_emf_constant=d.torque_constant,
        rotor_inertia=d.rotor_inertia,
        max_voltage=d.supply,
        max_current=d.max_current,
        no_load_current=d.no_load_current,
    )
    torque = d.no_load_current * d.torque_constant
    return BaseDrive(
        motor=motor,
        gear=Gear(d.gear_ratio, d.gear_efficiency),
        encoder=Encoder(d.counts_per_turn),
        friction=Friction(coulomb_positive=torque, coulomb_negative=torque),
        wheel_inertia=d.wheel_inertia,
    )


def _floor(cell: BaseCell) -> Floor:
    floor = cell.floor
    material = Material(floor.friction, floor.sliding_friction, floor.slip_at_peak)
    return Floor(material, tuple(_patch(patch, floor.slip_at_peak) for patch in floor.patches))


def _patch(patch: Patch, slip_at_peak: float) -> RoundPatch | RectangularPatch:
    material = Material(patch.friction, patch.sliding_friction, slip_at_peak)
    if patch.radius is not None:
        return RoundPatch(patch.centre, patch.radius, material)
    assert patch.size is not None
    return RectangularPatch(patch.centre, *patch.size, material, patch.angle)


def _path(cell: BaseCell) -> ReferencePath:
    path = cell.path
    points = PATHS.make(path.shape, {field.name: getattr(path, field.name) for field in PATHS[path.shape].fields})
    limits = PathLimits(path.speed, path.acceleration)
    return plan_path(points + np.array(path.origin), limits, laps=path.laps, heading=path.heading, start=path.angle)


def _fault(time: float, wheel: str, kind: str, base: WheelBase) -> BaseFault:
    if wheel not in base.driven:
        raise UnknownName("driven wheel", wheel, base.driven)
    return BaseFault(time, wheel, FAULTS[kind])
