# Purpose: the documentation as a site (`snakemake --cores 1 docs`), with the pages of the gallery that have been run
#          (`snakemake --cores 2 gallery`, half an hour).
# Inputs:  mkdocs.yml; the pages of docs and the library's docstrings, by their contents; the gallery's scenes and studies.
# Outputs: results/gallery: a folder a page of the gallery, as it was run, with its figures
#          results/docs: index.html, a page for each page of docs; api: the public interface and a page per module
import re

DOCS = SPH.parent / "docs"
GALLERY = {
    path.stem: path for path in DOCS.glob("gallery/*.md") if path.stem != "index"
}


wildcard_constraints:
    page="|".join(GALLERY) or "none",


rule gallery_page:
    """Run the commands of a page of the gallery, and put what they print and draw into it."""
    input:
        page=lambda wildcards: GALLERY[wildcards.page],
        files=lambda wildcards: [
            SPH.parent / name
            for name in re.findall(
                r"\b(?:config|docs)/[\w/.-]+\.\w+", GALLERY[wildcards.page].read_text()
            )
        ],
    output:
        directory("results/gallery/{page}"),
    log:
        "results/logs/gallery/{page}.log",
    threads: 2
    params:
        sources=SEARCHING + PAGE,
        root=str(SPH.parent),
    script:
        "../scripts/docs/run_page.py"


rule gallery:
    """Run all pages of the gallery."""
    input:
        expand("results/gallery/{page}", page=GALLERY),


rule docs:
    """Write the documentation; what it needs: pip install -c constraints.txt -e ".[docs]"."""
    input:
        settings=str(SPH.parent / "mkdocs.yml"),
    output:
        "results/docs/index.html",
    log:
        "results/logs/docs.log",
    params:
        sources=lambda wildcards: contents(
            "**/*.py",
            "experiments/measured/*.csv",
            "../docs/**/*.*",
            "../tools/*.py",
        ),
        gallery={
            page: os.path.getmtime(f"results/gallery/{page}")
            for page in GALLERY
            if os.path.isdir(f"results/gallery/{page}")
        },
    script:
        "../scripts/docs/write_docs.py"
