"""The command ``sph``: its commands, one after another; what each does stands in the module that it imports.

Exit codes: 0 done; 2 refused, with one message that names the cause and the remedy: the scene, the command line, a file that cannot be
read or written (earlier files are as they were), or nothing measured is as good as asked; 3 the run was stopped by its guard (status
``diverged``), and the run so far was written; 4 a result is out of date or altered (``explain``).  A static test that diverges after
the slope has failed counts as failed: 0.  Anything else is a fault of the program, with a traceback (1), or of its surroundings: 1
without one where nobody reads what is printed (``| head``), 130 interrupted, 137 killed; ``sph run`` then continues from its checkpoint.
"""

from __future__ import annotations

import functools
import os
import sys
import warnings
from collections.abc import Callable
from io import TextIOWrapper
from pathlib import Path
from typing import Annotated, ParamSpec

import typer

from sph.command.options import (
    AsJson,
    BandPass,
    Baseline,
    CheckedFile,
    Component,
    Configfile,
    Picture,
    Progressing,
    Rule,
    SceneFile,
    Settings,
    Single,
    Spacings,
    Study,
    Tolerance,
    Trajectory,
    Trials,
    Unit,
    WithPlaces,
    parse_acceleration,
    parse_conditions,
    parse_error,
    parse_numbers,
    parse_settings,
    parse_treatment,
)
from sph.command.terminal import Commands, refusals, say
from sph.jobs.exit_codes import REFUSED
from sph.stability.search import TOLERANCE

app = typer.Typer(
    cls=Commands,
    no_args_is_help=True,
    context_settings={"help_option_names": ["-h", "--help"]},
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)
Asked = ParamSpec("Asked")
Told = str | tuple[str, int] | None
"""What a command prints, with its exit code where that may be another than 0; None where it has printed itself."""


def command(epilog: str, doing: str = "", name: str | None = None) -> Callable[[Callable[Asked, Told]], Callable[Asked, Told]]:
    """Make a function a command, which says what it is ``doing`` where that takes long."""

    def made(body: Callable[Asked, Told]) -> Callable[Asked, Told]:
        @functools.wraps(body)
        def called(*args: Asked.args, **kwargs: Asked.kwargs) -> None:
            with refusals(doing):
                told = body(*args, **kwargs)
            text, code = told if isinstance(told, tuple) else (told, 0)
            if text is not None:
                print(text)
            if code:
                raise typer.Exit(code)

        app.command(name, epilog=epilog)(called)
        return body

    return made


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


