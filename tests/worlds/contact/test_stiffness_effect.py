"""What stiffness can do: by creep, by sums over frames, by errors of timing."""

from __future__ import annotations

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from casr.spread import fit_power_laws
from emg2vsa.devices.qbmove.springs import RAD_PER_TICK, SPRINGS
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.errors import DataError
from emg2vsa.stiffness_effect import StiffnessEffect, replicates_needed
from emg2vsa.worlds.contact import ELASTIC, Drive, StiffnessSteps, simulate_presses
from emg2vsa.worlds.contact.stiffness_effect import (
    Bench,
    FrameErrors,
    frames_of,
    materials_of,
    stiffness_effect,
)

NAMES = ("S1", "S2", "S5")
EDGES = np.array([0.5, 1.4, 2.9, 4.4, 7.0])
HUMAN_LIKE = {"S1": (48, 63, 71, 77), "S2": (43, 56, 62, 67), "S5": (25, 30, 33, 35)}
RELAXING = {"S1": 0.03, "S2": 0.04, "S5": 0.12}
TIMING = FrameErrors(area_share=0.01, force_n=0.01, latency_sd_s=0.005, jitter_s=0.005)


def law(name: str) -> PowerLaw:
    return PowerLaw(1 / (1 / 0.4 + 10 / SPECIMENS[name]))


def bench(names: tuple[str, ...] = NAMES) -> Bench:
    return Bench(
        stiffness_mpa={name: SPECIMENS[name] / 10 for name in names},
        sensor_mpa=0.4,
        tip_radius_mm=20.0,
        exponent=0.25,
        area_mm2=lambda name, force: law(name).area_mm2(force),
        drive=Drive(springs=SPRINGS["qbmove-maker-pro"]),
        steps={
            "modular": {
                name: StiffnessSteps(EDGES, 30.0 * RAD_PER_TICK * np.array(HUMAN_LIKE[name])) for name in HUMAN_LIKE
            },
            "all-20": dict.fromkeys(NAMES, StiffnessSteps.constant(600.0 * RAD_PER_TICK)),
        },
        window_n=(0.5, 7.0),
        rate_hz=20.0,
    )


@pytest.fixture(scope="module")
def effect() -> StiffnessEffect:
    return stiffness_effect(bench(), materials_of(0.15, RELAXING), TIMING, "high-stiffness")


def test_of_elastic_bodies_no_condition_changes_the_contrast(effect: StiffnessEffect) -> None:
    assert effect.conditions == ("high-stiffness", "modular", "all-20")
    elastic = effect.contrast(effect.rate)[0]
    assert elastic == pytest.approx(np.full(3, 0.5527), abs=5e-5)
    assert np.ptp(elastic) < 2e-5  # areas lie on straight lines between steps of 2.5 ms
    assert effect.rate_swapped == pytest.approx(effect.rate[0], rel=1e-5)


def test_creep_changes_it_by_less_than_two_percent(effect: StiffnessEffect) -> None:
    gains = effect.contrast(effect.rate) - effect.contrast(effect.rate)[:, :1]
    assert gains[1] == pytest.approx([0, 0.004, -0.004], abs=0.001)
    assert gains[2] == pytest.approx([0, 0.005, -0.017], abs=0.0015)


def test_a_sum_over_frames_follows_the_schedule(effect: StiffnessEffect) -> None:
    rigid, modular, softest = effect.contrast(effect.frame_sum)
    assert modular > rigid + 0.1 > softest + 0.3
    own, swapped = (effect.contrast(each, 1)[1] for each in (effect.frame_sum, effect.frame_sum_swapped))
    # three specimens: S2 keeps its own schedule, and S1 gets that of S5
    assert own > 0.2
    assert swapped < -0.1
    assert effect.frame_sum_swapped[1] == pytest.approx(effect.frame_sum[1], rel=1e-12)
    assert effect.frame_sum_swapped[:, [0, 2]] == pytest.approx(effect.frame_sum[:, [0, 2]], rel=1e-12)


def test_against_errors_of_timing_the_softest_wins(effect: StiffnessEffect) -> None:
    rigid, modular, softest = effect.timing_d
    assert softest > modular > rigid > 1
    assert effect.timing_cv[:, 2].max() < effect.timing_cv[:, 0].min()


def test_what_it_takes_to_see_a_change() -> None:
    assert replicates_needed(np.array([0.004]), 0.03) == pytest.approx([1766], abs=1)
    assert np.isinf(replicates_needed(np.array([0.0]), 0.03)).all()


def test_the_creep_that_the_claim_would_need(effect: StiffnessEffect) -> None:
    longer = np.log(effect.duration_s[-1, 1] / effect.duration_s[-1, 0])
    share = 4 / (4 + SPECIMENS["S5"])
    assert effect.creep_exponent(0.2, 1) == pytest.approx(np.log(1.2) / (0.5 * share * longer))
    assert effect.creep_exponent(0.2, 0) == np.inf


def test_fewer_than_two_specimens_or_a_lacking_schedule_are_refused() -> None:
    materials = materials_of(0.15, RELAXING)
    with pytest.raises(DataError, match=r"effect of stiffness: expected two specimens or more, .* found 1 specimens"):
        stiffness_effect(bench(("S1",)), materials, TIMING, "high-stiffness")
    with pytest.raises(DataError, match="found 2 specimens, none for S3, modular"):
        stiffness_effect(bench(("S1", "S3")), materials, TIMING, "high-stiffness")


ONE_LAW = PowerLaw(0.2624)
ONE_PRESS = simulate_presses([ONE_LAW], ELASTIC, Drive())


def frames_with(errors: FrameErrors, count: int = 200) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(4)
    return frames_of(ONE_PRESS, 0, rng.uniform(0, 0.05, count), errors, rng)


def test_frames_without_errors_lie_on_the_press() -> None:
    force, area = frames_with(FrameErrors())
    seen = np.isfinite(force)
    assert np.array_equal(seen, np.isfinite(area))
    assert force[seen].min() >= 0.5
    assert force[seen].max() <= 7.0
    assert seen.sum(axis=1).mean() == pytest.approx(20 * float(ONE_PRESS.duration_s()[0]), rel=0.02)
    assert area[seen] == pytest.approx(ONE_LAW.area_mm2(force[seen]), rel=1e-4)
    assert fit_power_laws(area, force).mean_rates(0.5, 7.0) == pytest.approx(
        (ONE_LAW.area_mm2(7.0) - ONE_LAW.area_mm2(0.5)) / 6.5, rel=1e-4
    )


def test_a_delay_shows_an_earlier_contact_of_one_press_and_jitter_that_of_a_frame() -> None:
    clean, _ = frames_with(FrameErrors())
    late = {}
    for name in ("latency_sd_s", "jitter_s"):
        force, area = frames_with(FrameErrors(**{name: 0.005}))
        assert np.array_equal(force, clean, equal_nan=True)
        shown_s = np.interp(area, ONE_LAW.area_mm2(ONE_PRESS.force_n[:-1, 0]), ONE_PRESS.time_s[:-1])
        late[name] = np.interp(force, ONE_PRESS.force_n[:-1, 0], ONE_PRESS.time_s[:-1]) - shown_s
    assert np.nanstd(late["latency_sd_s"]) == pytest.approx(0.005, rel=0.15)
    assert np.nanmedian(np.nanstd(late["latency_sd_s"], axis=1)) < 1e-6
    assert np.nanmean(np.nanstd(late["jitter_s"], axis=1)) == pytest.approx(0.005, rel=0.15)
