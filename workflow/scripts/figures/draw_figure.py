"""Draw one of Figures 1-7, or profiles of other runs."""

from collections.abc import Sequence
from typing import Any

from sph.figures import FIGURES, save
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned


def draw_figure(
    number: int,
    paths_to_runs: Sequence[str],
    scenes: Sequence[Planned],
    titles: Sequence[Sequence[str]],
    fidelity: str,
    paths_to_pictures: Sequence[str],
) -> None:
    """Draw a figure from runs of planned scenes; ``titles`` name each run: nothing, its panel, or its panel and its curve."""
    runs = [scene.read(path) for path, scene in zip(paths_to_runs, scenes, strict=True)]
    shown: Any = runs[0]
    if titles[0]:
        shown = {}
        for (*panel, last), run in zip(titles, runs, strict=True):
            (shown.setdefault(panel[0], {}) if panel else shown)[last] = run
    save(FIGURES[number](shown, fidelity=fidelity), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        draw_figure(
            snakemake.params.figure,
            snakemake.input.runs,
            snakemake.params.scenes,
            snakemake.params.titles,
            snakemake.params.fidelity,
            [snakemake.output.png, snakemake.output.pdf],
        )
