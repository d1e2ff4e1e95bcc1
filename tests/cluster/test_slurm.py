"""A small study through a real Slurm on this machine: the same tables as here, few submissions, and on after a cancelled job."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pandas as pd
import pytest
import xarray as xr
import yaml
from comparison import same_files, same_variables
from killing import TIMINGS
from local_slurm import CannotStart, LocalSlurm
from small_scenes import FEW, SLOPE

from sph.scene.configuration import merge
from sph.storage import trajectory

pytestmark = pytest.mark.long

ROOT = Path(__file__).resolve().parents[2]
PROFILE = ROOT / "workflow" / "profiles" / "slurm"
STUDY = {
    "study": "small",
    "scene": "slope.yaml",
    "fidelity": "draft",
    "grid": {"S_R": ["0.10", "0.50"], "gamma": ["100"], "amplitude": ["8.0"]},
    "fidelities": {"draft": {}},
    "figures": {"strengths": ["0.10", "0.50"], "compared_strengths": ["0.10"], "compared_gammas": ["100"]},
    "claims": {"amplitude": 8.0},
}
RESULTS = Path("results", "small", "draft")
RUNS = 2
HERE = ["--slurm-status-command", "squeue", "--slurm-no-account", "--slurm-init-seconds-before-status-checks", "2", "--latency-wait", "5"]
"""What a Slurm without accounting needs, and waits that suit one machine."""
PATIENCE = 300.0
"""How long the first run may take to start, s."""


@pytest.fixture(scope="module")
def slurm(tmp_path_factory: pytest.TempPathFactory) -> Iterator[LocalSlurm]:
    if importlib.util.find_spec("snakemake_executor_plugin_slurm") is None:
        pytest.skip("snakemake-executor-plugin-slurm is not installed (pip install -e '.[slurm]')")
    try:
        with LocalSlurm(tmp_path_factory.mktemp("slurm")) as started:
            yield started
    except CannotStart as reason:
        pytest.skip(f"Slurm cannot start: {reason}")


def study_in(folder: Path) -> Path:
    (folder / "slope.yaml").write_text(yaml.safe_dump(SLOPE))
    (folder / "study.yaml").write_text(yaml.safe_dump(STUDY))
    return folder


def command(folder: Path, *arguments: str, target: str = "study.csv") -> list[str]:
    snakemake = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), "--directory", str(folder)]
    return [*snakemake, "--configfile", str(folder / "study.yaml"), *arguments, "--", str(RESULTS / target)]


def environment(slurm: LocalSlurm) -> dict[str, str]:
    return slurm.environment | {"PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])}


@pytest.fixture(scope="module")
def alone(slurm: LocalSlurm, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The study by Snakemake on its own, in one job that has a node's cores."""
    folder = study_in(tmp_path_factory.mktemp("alone"))
    wrapped = " ".join(command(folder, "--cores", "$SLURM_CPUS_PER_TASK"))
    job = ["sbatch", "--wait", "--cpus-per-task=2", "--output", str(folder / "job.log"), "--wrap", wrapped]
    done = subprocess.run(job, env=environment(slurm), capture_output=True, text=True, check=False)
    assert done.returncode == 0, (folder / "job.log").read_text()
    return folder / RESULTS


