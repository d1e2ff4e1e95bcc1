"""Other systems: what only POSIX has is not needed to import the package."""

from __future__ import annotations

import subprocess
import sys

POSIX = ("fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty")
IMPORTED = """
import builtins, importlib, pkgutil, sys

taken = builtins.__import__


def without_posix(name, globals=None, *others, **named):
    if name in sys.argv[1:] and (globals or {}).get("__name__", "").startswith("sph"):
        raise ImportError(f"{globals['__name__']} imports {name}")
    return taken(name, globals, *others, **named)


builtins.__import__ = without_posix
import sph

modules = [module.name for module in pkgutil.walk_packages(sph.__path__, "sph.")]
for module in modules:
    importlib.import_module(module)
print(len(modules))
"""


def test_no_module_needs_posix_to_be_imported() -> None:
    done = subprocess.run([sys.executable, "-c", IMPORTED, *POSIX], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) > 150


def test_an_import_of_it_would_be_seen() -> None:
    code = IMPORTED.replace("import sph\n", "exec('import fcntl', {'__name__': 'sph.storage.files'})\nimport sph\n", 1)
    done = subprocess.run([sys.executable, "-c", code, *POSIX], capture_output=True, text=True, check=False)
    assert done.returncode and "sph.storage.files imports fcntl" in done.stderr
