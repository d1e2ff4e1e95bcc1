# Purpose: one page for the browser that holds the whole study and needs no network.
# Inputs:  study.csv, claims.csv, figures, all runs and stages; the tables and figures of other targets that exist
#          (sph/page/sections.py and paper.py list them); the page's sources.
# Outputs: report.html
from sph.page.sections import existing


rule page:
    """Write the page: verdicts, figures, tables, cost, and every run to look at."""
    input:
        study=f"{RESULTS}/study.csv",
        runs=lambda wildcards: expand(RUN, folder=RESULTS, run=PLAN.study.page_runs),
        stages=lambda wildcards: expand(
            "{results}/stages/{stage}.nc", results=RESULTS, stage=PLAN.page_stages
        ),
        yields=lambda wildcards: sorted(
            {search.file for search in PLAN.searches.values()}
        ),
        files=list(
            dict.fromkeys(
                certain(RESULTS, SECTIONS)
                + existing(RESULTS, SECTIONS)
                + list(filter(os.path.isfile, PLAN.search_files(SAFETY)))
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
        sources=SOLVER + PAGE,
        name=PLAN.study.study,
        fidelity=PLAN.study.fidelity,
        layout=lambda wildcards: PLAN.layout,
        dimensions=lambda wildcards: PLAN.dimensions,
        size=lambda wildcards: len(PLAN.study.runs),
        names=lambda wildcards: PLAN.study.page_runs,
        scenes=lambda wildcards: [
            planned(PLAN.run_scene(run)) for run in PLAN.study.page_runs
        ]
        + [planned(PLAN.stage(stage)) for stage in PLAN.page_stages],
        stages=lambda wildcards: [
            tuple(f"{RESULTS}/stages/{name}.nc" for name in PLAN.stages(run))
            for run in PLAN.study.page_runs
        ],
        probe=PLAN.study.metrics.probe,
        shown=lambda wildcards: {
            figure: expand(RUN, folder=RESULTS, run=runs)
            for figure, runs in PLAN.study.figure_files.items()
        },
        sections=lambda wildcards: SECTIONS,
    script:
        "../scripts/report/write_page.py"
