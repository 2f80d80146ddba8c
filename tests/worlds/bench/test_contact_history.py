"""The emulated contact, stepped as plain numbers, beside the bodies that it stands for."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa.errors import SettingError
from emg2vsa.worlds.bench.contact_history import ContactHistory
from emg2vsa.worlds.contact import ELASTIC, ConvolvedForce, Relaxation, Shear, in_series

SOFT = in_series([(0.4, Relaxation.of_share(0.3)), (0.6, Relaxation.of_share(0.1))])
SKIN = {"friction": 0.6, "friction_drop": 0.05, "mount_n_per_mm": 30.0}


@pytest.mark.parametrize("body", [SOFT, ELASTIC])
def test_it_is_the_convolved_force_and_the_shear_to_the_last_bit(body: Relaxation) -> None:
    """Over steps that stick, slip, let go and begin anew, looked at several times before they are taken."""
    history, normal, shear = ContactHistory(body, **SKIN), ConvolvedForce(body, 0.0), Shear(body, 0.0, **SKIN)
    rng, seen = np.random.default_rng(3), {"stuck": 0, "slid": 0, "apart": 0}
    elastic_n = 0.0
    for k in range(600):
        step_s = float(rng.choice([0.001, 0.0009999999999998899, 0.03]))
        elastic_n = max(0.0, elastic_n + float(rng.normal(0.05 if k % 150 < 100 else -0.2, 0.05)))
        slope, way_mm = 1 + elastic_n, float(rng.normal(0.002 * (k % 60), 0.01))
        history.begin(step_s)
        for asked_n in (elastic_n + 0.1, elastic_n):
            alpha, beta = normal.alpha_beta(step_s)
            normal_n = (asked_n - alpha) / beta
            wanted = (0.0, 0.0) if normal_n <= 0 else (normal_n, shear.after(step_s, way_mm, slope, normal_n))
            assert history.forces(asked_n, slope, way_mm) == wanted
        normal_n = max(0.0, normal_n)
        shear_n = shear.advance(step_s, way_mm, slope, normal_n)
        normal.advance(step_s, normal_n)
        assert history.advance(elastic_n, slope, way_mm) == (normal_n, shear_n)
        assert history.way_mm == shear.way_mm
        seen["apart" if normal_n == 0 else "stuck" if abs(shear_n) < 0.5 * normal_n - 1e-12 else "slid"] += 1
        if k % 150 == 149:
            elastic_n = 0.0
            for each in (history, normal, shear):
                each.reset()
    assert min(seen.values()) > 10, seen


@pytest.mark.parametrize("wrong", [{"friction": 0.05}, {"friction": -1.0}, {"mount_n_per_mm": 0.0}])
def test_a_skin_that_cannot_be_is_refused(wrong: dict[str, float]) -> None:
    with pytest.raises(SettingError, match="Correct the"):
        ContactHistory(SOFT, **(SKIN | wrong))
