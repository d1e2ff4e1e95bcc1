"""The benchmark of compiling counts what is compiled, and its times are in order."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

SCENE = """
name: {name}
scheme: paper
duration: 0.01
geometry: {{shape: block, width: 4.0, height: 4.0}}
gravity: {{ramp: 0.001, duration: 0.002}}
motion: {{kind: none}}
numerics: {{spacing: 1.0, time_step: 1.0e-4, gradient_correction: {correction}}}
outputs: {{frame_interval: 0.01, series_interval: 0.001}}
"""


@pytest.mark.long
def test_what_is_cached_is_not_compiled_again(script: Any, tmp_path: Path) -> None:
    scenes = [tmp_path / f"{name}.yaml" for name in ("plain", "corrected")]
    for path, correction in zip(scenes, ("null", "{}"), strict=True):
        path.write_text(SCENE.format(name=path.stem, correction=correction))
    found, printed = script("compiling.py", *map(str, scenes))
    plain, corrected = (found[path.stem][""] for path in scenes)
    for times in (plain["first"], corrected["first"], corrected["after"]):
        assert times["variants"] == 1
    for times in (plain, corrected):
        assert times["again"]["functions"] == 0
        assert times["again"]["seconds"] < times["first"]["seconds"]
    assert corrected["after"]["functions"] < corrected["first"]["functions"]
    assert all(path.stem in printed for path in scenes)
