"""The hand-made study of ``made``, in the working folder of a test."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from made import made_study

from sph.page.build import StudyFiles


@pytest.fixture(scope="session")
def written(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, StudyFiles]:
    """The folder below which the study was written, and its files."""
    folder = tmp_path_factory.mktemp("made")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        return folder, made_study()


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, written: tuple[Path, StudyFiles]) -> StudyFiles:
    """Files of the study, which a test may change."""
    folder, study = written
    shutil.copytree(folder, tmp_path, dirs_exist_ok=True)
    monkeypatch.chdir(tmp_path)
    return study