@command(
    "Examples:  sph new ground.csv RSN6_ELC180.AT2 --out myslope  |  sph new --slope 28,32 --cover 4 "
    "--soil unit_weight=19,cohesion=6,friction_angle=32,residual_cohesion=0,residual_friction_angle=20 --water 2.5 "
    "--record A.csv --record B.csv --scale-to 0.35g --place path=8,house=40 --alternative drained=5,berm=5 --out myslope",
    "reading ground and records",
)
def new(
    ground: Annotated[
        Path | None, typer.Argument(metavar="[GROUND]", help="ground line of the survey (CSV, GeoJSON or WKT), unless --slope is given")
    ] = None,
    first: Annotated[
        Path | None, typer.Argument(metavar="[RECORD]", help="ground motion (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv), as --record")
    ] = None,
    slope: Annotated[
        str | None, typer.Option(metavar="HEIGHT,ANGLE", help="a plain slope instead of a survey, m and degree; x is 0 at its toe")
    ] = None,
    cover: Annotated[
        float | None,
        typer.Option(metavar="THICKNESS", help="of a weak cover on stronger ground, vertically, m: adds a layer, and chooses the spacing"),
    ] = None,
    soil: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUE,...",
            help="soil of the slope or of its cover: unit_weight (kN/m3), peak strength by cohesion (kPa) and friction_angle (degree), "
            "that of failed soil by both residual_cohesion (0 is usual) and residual_friction_angle, shear_wave_speed (m/s), poisson_ratio",
        ),
    ] = None,
    below: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUE,...", help="soil below the cover, as --soil, with residual strengths; weathered rock where it is not given"
        ),
    ] = None,
    water: Annotated[
        str | None, typer.Option(metavar="DEPTH", help="of the water table below the ground, m, or a file of its line")
    ] = None,
    record: Annotated[list[Path] | None, typer.Option(help="ground motion; repeat it for several, which the study compares")] = None,
    scale_to: Annotated[
        list[str] | None,
        typer.Option(metavar="A,...", help="scale every record to this peak acceleration, as 0.35g; to each of several, as 0.2g,0.35g"),
    ] = None,
    design: Annotated[
        str | None, typer.Option(metavar="A", help="that one of these accelerations which the page answers first; otherwise the largest")
    ] = None,
    component: Component = None,
    unit: Unit = None,
    place: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=X,...",
            help="what the debris must not reach, or the ground not move at: its x, m; of a plain slope its distance from the toe, "
            "negative on the slope and behind it",
        ),
    ] = None,
    alternative: Annotated[
        list[str] | None,
        typer.Option(
            metavar="NAME=VALUE,...",
            help="measures to compare: drained, by the depth of the lowered water table, or by how much the line of "
            "--water is lowered (m); berm, by its height (m); reinforced, by the cohesion that roots or nails add (kPa)",
        ),
    ] = None,
    softening: Annotated[
        list[str] | None,
        typer.Option(
            metavar="KEY=VALUE,...",
            help="loss of strength with slip, as sph fit-shear prints it: slip_at_peak and slip_at_residual (m), shape (linear or "
            "exponential), width (m); 1 and 100 mm where it is not given",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="folder to write scene.yaml, study.yaml and their lines into")] = Path(),
) -> Told:
    """Write a scene and a study of your own slope, ready to run, and tell what was assumed because you did not type it."""
    from sph.command.new import new

    records = [*([first] if first else ()), *(record or ())]
    return new(ground, slope, records, scale_to, design, component, unit, cover, soil, below, water, place, alternative, softening, out)


@command(
    "Examples:  sph run config/scenes/paper.yaml  |  sph run config/scenes/paper.yaml --set coupling.S_R=0.10 "
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
    backend: Annotated[str, typer.Option(help="cpu, or cuda: a graphics card of NVIDIA")] = "cpu",
) -> Told:
    """Simulate a scene and write its trajectory; after Ctrl-C or a kill the same command continues from the last checkpoint.

    Given a trajectory, it repeats the run from the start to the same stage, bit for bit.
    """
    from sph.command.run import run

    return run(scene, parse_settings(set_), out, restart, until, threads, checkpoint, overwrite, backend)


@command("Example:  sph compile config/scenes/*.yaml", "loading the solver", "compile")
def compile_(scenes: Annotated[list[Path], typer.Argument(metavar="SCENE...", help="scene files (YAML)")]) -> Told:
    """Compile the solver for scenes and their static tests; later runs with the same terms reuse it on this machine."""
    from sph.command.compile import compile_all

    compile_all(scenes)
    return None


@command("Example:  sph info config/scenes/paper.yaml --set numerics.spacing=0.5", "placing the particles")
def info(scene: SceneFile, set_: Settings = None) -> Told:
    """Show a summary of a scene: particles, wave speeds, time-step limits, terms, cost."""
    from sph.command.info import info

    return info(scene, parse_settings(set_))


