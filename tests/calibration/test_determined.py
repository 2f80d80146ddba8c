"""Whether kappa is determined follows from the design, so that no interval is called so because it came out narrow."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.unknown import Estimate, estimate

EXPERIMENTS = 4000
KNOWN = np.array([7.63, 3.35, 1.11])


def front(kappa):
    """CASR of the demo's front: 1 % of it is 9 % of the kappa of S2."""
    return ((1 / kappa + 0.917) / 0.002112) ** (2 / 3)


def experiments(
    new: float,
    mountings: int,
    presses: int,
    mounting: float,
    assumed: float,
    *,
    press: float = 0.021,
    correlation: float = 0.0,
    curve=front,
    d: int = EXPERIMENTS,
    known: float | None = None,
) -> Estimate:
    rng = np.random.default_rng(7)
    noise = rng.standard_normal((d, 4, mountings, presses))
    for i in range(1, presses):
        noise[..., i] = correlation * noise[..., i - 1] + np.sqrt(1 - correlation**2) * noise[..., i]
    logs = press * noise + mounting * rng.standard_normal((d, 4, mountings, 1))
    scores = (curve(np.append(KNOWN, new))[:, None, None] * np.exp(logs)).reshape(d, 4, -1)
    labels = np.repeat(np.arange(1, mountings + 1), presses)
    calibration = calibrate(KNOWN, scores[:, :3], casr_unit="u", mounting_sd=assumed, mountings=np.tile(labels, (3, 1)))
    return estimate(calibration, scores[:, 3], labels, known=new if known is None else known, bootstrap=False)


def held(found: Estimate, new: float, which: np.ndarray) -> float:
    return float(np.mean((found.low <= new)[which] & (new <= found.high)[which]))


@pytest.mark.parametrize(
    ("new", "mountings", "presses", "mounting", "assumed", "correlation"),
    [(5.32, 1, 10, 0.0, 0.0, 0.0), (2.0, 1, 10, 0.043, 0.043, 0.0), (5.32, 3, 3, 0.043, 0.043, 0.0),
     (2.0, 3, 3, 0.043, 0.043, 0.0), (2.0, 1, 10, 0.043, 0.043, 0.7), (5.32, 1, 10, 0.0, 0.0, 0.7)],
)  # fmt: skip
def test_intervals_that_are_called_determined_hold_kappa_as_often_as_all(
    new, mountings, presses, mounting, assumed, correlation
):
    found = experiments(new, mountings, presses, mounting, assumed, correlation=correlation)
    determined = found.determined
    assert np.count_nonzero(determined) > 200
    assert 0.915 < held(found, new, determined) < 0.985
