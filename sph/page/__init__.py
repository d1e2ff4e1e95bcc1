"""The page of a study: one HTML file that holds its tables, figures and runs, and opens without a network.

* ``sections``: what the page shows besides the runs: tables and figures by their paths; ``paper``: of the paper's study
* ``tables``: the page's tables: of the runs, of the scene, from CSV files and of the release
* ``explorer``: the runs themselves, packed for the part that lets the reader choose one
* ``build``: all of it put into ``page.html``, with ``page.css`` and ``page.js``
"""
