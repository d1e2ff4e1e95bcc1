"""Draw one of the paper's figures."""

from collections.abc import Sequence
from typing import Any

from sph.figures import save
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
    """Draw one of ``FIGURES`` from runs of planned scenes; ``titles`` name each run: its panel, or its panel and its curve."""
    shown: dict[str, Any] = {}
    for path, scene, (*panel, last) in zip(paths_to_runs, scenes, titles, strict=True):
        (shown.setdefault(panel[0], {}) if panel else shown)[last] = scene.read(path)
    save(FIGURES[name](shown, fidelity=fidelity), *paths_to_pictures)


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
