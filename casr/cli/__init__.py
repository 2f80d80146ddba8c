"""The command ``casr``: one file per sub-command, heavy modules loaded only by the one that runs."""

from __future__ import annotations

from collections.abc import Sequence

import casr
from casr.command_line import Program
from casr.errors import EXTRAS

PROGRAM = Program(
    name="casr",
    version=casr.__version__,
    description="From tactile frames and force to the contact area spread rate (CASR) of a soft specimen.",
    epilog="Try: casr simulate presses, then casr score presses --page scores.html.",
    commands=(
        "score",
        "kappa",
        "sensor",
        "stream",
        "area",
        "flow",
        "calibrate",
        "simulate",
        "dome",
        "bench",
        "completion",
    ),
    stopped="Files that were finished are kept.",
    extras=EXTRAS,
)


def main(argv: Sequence[str] | None = None) -> int:
    """Run one sub-command; returns the exit status: 0 done, 1 something is not good, 2 unusable input."""
    return PROGRAM.main(argv)