@command(
    "Examples:  sph check config/scenes/paper.yaml --plot paper.png  |  sph check study.yaml  |  sph check slope.yaml --watch  |  "
    "sph check slope.yaml --json",
    "placing the particles; with --stability, testing whether it stands by trial runs",
)
def check(
    scene: CheckedFile = None,
    set_: Settings = None,
    plot: Picture = None,
    study: Annotated[
        Path | None,
        typer.Option(
            "--configfile",
            help="configuration of a study, whose fidelities and alternatives to check as well and whose places to draw; alone, its scene",
        ),
    ] = None,
    static: Annotated[
        bool,
        typer.Option(
            "--stability",
            help="also test whether the slope stands without shaking, and find its factor of safety and yield acceleration; takes minutes",
        ),
    ] = False,
    magnitude: Annotated[
        float | None,
        typer.Option(
            help="moment magnitude of the earthquake, for factors of safety of sand with a blow count against liquefaction and of clay "
            "against cyclic softening",
            min=4.0,
            max=10.0,
        ),
    ] = None,
    watching: Annotated[
        bool, typer.Option("--watch", help="show section and findings in the browser, and again whenever the scene or its files are saved")
    ] = False,
    as_json: AsJson = False,
) -> Told:
    """Check a scene before it is run: a table, a drawing, and findings on what may spoil its results."""
    from sph.command.check import answer

    return answer(scene, parse_settings(set_), plot, study, static, magnitude, as_json, watching)


@command("Examples:  sph plot slide.nc  |  sph plot slide.nc --field speed --time 6", "reading the trajectory and drawing it")
def plot(
    file: Trajectory,
    out: Annotated[Path | None, typer.Option(help="picture to write (.png, .pdf, .svg); beside the trajectory by default")] = None,
    field: Annotated[
        str, typer.Option(help="quantity that colours the profile: initial_height, displacement, speed, beta, ...")
    ] = "initial_height",
    time: Annotated[float | None, typer.Option(help="time of the profile in s; the last frame by default")] = None,
    study: WithPlaces = None,
) -> Told:
    """Draw a trajectory: profile, probes and energies."""
    from sph.command.results import plot

    return plot(file, out, field, time, study)


@command(
    "Examples:  sph animate slide.nc --out slide.gif  |  sph animate slide.nc --out slide.mp4 --field beta --motion --speed 2  |  "
    "sph animate slide.nc --out slide.gif --every 2 --fps 5 --dpi 80",
    "reading the trajectory and drawing its frames, about ten per second",
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
    study: WithPlaces = None,
) -> Told:
    """Animate a trajectory: the profile, coloured by a field on a fixed scale, as a GIF or an MP4."""
    from sph.command.results import animate

    return animate(file, out, field, every, fps, speed, motion, dpi, study)


@command("Example:  sph export slide.nc --vtk slide_vtk  (then open slide_vtk/slide.pvd in ParaView)", "writing one file per frame")
def export(
    file: Trajectory,
    vtk: Annotated[str, typer.Option(metavar="FOLDER", help="folder for NAME.pvd and one NAME_0000.vtu for each frame")],
) -> Told:
    """Export a trajectory to ParaView: particles with displacement, velocity, stress, beta and other variables, as stored."""
    from sph.command.results import export

    return export(file, vtk)


@command("Examples:  sph metrics slide.nc  |  sph metrics slide.nc --all  |  sph metrics slide.nc --json", "measuring the trajectory")
def metrics(
    file: Trajectory,
    every: Annotated[bool, typer.Option("--all", help="every metric, with its definition")] = False,
    as_json: AsJson = False,
) -> Told:
    """Measure a trajectory: status, class, displacement of A, run-out, deposit."""
    from sph.command.results import metrics

    return metrics(file, every, as_json)


@command("Examples:  sph status  |  sph status study.yaml --watch  |  sph status results/paper/standard")
def status(
    study: Progressing = None,
    configfile: Configfile = None,
    watching: Annotated[bool, typer.Option("--watch", help="refresh every 2 s until all simulations are done")] = False,
    as_json: AsJson = False,
) -> Told:
    """Follow a running study from a second terminal: jobs done, running, failed and waiting, and the time left; it only reads files."""
    from sph.command.status import status

    return status(study, configfile, watching, as_json)


