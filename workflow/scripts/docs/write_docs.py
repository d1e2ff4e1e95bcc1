"""Write the documentation: the pages of ``docs``, those of the gallery as they were run, and those of the library, from its docstrings."""

import pkgutil
import re
import subprocess
import sys
import tempfile
import warnings
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import IO, Any, get_type_hints

import sph
from sph.jobs.log import Job, job_log

GALLERY = Path("results/gallery")
"""The pages of the gallery as they were run, below the working folder."""


def write_api(folder: Path) -> None:
    """Write the public interface and a page per module into a folder; UserWarning for a docstring or annotation that pdoc cannot read."""
    import pdoc

    warnings.filterwarnings("error", module="pdoc")
    names = [module.name for module in pkgutil.walk_packages(sph.__path__, "sph.")]
    for public in vars(sph)["__all__"]:
        getattr(sph, public)  # pdoc shows what has been imported
    for name in names:
        for value in vars(import_module(name)).values():
            if isinstance(value, type) and issubclass(value, tuple) and hasattr(value, "_fields"):
                # pdoc looks for the names of these annotations in the wrong module.
                value.__new__.__annotations__ = get_type_hints(value)
    pdoc.render.configure(show_source=False)
    # pdoc itself leaves out the modules of a package that has __all__.
    hidden = [name for name in names if hasattr(import_module(name.rpartition(".")[0]), "__all__")]
    pdoc.pdoc("sph", *hidden, output_directory=folder)


NOT_RUN = "!!! note\n    This page has not been run here: `snakemake --cores 2 gallery` makes its results and pictures.\n\n"
"""Stands below the title of such a page of the gallery."""


def not_run(source: Path) -> str:
    """A page of the gallery without links to what running it makes."""
    title, text = source.read_text(encoding="utf-8").split("\n", 1)

    def kept(link: re.Match[str]) -> str:
        return link[0] if (source.parent / link[1]).exists() else ""

    return f"{title}\n\n{NOT_RUN}" + re.sub(r"!?\[[^\]]*\]\((?!\.\.)([^)#:]*)\)", kept, text)


def on_files(files: Any, config: Any) -> Any:
    """MkDocs asks for it: the pages of the library lie in ``api``, those of the gallery take the place of their sources."""
    from mkdocs.structure.files import File

    for source in sorted(path for path in Path(config.docs_dir, "gallery").glob("*.md") if path.stem != "index"):
        name, executed = f"gallery/{source.stem}.md", GALLERY / source.stem
        files.remove(files.get_file_from_path(name))
        if not (executed / "page.md").is_file():
            files.append(File.generated(config, name, content=not_run(source)))
            continue
        files.append(File.generated(config, name, abs_src_path=str((executed / "page.md").resolve(strict=True))))
        for made in sorted(path for path in executed.rglob("*.*") if path.is_file() and path != executed / "page.md"):
            name = f"gallery/{source.stem}/{made.relative_to(executed).as_posix()}"
            files.append(File.generated(config, name, abs_src_path=str(made.resolve())))
    with tempfile.TemporaryDirectory() as folder:
        write_api(Path(folder))
        for path in sorted(Path(folder).rglob("*.*")):
            place = f"api/{path.relative_to(folder).as_posix()}"
            files.append(File.generated(config, place, content=path.read_text(encoding="utf-8")))
    return files


def on_page_markdown(markdown: str, **_: Any) -> str:
    """MkDocs asks for it: tables that the repository does not keep are made."""
    sys.path[:0] = [root] if (root := str(Path(__file__).parents[3])) not in sys.path else []
    from tools.reference import with_tables

    return with_tables(markdown)


def write_docs(path_to_settings: str, folder: Path, log: IO[str]) -> None:
    """Write the site into a folder; ValueError where what it needs is not installed, or for a warning, which the log names."""
    for needed in ("mkdocs", "material", "pdoc"):
        if find_spec(needed) is None:
            raise ValueError(f'{needed} is not installed; pip install -c constraints.txt -e ".[docs]"')
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--config-file", path_to_settings, "--site-dir", str(folder.resolve())]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    print(done.stdout + done.stderr, file=log)
    if done.returncode:
        raise ValueError(f"the documentation has faults:\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    snakemake: Job
    with job_log(snakemake.log[0]) as log:
        write_docs(snakemake.input.settings, Path(snakemake.output[0]).parent, log)
