"""Write the page of a study."""

from pathlib import Path

from sph.command.job import job_log
from sph.page.build import StudyFiles, write_page

if __name__ == "__main__":
    with job_log(snakemake.log[0]) as log:  # type: ignore[name-defined]
        given, params = snakemake.input, snakemake.params  # type: ignore[name-defined]
        study = StudyFiles(
            params.name,
            params.fidelity,
            str(Path(snakemake.output[0]).parent),  # type: ignore[name-defined]
            given.study,
            params.points,
            given.runs,
            given.gravity,
            dict(zip(params.amplitudes, given.trunks, strict=True)),
            given.files,
            params.shown,
            params.probe,
        )
        size = write_page(snakemake.output[0], study)  # type: ignore[name-defined]
        print(f"{snakemake.output[0]}: {size / 1e6:.1f} MB", file=log)  # type: ignore[name-defined]
