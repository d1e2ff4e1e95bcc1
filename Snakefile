# Slope failure over strength ratio x coupling x amplitude, or any keys of a scene: config/config.yaml -> results/<study>/<fidelity>.
import functools
import os
import re
import sys
from pathlib import Path

from snakemake.utils import min_version

import sph
from sph.figures import RUN_FIGURES, STUDY_FIGURES, caption as caption_of
from sph.page.paper import sections_of
from sph.page.sections import certain
from sph.paper.study import load_study
from sph.study.plan import claim_results
from sph.study.planned import contents, planned, sources
from sph.study.preflight import MOST_SCENES, preflight_searches
from sph.study.sampling import chosen_study
from sph.study.searches import SAFETY, SLOPE_LIMITS, searched_limit
from sph.experiments.trigger.design import load_trigger, plan_of
from sph.scene.configuration import check_files
from sph.solver.compiled.jit import solver_digest

min_version("9.18")


configfile: "config/config.yaml"


# Snakemake reads 030 as 24, and of two equal keys the last.  Files of which another workflow hands on a part hold more than is known here.
outermost = workflow.modifier
while outermost.parent_modifier:
    outermost = outermost.parent_modifier
check_files(workflow.configfiles if outermost.globals["config"] is config else [])
# Where the library lies that is imported, also when this workflow is a module of another one.
SPH = Path(os.path.abspath(sph.__file__)).parent
FOLDERS = [Path.cwd(), SPH.parent]
# Its scenes are built before the first job, not again by each.
PLAN = load_study(
    chosen_study(config, workflow.config_settings.overwrite_config),
    FOLDERS,
    workflow.is_main_process,
)
RESULTS = PLAN.folder
# What the page shows: of these files every study has some, one over the paper's dimensions its claims and Figures 1-7.
SECTIONS = sections_of(PLAN.study)
# Stages and runs of the study, or of a case or fidelity of the trigger, lie in a folder: that of its plan.
RUN = "{folder}/runs/{run}.nc"
TRIGGER = functools.cache(
    lambda: load_trigger(PLAN.experiment_file("trigger"), PLAN, FOLDERS)
)
PLANS = functools.partial(plan_of, PLAN, TRIGGER)
# Snakemake does not see edits in imported modules: what the sources of each stage say to the machine is its parameter.
SOLVER = solver_digest()
SEARCHING = SOLVER + sources("stability/*.py")
ANALYSIS = sources(
    "measures/*.py",
    "study/*.py",
    "experiments/**/*.py",
    "experiments/measured/*.csv",
)
DRAWING = ANALYSIS + sources("figures/*.py") + contents("scene/walls.py")  # labels
PAPER = sources("paper/*.py")
PAGE = DRAWING + PAPER + sources("page/*.*")


report: "workflow/report/workflow.rst"


wildcard_constraints:
    gravity="gravity(_[^/]+)?",
    pre_failure="pre_failure(_[^/]+)?",
    folder=f"results/{re.escape(PLAN.study.study)}/[^/]+(/trigger/[^/]+)?",


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


onsuccess:
    if os.path.isfile(f"{RESULTS}/report.html"):
        print(f"{RESULTS}/report.html: the study on one page", file=sys.stderr)


include: "workflow/rules/resources.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/paper.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/experiments.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/sensitivity.smk"
include: "workflow/rules/trigger.smk"
include: "workflow/rules/docs.smk"
include: "workflow/rules/simulate.smk"  # the last: it runs the experiments that those above have named
