# Slope failure over strength ratio x coupling x amplitude, or any keys of a scene: config/config.yaml -> results/<study>/<fidelity>.
import os
import sys
from pathlib import Path

from snakemake.utils import min_version

import sph
from sph.page.paper import sections_of
from sph.page.sections import certain
from sph.experiments.registry import load_study
from sph.study.plan import claim_results
from sph.study.preflight import look_first
from sph.study.sampling import chosen_study, keys_of
from sph.jobs.catalogue import Catalogue
from sph.scene.configuration import check_files

min_version("9.18")


configfile: "config/config.yaml"


# Snakemake reads 030 as 24, and of two equal keys the last.  Files of which another workflow hands on a part hold more than is known here.
check_files(path for path in workflow.configfiles if keys_of(path) <= {*config})
# Where the library lies that is imported, also when this workflow is a module of another one.
SPH = Path(os.path.abspath(sph.__file__)).parent
FOLDERS = [Path.cwd(), SPH.parent]
# Its scenes are built before the first job, not again by each.
STUDY = chosen_study(config, workflow.config_settings.overwrite_config)
PLAN = load_study(STUDY, FOLDERS, workflow.is_main_process)
RESULTS = PLAN.folder
# What the page shows: of these files every study has some, one over the paper's dimensions its claims and Figures 1-7.
SECTIONS = sections_of(PLAN)
# Every run that there is to make; configurations of experiments are read once a rule of theirs is asked for.
CATALOGUE = Catalogue(PLAN, FOLDERS, check=workflow.is_main_process)


report: "workflow/report/workflow.rst"


rule all:
    """Everything: tables, figures, the page of them all."""
    input:
        f"{RESULTS}/report.html",
        f"{RESULTS}/study.nc",
        f"{RESULTS}/study.csv",
        certain(RESULTS, SECTIONS, [".png", ".pdf"]),


onstart:
    if workflow.is_main_process:
        claim_results(PLAN)
        CATALOGUE.write()
        if any(job.rule.name == "check" for job in workflow.dag.needrun_jobs()):
            slopes = {name: run.built for name, run in looked_at(PLAN).items()}
            look_first(slopes, PLAN.study.on_error == "stop")
        for figure, reason in PLAN.study.left_out.items():
            print(f"{figure} is left out: {reason}", file=sys.stderr)


onsuccess:
    if workflow.is_main_process:
        CATALOGUE.write()
    if os.path.isfile(f"{RESULTS}/report.html"):
        print(f"{RESULTS}/report.html: the study on one page", file=sys.stderr)


include: "workflow/rules/common.smk"
include: "workflow/rules/run.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/variants.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/trigger.smk"
include: "workflow/rules/sensitivity.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/docs.smk"
