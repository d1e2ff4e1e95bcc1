"""Which numbers decide the answer: designs of runs, screening, a surrogate and its Sobol' indices."""
