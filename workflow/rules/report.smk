# Purpose: one page for the browser that holds the whole study and needs no network.
# Inputs:  study.csv, claims.csv, figures, all runs and stages; the tables and figures of other targets that exist
#          (sph/page/sections.py lists them); the page's sources and the tables that the release holds.
# Outputs: report.html
from sph.page.sections import certain, existing


rule page:
    """Write the page: verdicts, figures, tables, cost, and every run to look at."""
    input:
        sources=SOLVER + PAGE,
        study=f"{RESULTS}/study.csv",
        runs=[
            RUN.format(folder=RESULTS, **point)
            for point in PLAN.study.points.to_dict("records")
        ],
        gravity=f"{RESULTS}/stages/gravity.nc",
        trunks=expand(
            "{results}/stages/amplitude-{amplitude}.nc",
            results=RESULTS,
            amplitude=PLAN.study.grid.amplitude,
        ),
        files=list(dict.fromkeys(certain(RESULTS) + existing(RESULTS))),
    output:
        report(
            f"{RESULTS}/report.html",
            caption="../report/page.rst",
            category="Page",
            labels={"shows": "the whole study"},
        ),
    log:
        f"{RESULTS}/logs/page.log",
    params:
        name=PLAN.study.study,
        fidelity=PLAN.study.fidelity,
        points=PLAN.study.points.to_dict("records"),
        amplitudes=PLAN.study.grid.amplitude,
        probe=PLAN.study.metrics.probe,
        shown={
            f"fig{number}": [
                RUN.format(folder=RESULTS, **point)
                for _, point in PLAN.study.figure_runs(number)
            ]
            for number in range(1, 8)
        },
    script:
        "../scripts/write_page.py"
