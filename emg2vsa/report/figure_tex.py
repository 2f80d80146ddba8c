"""A figure as LaTeX puts it into a paper: its PDF at its own width, caption and label."""

from __future__ import annotations

import re

from emg2vsa.figures.canvas import ONE_COLUMN_MM, width_pt
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.latex import latex_text

_PT_PER_MM = 72 / 25.4


def figure_tex(drawing: Drawing) -> str:
    r"""A figure environment, over both columns where the drawing is wider than one.

    The PDF is sought in ``\emgfolder``, the folder that holds ``figures``: the current one unless the paper says else.
    """
    wide = width_pt(drawing.svg) > ONE_COLUMN_MM * _PT_PER_MM + 1
    figure = "figure*" if wide else "figure"
    # LaTeX counts the figures itself
    caption = latex_text(re.sub(r"^Fig\. \w+\. ", "", drawing.caption))
    lines = (
        "% takes the package graphicx", r"\providecommand{\emgfolder}{.}", rf"\begin{{{figure}}}", r"\centering",
        rf"\includegraphics[width=\linewidth]{{\emgfolder/figures/{drawing.name}.pdf}}", rf"\caption{{{caption}}}",
        rf"\label{{fig:{drawing.name}}}", rf"\end{{{figure}}}", "",
    )  # fmt: skip
    return "\n".join(lines)
