"""The command ``sph``.

Exit codes: 0 done; 2 refused, with one message that names the cause and the remedy: the scene, the command line, a file that cannot be
read or written (earlier files are as they were), or nothing measured is as good as asked; 3 the run was stopped by its guard (status
``diverged``), and the run so far was written; 4 a result is out of date or altered (``explain``).  A static test that diverges after
the slope has failed counts as failed: 0.  Anything else is a fault of the program, with a traceback (1), or of its surroundings: 1
without one where nobody reads what is printed (``| head``), 130 interrupted, 137 killed; ``sph run`` then continues from its checkpoint.
"""

from __future__ import annotations

import os
import sys
import warnings
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated

import typer

from sph.command.options import (
    AsJson,
    BandPassOption,
    BaselineOption,
    Commands,
    ComponentOption,
    Rule,
    SceneFile,
    Settings,
    Single,
    Spacings,
    Tolerance,
    Trajectory,
    Trials,
    UnitOption,
    aligned,
    check_apart,
    check_picture,
    check_writable,
    parse_acceleration,
    parse_error,
    parse_settings,
    parse_spacings,
    parse_treatment,
    refusals,
    say,
    show_table,
)
from sph.jobs.exit_codes import DIFFERS, DIVERGED, REFUSED
from sph.scene.names import check_known
from sph.scene.strict_json import to_json
from sph.stability.search import TOLERANCE

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


def _version(asked: bool) -> None:
    if asked:
        import sph

        print(f"sph {sph.__version__}")
        raise typer.Exit


