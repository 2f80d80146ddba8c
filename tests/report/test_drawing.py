from __future__ import annotations

import pytest
from matplotlib.figure import Figure

from emg2vsa.report.drawing import Drawing, figure_tex


@pytest.mark.parametrize(("width_pt", "environment"), [(252, "figure"), (513.07, "figure*")])
def test_a_figure_stands_in_the_columns_it_was_drawn_for(width_pt, environment):
    figure = Figure(figsize=(width_pt / 72, 0.5))
    made = figure_tex(Drawing("fig04_x", "T", "Fig. 4. Slopes of S_1, p < .05.", "D", figure, None))
    assert rf"\begin{{{environment}}}" in made
    assert rf"\end{{{environment}}}" in made
    assert r"\includegraphics[width=\linewidth]{\emgfolder/figures/fig04_x.pdf}" in made
    assert r"\caption{Slopes of S\_1, p \ensuremath{<} .05.}" in made
    assert r"\emgfigure{4}" in made
    assert r"\providecommand{\emgfigure}[1]{\renewcommand{\thefigure}{#1}}" in made
    assert made.index(r"\begin{") < made.index(r"\emgfigure{4}") < made.index(r"\caption")
    without = figure_tex(Drawing("x", "T", "Slopes.", "D", figure, None))
    assert r"\emgfigure{" not in without
    assert r"\caption{Slopes.}" in without
    assert r"\label{fig:fig04_x}" in made
