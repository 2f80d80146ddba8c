"""Panels in rows and columns at IEEE width, lettered (a), (b), ... row by row."""

from __future__ import annotations

from collections.abc import Sequence
from string import ascii_lowercase

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from emg2vsa.figures.canvas import TWO_COLUMNS_MM

_MM_PER_INCH = 25.4


def panel_grid(
    rows: int, shares: Sequence[float], panel_mm: float, margins_mm: Sequence[float], gaps_mm: tuple[float, float]
) -> tuple[Figure, list[list[Axes]]]:
    """A figure over both columns of the page, and its axes row by row. Call it inside ``style()``.

    shares : widths of the columns, relative. panel_mm : height of a panel. margins_mm : left, right, bottom, top.
    gaps_mm : between columns, between rows.
    """
    left, right, bottom, top = margins_mm
    across, down = gaps_mm
    width, height = TWO_COLUMNS_MM, bottom + top + rows * panel_mm + (rows - 1) * down
    figure = Figure(figsize=(width / _MM_PER_INCH, height / _MM_PER_INCH))
    unit = (width - left - right - across * (len(shares) - 1)) / sum(shares)
    axes = [
        [
            figure.add_axes(
                (
                    (left + unit * sum(shares[:column]) + column * across) / width,
                    1 - (top + (row + 1) * panel_mm + row * down) / height,
                    unit * share / width,
                    panel_mm / height,
                )
            )
            for column, share in enumerate(shares)
        ]
        for row in range(rows)
    ]
    for letter, panel in zip(ascii_lowercase, (panel for row in axes for panel in row), strict=False):
        panel.set_title(f"({letter})", loc="left")
    return figure, axes