@app.callback()
def common(
    version: Annotated[bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and exit")] = False,
) -> None:
    """Earthquake-induced slope failure with solid-fluid coupled smoothed particle hydrodynamics."""


@app.command(epilog="Example:  sph new ground.csv RSN6_ELC180.AT2 --out myslope")
def new(
    ground: Annotated[Path, typer.Argument(metavar="GROUND", help="ground line of the survey (CSV, GeoJSON or WKT)")],
    record: Annotated[Path, typer.Argument(metavar="RECORD", help="ground motion (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv)")],
    out: Annotated[Path, typer.Option(help="folder to write scene.yaml and study.yaml into")] = Path(),
    component: ComponentOption = None,
) -> None:
    """Write a scene and a study for your own slope, with comments; then replace the soil properties in them."""
    with refusals("reading ground and record"):
        from sph.command.new import write_new

        scene, study = write_new(ground, record, out, component)
    print(f"{scene}, {study}: replace the soil properties, then run sph check {scene} --plot scene.png")


@app.command(
    epilog="Examples:  sph run config/scenes/paper.yaml  |  sph run config/scenes/paper.yaml --set coupling.S_R=0.10 "
    "--set numerics.smoothing_ratio=1.3 --out slide.nc  |  sph run config/scenes/paper.yaml --until gravity --out gravity.nc  |  "
    "sph run slide.nc --out again.nc"
)
def run(
    scene: SceneFile,
    set_: Settings = None,
    out: Annotated[Path | None, typer.Option(help="trajectory to write; NAME.nc in this folder by default")] = None,
    restart: Annotated[Path | None, typer.Option(help="continue from this trajectory instead of from the start")] = None,
    until: Annotated[
        str | None,
        typer.Option(
            help="where to stop: gravity (end of the gravity stage), first_failure or end; by default end, or where the given run stopped"
        ),
    ] = None,
    threads: Annotated[
        int,
        typer.Option(
            min=1, max=256, help="threads of the run, for one large scene; below about 10,000 particles a single thread is faster"
        ),
    ] = 1,
    checkpoint: Annotated[
        float | None,
        typer.Option(min=0, metavar="SECONDS", help="wall time between checkpoints, 0 for none; $SPH_CHECKPOINT or 300 by default"),
    ] = None,
    overwrite: Annotated[bool, typer.Option("--overwrite", help="replace an existing run of another scene")] = False,
) -> None:
    """Simulate a scene and write its trajectory; after Ctrl-C or a kill the same command continues from the last checkpoint.

    Given a trajectory, it repeats the run from the start to the same stage, bit for bit.
    """
    with refusals():
        from sph.checks.after_run import found_after
        from sph.checks.finding import codes
        from sph.checks.scene import findings
        from sph.command.repeat import check_of_scene, compare, earlier_run, read_given, stopped_at
        from sph.jobs.progress import reporter
        from sph.output.run import Run
        from sph.solver.checkpoint import run_to_file
        from sph.storage.trajectory import Status

        check_known("--until", [until], ("end", "gravity", "first_failure"))
        earlier = earlier_run(scene)
        loaded, inputs = read_given(scene, parse_settings(set_), earlier)
        path = out or Path(f"{loaded.name}.nc")
        check_writable(path, [*inputs, *([restart] if restart else [])])
        if not overwrite:
            check_of_scene(path, loaded)
        repeats = earlier is not None and not set_ and until is None
        found = findings(loaded)
        for each in found:
            if each.counts:
                say(each.line())
        with reporter(loaded.name, loaded) as report:
            # What was allowed to run with a step above its limit may be repeated.
            stage = until or stopped_at(earlier)
            result = run_to_file(
                loaded,
                path,
                stage,  # type: ignore[arg-type]
                restart,
                report,
                threads,
                checkpoint,
                say,
                enforce_limit=not repeats,
                attrs={"findings": codes(found)},
            )
    attrs = result.trajectory.attrs
    reason = f" ({attrs['status_reason']})" if attrs["status_reason"] else ""
    print(
        f"{path}: {result.status}{reason}, {attrs['wall_time_s']:.1f} s, {attrs['particle_steps_per_second'] / 1e6:.2f} M particle-steps/s"
    )
    made = Run(result.trajectory, loaded)
    if made.time_step_ratio > 1.0:
        say(
            f"numerics.time_step was {made.time_step_ratio:.2f} times the stability limit measured during the run; "
            "choose a smaller step, or let it adapt (numerics.adaptive_step={})"
        )
    if result.status not in (Status.DIVERGED, Status.PAUSED):
        for each in found_after(made):
            say(each.line())
    if earlier is not None and repeats:
        say(compare(earlier, result.trajectory, scene))
    if result.status == Status.DIVERGED:
        raise typer.Exit(DIVERGED)


@app.command("compile", epilog="Example:  sph compile config/scenes/*.yaml")
def compile_(scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="scene files (YAML)")]) -> None:
    """Compile the solver for scenes and their static tests; later runs with the same terms reuse it on this machine."""
    with refusals("loading the solver"):
        from sph.command.compile import compile_for
        from sph.command.repeat import read_given

        loaded = [read_given(path, {})[0] for path in scenes]
        for path, scene in zip(scenes, loaded, strict=True):
            print(f"{path}: ready, {compile_for(scene, scene.name):.1f} s", flush=True)


@app.command(epilog="Example:  sph info config/scenes/paper.yaml --set numerics.spacing=0.5")
def info(scene: SceneFile, set_: Settings = None) -> None:
    """Show a summary of a scene: particles, wave speeds, time-step limits, terms, cost."""
    with refusals("placing the particles"):
        from sph.command.info import describe
        from sph.command.repeat import given_scene

        rows = describe(given_scene(scene, parse_settings(set_)))
    print("\n".join(aligned(rows)))


