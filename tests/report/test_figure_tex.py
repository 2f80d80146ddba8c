from __future__ import annotations

import pytest

from emg2vsa.report.drawing import Drawing
from emg2vsa.report.figure_tex import figure_tex


@pytest.mark.parametrize(("width_pt", "environment"), [(252, "figure"), (513.07, "figure*")])
def test_a_figure_stands_in_the_columns_it_was_drawn_for(width_pt, environment):
    svg = f'<svg height="9pt" width="{width_pt}pt">'
    made = figure_tex(Drawing("fig04_x", "T", "Fig. 4. Slopes of S_1, p < .05.", "D", svg, b"", None))
    assert rf"\begin{{{environment}}}" in made
    assert rf"\end{{{environment}}}" in made
    assert r"\includegraphics[width=\linewidth]{\emgfolder/figures/fig04_x.pdf}" in made
    assert r"\caption{Slopes of S\_1, p \ensuremath{<} .05.}" in made  # LaTeX counts by itself
    assert r"\label{fig:fig04_x}" in made
