"""Time to compile the solver for a scene: ``python tests/benchmarks/compiling.py [SCENE ...] [--against FOLDER] [--json FILE]``.

Each scene (by default those of ``config/scenes``) is prepared up to its first step by a process of its own: with an empty cache, as on a
new machine, and with one that holds what the first scene has left, as for another set of terms.  Times are those of the processor,
which other work on the machine lengthens as well: to compare two versions give the folder of the other, and both are timed in turn.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from measuring import PAPER, command_line, hand_out

ROOT = Path(__file__).resolve().parents[2]
PREPARE = """
import json, sys, time
from pathlib import Path
from numba.core import event
from sph.scene.schema import load_scene
from sph.solver.simulation import Simulation

simulation = Simulation(load_scene(Path(sys.argv[1])))
with event.install_recorder("numba:compile") as recorder:
    start = time.process_time()
    simulation.prepare()
    seconds = time.process_time() - start
names = [found.data["dispatcher"].py_func.__name__ for _, found in recorder.buffer if found.is_start]
print(json.dumps({"seconds": seconds, "functions": len(names), "variants": names.count("advance")}))
"""


def prepare(scene: Path, root: Path, cache: Path) -> dict[str, Any]:
    """Processor time (s) to prepare a scene with the sources in a folder, functions compiled, and how many of them are ``advance``."""
    environment = os.environ | {"PYTHONPATH": str(root), "SPH_CACHE_DIR": str(cache), "OMP_NUM_THREADS": "1"}
    command = [sys.executable, "-c", PREPARE, str(scene.resolve())]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, cwd=root, check=False)
    if done.returncode:
        raise SystemExit(done.stderr)
    return json.loads(done.stdout)


def measure(scenes: list[Path], roots: dict[str, Path]) -> dict[str, Any]:
    """For each scene and each version: from an empty cache, after the first scene, and again."""
    found: dict[str, Any] = {scene.stem: {name: {} for name in roots} for scene in scenes}
    with tempfile.TemporaryDirectory() as folder:
        for number, scene in enumerate(scenes):
            for name, root in roots.items():
                cache, first = Path(folder, name, scene.stem), Path(folder, name, scenes[0].stem)
                times = found[scene.stem][name]
                times["first"] = prepare(scene, root, cache)
                if number:
                    after = cache.with_name("after")
                    shutil.copytree(first, after)
                    times["after"] = prepare(scene, root, after)
                    shutil.rmtree(after)
                times["again"] = prepare(scene, root, cache)
    return found


def table(found: dict[str, Any]) -> str:
    """The numbers as text."""
    lines = [f"{'':24s}{'empty cache':>14s}{'functions':>12s}{'after the first':>18s}{'again':>10s}   (s of the processor)"]
    for scene, versions in found.items():
        for name, times in versions.items():
            after = f"{times['after']['seconds']:18.1f}" if "after" in times else f"{'-':>18s}"
            lines.append(
                f"{scene + (' ' + name if name else ''):24s}{times['first']['seconds']:14.1f}{times['first']['functions']:12d}{after}"
                f"{times['again']['seconds']:10.1f}"
            )
        if len(versions) == 2:
            here, other = (times["first"]["seconds"] for times in versions.values())
            lines.append(f"{'':4s}{'over that of the other':20s}{here / other:14.2f}")
    return "\n".join(lines)


def main(arguments: list[str] | None = None) -> None:
    """Parse the command line, measure, print a table and write JSON."""
    parser = command_line(__doc__)
    parser.add_argument("scenes", nargs="*", type=Path, help="scene files (default: those of config/scenes)")
    parser.add_argument("--against", type=Path, metavar="FOLDER", help="another version of the sources, timed in turn")
    options = parser.parse_args(arguments)
    scenes = options.scenes or [PAPER, *sorted(path for path in PAPER.parent.glob("*.yaml") if path != PAPER)]
    roots = {"": ROOT} if options.against is None else {"here": ROOT, "other": options.against.resolve()}
    found = measure(scenes, roots)
    hand_out(found, table(found), options.json)


if __name__ == "__main__":
    main()
