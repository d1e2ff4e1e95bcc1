"""Write the documentation of the library: the public interface, then a page a module."""

import pkgutil
import warnings
from importlib import import_module
from pathlib import Path
from typing import get_type_hints

import sph
from sph.command.job import job_log


def write_docs(folder: Path) -> int:
    """Write it into a folder; how many pages.  UserWarning for a docstring or annotation that pdoc cannot read."""
    import pdoc

    warnings.filterwarnings("error", module="pdoc")
    names = [module.name for module in pkgutil.walk_packages(sph.__path__, "sph.")]
    for public in sph.__all__:  # type: ignore[attr-defined]
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
    return 1 + len(names)


if __name__ == "__main__":
    with job_log(snakemake.log[0]) as log:  # type: ignore[name-defined]
        try:
            pages = write_docs(Path(snakemake.output[0]).parent)  # type: ignore[name-defined]
        except ModuleNotFoundError as error:
            raise ValueError(f'{error}; pip install -c constraints.txt -e ".[docs]"') from error
        print(f"{pages} pages", file=log)
