"""What commands make of a trajectory: pictures, films, files for ParaView, its numbers."""

from __future__ import annotations

from pathlib import Path

from sph.checks.after_run import after_run
from sph.checks.layers import braked
from sph.checks.messages import line
from sph.command.check import places_of
from sph.command.outputs import check_apart, check_picture, check_writable
from sph.command.terminal import say, table
from sph.measures.fields import check_field
from sph.measures.metrics import CHIEF, METRICS, MetricSettings, measure
from sph.output.run import Run
from sph.scene.strict_json import to_json


def plot(file: Path, out: Path | None, field: str, time: float | None, study: Path | None) -> str:
    """Draw a profile, probes and energies; the picture's name."""
    from sph.figures.overview import plot

    path = out or file.parent / f"{file.stem}.png"
    check_picture(path, [file])
    run = Run.read(file)
    plot(run, path, time, field, {} if study is None else places_of(study, run.scene))
    return str(path)


def animate(
    file: Path,
    out: Path | None,
    field: str,
    every: int,
    fps: float | None,
    speed: float | None,
    motion: bool,
    dpi: int,
    study: Path | None,
) -> str:
    """Film the profile; the film's name."""
    from sph.figures.film import check_film, rate, save_film

    path = out or file.parent / f"{file.stem}.gif"
    if fps is not None and speed is not None:
        raise ValueError(f"--fps {fps:g} and --speed {speed:g}: give one of them")
    pictures = 10.0 if fps is None else fps
    check_film(path, pictures, dpi)
    check_field(field)
    check_writable(path, [file])
    run = Run.read(file)
    places = {} if study is None else places_of(study, run.scene)
    save_film(run, path, field, every, pictures if speed is None else rate(run, every, speed), motion, dpi, places)
    return str(path)


def export(file: Path, vtk: str) -> str:
    """Write files for ParaView; the name of the one to open."""
    from sph.output.paraview import export_paraview

    folder = Path(vtk)
    if not vtk or folder.exists() and not folder.is_dir():
        raise ValueError(f"--vtk {vtk!r}: is {'a file' if vtk else 'an empty name'}; name a folder")
    check_apart(folder / f"{file.stem}.pvd", [file], "--vtk")
    return str(export_paraview(Run.read(file).trajectory, folder, file.stem))


def metrics(file: Path, every: bool, as_json: bool) -> str:
    """The chief metrics or ``every`` one; beside them the findings after the run, and those before it that make them lower bounds."""
    run = Run.read(file)
    values = measure(run, MetricSettings())
    if as_json:
        return to_json(values, indent=1)
    say(*(line(each) for each in [*braked(run.scene), *after_run(run.scene, values)]))
    shown = {name: f"{value:.4g}" if isinstance(value, float) else str(value) for name, value in values.items()}
    if every:
        return table(("metric", "value", "unit", "definition"), ((row.name, shown[row.name], row.units, row.text) for row in METRICS))
    chief = table(("metric", "value", "unit"), ((row.name, shown[row.name], row.units) for row in METRICS if row.name in CHIEF))
    return f"{chief}\n--all shows {len(METRICS) - len(CHIEF)} more, with definitions"
