"""The profiles for clusters and the container's recipe: they plan, they run, and they name what there is."""

from __future__ import annotations

import importlib.util
import json
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]
PROFILES = {
    "slurm": "snakemake_executor_plugin_slurm",
    "slurm-gpu": "snakemake_executor_plugin_slurm",
    "generic": "snakemake_executor_plugin_cluster_generic",
}
"""Profile and the plugin that it needs."""
RECIPE = (ROOT / "Containerfile").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", ["slurm", *(pytest.param(name, marks=pytest.mark.long) for name in ("slurm-gpu", "generic"))])
def test_a_profile_plans_the_shipped_study(name: str) -> None:
    if importlib.util.find_spec(PROFILES[name]) is None:
        pytest.skip(f"{PROFILES[name]} is not installed")
    asked = [sys.executable, "-m", "snakemake", "--profile", str(ROOT / "workflow" / "profiles" / name), "--dry-run", "--forceall"]
    on_cards = name == "slurm-gpu"
    done = subprocess.run([*asked, *["--config", "backend=cuda"] * on_cards], capture_output=True, text=True, check=False, cwd=ROOT)
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    if on_cards:
        assert re.findall(r"Group job (\w+)", said).count("runs") == 1, "24 runs on one card"
        assert said.count("gpu=1, slurm_partition=gpu") == 28 and said.count("gpu=0") == 3, "not the search, the check, nor the preflight"
        return
    groups = re.findall(r"Group job (\w+)", said)
    assert groups.count("stages") == 1 and groups.count("runs") == 2 and len({*groups}) == 2, "the search in no group, 24 runs by 16"
    assert "mem_mb=2000" in said and "runtime=30" in said, "what is no simulation"


def test_a_profile_names_rules_of_the_workflow() -> None:
    """Snakemake passes over the name of a rule that is not there."""
    listed = subprocess.run([sys.executable, "-m", "snakemake", "--list-rules"], capture_output=True, text=True, check=True, cwd=ROOT)
    rules = set(listed.stdout.split())
    for name in PROFILES:
        profile = yaml.safe_load((ROOT / "workflow" / "profiles" / name / "config.yaml").read_text(encoding="utf-8"))
        grouped = dict(pair.split("=") for pair in profile["groups"])
        assert {*grouped, *profile.get("set-resources", ())} <= rules
        assert {pair.split("=")[0] for pair in profile["group-components"]} <= set(grouped.values())


# ---------------------------------------------------------------- container


def instructions(recipe: str) -> list[tuple[str, str]]:
    """Instruction and argument of every line, continued lines joined."""
    joined = re.sub(r"\\\n", " ", recipe)
    lines = [line for line in joined.splitlines() if line.strip() and not line.startswith("#")]
    return [(line.split(maxsplit=1)[0], line.split(maxsplit=1)[1]) for line in lines]


def test_the_container_copies_what_there_is() -> None:
    copied = [shlex.split(argument) for name, argument in instructions(RECIPE) if name == "COPY"]
    sources = {word for words in copied for word in words[:-1] if not word.startswith("--")}
    assert sources and all((ROOT / source).exists() for source in sources)
    needed = {"constraints.txt", "pyproject.toml", "README.md", "LICENSE", "Snakefile", "sph", "workflow", "config"}
    assert needed <= sources, "pip and Snakemake need these"
    assert all(words[0] == "--chown=sph" for words in copied)


def test_the_container_installs_as_the_readme_does() -> None:
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    installed = re.search(r"pip install --no-compile (-c constraints\.txt -e \"\.\[workflow\]\")", readme)
    assert installed
    ran = " ".join(argument for name, argument in instructions(RECIPE) if name == "RUN")
    assert f".venv/bin/pip install --no-cache-dir {installed[1]}" in ran and "python3 -m venv .venv" in ran
    entry = next(argument for name, argument in instructions(RECIPE) if name == "CMD")
    assert json.loads(entry)[:2] == ["snakemake", "--cores"]


def test_the_container_has_a_user_and_a_cache_of_compiled_code() -> None:
    written = dict(instructions(RECIPE))
    assert written["FROM"] == "python:3.11-slim" and written["USER"] == "sph"
    assert "SPH_CACHE_DIR=/var/cache/sph" in written["ENV"]
    order = [name for name, _ in instructions(RECIPE)]
    assert order.index("USER") < order.index("COPY"), "nothing is installed as root"
    warmed = next(argument for name, argument in instructions(RECIPE) if name == "RUN" and "sph compile" in argument)
    assert "chmod -R go-w /var/cache/sph" in warmed, "what lies there is executed"
    user = re.search(r"--uid (\d+) sph", RECIPE)
    assert user is not None and "a+" not in RECIPE
    pages = (ROOT / "docs" / "how-to" / "clusters.md").read_text(encoding="utf-8")
    for text in (RECIPE, pages):
        assert f"podman run --rm --userns keep-id:uid={user[1]},gid={user[1]} " in text, "whoever runs it is the user of the cache"


def test_no_page_keeps_compiled_code_in_a_shared_temporary_folder() -> None:
    """Whoever makes the folder first decides what is executed."""
    texts = [
        *ROOT.glob("*.md"),
        *(ROOT / "docs").rglob("*.md"),
        ROOT / "Containerfile",
        *(path for path in (ROOT / "workflow").rglob("*.*") if path.suffix != ".pyc"),
        *(ROOT / ".ci").iterdir(),
    ]
    lines = [line for path in texts if path.is_file() for line in path.read_text(encoding="utf-8").splitlines() if "SPH_CACHE_DIR" in line]
    assert lines and not [line for line in lines if re.search(r"SPH_CACHE_DIR\W*(/var)?/(tmp|dev/shm)|SPH_CACHE_DIR\W*\$\{?TMP", line)]


def test_what_warms_the_cache_is_a_command() -> None:
    """It is run as it stands, but for one scene."""
    warmed = next(argument for name, argument in instructions(RECIPE) if name == "RUN" and "sph compile" in argument)
    words = shlex.split(warmed.split("&&")[0])
    assert words[0] == ".venv/bin/sph"
    assert ROOT / "config" / "scenes" / "paper.yaml" in list(ROOT.glob(words.pop()))
    command = [sys.executable, "-m", "sph.command.cli", *words[1:], "config/scenes/paper.yaml"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0 and "paper.yaml: ready" in done.stdout, done.stderr


def test_the_container_builds() -> None:
    builder = next((name for name in ("podman", "docker") if shutil.which(name) and _answers(name)), None)
    if builder is None:
        pytest.skip("neither podman nor docker answers")
    done = subprocess.run([builder, "build", "-t", "sph-slope-test", "."], capture_output=True, text=True, check=False, cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    ran = subprocess.run([builder, "run", "--rm", "sph-slope-test", "snakemake", "-n"], capture_output=True, text=True, check=False)
    assert ran.returncode == 0, ran.stderr


def _answers(builder: str) -> bool:
    return subprocess.run([builder, "info"], capture_output=True, check=False).returncode == 0
