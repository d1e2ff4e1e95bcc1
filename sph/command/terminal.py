"""What a command prints: answers, messages beside them, tables, refusals."""

from __future__ import annotations

import sys
import threading
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import typer
from typer.core import TyperGroup

from sph.jobs.exit_codes import REFUSED

PATIENCE = 2.0
"""Wall time after which a command says what it does, s."""


class Commands(TyperGroup):
    """The list of commands with their whole first sentences, which wrap where the terminal ends."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the section of ``--help``."""
        named = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl([(name, (command.help or "").partition("\n\n")[0]) for name, command in named if command])


def table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> str:
    """A table as wide as the terminal; what is too wide is folded, never cut."""
    from rich.console import Console
    from rich.table import Table

    made = Table()
    for name in head:
        made.add_column(name, overflow="fold")
    for row in rows:
        made.add_row(*row)
    console = Console()
    with console.capture() as text:
        console.print(made)
    return text.get().rstrip("\n")


def aligned(rows: Sequence[tuple[str, str]]) -> str:
    """Lines of labels and texts, in two columns."""
    width = max(len(label) for label, _ in rows)
    return "\n".join(f"{label:<{width}}  {text}" for label, text in rows)


@contextmanager
def refusals(doing: str = "") -> Iterator[None]:
    """Turn errors of the user's input into one message and exit code 2; say what it is ``doing`` if that takes more than ``PATIENCE``."""
    late = threading.Timer(PATIENCE, say, [f"{doing} ..."])
    late.daemon = True
    try:
        if doing:
            late.start()
        yield
    except MemoryError as error:
        print("sph: not enough memory; choose a larger numerics.spacing or a longer outputs.frame_interval", file=sys.stderr)
        raise typer.Exit(REFUSED) from error
    except BrokenPipeError:
        raise  # who reads what is printed has enough
    except (ValueError, OSError) as error:
        say(str(error))
        raise typer.Exit(REFUSED) from error
    finally:
        late.cancel()


def say(*lines: str) -> None:
    """Print messages beside the result."""
    for line in lines:
        print(f"sph: {line}", file=sys.stderr, flush=True)
