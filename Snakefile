# Slope failure over strength ratio x coupling x amplitude: config/config.yaml -> results/<study>/<fidelity>.
import functools
import os
import re
from pathlib import Path

from snakemake.utils import Paramspace, min_version

import sph
from sph.analysis.study import load_study
from sph.analysis.trigger import load_trigger, plan_of

min_version("9.18")


configfile: "config/config.yaml"


# Where the library lies that is imported, also when this workflow is a module of another one.
SPH = Path(os.path.abspath(sph.__file__)).parent
FOLDERS = [Path.cwd(), SPH.parent]
PLAN = load_study(config, FOLDERS)
RESULTS = PLAN.folder
GRID = Paramspace(PLAN.study.points, filename_params="*", param_sep="-")
# Stages and runs of the study, or of a case or fidelity of the trigger, lie in a folder: that of its plan.
RUN = f"{{folder}}/runs/{GRID.wildcard_pattern}.nc"
TRIGGER = functools.cache(functools.partial(load_trigger, PLAN, FOLDERS))
PLANS = functools.partial(plan_of, PLAN, TRIGGER)
# Snakemake does not see edits in imported modules: the sources of each stage are its inputs.
SOLVER = sorted(str(path) for path in SPH.glob("[!_]*.py"))
SEARCHING = SOLVER + sorted(str(path) for path in SPH.glob("stability/*.py"))
ANALYSIS = sorted(
    str(path)
    for pattern in ("analysis/*.py", "analysis/measured/*.csv")
    for path in SPH.glob(pattern)
)
DRAWING = ANALYSIS + sorted(str(path) for path in SPH.glob("analysis/figures/*.py"))


PAGE = DRAWING + sorted(
    str(path)
    for pattern in ("page/*.*", "command/reference.py", "validation/measured/*.csv")
    for path in SPH.glob(pattern)
)


report: "workflow/report/workflow.rst"


wildcard_constraints:
    S_R="[^_/]+",
    gamma="[^_/]+",
    amplitude="[^_/]+",
    folder=f"results/{re.escape(PLAN.study.study)}/[^/]+(/trigger/[^/]+)?",


rule all:
    """Everything: tables, claims, Figures 1-7, the page of them all."""
    input:
        f"{RESULTS}/report.html",
        f"{RESULTS}/study.nc",
        f"{RESULTS}/study.csv",
        f"{RESULTS}/claims.csv",
        expand(
            "{results}/figures/fig{number}.{kind}",
            results=RESULTS,
            number=range(1, 8),
            kind=["png", "pdf"],
        ),


include: "workflow/rules/resources.smk"
include: "workflow/rules/simulate.smk"
include: "workflow/rules/study.smk"
include: "workflow/rules/figures.smk"
include: "workflow/rules/report.smk"
include: "workflow/rules/trade.smk"
include: "workflow/rules/validation.smk"
include: "workflow/rules/limits.smk"
include: "workflow/rules/extremes.smk"
include: "workflow/rules/sensitivity.smk"
include: "workflow/rules/trigger.smk"
include: "workflow/rules/docs.smk"