@command("Examples:  sph page study.yaml --watch  |  sph page results/paper/standard", "measuring the runs that are done")
def page(
    study: Progressing = None,
    configfile: Configfile = None,
    watching: Annotated[bool, typer.Option("--watch", help="write it again whenever runs are done, until all are")] = False,
) -> Told:
    """Write so_far.html, the page of a study of which only some runs are done; a second terminal follows snakemake with it."""
    from sph.command.page import page

    return page(study, configfile, watching, say)


@command(
    "Examples:  sph explain study.yaml S_R=0.10 --column runout  |  sph explain results/paper/standard/study.csv S_R=0.10 gamma=100 "
    "amplitude=6.0  |  sph explain results/paper/standard/stages/gravity.nc --json",
    "reading the runs and measuring them again",
)
def explain(
    file: Annotated[
        Path,
        typer.Argument(metavar="FILE", help="study (YAML) or its study.csv, or a run or a stage (netCDF) of any target"),
    ],
    where: Annotated[list[str] | None, typer.Argument(metavar="[COLUMN=VALUE]...", help="rows to trace; all by default")] = None,
    column: Annotated[str | None, typer.Option(help="the one column to define; all by default")] = None,
    configfile: Configfile = None,
    as_json: AsJson = False,
) -> Told:
    """Trace numbers in a table to run, scene, record, ground line, solver and definition; exit code 4 if any is out of date or altered."""
    from sph.command.explain import explain

    return explain(file, parse_conditions(where), column, configfile, as_json)


@command(
    "Examples:  sph pack config/studies/gentle_layered.yaml  |  sph pack study.yaml --results -o myslope.zip",
    "building the scenes of the study and packing its files",
)
def pack(
    study: Study,
    results: Annotated[bool, typer.Option("--results", help="include results/<study>: page, tables, figures, runs")] = False,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="archive to write (.zip); <study>.zip in this folder by default")] = None,
) -> Told:
    """Pack a study and every file that it names into an archive that can be run elsewhere; its README.txt says how."""
    from sph.command.pack import pack

    path, files = pack(study, out, results)
    return f"{path}: {files} files, {path.stat().st_size / 1e6:.2f} MB; README.txt in it says how to run the study elsewhere"


@command(
    "Examples:  sph fos slope.yaml  |  sph fos slope.yaml --reduce S_R --set numerics.spacing=2 --rule observation=20",
    "searching by trial runs, each reported when it ends",
)
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
) -> Told:
    """Find the static factor of safety, or the strength ratio S_R at which the weakened slope just stands, extrapolated to spacing 0."""
    from sph.command.stability import answer
    from sph.scene.names import check_known
    from sph.stability.record import SAFETY, WEAKENED

    reduced = {"strength": SAFETY, "S_R": WEAKENED}
    check_known("--reduce", [reduce], reduced)
    changes, of_rule = parse_settings(set_), parse_settings(rule, "--rule")
    return answer(reduced[reduce], scene, changes, tolerance, of_rule, as_json, out, single, parse_numbers(spacings, "--spacings"))


@command(
    "Example:  sph yield-acceleration slope.yaml --set numerics.spacing=2 --out trials.csv",
    "searching by trial runs, each reported when it ends",
)
def yield_acceleration(
    scene: SceneFile,
    set_: Settings = None,
    tolerance: Tolerance = TOLERANCE,
    rule: Rule = None,
    as_json: AsJson = False,
    out: Trials = None,
    spacings: Spacings = None,
    single: Single = False,
) -> Told:
    """Find the pseudo-static yield acceleration for Newmark's method: the constant horizontal acceleration at which the slope fails."""
    from sph.command.stability import answer
    from sph.stability.record import YIELD

    changes, of_rule = parse_settings(set_), parse_settings(rule, "--rule")
    return answer(YIELD, scene, changes, tolerance, of_rule, as_json, out, single, parse_numbers(spacings, "--spacings"))


