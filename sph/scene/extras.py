"""Packages of one use, which not everybody installs: extras of this package (``pyproject.toml``)."""

from __future__ import annotations

from importlib import import_module
from typing import Any


def of_extra(module: str, extra: str) -> Any:
    """A module that an extra installs; ValueError with the command that installs it where it is missing."""
    try:
        return import_module(module)
    except ImportError as error:
        package = module.partition(".")[0]
        raise ValueError(f'{package} is not installed; pip install -c constraints.txt -e ".[{extra}]", or pip install {package}') from error
