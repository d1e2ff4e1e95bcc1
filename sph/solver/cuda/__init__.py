"""Several runs at once on a graphics card of NVIDIA: ``memory`` places them, ``kernel`` advances them, ``ensemble`` calls it for them.

The card is another team (``sph.solver.compiled.threads``): ``kernel.advance_run`` mirrors ``sph.solver.integration.advance`` and calls the
same functions of rows, so that a term of physics is written once.  Nothing here is imported by a run on processors, which needs none of
what the extra ``cuda`` installs.
"""
