"""Sets of connected particles."""

from __future__ import annotations

import numpy as np
import scipy  # type: ignore[import-untyped]


def linked_sets(x: np.ndarray, y: np.ndarray, link: float) -> np.ndarray:
    """Number (n,), from 0, of the set of points linked by distances up to ``link`` (m) that each point belongs to."""
    pairs = scipy.spatial.cKDTree(np.column_stack([x, y])).query_pairs(link, output_type="ndarray")
    links = scipy.sparse.coo_array((np.ones(len(pairs), bool), (pairs[:, 0], pairs[:, 1])), shape=(x.size, x.size))
    return np.asarray(scipy.sparse.csgraph.connected_components(links, directed=False)[1])


def largest_mass(x: np.ndarray, y: np.ndarray, link: float) -> np.ndarray:
    """Mask (n,) of the largest set of points (n,) linked by distances up to ``link``, all in m; of equal sets the first."""
    label = linked_sets(x, y, link)
    return label == np.argmax(np.bincount(label))
