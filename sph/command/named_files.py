"""The files that a configuration or a scene names, with the places in its text where they stand, so that a name can be replaced there.

Everything but the names stays as it was written, comments too.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from enum import StrEnum
from typing import NamedTuple

import yaml

from sph.command.new import quoted
from sph.scene.configuration import CONTENT_KEYS

NULL = "tag:yaml.org,2002:null"
TEXT = "tag:yaml.org,2002:str"
NOTHING = ("null", "~", "")
"""Values of a dimension that name no file."""


class Role(StrEnum):
    """What a named file is, and so where it is looked for."""

    CONTENT = "content"
    """ground line, water table or record, by the key ``file``: beside the scene, else in the working folder"""
    SCENE = "scene"
    """a scene, in the working folder or else beside the library, as the following"""
    CONFIGURATION = "experiment"
    """the configuration of one"""
    CASES = "cases"
    """table of the cases of a study"""
    HAZARD = "hazard curve"


WORDS = {"geometry": "ground line", "water": "water table"}
"""Of the section that a file with content belongs to; all others are records."""


class Named(NamedTuple):
    """A file, as it is named."""

    path: tuple[str, ...]
    """the keys down to it"""
    value: str
    role: Role
    start: int
    """of the value in the text, characters"""
    end: int

    @property
    def is_dimension(self) -> bool:
        """Whether it is a value of a dimension, of which the names of runs are made."""
        return self.path[-1].endswith(".file")

    @property
    def key(self) -> str:
        """Dotted."""
        return ".".join(self.path)

    @property
    def words(self) -> str:
        """Its description in messages."""
        return words_of(self.key) if self.role == Role.CONTENT else str(self.role)


def words_of(key: str) -> str:
    """What the file with content of a dotted key is, for people."""
    return WORDS.get(key.split(".")[-2], "record")


def named_files(text: str) -> list[Named]:
    """The files that a YAML text names, each place once, in the order of the text; none of a section that holds their content."""
    node = yaml.compose(text, yaml.SafeLoader)
    named = [] if node is None else _below(node, ())
    found = {each.start: each for each in sorted(named, key=lambda each: each.is_dimension)}  # where an alias makes it both, it is one
    return [found[start] for start in sorted(found)]


def _below(node: yaml.Node, path: tuple[str, ...]) -> Iterator[Named]:
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            yield from _below(item, path)
    if not isinstance(node, yaml.MappingNode):
        return
    holds_content = any(name.value in CONTENT_KEYS and value.tag != NULL for name, value in node.value)
    for name, value in node.value:
        key = (*path, str(name.value))
        role = _role(key)
        if role is None or holds_content and name.value == "file":
            yield from _below(value, key)
            continue
        for item in value.value if isinstance(value, yaml.SequenceNode) else [value]:
            if item.tag == TEXT and item.value not in NOTHING:
                yield Named(key, item.value, role, item.start_mark.index, item.end_mark.index)
            else:
                yield from _below(item, key)


def _role(key: tuple[str, ...]) -> Role | None:
    """What the value of a key is, by its path, if it is a text; None for a key that names no file."""
    if key[-1] == "file" or key[-1].endswith(".file"):
        return Role.CONTENT
    if key[-1] == "scene" and (len(key) == 1 or len(key) == 3 and key[0] in ("cases", "parameters")):
        return Role.SCENE
    if key[0] == "experiments" and len(key) == 2:
        return Role.CONFIGURATION
    return {"cases": Role.CASES, "hazard": Role.HAZARD}.get(key[0]) if len(key) == 1 else None


def renamed(text: str, names: Mapping[Named, str]) -> str:
    """The text with other names for some of its files; ValueError where one stands in a form that cannot be replaced."""
    changed = text
    for each in sorted(names, key=lambda named: -named.start):
        properties = re.match(r"([&!]\S*\s+)*", text[each.start : each.end])
        kept = properties[0] if properties else ""
        changed = changed[: each.start] + kept + quoted(names[each]) + changed[each.end :]
    for before, after in zip(named_files(text), named_files(changed), strict=True):
        if after.value != names.get(before, before.value):
            raise ValueError(f"{before.key}: {before.value!r}: cannot be replaced; write it on one line, in quotes")
    return changed
