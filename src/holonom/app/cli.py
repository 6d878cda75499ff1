"""The command line: `holonom run|check|calibrate|bench|doctor`.

Each command lives in a module of its own, imported when it is called, and returns an `Answer`. What it raises decides
the exit status: 2 for an `InputError` (nothing has been written), 1 for a `RunError` (the records are kept), 130 for
Ctrl-C. Any other exception is a defect and shows its traceback.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from holonom import __version__
from holonom.errors import HolonomError, InputError, RunError

if TYPE_CHECKING:
    from holonom.app.answer import Answer

__all__ = ["main"]

BAD_INPUT, FAILED, INTERRUPTED = 2, 1, 130


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Parameters
    ----------
    argv : the arguments behind the program's name; those of the process unless given.

    Returns
    -------
    The exit status: 0, 2 (bad input), 1 (failed after the start) or 130 (interrupted).
    """
    options = _parser().parse_args(argv)
    try:
        answer: Answer = options.command(options)
    except InputError as error:
        return _fail(error, BAD_INPUT, as_json=options.json)
    except RunError as error:
        return _fail(error, FAILED, as_json=options.json)
    except KeyboardInterrupt:
        print("holonom: interrupted; what was recorded until now is kept", file=sys.stderr)
        return INTERRUPTED
    if options.json:
        print(json.dumps(answer.data, indent=2, allow_nan=False))
    elif answer.text:
        print(answer.text)
    return 0


def _fail(error: HolonomError, status: int, *, as_json: bool) -> int:
    if as_json:
        details = {"type": type(error).__name__, "message": str(error), "status": status}
        print(json.dumps({"error": details}, indent=2))
    else:
        print(f"holonom: error: {error}", file=sys.stderr)
    return status


def _run(options: argparse.Namespace) -> Answer:
    from holonom.app.run import run_cell

    folder = options.output or Path("runs") / options.cell.resolve().parent.name
    return run_cell(options.cell, folder, seed=options.seed, quiet=options.quiet or options.json)


def _check(options: argparse.Namespace) -> Answer:
    from holonom.app.check import check_file

    return check_file(options.file)


def _calibrate_dynamics(options: argparse.Namespace) -> Answer:
    from holonom.app.calibrate import calibrate_dynamics

    friction = not options.no_friction
    return calibrate_dynamics(
        options.recording, options.arm, cutoff=options.cutoff, friction=friction, output=options.output
    )


def _calibrate_odometry(options: argparse.Namespace) -> Answer:
    from holonom.app.calibrate_odometry import calibrate_odometry

    return calibrate_odometry(
        options.logs,
        drive=options.drive,
        method=options.method,
        parameters=options.parameters,
        form=options.form,
        rule=options.rule,
        held_out=options.held_out,
        limits=options.limits,
        allow_gaps=options.allow_gaps,
        mcap=options.mcap,
        output=options.output,
    )


def _bench(options: argparse.Namespace) -> Answer:
    from holonom.app.bench import run_benchmarks

    quiet = options.quiet or options.json
    return run_benchmarks(options.names, output=options.output, seed=options.seed, small=options.small, quiet=quiet)


