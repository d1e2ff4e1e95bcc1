"""What is known to be wrong with a study before its runs stops their jobs, unless the study is to go on.

Each job looks for itself: as an input of runs, the table of the check would have them made again whenever the check is.
"""

from __future__ import annotations

from pathlib import Path

CHECKED = "checked.csv"
"""In the folder of a study: what is found before its runs, errors first."""
GO_ON = "go_on"
"""Value of the study's key ``on_error`` with which its runs are made all the same."""


def stop_for_errors(folder: Path | str) -> None:
    """ValueError where ``CHECKED`` of a study's folder begins with errors: what they are, and the remedies."""
    path = Path(folder, CHECKED)
    try:
        with path.open(encoding="utf-8") as file:
            if not (file.readline() and file.readline().startswith("error,")):
                return
    except FileNotFoundError:
        return
    # Loaded here alone, for a job of a short run takes less time than that.
    from sph.checks.finding import Severity
    from sph.checks.messages import line
    from sph.study.preflight import read_preflight

    rows = [row for row in read_preflight(path) if row.finding.severity == Severity.ERROR]
    told = "\n".join(f"  {row.worst_run}{f' and {row.runs - 1} more' if row.runs > 1 else ''}: {line(row.finding)}" for row in rows)
    raise ValueError(
        f"no run is made, since results would not be those that you want:\n{told}\n"
        f"mend this, or write on_error: {GO_ON} in the study (--config on_error={GO_ON}) to run it as it is; finished runs stay as they are"
    )
