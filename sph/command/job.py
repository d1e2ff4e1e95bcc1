"""The log of a workflow's job, which ends with the reason if the job fails."""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TextIO

from sph.command.cli import REFUSED


@contextmanager
def job_log(path: Path | str) -> Iterator[TextIO]:
    """The log to write to.  An error ends the job with a line, in the log and on stderr, where the workflow shows it.

    What the user can mend (exit code 2) is that line alone; anything else leaves its traceback in the log.  A log that cannot be
    written stops nobody.
    """
    path = Path(path)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        log: TextIO = open(path, "w", encoding="utf-8", buffering=1)  # noqa: SIM115
    except OSError as error:
        print(f"{path}: no log: {error.strerror}", file=sys.stderr)
        log = sys.stderr
    try:
        yield log
    except Exception as error:
        mendable = isinstance(error, (ValueError, OSError))
        line = f"{path.stem}: {error if mendable else repr(error)}"
        with suppress(OSError):
            print(line if mendable else traceback.format_exc().rstrip(), file=log)
        print(line, file=sys.stderr, flush=True)
        raise SystemExit(REFUSED if mendable else 1) from error
    finally:
        if log is not sys.stderr:
            with suppress(OSError):
                log.close()
