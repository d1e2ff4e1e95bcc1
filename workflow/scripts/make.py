"""Make tables and figures by a function of the library: of the paths of the job's named inputs, its runs and what it is given."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import pandas as pd
import xarray as xr

from sph.jobs.log import Job, job_log
from sph.output.run import Run
from sph.scene.strict_json import to_json
from sph.storage import trajectory
from sph.storage.files import whole
from sph.study.planned import Planned
from sph.study.tables import write_csv


class Runs(Mapping[Any, Run]):
    """Runs by their names or numbers, each read when it is asked for, from their files and planned scenes."""

    def __init__(self, paths: Sequence[str], scenes: Mapping[Any, Planned]) -> None:
        self.files = {name: (scene, path) for (name, scene), path in zip(scenes.items(), paths, strict=True)}

    def __getitem__(self, name: Any) -> Run:
        scene, path = self.files[name]
        return scene.read(path)

    def __iter__(self) -> Iterator[Any]:
        return iter(self.files)

    def __len__(self) -> int:
        return len(self.files)


def make(
    function: Callable[..., Any],
    inputs: Mapping[str, Any],
    given: Mapping[str, Any],
    scenes: Mapping[Any, Planned] | None,
    outputs: Sequence[str],
) -> None:
    """Call the function and write what it makes, in the order of ``outputs``; an input without a file is left out.

    ``scenes`` are those of ``inputs["runs"]``; None for a function that takes no runs.
    """
    read = {name: files for name, files in inputs.items() if files and name != "runs"}
    if scenes is not None:
        read["runs"] = Runs(inputs.get("runs", ()), scenes)
    made, paths = function(**read, **given), iter(outputs)
    for each in made if isinstance(made, tuple) else (made,):
        write(each, paths)


def write(made: Any, paths: Iterator[str]) -> None:
    """Write a table, or names, to the next of some paths, a figure to the next two."""
    path = next(paths)
    if isinstance(made, pd.DataFrame):
        write_csv(made, path)
    elif isinstance(made, xr.Dataset):
        trajectory.write(path, made)
    elif hasattr(made, "savefig"):
        # Takes as long to import as most tables to make.
        from sph.figures import save

        save(made, path, next(paths))
    else:
        with whole(path) as temporary:
            temporary.write_text(to_json(made) + "\n", encoding="utf-8")


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        function, given, scenes = snakemake.params.given
        make(function, snakemake.input, given, scenes, snakemake.output)
