"""What the commands of ``sph`` share: types of their arguments and options, how the texts of these are read, and refusals."""

from __future__ import annotations

import re
import sys
import tempfile
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from typer.core import TyperGroup

from sph.jobs.exit_codes import REFUSED
from sph.storage.files import ROLES, beside, same_file

SMALLEST_ACCELERATION = 1e-6
"""Smallest yield acceleration, m/s2; a block slides the farther the smaller it is."""
EXAMPLES = {"--set": "coupling.S_R=0.10", "--rule": "displacement=0.02"}

SceneFile = Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (YAML), or a trajectory (netCDF), which contains its scene")]
Settings = Annotated[
    list[str] | None,
    typer.Option(
        "--set",
        metavar="KEY=VALUE",
        help="change one key, e.g. coupling.S_R=0.10; a section in braces takes the place of the whole old one; may be repeated",
    ),
]
Trajectory = Annotated[Path, typer.Argument(metavar="FILE", help="trajectory file (netCDF)")]
Tolerance = Annotated[float, typer.Option(max=1, help="relative width of the bracket at which the search ends")]
Rule = Annotated[
    list[str] | None,
    typer.Option("--rule", metavar="KEY=VALUE", help="change the failure rule: displacement, area, observation, ramp; may be repeated"),
]
AsJson = Annotated[bool, typer.Option("--json", help="machine-readable, in SI units, trials included")]
Trials = Annotated[Path | None, typer.Option(help="table of the trials to write (CSV)")]
Spacings = Annotated[
    str | None,
    typer.Option(
        metavar="COARSE,FINE",
        help="two spacings (m) to extrapolate from; by default the scene's own and about twice that, both dividing the slope's height",
    ),
]
Single = Annotated[bool, typer.Option("--single", help="search only at the scene's own spacing, without extrapolation")]


PATIENCE = 2.0
"""Wall time after which a command says what it does, s."""


class Commands(TyperGroup):
    """The list of commands with their whole first sentences, which wrap where the terminal ends."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the section of ``--help``."""
        named = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl([(name, (command.help or "").partition("\n\n")[0]) for name, command in named if command])


def show_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """Print a table; what is too wide for the terminal is folded, never cut."""
    table = Table()
    for name in head:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*row)
    Console().print(table)


def aligned(rows: Sequence[tuple[str, str]]) -> list[str]:
    """Lines of labels and texts, in two columns."""
    width = max(len(label) for label, _ in rows)
    return [f"{label:<{width}}  {text}" for label, text in rows]


@contextmanager
def refusals(doing: str = "") -> Iterator[None]:
    """Turn errors of the user's input into one message and exit code 2; say what it is ``doing`` if that takes more than ``PATIENCE``."""
    late = threading.Timer(PATIENCE, say, [f"{doing} ..."])
    late.daemon = True
    try:
        if doing:
            late.start()
        yield
    except MemoryError as error:
        print("sph: not enough memory; choose a larger numerics.spacing or a longer outputs.frame_interval", file=sys.stderr)
        raise typer.Exit(REFUSED) from error
    except BrokenPipeError:
        raise  # who reads what is printed has enough
    except (ValueError, OSError) as error:
        say(str(error))
        raise typer.Exit(REFUSED) from error
    finally:
        late.cancel()


def say(line: str) -> None:
    """Print a message beside the result."""
    print(f"sph: {line}", file=sys.stderr, flush=True)


def check_writable(path: Path, inputs: Iterable[Path | str], option: str = "--out") -> None:
    """Refuse a file that could not be written after hours of work, and one that the command reads; ValueError names the option."""
    from sph.storage.files import check_name

    if not path.parent.is_dir():
        raise ValueError(f"{option} {path}: the folder {path.parent} does not exist")
    try:
        check_name(path)
    except ValueError as error:
        raise ValueError(f"{option} {error}") from error
    if path.is_dir():
        raise ValueError(f"{option} {path}: is a folder; name a file")
    if path.exists() and not path.is_file() or path == Path("-"):
        raise ValueError(f"{option} {path}: must be a new file, or an ordinary one to be replaced; name another")
    check_apart(path, inputs, option)
    try:
        with tempfile.NamedTemporaryFile(dir=path.parent, prefix=".sph."):
            pass
    except OSError as error:
        raise ValueError(f"{option} {path}: cannot be written: {error.strerror}; remove the cause or choose another place") from error


PICTURES = (".png", ".pdf", ".svg")


def check_picture(path: Path, inputs: Iterable[Path | str], option: str = "--out") -> None:
    """Refuse what ``check_writable`` refuses, and an ending that is not that of a picture."""
    if not path.name.lower().endswith(PICTURES):
        raise ValueError(f"{option} {path}: the name must end in {', '.join(PICTURES)}")
    check_writable(path, inputs, option)