@pytest.fixture(scope="module")
def cancelled(slurm: LocalSlurm, alone: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The folder of the study through the profile, the submission of its runs cancelled on the way, and what Snakemake says of it."""
    folder = study_in(tmp_path_factory.mktemp("profile"))
    with open(folder / "log", "w") as log:
        arguments = command(folder, "--profile", str(PROFILE), "--retries", "0", *HERE)
        process = subprocess.Popen(arguments, cwd=folder, env=environment(slurm), stdout=log, stderr=log)
        end = time.monotonic() + PATIENCE
        while not list(folder.glob(f"{RESULTS}/logs/S_R*")) and process.poll() is None and time.monotonic() < end:
            time.sleep(0.05)
        number = running(slurm, "rule_runs_simulate")
        slurm.ask("scancel", number)
        process.wait()
    return folder, (folder / "log").read_text()


def running(slurm: LocalSlurm, comment: str) -> str:
    """Number of the running job that has a comment."""
    told = slurm.ask("squeue", "--noheader", "--states=RUNNING", "--format=%i %k").splitlines()
    return next(line.split()[0] for line in told if line.split()[1:] == [comment])


@pytest.fixture(scope="module")
def finished(slurm: LocalSlurm, cancelled: tuple[Path, str]) -> tuple[Path, str]:
    """The same study after the same command again, and what Snakemake says."""
    folder = cancelled[0]
    done = subprocess.run(
        command(folder, "--profile", str(PROFILE), *HERE), cwd=folder, env=environment(slurm), capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return folder / RESULTS, done.stdout + done.stderr


def test_a_cancelled_job_is_reported(cancelled: tuple[Path, str]) -> None:
    folder, said = cancelled
    assert "Error in group runs" in said and "Exiting because a job execution failed" in said
    told = [path.read_text() for path in folder.glob(".snakemake/slurm_logs/group_runs_simulate/*.log")]
    assert len(told) == 1 and "CANCELLED" in told[0]
    assert not (folder / RESULTS / "study.csv").exists()


def test_short_runs_share_submissions(cancelled: tuple[Path, str], finished: tuple[Path, str]) -> None:
    """Gravity and shaking are one, the yield acceleration one, all runs one; after the cancelled one runs, measures, the table."""
    submitted = [len(re.findall(r"has been submitted with SLURM jobid", said)) for said in (cancelled[1], finished[1])]
    assert submitted == [3, 3]
    assert len(list((finished[0] / "runs").glob("*.nc"))) == RUNS


def test_the_cluster_gives_the_tables_of_one_machine(alone: Path, finished: tuple[Path, str]) -> None:
    one, other = (pd.read_csv(folder / "study.csv").drop(columns=list(TIMINGS)) for folder in (alone, finished[0]))
    pd.testing.assert_frame_equal(one, other, check_exact=True)
    one, other = (xr.load_dataset(folder / "study.nc").drop_vars(TIMINGS) for folder in (alone, finished[0]))
    same_variables(one, other)


def test_every_run_has_the_same_bits(alone: Path, finished: tuple[Path, str]) -> None:
    for path in sorted(alone.glob("runs/*.nc")):
        same_files(path, finished[0] / "runs" / path.name)


def test_the_generic_profile_with_another_command_to_submit(slurm: LocalSlurm, alone: Path, tmp_path: Path) -> None:
    """Gravity and the shaking in one submission."""
    if importlib.util.find_spec("snakemake_executor_plugin_cluster_generic") is None:
        pytest.skip("snakemake-executor-plugin-cluster-generic is not installed (pip install -e '.[cluster]')")
    folder, before = study_in(tmp_path), len(slurm.jobs())
    submit = (
        f"sbatch --parsable --cpus-per-task={{threads}} --mem={{resources.mem_mb}} --time={{resources.runtime}} --output={folder}/job.log"
    )
    with_sbatch = ["--cluster-generic-submit-cmd", submit, "--cluster-generic-cancel-cmd", "scancel", "--latency-wait", "5"]
    asked = command(folder, "--profile", str(PROFILE.with_name("generic")), *with_sbatch, target="stages/pre_failure_amplitude-8.0.nc")
    done = subprocess.run(asked, cwd=folder, env=environment(slurm), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr + (folder / "job.log").read_text()
    assert len(slurm.jobs()) == before + 1
    same_files(folder / RESULTS / "stages" / "pre_failure_amplitude-8.0.nc", alone / "stages" / "pre_failure_amplitude-8.0.nc")


def test_the_profile_with_cards(slurm: LocalSlurm, tmp_path: Path) -> None:
    """Stages follow each other in a submission that has the card, for which numba's simulator stands."""
    if importlib.util.find_spec("numba_cuda") is None:
        pytest.skip("numba-cuda is not installed (pip install -e '.[cuda]')")
    (tmp_path / "slope.yaml").write_text(yaml.safe_dump(merge(SLOPE, FEW)))
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(STUDY | {"grid": {"soil.cohesion": ["10", "20"]}, "claims": None}))
    stages = [f"stages/gravity_soil.cohesion-{cohesion}.nc" for cohesion in (10, 20)]
    options = ["--profile", str(PROFILE.with_name("slurm-gpu")), "--group-components", "stages=2", "--config", "backend=cuda", *HERE]
    settings = {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    asked = [*command(tmp_path, *options, target=stages[0]), str(RESULTS / stages[1])]
    done = subprocess.run(asked, cwd=tmp_path, env=environment(slurm) | settings, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert len(re.findall(r"has been submitted with SLURM jobid", done.stdout + done.stderr)) == 1
    assert all(trajectory.read(tmp_path / RESULTS / stage).attrs["backend"] == "cuda" for stage in stages)
    assert re.search(r"gpu +gres[/:]gpu:1", slurm.ask("squeue", "--noheader", "--states=all", "--Format=partition,tres-per-job"))
