"""A cost in words: its time, and the machine that it was measured on, by its processor and its cores."""

from __future__ import annotations

import os
import platform
import subprocess
from pathlib import Path


def duration(seconds: float) -> str:
    """A time in words: 45 s, 21 min, 3 min 20 s, 2 h 5 min."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    parts = [(hours, "h"), (minutes, "min"), (rest if hours == 0 else 0, "s")]
    return " ".join(f"{count} {unit}" for count, unit in parts if count) or "0 s"


def machine_class() -> str:
    """Processor and number of cores in one phrase."""
    return f"{processor()}, {os.cpu_count()} cores"


def processor() -> str:
    """Model name of the processor; the architecture where the operating system gives none."""
    try:
        if platform.system() == "Darwin":
            asked = subprocess.run(["sysctl", "-n", "machdep.cpu.brand_string"], capture_output=True, text=True, check=True)
            return asked.stdout.strip()
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except (OSError, subprocess.CalledProcessError):
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()
