# Purpose: the documentation as a site. (`snakemake --cores 1 docs`)
# Inputs:  mkdocs.yml; the pages of docs and the library's docstrings, by their contents.
# Outputs: results/docs: index.html, a page for each page of docs; api: the public interface and a page a module


rule docs:
    """Write the documentation; what it needs: pip install -c constraints.txt -e ".[docs]"."""
    input:
        settings=str(SPH.parent / "mkdocs.yml"),
    output:
        "results/docs/index.html",
    log:
        "results/logs/docs.log",
    params:
        sources=sources("**/*.py", "../docs/**/*.*"),
    script:
        "../scripts/docs/write_docs.py"
