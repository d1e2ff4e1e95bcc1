"""Write the verification book: a page a reference case."""

from collections.abc import Mapping, Sequence
from typing import Any

from sph.jobs.log import Job, job_log
from sph.validation.book import Page, costs_of, save_book
from sph.validation.table import read_validation


def write_book(
    plans: Sequence[Mapping[str, Any]], path_to_table: str, paths_to_runs: Sequence[str], paths_to_pictures: Sequence[str], *paths: str
) -> None:
    """Markdown and PDF; the runs of all plans in their order, none for a case of functions alone, and a picture a plan."""
    table, runs, pages = read_validation(path_to_table), iter(paths_to_runs), []
    for plan in plans:
        simulated = plan["case"]["by"] != "computation"
        costs = costs_of([level for level, _, _ in plan["runs"]], [next(runs) for _ in plan["runs"]]) if simulated else []
        scene = plan["runs"][0][2].build() if simulated else None
        pages.append(Page(plan["name"], plan["case"], table[table["case"] == plan["name"]], costs, scene))
    save_book(pages, paths_to_pictures, *paths)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        write_book(
            snakemake.params.plans,
            snakemake.input.table,
            snakemake.input.runs,
            snakemake.input.pictures,
            *snakemake.output,
        )
