"""Natural cubic splines between tables, as weights of the tables."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Spline:
    """Natural cubic spline through K rising nodes, as weights of the values there; straight beyond the ends."""

    def __init__(self, nodes: Array) -> None:
        n = len(nodes)
        self._nodes, h = nodes.tolist(), np.diff(nodes)
        bend = np.zeros((n, n))
        if n > 2:
            inner = np.arange(n - 2)
            left, right = np.zeros((n - 2, n - 2)), np.zeros((n - 2, n))
            left[inner, inner] = 2 * (h[:-1] + h[1:])
            left[inner[1:], inner[:-1]] = left[inner[:-1], inner[1:]] = h[1:-1]
            right[inner, inner], right[inner, inner + 2] = 6 / h[:-1], 6 / h[1:]
            right[inner, inner + 1] = -6 / h[:-1] - 6 / h[1:]
            bend[1:-1] = np.linalg.solve(left, right)
        at_nodes, wide = np.eye(n), h[:, None]
        slope = (at_nodes[1:] - at_nodes[:-1]) / wide - wide * (2 * bend[:-1] + bend[1:]) / 6
        self._powers = np.stack([at_nodes[:-1], slope, bend[:-1] / 2, (bend[1:] - bend[:-1]) / (6 * wide)], axis=1)
        """(K - 1, 4, K) of the powers of the distance from the node below."""
        self._last_slope = np.zeros(n)
        if n > 1:
            self._last_slope = (at_nodes[-1] - at_nodes[-2]) / h[-1] + h[-1] * bend[-2] / 6

    def weights(self, at: float) -> Array:
        """(K,) of the nodes' values in the value at ``at``."""
        x = self._nodes
        if len(x) == 1:
            return np.ones(1)
        k = min(max(bisect_right(x, at) - 1, 0), len(x) - 2)
        far = at - x[k]
        if far < 0:
            return np.asarray(self._powers[k, 0] + far * self._powers[k, 1])
        near = min(far, x[k + 1] - x[k])
        weights = np.array([1.0, near, near * near, near**3]) @ self._powers[k]
        return np.asarray(weights + (far - near) * self._last_slope if far > near else weights)
