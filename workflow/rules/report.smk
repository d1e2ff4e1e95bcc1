# Purpose: one page for the browser that holds the whole study and needs no network.
# Inputs:  study.csv, claims.csv, figures, all runs and stages; the tables and figures of other targets that exist
#          (sph/page/sections.py and paper.py list them); the page's sources.
# Outputs: report.html
from sph.page.sections import existing

MADE = existing(RESULTS, SECTIONS)


rule page:
    """Write the page: verdicts, figures, tables, cost, and every run to look at."""
    input:
        study=f"{RESULTS}/study.csv",
        runs=lambda wildcards: [run.file for run in PLAN.page_runs],
        stages=lambda wildcards: [run.file for run in PLAN.page_stages],
        yields=lambda wildcards: sorted(
            {search.file for search in PLAN.searches.values()}
        ),
        files=lambda wildcards: list(
            dict.fromkeys(
                certain(RESULTS, SECTIONS)
                + [file for file in MADE if not CATALOGUE.refuses(file)]
                + [
                    run.file
                    for run in PLAN.shared.searches(SAFETY)
                    if os.path.isfile(run.file)
                ]
            )
        ),
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
        **told(
            lambda wildcards: {
                "scenes": [
                    planned(run.scene) for run in PLAN.page_runs + PLAN.page_stages
                ],
                "names": [run.id for run in PLAN.page_runs],
                "name": PLAN.study.study,
                "fidelity": PLAN.study.fidelity,
                "layout": PLAN.layout,
                "dimensions": PLAN.dimensions,
                "size": len(PLAN.study.runs),
                "stages": [
                    (PLAN.shared.gravity_of(run.id).file, run.parent)
                    for run in PLAN.page_runs
                ],
                "metrics": PLAN.study.metrics,
                "client": PLAN.study.page == "client",
                "project": PLAN.study.project,
                "author": PLAN.study.author,
                "shown": {
                    figure: [run.file for run in PLAN.figure_runs(figure)]
                    for figure in PLAN.study.figure_files
                },
                "sections": SECTIONS,
                # of experiments whose configuration is refused now: as input, they would keep the page from being made
                "kept": {
                    file: os.path.getmtime(file)
                    for file in MADE
                    if CATALOGUE.refuses(file)
                },
            }
        ),
        sources=SOLVER + PAGE,
    script:
        "../scripts/report/write_page.py"
