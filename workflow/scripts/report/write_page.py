"""Write the page of a study."""

from pathlib import Path

from sph.jobs.log import Job, job_log
from sph.page.build import StudyFiles, attributes, write_page

if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        given, params = snakemake.input, snakemake.params
        for path, planned in zip([*given.runs, *given.stages], params.scenes, strict=True):
            planned.check(attributes(path), path)
        study = StudyFiles(
            params.name,
            params.fidelity,
            str(Path(snakemake.output[0]).parent),
            given.study,
            params.layout,
            params.dimensions,
            params.size,
            dict(zip(params.names, given.runs, strict=True)),
            params.stages,
            [*given.yields, *given.files],
            params.sections,
            params.shown,
            params.probe,
        )
        size = write_page(snakemake.output[0], study)
        print(f"{snakemake.output[0]}: {size / 1e6:.1f} MB", file=log)
