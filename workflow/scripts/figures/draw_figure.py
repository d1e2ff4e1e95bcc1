"""Draw a figure of one run, or of some."""

from collections.abc import Sequence
from typing import Any

from sph.figures import RUN_FIGURES, save
from sph.jobs.log import Job, job_log
from sph.paper.figures import FIGURES
from sph.study.planned import Planned


def draw_figure(
    name: str,
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    titles: Sequence[Sequence[str]],
    fidelity: str,
    paths_to_pictures: Sequence[str],
) -> None:
    """Draw a figure of any study or of the paper's from runs of planned scenes.

    ``titles`` name each run: its curve or profile, or its panel and that; there are none where the figure shows one run.
    """
    runs = [scene.read(path) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    shown: Any = {} if titles else runs[0]
    for (*panel, last), run in zip(titles, runs, strict=False):
        (shown.setdefault(panel[0], {}) if panel else shown)[last] = run
    save((RUN_FIGURES | FIGURES)[name](shown, fidelity=fidelity), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_figure(
            snakemake.params.figure,
            snakemake.input.runs,
            snakemake.params.scenes,
            snakemake.params.titles,
            snakemake.params.fidelity,
            snakemake.output,
        )
