"""A sensor that its presses have told once, and presses that join it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.kappa import CAMERA, Trial, library_without, presses_of
from casr.kappa.estimate import estimate_kappa, fitted, press_fields, stated_errors
from casr.kappa.family import families
from casr.kappa.field import PressField
from casr.kappa.known import KnownSensor
from casr.kappa.posterior import Posterior
from casr.kappa.presses import KappaPress

TRIAL = Trial("H", 1.0, 0.05, 0.0, (1.1, 3.35, 7.63), 5.32, seed=3)
NEW = "5.32"
ALL = presses_of(TRIAL)
LIBRARY = library_without("H")


@pytest.fixture(scope="module")
def sensor() -> KnownSensor:
    return KnownSensor.of(fitted(ALL[:-2], CAMERA, families(LIBRARY), stated_errors(CAMERA)))


def fields_of(presses: list[KappaPress]) -> list[PressField]:
    return press_fields(presses, CAMERA, families(LIBRARY)[0])


def log_kappa(sensor: KnownSensor) -> tuple[float, float]:
    posterior = Posterior(sensor, sensor.discrepancy)
    value, sd = posterior.log_kappa(NEW)
    return value, posterior.widened * sd


def joined(sensor: KnownSensor, presses: list[KappaPress]) -> KnownSensor:
    return sensor.joined_by(sensor.labelled(fields_of(presses)))


@pytest.mark.parametrize("apart", [False, True])
def test_presses_that_join_say_what_all_together_say(sensor: KnownSensor, apart: bool) -> None:
    new = [replace(press, mounting=f"new {k * apart}") for k, press in enumerate(ALL[-2:])]
    together = estimate_kappa([*ALL[:-2], *new], CAMERA, library=LIBRARY).kappas[NEW]
    value, sd = log_kappa(joined(sensor, new))
    assert value == pytest.approx(np.log(together.value), abs=0.05 * together.log_sd)
    assert sd == pytest.approx(together.log_sd, rel=0.02)
    one_by_one = log_kappa(joined(joined(sensor, new[:1]), new[1:]))
    assert one_by_one[0] == pytest.approx(value, abs=0.05 * sd)
    assert one_by_one[1] == pytest.approx(sd, rel=0.02)


def test_a_press_that_goes_on_is_told_as_well_as_from_its_end(sensor: KnownSensor) -> None:
    press, labels = ALL[-1], None
    assert press.force_n is not None
    for count in range(6, press.pins_px.shape[0] + 1, 3):
        part = replace(press, pins_px=press.pins_px[:count], force_n=press.force_n[:count])
        labels = sensor.labelled(fields_of([part]), labels)
    assert labels is not None
    value, sd = log_kappa(sensor.joined_by(labels))
    whole, _ = log_kappa(joined(sensor, [press]))
    assert value == pytest.approx(whole, abs=0.3 * sd)
    assert sensor.labelled(fields_of([part]), labels) is labels


def test_what_is_expected_of_presses_is_what_they_reach(sensor: KnownSensor) -> None:
    posterior = Posterior(sensor, sensor.discrepancy)
    for presses in (1, 2):
        (expected,) = posterior.expected_log_sd(np.array([5.32]), presses, 1)
        assert expected == pytest.approx(log_kappa(joined(sensor, ALL[-2:][:presses]))[1], rel=0.03)
    one, two, apart = (posterior.expected_log_sd(np.array([5.32]), *each)[0] for each in ((1, 1), (2, 1), (2, 2)))
    assert apart < two < one


def test_an_exact_label_narrows_and_moves_nothing(sensor: KnownSensor) -> None:
    one = joined(sensor, ALL[-1:])
    covariance, z = np.linalg.inv(one.precision), one.z_at[-1]
    covariance[z, z] += 0.02**2
    poor = replace(one, precision=np.linalg.inv(covariance))
    value, sd = log_kappa(poor.exact(-1))
    assert sd < 0.8 * log_kappa(poor)[1]
    assert (value, sd) == pytest.approx(log_kappa(one), rel=0.03)
