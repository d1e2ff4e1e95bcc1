"""Measure a reference case on all its levels, and draw it."""

from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd
import xarray as xr

from sph.figures import save
from sph.jobs.log import Job, job_log
from sph.study.tables import write_csv
from sph.validation import CASES
from sph.validation.level import Level, Result, read_result
from sph.validation.slopes import read_search
from sph.validation.suite import Case
from sph.validation.table import case_rows


def measure_case(plan: Mapping[str, Any], paths_to_runs: Sequence[str], path_to_csv: str, paths_to_pictures: Sequence[str]) -> None:
    """One row a quantity, and the picture; the paths in the plan's order, none for a case of functions alone."""
    case = Case(**plan["case"])
    levels: dict[str, Level] = {}
    for number, (level, run, planned) in enumerate(plan["runs"]):
        if case.by == "computation":
            result = Result(planned.build(), xr.Dataset())
        else:
            result = (read_result if case.by == "simulation" else read_search)(paths_to_runs[number])
            planned.check(result.data.attrs, paths_to_runs[number])
        levels[level] = {**levels.get(level, {}), run: result}
    write_csv(pd.DataFrame(case_rows(plan["name"], case, levels, plan["sizes"])), path_to_csv)
    save(CASES[plan["name"]][1](levels), *paths_to_pictures)


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]):
        measure_case(
            snakemake.params.suite,
            snakemake.input.runs,
            snakemake.output.csv,
            [snakemake.output.png, snakemake.output.pdf],
        )
