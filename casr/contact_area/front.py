"""Contact area of every frame from its front, with what its error is made of, and where it is determined at all."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LEAST_PITCHES, LEAST_PINS = 1.5, 7
"Smallest radius, in pitches, and fewest pins inside the edge for which an area is determined."
PARTS = ("pins", "dome", "misfit", "pin length", "depth", "beyond the tables")
"Parts of the standard error of an area."


@dataclass(frozen=True, eq=False)
class ContactFront:
    """The contact of T frames.

    area : (T,) in mm^2, or px^2 at the tips of the pins without a camera. candidates : (K, T) the same by each world
    that explains the press. weight, spread_weight : (K,) of each for the estimate, and for how far they differ.
    parts : name to (T,) relative standard error of ``area``; see ``PARTS``. Pin length and depth keep the sign that
    belongs to longer pins and a larger depth.
    centre_px : (2,) middle of the contact in the rest frame. edge_px : (T, M, 2) its edge in each frame.
    inside : (T, N) whether the root of each pin is inside the edge. pins_inside : (T,) how many are.
    pitches : (T,) radius of the contact over the pins' pitch.
    misfit : share of the motion that the best world leaves over beyond the scatter of the pins. off_library : the same
    of the library's best world, whatever model is taken. usual_misfit : up to which the latter is no reason to doubt.
    model_sd : relative standard error of an area although the model explains the motion; within "dome".
    model : ``finite elements`` or ``analytic``. dome, stiffness_n_per_mm : of the best world.
    log_misfit : name of each dome to the logarithm of its least misfit.
    shear_px, torsion_deg : (T, 2) and (T,) motion of the pins inside as a whole, and their turn about the centre.
    notes : what a reader should know.
    """

    area: Array
    candidates: Array
    weight: Array
    spread_weight: Array
    parts: dict[str, Array]
    centre_px: Array
    edge_px: Array
    inside: NDArray[np.bool_]
    pins_inside: NDArray[np.intp]
    pitches: Array
    misfit: float
    off_library: float
    usual_misfit: float
    model: str
    model_sd: float
    dome: str
    stiffness_n_per_mm: float
    log_misfit: dict[str, float]
    shear_px: Array
    torsion_deg: Array
    notes: tuple[str, ...]

    @property
    def relative_sd(self) -> Array:
        """(T,) total relative standard error of ``area``."""
        return np.sqrt(sum(part**2 for part in self.parts.values()))

    @property
    def determined(self) -> NDArray[np.bool_]:
        """(T,) frames in which the contact is large enough against the pitch of the pins."""
        return (self.pitches >= LEAST_PITCHES) & (self.pins_inside >= LEAST_PINS)

    def with_note_on_size(self) -> ContactFront:
        """The same, saying where it is not determined."""
        small = int((~self.determined).sum())
        if not small:
            return self
        return replace(
            self,
            notes=(
                *self.notes,
                f"In {small} of {len(self.area)} frames the contact is smaller than {LEAST_PITCHES:g} pitches or holds "
                f"fewer than {LEAST_PINS} pins: its area is not determined there and does not count.",
            ),
        )
