"""Name the factors that matter."""

from collections.abc import Sequence
from pathlib import Path

from sph.experiments.sensitivity.elementary_effects import MORRIS, influential
from sph.jobs.log import Job, job_log
from sph.scene.strict_json import to_json
from sph.storage.files import whole
from sph.study.tables import read_csv


def choose_factors(
    paths_to_tables: Sequence[str], factors: Sequence[str] | None, sought: Sequence[str], share: float, path_to_names: str
) -> None:
    """Those given, or those that the table of the screening, the only path, finds, with those sought."""
    names = list(factors) if factors else influential(read_csv(paths_to_tables[0], MORRIS, "a screening"), share)
    names += [name for name in sought if name not in names]
    with whole(path_to_names) as temporary:
        Path(temporary).write_text(to_json(names) + "\n", encoding="utf-8")


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        choose_factors(
            snakemake.input,
            snakemake.params.factors,
            snakemake.params.sought,
            snakemake.params.share,
            snakemake.output[0],
        )
