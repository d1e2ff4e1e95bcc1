"""Write the page of a study."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

from sph.jobs.log import Job, job_log
from sph.page.build import StudyFiles, attributes, write_page
from sph.study.planned import Planned


def write(path_to_page: str, given: Any, scenes: Sequence[Planned], names: Sequence[str], kept: Iterable[str], **facts: Any) -> int:
    """The page, of runs and stages of planned scenes, and its size; ``names`` are those of the runs, ``kept`` are files that are shown
    though nothing makes them now, ``facts`` go into ``StudyFiles``."""
    checked = {path: planned.check(attributes(path), path) for path, planned in zip([*given.runs, *given.stages], scenes, strict=True)}
    study = StudyFiles(
        folder=str(Path(path_to_page).parent),
        table=given.study,
        runs=dict(zip(names, given.runs, strict=True)),
        scenes=checked,
        files=[*given.yields, *given.files, *kept],
        **facts,
    )
    return write_page(path_to_page, study)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        size = write(snakemake.output[0], snakemake.input, **snakemake.params.given)
        print(f"{snakemake.output[0]}: {size / 1e6:.1f} MB", file=log)