@app.command(epilog="Examples:  sph check config/scenes/paper.yaml --plot paper.png  |  sph check slope.yaml --json")
def check(
    scene: SceneFile,
    set_: Settings = None,
    plot: Annotated[Path | None, typer.Option(help="picture of the scene to write (.png, .pdf, .svg)")] = None,
    study: Annotated[
        Path | None, typer.Option("--configfile", help="configuration of a study whose places (metrics.places) to draw")
    ] = None,
    static: Annotated[
        bool,
        typer.Option(
            "--stability",
            help="also test whether the slope stands without shaking, and find its factor of safety and yield acceleration; takes minutes",
        ),
    ] = False,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable: layers and findings")] = False,
) -> None:
    """Check a scene before it is run: a table, a drawing, and findings on what may spoil its results."""
    with refusals("testing whether it stands, by trial runs" if static else "placing the particles"):
        from sph.command.check import LAYER_COLUMNS, draw, layer_rows, places_of, rows
        from sph.command.check import check as look_at
        from sph.command.repeat import read_given
        from sph.study.preflight import stability

        loaded, inputs = read_given(scene, parse_settings(set_))
        if plot is not None:
            check_picture(plot, [*inputs, *([] if study is None else [study])], "--plot")
        places = {} if study is None else places_of(study, loaded)
        found = look_at(loaded)
        if plot is not None:
            from sph.figures.style import save

            save(draw(found, places), plot)
        facts, told = rows(found), (stability(loaded) if static else []) + found.findings
    layers = layer_rows(found)
    if as_json:
        named = [dict(zip(LAYER_COLUMNS, row, strict=True)) for row in layers]
        print(to_json({"rows": dict(facts), "layers": named, "findings": [each._asdict() for each in told]}, indent=1))
        return
    print("\n".join(aligned(facts)))
    show_table(LAYER_COLUMNS, layers)
    for each in told:
        print(each.line())
    if not any(each.counts for each in told):
        print("no warnings")


@app.command(epilog="Examples:  sph plot slide.nc  |  sph plot slide.nc --field speed --time 6 --out slide.pdf")
def plot(
    file: Trajectory,
    out: Annotated[Path | None, typer.Option(help="picture to write (.png, .pdf, .svg); beside the trajectory by default")] = None,
    field: Annotated[
        str, typer.Option(help="quantity that colours the profile: initial_height, displacement, speed, beta, ...")
    ] = "initial_height",
    time: Annotated[float | None, typer.Option(help="time of the profile in s; the last frame by default")] = None,
) -> None:
    """Draw a trajectory: profile, probes and energies."""
    with refusals("reading the trajectory and drawing it"):
        from sph.figures.overview import plot

        path = out or file.parent / f"{file.stem}.png"
        check_picture(path, [file])
        plot(file, path, time, field)
    print(path)


@app.command(
    epilog="Examples:  sph animate slide.nc --out slide.gif  |  sph animate slide.nc --out slide.mp4 --field beta --motion --speed 2  |  "
    "sph animate slide.nc --out slide.gif --every 2 --fps 5 --dpi 80"
)
def animate(
    file: Trajectory,
    out: Annotated[
        Path | None, typer.Option(help="film to write (.gif, or .mp4 with ffmpeg); a GIF beside the trajectory by default")
    ] = None,
    field: Annotated[
        str, typer.Option(help="quantity that colours the profile: displacement, speed, beta, initial_height or pressure")
    ] = "displacement",
    every: Annotated[int, typer.Option(min=1, help="draw every n-th stored frame (outputs.frame_interval)")] = 1,
    fps: Annotated[float | None, typer.Option(help="frames per second of the film, 10 by default")] = None,
    speed: Annotated[float | None, typer.Option(help="instead of --fps: simulated seconds per second of the film, 1 for real time")] = None,
    motion: Annotated[bool, typer.Option("--motion", help="show the acceleration of the ground below the profile")] = False,
    dpi: Annotated[int, typer.Option(help="dots per inch; 120 gives a picture 850 pixels wide")] = 120,
) -> None:
    """Animate a trajectory: the profile, coloured by a field on a fixed scale, as a GIF or an MP4."""
    with refusals("reading the trajectory and drawing its frames, about ten per second"):
        from sph.figures.film import check_film, rate, save_film
        from sph.measures.fields import check_field
        from sph.output.run import Run

        path = out or file.parent / f"{file.stem}.gif"
        if fps is not None and speed is not None:
            raise ValueError(f"--fps {fps:g} and --speed {speed:g}: give one of them")
        pictures = 10.0 if fps is None else fps
        check_film(path, pictures, dpi)
        check_field(field)
        check_writable(path, [file])
        run = Run.read(file)
        save_film(run, path, field, every, pictures if speed is None else rate(run, every, speed), motion, dpi)
    print(path)


