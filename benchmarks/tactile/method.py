"""What is compared: a way to get from two frames to a motion, ours or a peer's, behind one call."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.timing import Run
from casr.flow.region import Region

Image = NDArray[np.uint8]
Prepare = Callable[[Image, Image, Region], Run]


@dataclass(frozen=True)
class Method:
    """One way.

    Parameters
    ----------
    library, name : as printed.
    prepare : from first frame, second frame and the core of the contact to the call that is timed. What is done once
        per sequence, or belongs to the frame before, is done in ``prepare``. The first call gives the motion from the
        first to the second frame: a flow (H, W, 2) in px, or an ``Affine``.
    slow : scored on fewer seeds.
    needs : module to import, or ``module.part`` of one, for peers that need not be there.
    note : where it does more or less than the others, what.
    """

    library: str
    name: str
    prepare: Prepare
    slow: bool = False
    needs: str = "cv2"
    note: str = ""

    @property
    def installed(self) -> bool:
        """Whether it can be run here."""
        module, _, part = self.needs.partition(".")
        if importlib.util.find_spec(module) is None:
            return False
        return not part or hasattr(importlib.import_module(module), part)
