"""Which parameters decide the results: designs of runs, screening, a surrogate and its Sobol' indices."""
