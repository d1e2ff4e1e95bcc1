"""The command, called within the tests' process."""

from __future__ import annotations

from typer.testing import CliRunner, Result

from sph.command.cli import app


def call(*arguments: object) -> Result:
    """What ``sph`` does with arguments: its exit code, and what it prints."""
    return CliRunner().invoke(app, [str(argument) for argument in arguments])
