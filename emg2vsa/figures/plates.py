"""Indentations by a flat plate: force against depth with the line of each specimen, and what departs from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.arrays import Floats
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import INK, Look

_POINTS = 80
"""Of a curve that are drawn, about."""


@dataclass(frozen=True)
class PlateCurves:
    """Trials on one specimen: depth (m,) past contact in mm and force (m,) in N of each; kappa : (n,) N/mm."""

    trials: Sequence[tuple[Floats, Floats]]
    kappa: Floats


def draw_plates(specimens: Mapping[str, PlateCurves], looks: Mapping[str, Look]) -> Figure:
    """Left the trials and the mean line F = kappa x of each specimen, right force less the line of its own trial."""
    figure, ((curves, rest),) = panel_grid(1, (1.4, 1), 52, (13, 2, 12, 6), (16, 0))
    for name, each in specimens.items():
        look, deepest = looks[name], 0.0
        for (depth, force), kappa in zip(each.trials, each.kappa, strict=True):
            every = max(1, depth.size // _POINTS)
            x, y = depth[::every], force[::every]
            curves.plot(x, y, color=look.colour, linewidth=2.5, alpha=0.3)
            rest.plot(x[x > 0], 1e3 * (y[x > 0] - kappa * x[x > 0]), color=look.colour, linewidth=0.7)
            deepest = max(deepest, float(depth.max(initial=0.0)))
        line = np.array([0.0, deepest])
        label = f"{name}: {np.mean(each.kappa):#.3g} N/mm"
        curves.plot(line, np.mean(each.kappa) * line, color=look.colour, linestyle=look.dash, label=label)
    rest.axhline(0, color=INK, linewidth=0.6)
    curves.set(xlabel="Depth past contact (mm)", ylabel="Force (N)", xlim=(-0.1 * curves.get_xlim()[1], None))
    rest.set(xlabel="Depth past contact (mm)", ylabel="Force less line (mN)")
    curves.legend(loc="lower right")
    return figure
