"""Write requirements-hashed.txt: the exact set of constraints.txt with the digests of its files for Linux on x86-64.

    .venv/bin/python tests/packaging/write_hashes.py

pip resolves the set for each version of Python and installs nothing.  Two packages have no wheels: their source is listed.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
PYTHONS = ("3.11", "3.12", "3.13")
SOURCES = ("connection_pool", "eqsig")
"""Packages without wheels."""
PLATFORMS = [
    *(f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 26, 24, 17, 12, 5)),
    *(f"manylinux{year}_x86_64" for year in (2014, 2010, 1)),
]
HEAD = f"""\
# The exact set of constraints.txt with the digests of its files, for Linux on x86-64 with Python {PYTHONS[0]} to {PYTHONS[-1]}:
# pip install --require-hashes -r requirements-hashed.txt, then pip install --no-deps --no-build-isolation -e .
# Written by tests/packaging/write_hashes.py.
"""


def digests(requirements: list[str], *options: str) -> dict[str, str]:
    """sha256 of the file that pip would take for each requirement, by the requirement."""
    with tempfile.TemporaryDirectory() as folder:
        given, report = Path(folder, "requirements.txt"), Path(folder, "report.json")
        given.write_text("\n".join(requirements), encoding="utf-8")
        command = [sys.executable, "-m", "pip", "install", "--quiet", "--dry-run", "--ignore-installed", "--no-deps", *options]
        subprocess.run([*command, "--report", str(report), "--target", folder, "-r", str(given)], check=True)
        found = {plain(each["metadata"]["name"]): each for each in json.loads(report.read_text(encoding="utf-8"))["install"]}
    return {name: found[plain(name)]["download_info"]["archive_info"]["hashes"]["sha256"] for name in requirements}


def plain(requirement: str) -> str:
    """Name of a package as pip compares them."""
    return requirement.split("==")[0].lower().replace("_", "-").replace(".", "-")


def main() -> None:
    exact = [line for line in (ROOT / "constraints.txt").read_text(encoding="utf-8").splitlines() if "==" in line]
    sources = [line for line in exact if line.split("==")[0] in SOURCES]
    wheels = [line for line in exact if line not in sources]
    known: dict[str, set[str]] = defaultdict(set)
    for python in PYTHONS:
        options = ["--only-binary", ":all:", "--python-version", python, *(word for name in PLATFORMS for word in ("--platform", name))]
        for name, digest in (digests(wheels, *options) | digests(sources)).items():
            known[name].add(digest)
    lines = [" ".join([name, *(f"--hash=sha256:{digest}" for digest in sorted(known[name]))]) for name in exact]
    (ROOT / "requirements-hashed.txt").write_text(HEAD + "\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
