"""Tables of a lab's own dome, made from the shipped ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from casr.dome.library import DEFAULT_WORLD, shipped

Arrays = dict[str, NDArray[np.float64]]


def arrays_of(stiffness_n_per_mm: float, friction: str = "stick") -> Arrays:
    """Dome A as a file of one solution."""
    library = shipped(DEFAULT_WORLD)
    stiffness = library.stiffness_n_per_mm == stiffness_n_per_mm
    (row,) = np.flatnonzero(stiffness & (library.friction == friction))
    computed = library.radius_mm <= library.computed_mm[row]
    motion = library.motion[row][computed].astype(np.float64)

    def from_rest(values: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.concatenate([np.zeros_like(values[:1]), values])

    return {
        "force_n": from_rest(library.force_n[row][computed]),
        "contact_radius_mm": from_rest(library.radius_mm[computed]),
        "edge_arc_mm": from_rest(library.edge_arc_mm[row][computed]),
        "s_mm": library.arc_mm,
        **{key: from_rest(motion[..., k]) for k, key in enumerate(("u_r_mm", "u_z_mm", "tilt_rad"))},
    }


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder of three solutions of the dome "mine"."""
    folder = tmp_path_factory.mktemp("domes")
    for stiffness, name in ((1.1, "1.1"), (5.3, "5.3"), (np.inf, "rigid")):
        np.savez(folder / f"mine_k{name}_stick.npz", **arrays_of(stiffness))
    return folder
