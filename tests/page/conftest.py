"""The hand-made study of ``made``, in the working folder of a test."""

from __future__ import annotations

from pathlib import Path

import pytest
from made import made_study

from sph.page.build import StudyFiles


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> StudyFiles:
    """Files of the study."""
    monkeypatch.chdir(tmp_path)
    return made_study()
