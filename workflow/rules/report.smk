# Purpose: one page for the browser that holds the whole study and needs no network.
# Inputs:  study.csv, claims.csv, figures, all runs and stages; the tables and figures of other targets that exist
#          (sph/page/sections.py and paper.py list them); the page's sources.
# Outputs: report.html, and until it is there so_far.html, of the runs alone
from sph.command.page import SO_FAR, ahead_of_page
from sph.page.sections import existing

MADE = existing(RESULTS, SECTIONS)
AHEAD = {plan.folder: plan for plan in (PLAN.draft, PLAN) if plan}


rule answer:
    """Write the page of the runs alone, as sph page does, before the searches."""
    input:
        lambda wildcards: [
            run.file for run in AHEAD[wildcards.folder].shared.runs.values()
        ],
    output:
        temp(expand("{{folder}}/{name}", name=SO_FAR)),
    log:
        "{folder}/logs/answer.log",
    wildcard_constraints:
        folder="|".join(map(re.escape, AHEAD)),
    priority: 50
    params:
        plan=lambda wildcards, input: AHEAD[wildcards.folder],
    script:
        "../scripts/report/first_page.py"


rule page:
    """Write the page: verdicts, figures, tables, cost, and every run to look at."""
    input:
        study=f"{RESULTS}/study.csv",
        # sph page may write it again; asked for here alone, since what searches take is not known at once
        so_far=lambda wildcards: [
            ancient(f"{folder}/{name}")
            for folder in ahead_of_page(PLAN)
            for name in SO_FAR
        ],
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
                "assumed": PLAN.study.assumed,
                "alternatives": PLAN.study.alternatives,
                "design": PLAN.study.design,
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
