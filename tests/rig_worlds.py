"""Made scores of the rig with a known truth: designs by specimens, mounted and pressed a number of times."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable

DESIGNS = (
    *(("high-stiffness", angle) for angle in (0.0, 30.0, 45.0)),
    *(("modular", angle) for angle in (0.0, 30.0, 45.0)),
    *((f"constant-{level}", 0.0) for level in ("min", "mean", "max")),
)
STIFFNESS = {"S1": 7.63, "S_new": 5.32, "S3": 3.35, "S5": 1.11}
TRUE_LN = np.array([0.0, 0.077, 0.270, 0.554])
"Of CASR, by compliance in series with the sensor's."


def drawn(
    rng: np.random.Generator,
    truth: Floats,
    *,
    mountings: int = 3,
    presses: int = 3,
    mounting_sd: Floats | float = 0.043,
    press_sd: Floats | float = 0.021,
    t3: bool = False,
) -> Floats:
    """(D, S, M n) scores whose logarithms have the means ``truth`` (D, S)."""
    shape = (*truth.shape, mountings)
    normal = (lambda size: rng.standard_t(3, size) / 3**0.5) if t3 else rng.standard_normal
    between = np.broadcast_to(mounting_sd, truth.shape)[..., None] * normal(shape)
    within = np.broadcast_to(press_sd, truth.shape)[..., None, None] * normal((*shape, presses))
    return np.exp(truth[..., None, None] + between[..., None] + within).reshape(*truth.shape, -1)


def numbers(shape: Sequence[int], mountings: int, presses: int) -> np.ndarray:
    """(D, S, M n) numbers of the mountings."""
    return np.broadcast_to(np.repeat(np.arange(1, mountings + 1), presses), (*shape, mountings * presses)).copy()


def rig_table(
    rng: np.random.Generator,
    truth: Floats | None = None,
    area: Floats | None = None,
    *,
    designs: Sequence[tuple[str, float]] = DESIGNS,
    mountings: int = 3,
    presses: int = 3,
    order: np.ndarray | None = None,
    drift: float = 0.0,
    **scatter: Floats | float,
) -> RunTable:
    """An experiment. truth, area : (D, S) mean ln CASR and ln area, by default the same in all designs.

    order : of the mountings (D, S, M), random unless given. drift : of ln score from a mounting to the next.
    """
    shape, count = (len(designs), len(STIFFNESS)), {"mountings": mountings, "presses": presses}
    means = [
        np.broadcast_to(each, shape) for each in (TRUE_LN if truth is None else truth, 0.0 if area is None else area)
    ]
    if order is None:
        order = 1 + rng.permutation(np.prod(shape) * mountings).reshape(*shape, mountings)
    place = np.repeat(order, presses, axis=2).astype(np.float64)
    casr, areas = (drawn(rng, each, **count, **scatter) for each in means)  # type: ignore[arg-type]
    return RunTable(
        conditions=tuple(condition for condition, _ in designs), angles_deg=np.array([angle for _, angle in designs]),
        specimens=tuple(STIFFNESS), stiffness_n_per_mm=np.array([*STIFFNESS.values()]), new=1, algorithm="front",
        area_unit="mm2", position=place, casr={"front": casr * np.exp(drift * place)},
        start_area={"front": areas * np.exp(drift * place)}, mounting=numbers(shape, **count),
    )  # fmt: skip
