"""Importing this makes numba ready to compile and to load compiled code, which takes half a second."""

import numba

numba.njit(lambda number: number)(1)
