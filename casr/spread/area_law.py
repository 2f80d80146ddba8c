"""Contact area frame by frame from the initial area and the growth the flow shows (paper, eq. 1)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import FramesError, NoContactError, SettingError

AREA_LAWS = ("ode", "paper")


def contact_areas(
    initial_area: float, growth: ArrayLike, force_n: ArrayLike | None = None, *, law: str = "ode"
) -> NDArray[np.float64]:
    """Area of contact in every frame.

    initial_area : A_c0 of the first frame, mm^2 or px^2; 0 gives 0 everywhere.
    growth : (T-1,) growth from each frame to the next: log of the region's area ratio for ``ode`` (``log_growth`` of
        a flow step), its mean divergence for ``paper``.
    force_n : (T,) force per frame, N; only ``paper`` needs it. NaN gives NaN in that frame.
    law : ``ode``: A_i = A_c0 exp(growth_1 + ... + growth_i), the solution of dA = A D for a divergence per frame.
        ``paper``: A_i = A_c0 exp(D_cum F_i) as printed. D_cum carries no index there and must be constant for (1) to
        solve dA/dF = A D_cum, so it is the sum over the whole sequence; A_0 = A_c0 because the paper puts F_0 = 0.
        A dimensionless sum times a force is no pure number: the scale of these areas depends on the unit of force.

    Returns (T,) areas in the unit of ``initial_area``.
    NoContactError : negative or not finite initial area.
    FramesError : growth not finite, lengths that do not fit, or an area beyond the largest number.
    SettingError : unknown law.
    """
    if law not in AREA_LAWS:
        raise SettingError("law", wanted=" or ".join(AREA_LAWS), found=repr(law), do="Choose one of these.")
    if not (np.isfinite(initial_area) and initial_area >= 0):
        raise NoContactError("initial area", wanted="0 or more", found=repr(initial_area), do="Find the contact first.")
    growth = np.asarray(growth, dtype=np.float64).reshape(-1)
    if not np.isfinite(growth).all():
        raise FramesError(
            f"growth, step {int(np.flatnonzero(~np.isfinite(growth))[0])}", wanted="a finite number",
            found="NaN or infinity", do="Drop or repair the frames of this step.",
        )  # fmt: skip
    exponent = np.append(0.0, np.cumsum(growth)) if law == "ode" else _paper_exponent(growth, force_n)
    return np.asarray(initial_area * _exp(exponent))


def _paper_exponent(growth: NDArray[np.float64], force_n: ArrayLike | None) -> NDArray[np.float64]:
    force = np.array([] if force_n is None else force_n, dtype=np.float64).reshape(-1)
    if force.size != growth.size + 1:
        raise FramesError(
            "force", wanted=f"one force for each of {growth.size + 1} frames, as law 'paper' multiplies by it",
            found=f"{force.size}", do="Give the force of every frame, or use law 'ode'.",
        )  # fmt: skip
    force[0] = 0.0
    return np.asarray(growth.sum() * force)


def _exp(exponent: NDArray[np.float64]) -> NDArray[np.float64]:
    with np.errstate(over="ignore"):
        factor = np.exp(exponent)
    if np.isinf(factor).any():
        frame = int(np.flatnonzero(np.isinf(factor))[0])
        raise FramesError(
            f"area, frame {frame}", wanted="a growth exponent below 709", found=f"{exponent[frame]:.3g}",
            do="Check divergence and force of the frames before; law 'ode' does not multiply by the force.",
        )  # fmt: skip
    return factor
