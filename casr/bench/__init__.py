"""Speed and error together: flow beside other libraries, whole presses against their truth, arithmetic at its edges."""

from __future__ import annotations

from casr.bench.run import KINDS, run

__all__ = ["KINDS", "run"]
