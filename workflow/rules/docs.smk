# Purpose: the documentation of the library. (`snakemake --cores 1 docs`)
# Inputs:  its docstrings.
# Outputs: results/docs: index.html, sph.html and a page a module


rule docs:
    """Write the documentation from the docstrings; what it needs: pip install -c constraints.txt -e ".[docs]"."""
    output:
        "results/docs/index.html",
    log:
        "results/docs/logs/docs.log",
    params:
        sources=sources("**/*.py"),
    script:
        "../scripts/write_docs.py"
