# Purpose: the reference cases and their runs.
# Inputs:  tests/cases, where the library has its tests beside it.
# Outputs: functions for the directives of ../validation.smk
import functools

if (SPH.parent / "tests" / "cases").is_dir():
    sys.path.append(str(SPH.parent / "tests"))
    from cases import CASES, suite
else:
    CASES = {}  # the library is installed without its tests


@functools.cache
def runs_of_case(case):
    """The runs of a reference case, by file."""
    return {run.file: run for run in suite.runs_of(case).values()}


def case_run(wildcards):
    """The run of a file, or a refusal."""
    file = "results/validation/runs/{case}/{variant}/{level}.nc".format(**wildcards)
    if wildcards.case not in CASES or file not in runs_of_case(wildcards.case):
        raise ValueError(f"{file}: no reference case has such a run")
    return runs_of_case(wildcards.case)[file]


def whole_suite(wildcards):
    """Tables and pictures of all cases, and their runs; a refusal where there are none."""
    if not CASES:
        raise ValueError(
            f"validation: the reference cases are no part of the installed package ({SPH}); run it in a clone of the repository with the "
            "package installed from there (pip install -e .)"
        )
    return {
        "tables": expand("results/validation/cases/{case}.csv", case=CASES),
        "pictures": expand("results/validation/figures/{case}.png", case=CASES),
        "runs": [file for case in CASES for file in runs_of_case(case)],
    }