@app.command(epilog="Example:  sph export slide.nc --vtk slide_vtk  (then open slide_vtk/slide.pvd in ParaView)")
def export(
    file: Trajectory,
    vtk: Annotated[str, typer.Option(metavar="FOLDER", help="folder for NAME.pvd and one NAME_0000.vtu for each frame")],
) -> None:
    """Export a trajectory to ParaView: particles with displacement, velocity, stress, beta and other variables, as stored."""
    with refusals("writing one file per frame"):
        from sph.output.paraview import export_paraview
        from sph.storage import trajectory

        folder = Path(vtk)
        if not vtk or folder.exists() and not folder.is_dir():
            raise ValueError(f"--vtk {vtk!r}: is {'a file' if vtk else 'an empty name'}; name a folder")
        check_apart(folder / f"{file.stem}.pvd", [file], "--vtk")
        print(export_paraview(trajectory.read_run(file), folder, file.stem))


@app.command(epilog="Examples:  sph metrics slide.nc  |  sph metrics slide.nc --all  |  sph metrics slide.nc --json")
def metrics(
    file: Trajectory,
    every: Annotated[bool, typer.Option("--all", help="every metric, with its definition")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable, in SI units, every metric")] = False,
) -> None:
    """Measure a trajectory: status, class, displacement of A, run-out, deposit."""
    with refusals("measuring the trajectory"):
        from sph.checks.after_run import after_run
        from sph.measures.metrics import CHIEF, METRICS, MetricSettings, measure
        from sph.output.run import Run

        run = Run.read(file)
        values = measure(run, MetricSettings())
        found = after_run(run.scene, values)
    if as_json:
        print(to_json(values, indent=1))
        return
    shown = {name: f"{value:.4g}" if isinstance(value, float) else str(value) for name, value in values.items()}
    if every:
        show_table(("metric", "value", "unit", "definition"), ((row.name, shown[row.name], row.units, row.text) for row in METRICS))
    else:
        show_table(("metric", "value", "unit"), ((row.name, shown[row.name], row.units) for row in METRICS if row.name in CHIEF))
        print(f"--all shows {len(METRICS) - len(CHIEF)} more, with definitions")
    for each in found:
        say(each.line())


@app.command(epilog="Examples:  sph status  |  sph status results/paper/standard --watch  |  sph status --configfile study.yaml")
def status(
    folder: Annotated[
        Path | None,
        typer.Argument(
            metavar="RESULTS_FOLDER", help="results/<study>/<fidelity> of any study here; by default that of config/config.yaml"
        ),
    ] = None,
    configfile: Annotated[Path | None, typer.Option(help="the study's configuration, as for snakemake --configfile")] = None,
    watching: Annotated[bool, typer.Option("--watch", help="refresh every 2 s until all simulations are done")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable, a row for each job")] = False,
) -> None:
    """Follow a running study from a second terminal: jobs done, running, failed and waiting, and the time left; it only reads files."""
    with refusals():
        from sph.command.status import Job, State, lines, located, look_at, record, watch

        catalogue = located(folder, configfile)
        known: dict[str, Job] = {}

        def look_again() -> list[State]:
            return look_at([*catalogue.plan.jobs, *catalogue.started], catalogue.base, known)

        if watching and not as_json:
            return watch(catalogue.plan, look_again)
        found = look_again()
    print(to_json(record(catalogue.plan, found), indent=1) if as_json else "\n".join(lines(catalogue.plan, found)))


@app.command(
    epilog="Examples:  sph explain results/paper/standard/study.csv S_R=0.10 gamma=100 amplitude=6.0 --column runout  |  "
    "sph explain results/paper/standard/study.csv  |  sph explain results/paper/standard/stages/gravity.nc --json"
)
def explain(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="table of runs (CSV) or file of a run (netCDF), in its results folder")],
    where: Annotated[list[str] | None, typer.Argument(metavar="[COLUMN=VALUE]...", help="rows to trace; all by default")] = None,
    column: Annotated[str | None, typer.Option(help="the one column to define; all by default")] = None,
    configfile: Annotated[Path | None, typer.Option(help="the study's configuration, as for snakemake --configfile")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable")] = False,
) -> None:
    """Trace numbers in a table to run, scene, record, ground line, solver and definition; exit code 4 if any is out of date or altered."""
    from sph.command.explain import explain, lines, record

    with refusals("reading the runs and measuring them again"):
        wrong = [condition for condition in where or () if "=" not in condition]
        if wrong:
            raise ValueError(f"{wrong[0]!r}: write COLUMN=VALUE, e.g. S_R=0.10")
        conditions = dict(condition.split("=", 1) for condition in where or ())
        rows, plan = explain(file, conditions, configfile)
        known = [number.column for number in rows[0].numbers]
        if column is not None and not known:
            raise ValueError(f"--column {column!r}: must be left out for the file of a run")
        check_known("--column", [column], known)
    print(to_json(record(rows, plan), indent=1) if as_json else "\n".join(lines(rows, plan, column)))
    if any(row.differs for row in rows):
        raise typer.Exit(DIFFERS)


@app.command(epilog="Examples:  sph pack config/studies/gentle_layered.yaml  |  sph pack study.yaml --results -o myslope.tar.gz")
def pack(
    study: Annotated[
        Path, typer.Argument(metavar="STUDY", help="configuration of a study (YAML), as for snakemake --configfile, from the same folder")
    ],
    results: Annotated[bool, typer.Option("--results", help="include results/<study>: page, tables, figures, runs")] = False,
    out: Annotated[
        Path | None, typer.Option("-o", "--out", help="archive to write (.zip, .tar.gz); <study>.zip in this folder by default")
    ] = None,
) -> None:
    """Pack a study and every file that it names into an archive that can be run elsewhere; its README.txt says how."""
    with refusals("building the scenes of the study and packing its files"):
        from sph.command.pack import pack

        path, files = pack(study, out, results)
    print(f"{path}: {files} files, {path.stat().st_size / 1e6:.2f} MB; README.txt in it says how to run the study elsewhere")


@app.command(epilog="Examples:  sph fos slope.yaml  |  sph fos slope.yaml --reduce S_R --set numerics.spacing=2 --rule observation=20")
def fos(
    scene: SceneFile,
    set_: Settings = None,
    reduce: Annotated[
        str, typer.Option(help="what to reduce: strength (c and tan(phi) divided by F) or S_R (the paper's factor on c and phi)")
    ] = "strength",
    tolerance: Tolerance = TOLERANCE,
    rule: Rule = None,
    as_json: AsJson = False,
    out: Trials = None,
    spacings: Spacings = None,
    single: Single = False,
) -> None:
    """Find the static factor of safety, or the strength ratio S_R at which the weakened slope just stands, extrapolated to spacing 0."""
    with refusals("searching by trial runs, each reported when it ends"):
        from sph.command.repeat import read_given
        from sph.command.stability import answer

        check_known("--reduce", [reduce], ("strength", "S_R"))
        loaded, inputs = read_given(scene, parse_settings(set_))
        if out is not None:
            check_writable(out, inputs)
        answer(reduce, loaded, tolerance, parse_settings(rule, "--rule"), as_json, out, single, parse_spacings(spacings))


@app.command(epilog="Example:  sph yield-acceleration slope.yaml --set numerics.spacing=2 --out trials.csv")
def yield_acceleration(
    scene: SceneFile,
    set_: Settings = None,
    tolerance: Tolerance = TOLERANCE,
    rule: Rule = None,
    as_json: AsJson = False,
    out: Trials = None,
    spacings: Spacings = None,
    single: Single = False,
) -> None:
    """Find the pseudo-static yield acceleration for Newmark's method: the constant horizontal acceleration at which the slope fails."""
    with refusals("searching by trial runs, each reported when it ends"):
        from sph.command.repeat import read_given
        from sph.command.stability import answer

        loaded, inputs = read_given(scene, parse_settings(set_))
        if out is not None:
            check_writable(out, inputs)
        answer("acceleration", loaded, tolerance, parse_settings(rule, "--rule"), as_json, out, single, parse_spacings(spacings))


@app.command(
    epilog="Examples:  sph advise slope.yaml --error 10%  |  sph advise --error 5% --of paper  |  sph advise --error 0.2 --table trade.csv"
)
def advise(
    error: Annotated[str, typer.Option(help="largest error allowed, 10% or 0.1")],
    scene: Annotated[Path | None, typer.Argument(metavar="[SCENE]", help="scene of your own slope, to compare spacings for")] = None,
    quantity: Annotated[str, typer.Option(help="displacement, runout or both")] = "both",
    of: Annotated[str | None, typer.Option(help="fidelity to compare with, e.g. paper; the finest run by default")] = None,
    scheme: Annotated[str, typer.Option(help="scheme of the scenes: paper, or resolved for your own slopes")] = "paper",
    table: Annotated[
        Path | None, typer.Option(help="table to answer from, trade.csv or resolution.csv; by default the one measured for this release")
    ] = None,
) -> None:
    """Name the cheapest measured setting within a given error, or the most accurate one (exit code 2) if there is none.

    With a scene: the errors of several spacings on its slope, in rows of particles over the height, and the coarsest within that error.
    """
    with refusals("reading the table"):
        from sph.command.advise import for_scene, lines
        from sph.command.repeat import read_given
        from sph.experiments.trade import advice
        from sph.experiments.trade.table import QUANTITIES, WORDS, against, read_trade
        from sph.scene.configuration import merge
        from sph.scene.schema import make_scene
        from sph.scene.scheme import SCHEMES
        from sph.study.cost import cost

        limit = parse_error(error)
        check_known("--quantity", [quantity], (*QUANTITIES, "both"))
        check_known("--scheme", [scheme], SCHEMES)
        measured = read_trade(table) if table else advice.shipped_table(scheme)
        if measured is None:
            raise ValueError(advice.NOT_MEASURED_YET)
        if of is not None:
            measured = against(measured, of)
        wanted = tuple(QUANTITIES) if quantity == "both" else (quantity,)
        if scene is not None:
            if of is not None:
                raise ValueError(f"--of {of}: has no effect with a scene, whose spacings are compared with the finest run; leave it out")
            loaded, _ = read_given(scene, {})
            spacings = advice.resolutions(loaded, read_trade(table) if table else None)
            finer = {each.spacing: make_scene(merge(loaded.model_dump(), {"numerics": {"spacing": each.spacing}})) for each in spacings}
            said, fits = for_scene(spacings, limit, wanted, {spacing: cost(built).seconds for spacing, built in finer.items()})
        else:
            found = advice.advise(measured, limit, wanted)
            said, fits = lines(found, limit, [WORDS[name] for name in wanted], measured), found.fits
    print("\n".join(said))
    if not fits:
        raise typer.Exit(REFUSED)


@app.command(
    epilog="Examples:  sph newmark config/scenes/paper.yaml --ay 0.25g  |  sph newmark record.csv --ay '2.5 m/s2' --scale-to 0.6g  |  "
    "sph newmark AKT0130001010000.EW --ay 0.05g --baseline 0 --direction both"
)
def newmark(
    motion: Annotated[Path, typer.Argument(metavar="MOTION", help="scene (YAML), or record (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv)")],
    ay: Annotated[str, typer.Option(metavar="A", help="yield acceleration with its unit, 0.25g or '2.5 m/s2'")],
    upslope: Annotated[
        str | None, typer.Option(metavar="A", help="yield acceleration for upslope slip; by default the block slips downslope only")
    ] = None,
    scale_to: Annotated[str | None, typer.Option(metavar="A", help="scale the motion to this peak acceleration")] = None,
    set_: Settings = None,
    unit: UnitOption = None,
    component: ComponentOption = None,
    baseline: BaselineOption = None,
    band_pass: BandPassOption = None,
    direction: Annotated[
        str, typer.Option(help="polarity: recorded, turned (reversed), or both to get the larger displacement")
    ] = "recorded",
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable, in SI units")] = False,
) -> None:
    """Find the displacement of a Newmark sliding block under a ground motion; positive accelerations drive it downslope, as in a scene."""
    with refusals("reading the motion and sliding the block"):
        from sph.command.newmark import DIRECTIONS, lines, slide

        check_known("--direction", [direction], DIRECTIONS)
        treatment = parse_treatment(unit, baseline, band_pass, component)
        down = parse_acceleration(ay, "--ay")
        up = None if upslope is None else parse_acceleration(upslope, "--upslope")
        peak = None if scale_to is None else parse_acceleration(scale_to, "--scale-to")
        answer, heed = slide(motion, parse_settings(set_), down, up, peak, treatment, direction)
    for each in heed:
        say(each.line())
    print(to_json(answer._asdict(), indent=1) if as_json else "\n".join(lines(answer)))


@app.command(epilog="Examples:  sph site slope.yaml  |  sph site slope.yaml --plasticity 30 --at 120 --out compatible.yaml")
def site(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (YAML)")],
    set_: Settings = None,
    at: Annotated[float | None, typer.Option(help="x of the column, in the coordinates of the scene, m; by default the crest edge")] = None,
    plasticity: Annotated[float, typer.Option(min=0, max=200, help="plasticity index of Darendeli's curves, %")] = 0.0,
    ocr: Annotated[float, typer.Option(min=1, max=50, help="overconsolidation ratio for Darendeli's curves")] = 1.0,
    out: Annotated[Path | None, typer.Option(help="scene to write (YAML), with the strain-compatible stiffness and damping")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable: strains and damping as ratios, SI units")] = False,
) -> None:
    """Find the strain-compatible stiffness and damping of each layer (equivalent-linear site response)."""
    with refusals("shaking a column of the scene"):
        from sph.command.site import COLUMNS, darendeli, lines, record, respond, rows
        from sph.scene.configuration import merge, scene_files
        from sph.scene.schema import make_scene, written_scene

        data = merge(written_scene(scene), parse_settings(set_))
        loaded = make_scene(data, str(scene))
        if out is not None:
            check_writable(out, [scene, *scene_files(data)])
        found = respond(loaded, darendeli(plasticity, ocr), at)
        if out is not None:
            from sph.command.compatible import WITHIN, compatible, write_compatible
            from sph.command.compatible import lines as comparison

            made = compatible(data, loaded, found)
            write_compatible(out, made, found)
            if not made.within:
                say(f"{out}: differs by more than {100 * WITHIN:g} % from the sublayered column; choose a smaller numerics.spacing")
    if as_json:
        print(to_json(record(found), indent=1))
        return
    show_table(COLUMNS, rows(loaded, found))
    print("\n".join(lines(found)))
    if out is not None:
        print("\n".join([*comparison(made), f"{out}: written; look at it with sph check {out}"]))


@app.command(epilog="Examples:  sph cost config/config.yaml  |  sph cost config/config.yaml --fidelity paper --cores 64 --speed 0.8")
def cost(
    study: Annotated[
        Path,
        typer.Argument(metavar="STUDY", help="configuration of a study (YAML); one without a scene overrides keys of config/config.yaml"),
    ],
    fidelity: Annotated[str | None, typer.Option(help="one of the study's fidelities; by default the one that it names")] = None,
    cores: Annotated[int | None, typer.Option(min=1, max=100_000, help="cores to run on; by default all cores of this machine")] = None,
    speed: Annotated[
        float | None,
        typer.Option(help="speed of a core relative to the reference machine; by default taken from finished runs, or measured here"),
    ] = None,
    start: Annotated[float, typer.Option(min=0, max=3600, help="start-up time of each job, s; about 10 on a cluster")] = 5.0,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable: times in s, memory and disk in MiB")] = False,
) -> None:
    """Predict the cost of a study: core-hours, wall time, memory and disk, in total and for the remaining runs."""
    with refusals("building the scenes of the study and measuring the speed of a core"):
        from sph.command.cost import lines, record, study_cost
        from sph.command.status import located

        if speed is not None and not 1e-3 <= speed <= 1e3:
            raise ValueError(f"--speed {speed:g}: must be from 0.001 to 1000")
        catalogue = located(None, study)
        plan = catalogue.plan
        if fidelity is not None:
            check_known("--fidelity", [fidelity], plan.study.fidelities)
            plan = plan.at(fidelity)
        found = study_cost(plan, catalogue.base, cores or os.cpu_count() or 1, speed, start)
    print(to_json(record(found), indent=1) if as_json else "\n".join(lines(found)))


@app.command(
    epilog="Examples:  sph motion RSN6_ELC180.AT2 --plot elcentro.png  |  sph motion record.csv --unit g  |  "
    "sph motion slope.yaml --set motion.amplitude=3.5 --plot motion.pdf"
)
def motion(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="record (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv), scene (YAML) or trajectory (netCDF)")
    ],
    set_: Settings = None,
    unit: UnitOption = None,
    component: ComponentOption = None,
    baseline: BaselineOption = None,
    band_pass: BandPassOption = None,
    direction: Annotated[str, typer.Option(help="polarity: recorded or turned (reversed)")] = "recorded",
    out: Annotated[
        Path | None,
        typer.Option("--plot", metavar="PICTURE", help="picture of histories and response spectrum (.png, .pdf, .svg)"),
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable, in SI units")] = False,
) -> None:
    """Measure a ground motion (a record, raw or processed, or the motion of a scene): peaks, Arias intensity, durations, spectrum."""
    with refusals("reading the motion and measuring it"):
        from sph.command.motion import measures, read_shaking, rows

        if direction not in ("recorded", "turned"):
            raise ValueError(f"--direction {direction!r}: must be recorded or turned; the measures of both are the same")
        shaking = read_shaking(file, parse_settings(set_), parse_treatment(unit, baseline, band_pass, component), direction == "turned")
        if out is not None:
            check_picture(out, shaking.files, "--plot")
        found = measures(shaking)
        if out is not None:
            from sph.figures.ground_motion import figure_ground_motion
            from sph.figures.style import save

            save(figure_ground_motion(shaking.components, shaking.interval, shaking.name), out)
    for each in shaking.findings:
        say(each.line())
    if as_json:
        print(to_json({name: values._asdict() for name, values in found.items()}, indent=1))
        return
    show_table(("", *found), rows(found))


@app.command(epilog="Examples:  sph schema scene > scene.schema.json  |  sph schema study > study.schema.json")
def schema(
    of: Annotated[
        str, typer.Argument(metavar="FILE", help="kind of file: scene, study, or an experiment such as trade or trigger")
    ] = "scene",
) -> None:
    """Print the JSON Schema of a file, with which an editor completes keys and marks mistakes (also in config/schemas)."""
    with refusals():
        from sph.command.schema import MODELS, schema_text

        check_known("FILE", [of], MODELS)
    print(schema_text(of), end="")


def main() -> None:
    """Entry point.  A character that the terminal lacks is printed as an escape, and what could not be printed is an error."""
    warnings.formatwarning = lambda message, *_: f"warning: {message}\n"
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")
    try:
        try:
            app()
        finally:
            print(end="", flush=True)
    except OSError as error:
        os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # for what is left in the buffer
        if isinstance(error, BrokenPipeError):
            raise SystemExit(1) from None
        say(f"the output cannot be printed: {error.strerror}")
        raise SystemExit(REFUSED) from error


if __name__ == "__main__":
    main()
