"""Draw a figure of one run, or of some."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.experiments.paper.figures import FIGURES
from sph.figures import RUN_FIGURES, save
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned


def draw_figure(
    paths_to_runs: Sequence[str],
    paths_to_pictures: Sequence[str],
    name: str,
    scenes: Sequence[Planned],
    titles: Sequence[Sequence[str]],
    fidelity: str,
    marked: Mapping[str, Any],
) -> None:
    """Draw a figure of any study or of the paper's from runs of planned scenes.

    ``titles`` name each run: its curve or profile, or its panel and that; there are none where the figure shows one run.
    ``marked`` are the places and the quantity of profiles; nothing is given to other figures.
    """
    runs = [scene.read(path) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    shown: Any = {} if titles else runs[0]
    for (*panel, last), run in zip(titles, runs, strict=False):
        (shown.setdefault(panel[0], {}) if panel else shown)[last] = run
    save((RUN_FIGURES | FIGURES)[name](shown, fidelity=fidelity, **marked), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_figure(snakemake.input.runs, snakemake.output, **snakemake.params.given)
