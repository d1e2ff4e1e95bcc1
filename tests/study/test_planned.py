"""Scenes as planned: told by contents, checked by the jobs that read them."""

from __future__ import annotations

import os
import pickle
import shutil
from pathlib import Path
from typing import Any

import pytest
import xarray as xr
from small_scenes import SLOPE

from sph.scene.configuration import differences, merge
from sph.scene.schema import make_scene
from sph.scene.scheme import RESOLVED
from sph.storage import trajectory
from sph.storage.files import content_digest
from sph.storage.trajectory import text_digest
from sph.study.planned import Planned, digest, planned

GROUND: dict[str, Any] = merge(SLOPE, {"geometry": {"shape": "ground_line", "file": "ground.csv", "base": 430.0}})
LINES = ("100,440\n150,440\n165,465\n200,465\n", "100,440\n150,440\n165,460\n200,460\n")


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ground.csv").write_text(LINES[0])
    return tmp_path


def attrs(scene: dict[str, Any]) -> dict[str, Any]:
    return trajectory.run_attributes(make_scene(scene))


def as_planned(scene: dict[str, Any]) -> Planned:
    """As a process of its own plans it: what files held is kept for the life of a process."""
    return Planned(scene, {"ground.csv": content_digest(Path("ground.csv"))})


def test_the_parameter_is_told_by_contents_alone(place: Path) -> None:
    first = digest(as_planned(GROUND))
    os.utime(place / "ground.csv", (1e9, 1e9))
    assert digest(as_planned(GROUND)) == first == digest(as_planned(dict(reversed(GROUND.items()))))
    stat = (place / "ground.csv").stat()
    (place / "ground.csv").write_text(LINES[1])
    os.utime(place / "ground.csv", (stat.st_atime, stat.st_mtime))
    assert (place / "ground.csv").stat().st_size == stat.st_size
    assert digest(as_planned(GROUND)) != first != digest(as_planned(merge(GROUND, {"soil": {"cohesion": 1.0}})))
    assert len(first) < 40, "whatever the scene holds: Snakemake keeps it with every result"


def test_the_parameter_changes_with_what_the_scheme_fills_in(monkeypatch: pytest.MonkeyPatch) -> None:
    own = {name: value for name, value in SLOPE.items() if name != "scheme"}
    before = repr(planned(own)), repr(planned({**SLOPE, "scheme": "paper"}))
    monkeypatch.setitem(RESOLVED["numerics"], "gradient_tolerance", 0.03)
    assert repr(planned(own)) != before[0] and repr(planned({**SLOPE, "scheme": "paper"})) == before[1]


def test_what_a_process_has_planned_stays(place: Path) -> None:
    found = planned(GROUND)
    assert found.files == {"ground.csv": content_digest(Path("ground.csv"))} and planned(SLOPE).files == {}
    (place / "ground.csv").write_text(LINES[1])
    assert planned(GROUND) == found == pickle.loads(pickle.dumps(found))


def test_a_file_that_changes_before_the_job_reads_it_is_refused(place: Path) -> None:
    found = as_planned(GROUND)
    assert found.build() == make_scene(GROUND)
    (place / "ground.csv").write_text(LINES[1])
    with pytest.raises(ValueError, match=r"^ground\.csv: has changed.*same command again$"):
        found.build()
    (place / "ground.csv").unlink()
    with pytest.raises(ValueError, match=r"ground\.csv: .*no such file"):
        found.build()


def test_a_file_that_is_not_there_cannot_be_planned(place: Path) -> None:
    with pytest.raises(ValueError, match=r"gone\.csv: cannot be read"):
        planned(merge(GROUND, {"geometry": {"file": "gone.csv"}}))


def test_a_file_of_the_planned_scene_is_read_wherever_its_ground_lay(place: Path) -> None:
    (place / "sub").mkdir()
    shutil.copy(place / "ground.csv", place / "sub" / "other.csv")
    found = as_planned(GROUND)
    found.check(attrs(GROUND), "run.nc")
    found.check(attrs(merge(GROUND, {"geometry": {"file": "sub/other.csv"}})), "run.nc")


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"coupling": {"S_R": 0.3}}, r"coupling\.S_R: 0\.3 in the file, 0\.25 planned"),
        ({"title": "other"}, "title: 'other' in the file, '' planned"),
        ({"motion": {"kind": "none"}}, r"motion\.amplitude: None in the file, 8\.0 planned"),
        ({"damping": None}, r"damping\.ratio: None in the file, 0\.02 planned"),
        (
            {"layers": {"fill": {"region": {"kind": "depth", "bottom": 2.0}}}},
            r"layers\.fill\.region\.kind: 'depth' in the file, None planned",
        ),
    ],
)
def test_a_file_of_another_scene_is_refused_with_its_keys(change: dict[str, Any], line: str) -> None:
    with pytest.raises(ValueError, match=line) as refused:
        planned(SLOPE).check(attrs(merge(SLOPE, change)), "runs/one.nc")
    assert str(refused.value).startswith("runs/one.nc: was made from another scene than the one planned; delete it")


def test_a_long_list_of_keys_is_cut() -> None:
    other = merge(SLOPE, {"layers": {f"layer{n}": {"region": {"kind": "depth"}, "soil": {"cohesion": 1.0 + n}} for n in range(9)}})
    with pytest.raises(ValueError, match="and [0-9]+ more$") as refused:
        planned(SLOPE).check(attrs(other), "run.nc")
    assert str(refused.value).count("\n") < 40


def test_a_file_is_read_and_checked(tmp_path: Path) -> None:
    trajectory.write(tmp_path / "run.nc", xr.Dataset(attrs=attrs(SLOPE)))
    assert planned(SLOPE).read(tmp_path / "run.nc").attrs["scene_digest"] == trajectory.scene_digest(make_scene(SLOPE))
    with pytest.raises(ValueError, match=r"duration: 3\.0 .*2\.5 planned"):
        planned(merge(SLOPE, {"duration": 2.5})).read(tmp_path / "run.nc")


def test_what_a_scene_says_has_one_digest(place: Path) -> None:
    plain = trajectory.scene_digest(make_scene(SLOPE))
    assert plain == trajectory.scene_digest(make_scene(make_scene(SLOPE).model_dump(mode="json")))
    assert plain != trajectory.scene_digest(make_scene(merge(SLOPE, {"soil": {"cohesion": 1.0}})))
    ground = trajectory.scene_digest(make_scene(GROUND))
    (place / "elsewhere.csv").write_text(LINES[0])
    assert ground == trajectory.scene_digest(make_scene(merge(GROUND, {"geometry": {"file": "elsewhere.csv"}})))
    (place / "ground.csv").write_text(LINES[1])
    assert ground != trajectory.scene_digest(make_scene(GROUND))


def test_the_order_of_layers_counts_and_no_other() -> None:
    # Of two layers that overlap the later one counts: a scene with the others first is another one.
    one, other = ({"soil": {"a": 1, "b": 2}, "layers": {name: {"top": 1} for name in names}} for names in ("ab", "ba"))
    assert differences(one, other) == {"layers": (["a", "b"], ["b", "a"])}
    assert text_digest(one) != text_digest(other)
    assert text_digest(one) == text_digest({"layers": one["layers"], "soil": {"b": 2, "a": 1}})


def test_differences_name_keys_and_leave_files_out() -> None:
    one = {"a": {"b": 1, "file": "x"}, "c": [1, 2], "file": None}
    assert differences(one, {"a": {"b": 2, "file": "y"}, "c": (1, 2), "d": 0}) == {"a.b": (1, 2), "d": (None, 0)}
