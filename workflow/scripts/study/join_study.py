"""Put the measured parts of a study together."""

from collections.abc import Mapping, Sequence

from sph.experiments.variants.advice import expected_sentence
from sph.jobs.log import Job, job_log
from sph.study.planned import Planned
from sph.study.tables import Layout, join_study


def join(
    paths_to_parts: Sequence[str],
    path_to_run: str,
    path_to_nc: str,
    path_to_csv: str,
    layout: Layout,
    planned: Planned,
    attrs: Mapping[str, str],
) -> None:
    """The tables of the study; ``attrs`` and those of a run, whose scene is planned, go into the netCDF."""
    run = planned.read(path_to_run)
    facts = {name: run.attrs[name] for name in ("source", "versions", "scene")} | {"expected_error": expected_sentence(run.scene)}
    join_study(paths_to_parts, layout, path_to_nc, path_to_csv, dict(attrs) | facts)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        join(snakemake.input.parts, snakemake.input.run, *snakemake.output, **snakemake.params.given)