def check_apart(path: Path, inputs: Iterable[Path | str], option: str) -> None:
    """Refuse to write over a file that the command reads, by whatever name; ValueError names the option."""
    for given in inputs:
        if any(same_file(own, given) for own in (path, *(beside(path, role) for role in ROLES))):
            raise ValueError(f"{option} {path}: would replace {given}, which the command reads; name another file")


def parse_settings(settings: list[str] | None, option: str = "--set") -> dict[str, Any]:
    """``["coupling.S_R=0.1"]`` as nested overrides; ValueError for anything that is not KEY=VALUE."""
    from sph.scene.configuration import DEEPEST, dotted, parse_yaml

    pairs = {}
    for setting in settings or []:
        name, equals, text = setting.partition("=")
        if not equals or not all(name.split(".")) or name.count(".") > DEEPEST:
            raise ValueError(f"{option} {setting!r}: write KEY=VALUE, e.g. {EXAMPLES[option]}")
        if name in pairs:
            raise ValueError(f"{option} {setting!r}: {name} is set twice; write it once")
        try:
            pairs[name] = parse_yaml(text)
        except ValueError as error:
            raise ValueError(f"{option} {setting!r}: the value is not readable: {error}") from error
    try:
        return dotted(pairs)
    except ValueError as error:
        raise ValueError(f"{option} {error}") from error


def parse_error(text: str) -> float:
    """``"10%"`` or ``"0.1"`` as 0.1; ValueError for anything else."""
    number, percent = text.strip().removesuffix("%"), text.strip().endswith("%")
    try:
        return float(number) / (100 if percent else 1)
    except ValueError as error:
        raise ValueError(f"--error {text!r}: write 10% or 0.1") from error


def parse_spacings(text: str | None) -> tuple[float, ...] | None:
    """``"2,1"`` as (2.0, 1.0); ValueError for anything else."""
    if text is None:
        return None
    try:
        return tuple(float(number) for number in text.split(","))
    except ValueError as error:
        raise ValueError(f"--spacings {text!r}: write two numbers (m), e.g. 2,1") from error


def parse_acceleration(text: str, option: str) -> float:
    """``"2.5 m/s2"`` or ``"0.25g"`` in m/s2; ValueError naming the option for anything else, a bare number among it, and unless positive
    and finite."""
    from sph.scene.ground_motion import LARGEST_ACCELERATION
    from sph.scene.units import acceleration

    bare = text.strip()
    if re.fullmatch(r"[-+]?(\d+\.?\d*|\.\d+)([eE][-+]?\d+)?", bare):
        raise ValueError(f"{option} {text!r}: has no unit; write {bare}g or {bare} m/s2, whichever is meant")
    try:
        value = float(acceleration(text))
    except ValueError as error:
        raise ValueError(f"{option} {text!r}: {error}") from error
    if not SMALLEST_ACCELERATION <= value <= LARGEST_ACCELERATION:
        raise ValueError(f"{option} {text!r}: must be positive and finite, from {SMALLEST_ACCELERATION:g} to {LARGEST_ACCELERATION:g} m/s2")
    return value


def parse_treatment(unit: str | None, baseline: int | None, band_pass: str | None, component: str | None = None) -> dict[str, Any]:
    """The options that treat a record as the keys of a scene's ``motion``, those that were given; ValueError names the option."""
    from sph.scene.names import check_known
    from sph.scene.units import SIZES

    check_known("--unit", [unit], tuple(SIZES))
    found: dict[str, Any] = {} if unit is None else {"unit": unit}
    if component is not None:
        found["component"] = component
    if baseline is not None:
        found["baseline"] = {"degree": baseline}
    if band_pass is not None:
        try:
            low, high = (float(corner) if corner.strip() else None for corner in band_pass.split(","))
        except ValueError as error:
            raise ValueError(
                f"--band-pass {band_pass!r}: write two corner frequencies in Hz, as 0.1,25, or one of them with the comma, as 0.1, or ,25"
            ) from error
        found["band_pass"] = {"low": low, "high": high}
    return found


UnitOption = Annotated[str | None, typer.Option("--unit", help="unit of a record whose file does not state it: m/s2, cm/s2, gal or g")]
ComponentOption = Annotated[
    str | None,
    typer.Option(
        "--component", metavar="NAME", help="horizontal component of a record that holds several: its name, e.g. N-S, or its number"
    ),
]
BaselineOption = Annotated[
    int | None,
    typer.Option(
        "--baseline", metavar="DEGREE", help="remove drift, like motion.baseline of a scene: degree 0 an offset, 1 a straight line"
    ),
]
BandPassOption = Annotated[
    str | None,
    typer.Option(
        "--band-pass", metavar="LOW,HIGH", help="band-pass filter, like motion.band_pass of a scene: corner frequencies in Hz, e.g. 0.1,25"
    ),
]