@command(
    "Examples:  sph advise slope.yaml --error 10%  |  sph advise --error 5% --of paper  |  "
    "sph advise --error 0.2 --table cost-accuracy.csv",
    "reading the table",
)
def advise(
    error: Annotated[str, typer.Option(help="largest error allowed, 10% or 0.1")],
    scene: Annotated[Path | None, typer.Argument(metavar="[SCENE]", help="scene of your own slope, to compare spacings for")] = None,
    quantity: Annotated[str, typer.Option(help="displacement, runout or both")] = "both",
    of: Annotated[str | None, typer.Option(help="fidelity to compare with, e.g. paper; the finest run by default")] = None,
    scheme: Annotated[str, typer.Option(help="scheme of the scenes: paper, or resolved for your own slopes")] = "paper",
    table: Annotated[
        Path | None,
        typer.Option(help="table to answer from, cost-accuracy.csv or resolution.csv; by default the one measured for this release"),
    ] = None,
) -> Told:
    """Name the cheapest measured setting within a given error, or the most accurate one (exit code 2) if there is none.

    With a scene: the errors of several spacings on its slope, in rows of particles over the height, and the coarsest within that error.
    """
    from sph.command.advise import advise

    return advise(parse_error(error), scene, quantity, of, scheme, table)


@command(
    "Examples:  sph newmark config/scenes/paper.yaml --ay 0.25g  |  sph newmark record.csv --ay '2.5 m/s2' --scale-to 0.6g  |  "
    "sph newmark AKT0130001010000.EW --ay 0.05g --baseline 0 --direction both",
    "reading the motion and sliding the block",
)
def newmark(
    motion: Annotated[Path, typer.Argument(metavar="MOTION", help="scene (YAML), or record (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv)")],
    ay: Annotated[str, typer.Option(metavar="A", help="yield acceleration with its unit, 0.25g or '2.5 m/s2'")],
    upslope: Annotated[
        str | None, typer.Option(metavar="A", help="yield acceleration for upslope slip; by default the block slips downslope only")
    ] = None,
    scale_to: Annotated[str | None, typer.Option(metavar="A", help="scale the motion to this peak acceleration")] = None,
    set_: Settings = None,
    unit: Unit = None,
    component: Component = None,
    baseline: Baseline = None,
    band_pass: BandPass = None,
    direction: Annotated[
        str, typer.Option(help="polarity: recorded, turned (reversed), or both to get the larger displacement")
    ] = "recorded",
    as_json: AsJson = False,
) -> Told:
    """Find the displacement of a Newmark sliding block under a ground motion; positive accelerations drive it downslope, as in a scene."""
    from sph.command.newmark import newmark

    treatment = parse_treatment(unit, baseline, band_pass, component)
    down = parse_acceleration(ay, "--ay")
    up = None if upslope is None else parse_acceleration(upslope, "--upslope")
    peak = None if scale_to is None else parse_acceleration(scale_to, "--scale-to")
    return newmark(motion, parse_settings(set_), down, up, peak, treatment, direction, as_json)


@command(
    "Examples:  sph fit-shear ringshear.csv --normal-stress 100  |  "
    "sph fit-shear box50.csv box100.csv box200.csv --normal-stress 50,100,200 --height 32 --plot tests.png",
    "fitting the tests",
)
def fit_shear(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="shear tests (CSV): displacement, shear stress and, if there, normal stress")
    ],
    normal: Annotated[
        str | None, typer.Option("--normal-stress", metavar="KPA,...", help="normal stress of each file without a column of it, kPa")
    ] = None,
    height: Annotated[
        float | None, typer.Option(min=0.1, max=1e4, help="height of the slope, m, from which the width of the softening follows")
    ] = None,
    out: Picture = None,
    as_json: AsJson = False,
) -> Told:
    """Fit peak and residual strength and the loss of strength with slip to shear tests, and print the keys of a scene."""
    from sph.command.fit_shear import fit_shear

    return fit_shear(files, parse_numbers(normal, "--normal-stress"), height, out, as_json)


