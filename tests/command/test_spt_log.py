"""The way from a boring log to liquefaction, as its page goes it."""

from __future__ import annotations

import re
from pathlib import Path

import pandas as pd
import pytest
from calling import call

from sph.scene.schema import load_scene

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "how-to" / "spt-log.md").read_text(encoding="utf-8")
SCENE = "config/scenes/loose_bank.yaml"
COARSE = ("--set", "numerics.spacing=2", "--set", "coupling.softening.width=6")


def sph(*words: str) -> str:
    done = call(*words)
    assert done.exit_code == 0, done.output
    return " ".join(done.output.split())


def test_the_scene_has_the_blow_counts_of_the_log(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    names: dict[str, pd.DataFrame] = {}
    (block,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(block, names)
    scene = load_scene(SCENE)
    for name, soil in zip(scene.layers, scene.soils[1:], strict=True):
        assert names["layers"].loc[name].tolist() == [soil.blow_count, soil.fines_content], name


def test_the_commands_say_what_liquefies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(ROOT)
    said = sph("check", SCENE, "--magnitude", "7", *COARSE)
    assert "loose liquefies in the earthquake" in said and "dense does not liquefy" in said


@pytest.mark.long
def test_the_run_says_when_and_how_far(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.chdir(ROOT)
    file = str(tmp_path / "bank.nc")
    said = sph("run", SCENE, "--out", file, *COARSE)
    share, middle = re.search(r"loose has liquefied: (\d+) % of its sand below water, half of that by ([\d.]+) s", said).groups()  # type: ignore[union-attr]
    assert int(share) > 90 and 4.0 < float(middle) < 12.0
    assert "collapse" in sph("metrics", file)
    sph("plot", file, "--field", "pore_pressure_ratio", "--time", "10", "--out", str(tmp_path / "bank.png"))
