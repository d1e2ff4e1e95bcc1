"""Reading configuration: texts that are hostile, broken or too large are refused at once; messages stay on their lines."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Any, ClassVar

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sph.command.options import parse_settings
from sph.scene.configuration import (
    DEEPEST,
    MAX_FILE,
    MAX_LINE,
    MAX_LINES,
    FileSection,
    Section,
    dotted,
    flat,
    key,
    merge,
    parse_yaml,
    read_scene,
    read_text,
    read_yaml,
    scene_files,
    validated,
    without_files,
)
from sph.scene.schema import make_scene

CHAIN = "a0: &a0 []\n" + "".join(f"a{i}: &a{i} [*a{i - 1}]\n" for i in range(1, 1000))
HOSTILE = {
    "a chain of aliases": (CHAIN, "nested deeper"),
    "an alias of itself": ("a: &a [*a]", "nested deeper"),
    "deep lists": ("a: " + "[" * 50_000, "nested deeper"),
    "deep sections": ("a: " + "{a: " * 50_000, "nested deeper"),
    "code": ("a: !!python/object/apply:os.system [echo]", "python/object/apply"),
    "a tagged truth": ("a: !!bool x", "x"),
    "a tagged date": ("a: !!timestamp x", "YAML"),
    "an impossible date": ("a: 2001-99-99", "a: 2001-99-99 is a date"),
    "digits": (f"a: {'9' * 5000}", "digits"),
    "a key twice": ("a: 1\nb: {c: 1, d: 2, c: 3}\n", "line 2 has the key 'c' twice"),
    "NUL": ("a: \0", "#x0000"),
    "two documents": ("a: 1\n---\na: 2\n", "single document"),
}


@pytest.mark.parametrize(("text", "wanted"), HOSTILE.values(), ids=HOSTILE)
def test_hostile_yaml_is_refused(tmp_path: Path, text: str, wanted: str) -> None:
    path = tmp_path / "hostile.yaml"
    path.write_text(text)
    with pytest.raises(ValueError, match=r"hostile\.yaml: cannot be read as YAML") as raised:
        read_yaml(path)
    assert wanted in str(raised.value)


def test_aliases_are_read_and_depth_has_a_limit() -> None:
    assert parse_yaml("a: &a {b: 1}\nc: *a\nd:\n  <<: *a\n  e: [*a, *a]\n")["d"] == {"b": 1, "e": [{"b": 1}, {"b": 1}]}
    deepest = "[" * (DEEPEST - 1) + "1" + "]" * (DEEPEST - 1)
    assert str(parse_yaml(deepest)) == deepest
    with pytest.raises(ValueError, match="nested deeper"):
        parse_yaml(f"[{deepest}]")


@pytest.mark.parametrize(
    "path", [Path("/dev/zero"), Path("/dev/null"), Path("/"), Path("a\0b"), Path("n" * 5000)], ids=lambda p: str(p)[:9]
)
def test_what_is_no_file_of_text_is_refused(path: Path) -> None:
    with pytest.raises(ValueError, match="cannot be read as YAML|must hold a mapping"):
        read_yaml(path)


def test_a_huge_file_is_not_read(tmp_path: Path) -> None:
    path = tmp_path / "huge.yaml"
    path.write_bytes(b"#" * (MAX_FILE + 1))
    with pytest.raises(ValueError, match=f"larger than {MAX_FILE:,} bytes"):
        read_yaml(path)


@pytest.mark.parametrize(
    "text",
    ["030", "-012", "+07", "00", "1:30", "-1:30:45", "1:30.5", "0b11", "0x1F", "1_000", "1_0.5", '!!int "030"', '!!float "1:30"']
    + ["2024-01-01", "2024-01-01 10:00:00", '!!timestamp "2024-01-01"'],
)
def test_a_number_is_decimal_to_all_readers_or_refused_with_its_key(tmp_path: Path, text: str) -> None:
    path = tmp_path / "some.yaml"
    path.write_text(f"soil: {{density: 1800}}\nlist:\n- a: 1\n- a: {text}\n")
    written = text.split()[-1].strip('"') if text.startswith("!!") else text
    with pytest.raises(ValueError, match=rf"some\.yaml: .*list\.1\.a: {re.escape(written)} is (not one number|a date).*quote it"):
        read_yaml(path)
    with pytest.raises(ValueError, match=rf"--set 'soil\.cohesion={re.escape(text)}': .*{re.escape(written)} is"):
        parse_settings([f"soil.cohesion={text}"])


@pytest.mark.parametrize(
    ("text", "value"),
    [("30", 30), ("-7", -7), ("0", 0), ("0.5", 0.5), ("030.5", 30.5), ("5.", 5.0), (".5", 0.5), ("1.5e+3", 1500.0)]
    + [("'030'", "030"), ("1e3", "1e3"), ("08", "08"), ("1/6 m", "1/6 m"), ("10:00 h", "10:00 h"), ("a_1", "a_1")],
)
def test_decimal_numbers_and_words_are_what_they_look_like(text: str, value: Any) -> None:
    assert parse_yaml(f"a: {text}") == {"a": value}


BODIES = {"geometry": {"shape": "bodies", "width": 9.0, "height": 9.0, "bodies": [{"points": [[0, 0], [4, 0], [4, 4]]}]}}
MISSPELT: dict[str, tuple[dict[str, Any], str]] = {
    "a section": ({"geometri": {}}, "geometri: there is no such key here; did you mean geometry?"),
    "a key": ({"soil": {"Cohesion_": 3.0}}, "soil.Cohesion_: there is no such key here; did you mean cohesion? (found 3.0)"),
    "a key of a variant": ({"motion": {"kind": "ricker", "amplitud": 1}}, "amplitud: there is no such key here; did you mean amplitude?"),
    "a key of another variant": ({"motion": {"kind": "ricker", "ramp": 1}}, "motion.ramp: there is no such key here (found 1)"),
    "a key of a layer": (
        {"layers": {"clay": {"soil": {"densty": 1}}}}, "layers.clay.soil.densty: there is no such key here; did you mean density?"
    ),
    "a variant": ({"motion": {"kind": "rickr"}}, "; did you mean ricker? (found 'rickr')"),
    "no variant": ({"motion": {"amplitude": 1}}, "motion.kind: must be one of tapered_sine, ricker"),
    "no kind of body": (BODIES, "geometry.bodies.0.kind: must be one of polygon, ring"),
    "a word": ({"scheme": "resolvd"}, "scheme: Input should be 'resolved' or 'paper'; did you mean resolved?"),
}  # fmt: skip


@pytest.mark.parametrize(("changes", "wanted"), MISSPELT.values(), ids=MISSPELT)
def test_the_nearest_of_the_names_known_is_told(changes: dict[str, Any], wanted: str) -> None:
    with pytest.raises(ValueError) as raised:
        make_scene({"name": "slope", "scheme": "paper", "geometry": {"shape": "slope"}} | changes, "slope")
    assert wanted in str(raised.value)


@pytest.mark.parametrize("setting", ["a=" + "[" * 9000, "a=&a [*a]", "a=!!timestamp x", ".".join(9000 * "a") + "=1", "a=2001-99-99"])
def test_a_hostile_setting_is_refused(setting: str) -> None:
    with pytest.raises(ValueError, match="--set 'a"):
        parse_settings([setting])


class Small(Section):
    """A section for the tests below."""

    number: float = key("a number", default=1.0)


@pytest.mark.parametrize(
    "value",
    [10**5000, "9" * 5000, list(range(100_000)), "\x1b[31m", "a\nb", "\ud800"],
    ids=lambda v: repr(v)[:9] if not isinstance(v, int) else "int",
)
def test_a_message_is_one_short_printable_line(value: Any) -> None:
    for data in ({"number": value}, {str(value)[:2000] if not isinstance(value, int) else "x": 1}):
        with pytest.raises(ValueError, match=r"some\.yaml") as raised:
            validated(Small, data, "some.yaml")
        assert str(raised.value).isprintable()
        assert len(str(raised.value)) <= MAX_LINE + len(" ...")


def test_a_message_has_few_lines() -> None:
    with pytest.raises(ValueError, match="and 970 more") as raised:
        validated(Small, {f"key_{number}": 1 for number in range(1000)}, "some.yaml")
    assert len(str(raised.value).splitlines()) == MAX_LINES + 1


def test_a_key_that_is_no_text_is_refused() -> None:
    for name in (1, None, (1, 2)):
        with pytest.raises(ValueError, match=r"some\.yaml: .*Keys should be strings"):
            validated(Small, {name: 1}, "some.yaml")


class Line(FileSection):
    content: ClassVar[tuple[str, ...]] = ("points",)
    points: tuple[float, ...] = key("numbers", min_length=2)

    @classmethod
    def read_content(cls, path: Path, keys: Any) -> dict[str, Any]:
        return {"points": [float(word) for word in read_text(path).split()]}


class Holder(Section):
    line: Line = key("a section with a file")


def test_content_of_a_file_is_kept_with_the_section(tmp_path: Path) -> None:
    file = tmp_path / "numbers.txt"
    file.write_text("1 2 3")
    line = validated(Line, {"file": str(file)}, "s.yaml")
    assert line.points == (1.0, 2.0, 3.0)
    file.unlink()
    assert validated(Line, line.model_dump(mode="json"), "s.yaml") == line  # a stored scene needs no file


@pytest.mark.parametrize(
    ("content", "message"),
    [(None, "no such file"), (b"1 x", "could not convert"), (b"1\x00\x00", "not a text file"), (b"1 " * MAX_FILE, "larger than")],
)
def test_a_bad_file_is_named_with_its_key(tmp_path: Path, content: bytes | None, message: str) -> None:
    file = tmp_path / "numbers.txt"
    if content is not None:
        file.write_bytes(content)
    with pytest.raises(ValueError, match=rf"^s.yaml: line: file: {file}: .*{message}"):
        validated(Holder, {"line": {"file": str(file)}}, "s.yaml")


def test_what_is_no_file_is_named_with_its_key(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for name, message in ((".", "is a folder; name a file"), ("pipe", "is a device or a pipe"), ("a\0b", "no such file")):
        with pytest.raises(ValueError, match=rf"^s.yaml: line: file: .*: .*{message}"):
            validated(Holder, {"line": {"file": str(tmp_path / name)}}, "s.yaml")


def test_file_and_content_replace_each_other() -> None:
    stored = {"line": {"file": "old.txt", "points": [1, 2]}}
    assert merge(stored, {"line": {"file": "new.txt"}}) == {"line": {"file": "new.txt"}}
    assert merge(stored, {"line": {"points": [3, 4]}}) == {"line": {"points": [3, 4]}}
    assert merge(stored, {"line": {"other": 1}}) == {"line": {"file": "old.txt", "points": [1, 2], "other": 1}}


def test_files_lie_beside_the_scene_or_in_the_working_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "scenes").mkdir()
    (tmp_path / "place").mkdir()
    (tmp_path / "scenes" / "beside.txt").write_text("1 2")
    scene = tmp_path / "scenes" / "scene.yaml"
    scene.write_text("one: {file: beside.txt}\nparts: [{file: ../place/here.txt}]\nother: {file: nowhere.txt}\n")
    (tmp_path / "place" / "here.txt").write_text("1 2")
    monkeypatch.chdir(tmp_path)
    data = read_scene(scene)
    assert data == {"one": {"file": "scenes/beside.txt"}, "parts": [{"file": "place/here.txt"}], "other": {"file": "nowhere.txt"}}
    assert scene_files(data | {"stored": {"file": "gone.txt", "points": [1, 2]}}) == ["nowhere.txt", "place/here.txt", "scenes/beside.txt"]
    monkeypatch.chdir(tmp_path / "place")
    assert read_scene("../scenes/scene.yaml")["one"] == {"file": (tmp_path / "scenes" / "beside.txt").as_posix()}


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "cp1252"])
def test_encodings_of_text(tmp_path: Path, encoding: str) -> None:
    file = tmp_path / "numbers.txt"
    file.write_bytes("höhe 1,5\r\n".encode(encoding))
    assert read_text(file).split() == ["höhe", "1,5"]


def test_scenes_are_compared_without_the_names_of_files() -> None:
    one = {"line": {"file": "a.csv", "points": [1, 2]}, "parts": [{"file": "b"}], "name": "file"}
    assert without_files(one) == {"line": {"points": [1, 2]}, "parts": [{}], "name": "file"}


letters = st.sampled_from("abc")
trees = st.recursive(st.integers(0, 9) | st.none(), lambda inner: st.dictionaries(letters, inner, max_size=3), max_leaves=8)
mappings = st.dictionaries(letters, trees, max_size=3)
paths = st.lists(letters, min_size=1, max_size=3).map(".".join)


@given(mappings, st.dictionaries(paths, trees, min_size=1, max_size=3))
def test_what_is_set_to_a_key_is_what_the_key_then_holds(base: dict[str, Any], settings: dict[str, Any]) -> None:
    """A section takes the place of the old one whole, whatever lies over what first; every key that is not named stays as it was."""
    order = list(settings)
    lost = [path for at, path in enumerate(order) if any(other.startswith(f"{path}.") for other in order[:at])]
    if lost:
        with pytest.raises(ValueError, match=f"({'|'.join(lost)}): replaces all that is set in it"):
            dotted(settings)
        return
    made = merge(base, dotted(settings))
    for at, (path, value) in enumerate(settings.items()):
        held: Any = made
        for part in path.split("."):
            held = held[part]
        assert held == value or any(other.startswith(f"{path}.") for other in order[at + 1 :])
    kept = {name: value for name, value in flat(base).items() if not any(is_within(name, path) for path in settings)}
    assert kept == {name: value for name, value in flat(made).items() if not any(is_within(name, path) for path in settings)}


def is_within(name: str, path: str) -> bool:
    """Whether one of two dotted keys lies in the other."""
    return f"{name}.".startswith(f"{path}.") or f"{path}.".startswith(f"{name}.")


def test_a_section_that_is_set_replaces_the_old_one() -> None:
    scene = {"coupling": {"gamma": 100.0, "softening": {"slip_at_peak": 0.001, "width": 4}}, "motion": {"kind": "none"}}
    assert merge(scene, parse_settings(["coupling={S_R: 0.3}"])) == scene | {"coupling": {"S_R": 0.3}}
    assert merge(scene, parse_settings(["coupling.softening={width: 2}"]))["coupling"] == {"gamma": 100.0, "softening": {"width": 2}}
    treated = merge(parse_settings(["motion={kind: record, file: a.csv}"]), {"motion": {"baseline": {"degree": 1}}})
    shaken = {"motion": {"kind": "record", "factor": -1.0}}
    assert merge(shaken, treated) == {"motion": {"kind": "record", "file": "a.csv", "baseline": {"degree": 1}}}
    assert parse_settings(["coupling={gamma: 1}", "coupling.S_R=0.1"]) == {"coupling": {"gamma": 1, "S_R": 0.1}}
    with pytest.raises(ValueError, match=r"--set coupling: replaces all that is set in it; write all its keys there"):
        parse_settings(["coupling.S_R=0.1", "coupling={gamma: 1}"])
    with pytest.raises(ValueError, match=r"--set 'a=2': a is set twice"):
        parse_settings(["a=1", "a=2"])