@command(
    "Examples:  sph site slope.yaml  |  sph site slope.yaml --plasticity 30 --at 120 --out compatible.yaml", "shaking a column of the scene"
)
def site(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="scene file (YAML)")],
    set_: Settings = None,
    at: Annotated[float | None, typer.Option(help="x of the column, in the coordinates of the scene, m; by default the crest edge")] = None,
    plasticity: Annotated[float, typer.Option(min=0, max=200, help="plasticity index of Darendeli's curves, %")] = 0.0,
    ocr: Annotated[float, typer.Option(min=1, max=50, help="overconsolidation ratio for Darendeli's curves")] = 1.0,
    out: Annotated[Path | None, typer.Option(help="scene to write (YAML), with the strain-compatible stiffness and damping")] = None,
    as_json: AsJson = False,
) -> Told:
    """Find the strain-compatible stiffness and damping of each layer (equivalent-linear site response)."""
    from sph.command.compatible import site

    return site(scene, parse_settings(set_), at, plasticity, ocr, out, as_json)


@command(
    "Examples:  sph cost config/config.yaml  |  sph cost config/config.yaml --fidelity paper --cores 64 --speed 0.8",
    "building the scenes of the study and measuring the speed of a core",
)
def cost(
    study: Study,
    fidelity: Annotated[str | None, typer.Option(help="one of the study's fidelities; by default the one that it names")] = None,
    cores: Annotated[int | None, typer.Option(min=1, max=100_000, help="cores to run on; by default all cores of this machine")] = None,
    speed: Annotated[
        float | None,
        typer.Option(help="speed of a core relative to the reference machine; by default taken from finished runs, or measured here"),
    ] = None,
    start: Annotated[float, typer.Option(min=0, max=3600, help="start-up time of each job, s; about 10 on a cluster")] = 5.0,
    backend: Annotated[str | None, typer.Option(help="what makes the runs, cpu or cuda; by default as the study says")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="machine-readable: times in s, memory and disk in MiB")] = False,
) -> Told:
    """Predict the cost of a study: core-hours, wall time, memory and disk, in total and for the remaining runs."""
    from sph.command.cost import cost_of_study

    return cost_of_study(study, fidelity, cores or os.cpu_count() or 1, speed, start, backend, as_json)


@command(
    "Examples:  sph motion RSN6_ELC180.AT2 --plot elcentro.png  |  sph motion record.csv --unit g  |  "
    "sph motion slope.yaml --set motion.amplitude=3.5 --plot motion.pdf",
    "reading the motion and measuring it",
)
def motion(
    file: Annotated[
        Path, typer.Argument(metavar="FILE", help="record (.AT2, .EW .NS ..., .smc, .V2, .ASC, .csv), scene (YAML) or trajectory (netCDF)")
    ],
    set_: Settings = None,
    unit: Unit = None,
    component: Component = None,
    baseline: Baseline = None,
    band_pass: BandPass = None,
    direction: Annotated[str, typer.Option(help="polarity: recorded or turned (reversed)")] = "recorded",
    out: Picture = None,
    as_json: AsJson = False,
) -> Told:
    """Measure a ground motion (a record, raw or processed, or the motion of a scene): peaks, Arias intensity, durations, spectrum."""
    from sph.command.motion import motion

    return motion(file, parse_settings(set_), parse_treatment(unit, baseline, band_pass, component), direction, out, as_json)


@command("Examples:  sph schema scene > scene.schema.json  |  sph schema study > study.schema.json")
def schema(
    of: Annotated[
        str, typer.Argument(metavar="FILE", help="kind of file: scene, study, or an experiment such as resolution or trigger")
    ] = "scene",
) -> Told:
    """Print the JSON Schema of a file, with which an editor completes keys and marks mistakes (also in config/schemas)."""
    from sph.command.schema import MODELS, schema_text
    from sph.scene.names import check_known

    check_known("FILE", [of], MODELS)
    return schema_text(of).rstrip("\n")


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
