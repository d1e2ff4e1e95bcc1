"""Earthquake-induced slope failure with solid-fluid coupled smoothed particle hydrodynamics.

Scene in, dataset out:

>>> import sph
>>> scene = sph.make_scene(
...     {
...         "name": "steep",
...         "scheme": "paper",
...         "duration": 6.0,
...         "geometry": {"shape": "slope", "slope_angle": 70.0, "slope_height": 20.0},
...         "coupling": {"S_R": 0.1},
...         "gravity": {"ramp": 0.5, "duration": 1.0},
...         "motion": {
...             "kind": "tapered_sine", "amplitude": 8.0,
...             "start": 1.0, "ramp": 0.5, "decay_start": 3.0, "end": 3.5,
...         },
...         "numerics": {"spacing": 4.0, "time_step": 1e-3},
...     }
... )
>>> result = sph.run(scene)
>>> result.status
'complete'
>>> result.trajectory["displacement_x"].dims
('frame', 'particle')
>>> numbers = sph.measure(result.trajectory)
>>> numbers["collapse_class"], round(numbers["runout"]) > 5
('collapse', True)

What is left out is taken from the paper's scene here; without `scheme` a scene must write its soil and coupling (`docs/model/choices.md`).
A mistake is refused by a ValueError with key, value and what is allowed.  Numbers are in SI units, but for kPa and degrees in scenes.
The first run of a kind of scene compiles for some seconds.

Where to begin:

1. `make_scene` and `load_scene` make a validated, immutable `Scene`, of a mapping or a YAML file.
2. `run` simulates it; `run_to_file` does so into a file, goes on after a kill, and is what the command `sph run` calls.  `run_many`
   advances several scenes together on a graphics card.
3. `read_run` reads a trajectory back and `scene_of` its scene; `sph.storage.trajectory.VARIABLES` has every variable with its unit.
   `in_survey`, or `read_run(..., survey=True)`, gives it in the coordinates of the survey.
4. `measure` gives the numbers of a run; `sph.measures.metrics.METRICS` defines each.  `plot` draws it: profile, probes, energies.
5. `load_study` is a grid of scenes as Snakemake runs it; `read_study` and `read_table` read what it has measured.
6. `factor_of_safety`, `critical_strength_ratio`, `yield_acceleration` and `sliding_block` are the methods of practice to compare with;
   `extrapolated` makes such a search at two spacings, as `sph fos` does, and states the remaining error.

These names are the public interface and keep their meaning from version to version; `CHANGELOG.md` says where one does not.  The
modules are open to read and to use without that promise.  A scene (`sph.scene`) goes through the solver (`sph.solver`, a term of physics
and a kind of wall a file) into a trajectory (`sph.storage`), which, read as a run (`sph.output`), gives numbers (`sph.measures`).
`sph.study` and `sph.experiments` plan many runs (among them the paper's study with its claims and figures, and the reference cases),
`sph.stability` searches, `sph.figures` draws, `sph.page` writes the report, `sph.command` is the command.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

__version__ = "0.4.0"

_HOMES = {
    name: module
    for module, names in {
        "sph.scene.schema": "make_scene load_scene Scene",
        "sph.solver.run": "run Progress Result",
        "sph.solver.checkpoint": "run_to_file",
        "sph.solver.backends": "run_many",
        "sph.storage.trajectory": "scene_of",
        "sph.output.surveyed": "read_run in_survey",
        "sph.measures.metrics": "measure MetricSettings",
        "sph.figures.overview": "plot",
        "sph.experiments.registry": "load_study",
        "sph.study.plan": "Plan",
        "sph.study.tables": "read_study read_table",
        "sph.stability.safety": "factor_of_safety critical_strength_ratio yield_acceleration",
        "sph.stability.extrapolation": "extrapolated Extrapolated",
        "sph.stability.search": "Search",
        "sph.stability.standing": "FailureRule",
        "sph.stability.newmark": "sliding_block SlidingBlock",
    }.items()
    for name in names.split()
}
"""Where the public names live.  They are imported when they are first used: ``sph --help`` needs none of them."""

if TYPE_CHECKING:
    from sph.experiments.registry import load_study as load_study
    from sph.figures.overview import plot as plot
    from sph.measures.metrics import MetricSettings as MetricSettings
    from sph.measures.metrics import measure as measure
    from sph.output.surveyed import in_survey as in_survey
    from sph.output.surveyed import read_run as read_run
    from sph.scene.schema import Scene as Scene
    from sph.scene.schema import load_scene as load_scene
    from sph.scene.schema import make_scene as make_scene
    from sph.solver.backends import run_many as run_many
    from sph.solver.checkpoint import run_to_file as run_to_file
    from sph.solver.run import Progress as Progress
    from sph.solver.run import Result as Result
    from sph.solver.run import run as run
    from sph.stability.extrapolation import Extrapolated as Extrapolated
    from sph.stability.extrapolation import extrapolated as extrapolated
    from sph.stability.newmark import SlidingBlock as SlidingBlock
    from sph.stability.newmark import sliding_block as sliding_block
    from sph.stability.safety import (
        critical_strength_ratio as critical_strength_ratio,
    )
    from sph.stability.safety import (
        factor_of_safety as factor_of_safety,
    )
    from sph.stability.safety import (
        yield_acceleration as yield_acceleration,
    )
    from sph.stability.search import Search as Search
    from sph.stability.standing import FailureRule as FailureRule
    from sph.storage.trajectory import scene_of as scene_of
    from sph.study.plan import Plan as Plan
    from sph.study.tables import read_study as read_study
    from sph.study.tables import read_table as read_table
else:
    __all__ = [*_HOMES]

    def __getattr__(name: str) -> Any:
        if name not in _HOMES:
            raise AttributeError(f"module 'sph' has no attribute {name!r}")
        globals()[name] = getattr(import_module(_HOMES[name]), name)
        return globals()[name]

    def __dir__() -> list[str]:
        """What is public; the modules are there as well."""
        return [*_HOMES, "__doc__", "__version__"]