def _doctor(options: argparse.Namespace) -> Answer:
    from holonom.app import doctor

    if options.schema:
        return doctor.schema()
    if options.show_kernel is not None:
        return doctor.show_kernel(options.show_kernel)
    return doctor.empty_cache() if options.empty_cache else doctor.examine()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="holonom",
        description="Robot control system: everything between a joint motor and a robot program.",
        epilog="Exit status: 0; 2 for bad input, found before anything runs; 1 for what fails after the start.",
    )
    parser.add_argument("--version", action="version", version=f"holonom {__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    _add_run(commands)
    _add_check(commands)
    _add_calibrate(commands)
    _add_bench(commands)
    _add_doctor(commands)
    return parser


Commands = argparse._SubParsersAction  # argparse has no public name for it


def _add_run(commands: Commands[argparse.ArgumentParser]) -> None:
    run = commands.add_parser("run", help="run a cell: simulate, record, report")
    run.add_argument("cell", metavar="CELL", type=Path, help="cell file (TOML)")
    _add_output(run, "recording, summary and report go here (runs/ and the name of the cell's folder unless given)")
    run.add_argument("--seed", type=_seed, metavar="N", help="seed instead of the cell's own")
    _add_quiet(run)
    _add_json(run)
    run.set_defaults(command=_run)


def _add_check(commands: Commands[argparse.ArgumentParser]) -> None:
    check = commands.add_parser("check", help="check a cell or an ARPS program off-line, without running it")
    check.add_argument("file", metavar="FILE", type=Path, help="cell file (.toml) or program (.arps)")
    _add_json(check)
    check.set_defaults(command=_check)


def _add_calibrate(commands: Commands[argparse.ArgumentParser]) -> None:
    calibrate = commands.add_parser("calibrate", help="find a robot's numbers from measurements")
    subjects = calibrate.add_subparsers(title="what to calibrate", required=True, metavar="SUBJECT")
    dynamics = subjects.add_parser("dynamics", help="masses, inertias and friction of an arm, from a recorded motion")
    dynamics.add_argument("recording", metavar="RECORDING", type=Path, help="recording of a run (MCAP)")
    dynamics.add_argument("--arm", metavar="NAME|URDF", required=True, help="preset or URDF file of the arm")
    dynamics.add_argument("--cutoff", metavar="HZ", type=float, default=10.0, help="of the filter, 10 Hz unless given")
    dynamics.add_argument("--no-friction", action="store_true", help="leave the friction as the arm states it")
    _add_output(dynamics, "dynamics.json goes here")
    _add_json(dynamics)
    dynamics.set_defaults(command=_calibrate_dynamics)
    _add_calibrate_odometry(subjects)


def _add_calibrate_odometry(subjects: Commands[argparse.ArgumentParser]) -> None:
    odometry = subjects.add_parser("odometry", help="wheels of a mobile base, from logs of them and the truth")
    odometry.add_argument(
        "logs", metavar="LOG|FOLDER", nargs="+", type=Path, help="OptiOdom folder, or TOML beside its CSV or MCAP"
    )
    drives = ("differential", "tricycle", "omni3", "mecanum")
    odometry.add_argument("--drive", choices=drives, help="that of the logs unless given")
    odometry.add_argument("--method", choices=("umbmark", "least-squares"), default="least-squares")
    sets = ("physical", "extended")
    odometry.add_argument("--parameters", choices=sets, help="of least squares; extended where the motion tells them")
    odometry.add_argument("--form", choices=("x", "y", "mean"), help="of UMBmark, x unless given")
    rules = ("turn_then_drive", "midpoint", "exact")
    odometry.add_argument("--rule", choices=rules, default="midpoint", help="of integration, midpoint unless given")
    odometry.add_argument("--held-out", action="store_true", help="also errors of each run by the others' calibration")
    units = ("M", "DEG", "M_END", "DEG_END")
    odometry.add_argument("--limits", nargs=4, type=float, metavar=units, help="largest errors allowed, inf for none")
    odometry.add_argument("--allow-gaps", action="store_true", help="gaps in a log are a note, not an error")
    odometry.add_argument("--mcap", action="store_true", help="with -o, the runs too, as MCAP with truth and odometry")
    _add_output(odometry, "odometry.json and a picture of the paths go here")
    _add_json(odometry)
    odometry.set_defaults(command=_calibrate_odometry)


def _add_bench(commands: Commands[argparse.ArgumentParser]) -> None:
    bench = commands.add_parser("bench", help="measure speed beside the peer libraries")
    bench.add_argument("names", metavar="NAME", nargs="*", help="benchmarks to run, all unless given")
    _add_output(bench, "the table goes here as JSON too")
    bench.add_argument("--small", action="store_true", help="only show that everything runs")
    bench.add_argument("--seed", type=_seed, metavar="N", default=0, help="seed of the random inputs, 0 unless given")
    _add_quiet(bench)
    _add_json(bench)
    bench.set_defaults(command=_bench)


def _add_doctor(commands: Commands[argparse.ArgumentParser]) -> None:
    doctor = commands.add_parser("doctor", help="say what is installed and what is missing")
    either = doctor.add_mutually_exclusive_group()
    either.add_argument(
        "--show-kernel", metavar="NAME", help='print generated code, such as "puma560.inverse_dynamics"'
    )
    either.add_argument("--empty-cache", action="store_true", help="remove all compiled kernels")
    either.add_argument("--schema", action="store_true", help="print the JSON Schema of cell files")
    _add_json(doctor)
    doctor.set_defaults(command=_doctor)


def _add_output(parser: argparse.ArgumentParser, meaning: str) -> None:
    parser.add_argument("-o", "--output", metavar="DIR", type=Path, help=meaning)


def _add_quiet(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("-q", "--quiet", action="store_true", help="no progress bar")


def _add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print the result, or the error, as JSON")


def _seed(text: str) -> int:
    seed = int(text)
    if not 0 <= seed < 2**63:
        raise argparse.ArgumentTypeError(f"{text} came; a seed is a whole number from 0 to 2^63 - 1")
    return seed


_seed.__name__ = "seed"  # argparse names it in its message about text that is no number
