"""Indentations by a flat plate: force against depth with the line of each specimen, and what departs from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from matplotlib.figure import Figure

from emg2vsa.curves.plate_tests import PlateTests
from emg2vsa.figures.canvas import panel_grid
from emg2vsa.figures.palette import INK, Look

_POINTS = 80
"""Points of a curve that are drawn, about."""


def draw_plates(plates: PlateTests, names: Sequence[str], looks: Mapping[str, Look]) -> Figure:
    """The trials from contact on, less the force of rest, and the line F = kappa x of each specimen; force less the
    line of its own trial; and kappa over force. names : specimens with trials that can say."""
    figure, ((curves, rest, over),) = panel_grid(1, (1.3, 1, 1), 52, (13, 2, 28, 6), (19, 0))
    fit = plates.fit
    for name in names:
        look, own, deepest, whole = looks[name], plates.of(name), 0.0, plates.specimen(name)
        assert whole is not None
        for i in own:
            (depth, force), n = plates.curves[i], fit.n_rest[i]
            x, y = depth - fit.contact[i], force - (force[:n].mean() if n else 0.0)
            deepest, every = max(deepest, float(x.max(initial=0.0))), max(1, x.size // _POINTS)
            x, y = x[::every], y[::every]
            curves.plot(x, y, color=look.colour, linewidth=2.5, alpha=0.3)
            rest.plot(x[x > 0], 1e3 * (y[x > 0] - fit.kappa[i] * x[x > 0]), color=look.colour, linewidth=0.7)
        force_n, tangent, half = plates.tangent(name)
        over.fill_between(force_n, tangent - half, tangent + half, color=look.colour, alpha=0.3, linewidth=0)
        over.plot(force_n, tangent, color=look.colour, linestyle=look.dash)
        line, kappa = np.array([0.0, deepest]), whole.kappa.mean
        label = f"{name}: {kappa:#.3g} ± {whole.half:#.2g} N/mm"
        curves.plot(line, kappa * line, color=look.colour, linestyle=look.dash, label=label)
    rest.axhline(0, color=INK, linewidth=0.6)
    curves.set(xlabel="Depth past contact (mm)", ylabel="Force (N)", xlim=(-0.1 * curves.get_xlim()[1], None))
    rest.set(xlabel="Depth past contact (mm)", ylabel="Force less line (mN)")
    over.set(xlabel="Force (N)", ylabel="Tangent κ (N/mm)", xlim=(0, None), ylim=(0, None))
    figure.legend(*curves.get_legend_handles_labels(), loc="lower center", ncols=3, frameon=False)
    return figure
