"""Kappa of the new specimen by the pins, of one angle and condition, as the calibration stage finds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.kappa import CAMERA, Trial, presses_of
from casr.camera import KEYS
from casr.dome.library import DIGESTS, SHIPPED, shipped, tables, worlds
from casr.errors import PassingError
from casr.kappa.estimate import estimate_kappa
from emg2vsa.calibration.by_pins import design_by_pins
from emg2vsa.calibration.online_pins import PinsEstimator
from emg2vsa.calibration.results import ConditionResult, DesignByPins
from emg2vsa.calibration.runs_calibration import calibrate_runs, online_calibrations
from emg2vsa.run_scores import RunScores
from emg2vsa.run_scores.domes import Domes
from emg2vsa.run_scores.product import PressPins
from emg2vsa.settings import CalibrationSettings

SEEN = {key: getattr(CAMERA, key) for key in KEYS} | {"sensor": CAMERA.sensor.known()}
KAPPA = {"S5": 1.11, "S3": 3.35, "S1": 7.63, "S_new": 5.32}
PRESSES = presses_of(Trial("H", 1.0, 0.05, 0.0, (1.11, 3.35, 7.63), 5.32, seed=3))
QUICK = CalibrationSettings(resamples=20)


@pytest.fixture(scope="module")
def runs(run_of: Callable[..., RunScores]) -> list[RunScores]:
    """With the pins of a simulated sensor; each specimen's last press has none."""
    found = []
    for name, kappa in KAPPA.items():
        pins = [
            PressPins(each.rest_px, each.pins_px.astype(np.float32), each.force_n, each.force_zero_sd_n)
            for each in PRESSES if each.specimen == f"{kappa:g}" and each.force_n is not None
        ]  # fmt: skip
        run = run_of(name, 0.0, "modular", len(pins) + 1)
        found.append(replace(run, pins=(*pins, None), camera=SEEN, mounting=np.ones(len(pins) + 1, dtype=np.int64)))
    return found


def calibrated(runs: list[RunScores], domes: dict[str, Domes] | None = None, **settings: float) -> ConditionResult:
    chosen = replace(QUICK, **settings)  # type: ignore[arg-type]
    pins = by_pins(runs, KAPPA, chosen, domes)
    (condition,) = calibrate_runs(runs, KAPPA, "S_new", chosen, by_pins=[pins]).conditions
    return condition


def by_pins(
    runs: list[RunScores],
    kappa: dict[str, float],
    settings: CalibrationSettings = QUICK,
    domes: dict[str, Domes] | None = None,
) -> DesignByPins:
    return design_by_pins(
        runs, kappa, "S_new", kappa_se={}, domes=domes or {}, confidence=settings.confidence,
        mounting_sd_percent=settings.mounting_sd_percent,
    )  # fmt: skip


def test_it_is_what_casr_tells_of_the_same_presses(runs: list[RunScores]) -> None:
    condition = calibrated(runs)
    pins = condition.pins
    assert pins is not None
    assert condition.no_pins == ""
    presses = [
        replace(
            each, specimen=name, mounting=name, stiffness_n_per_mm=None if name == "S_new" else kappa,
            rest_frames=1, pins_px=each.pins_px.astype(np.float32).astype(np.float64), travel_mm_per_n=float(mm_per_n),
        )
        for run, (name, kappa) in zip(runs, KAPPA.items(), strict=True)
        for each, mm_per_n in zip(
            [each for each in PRESSES if each.specimen == f"{kappa:g}"], 1 / run.indent_n_per_mm, strict=False
        )
    ]  # fmt: skip
    peer = estimate_kappa(presses, CAMERA, library=shipped()).kappas
    assert (pins.kappa, pins.low, pins.high) == pytest.approx(
        (peer["S_new"].value, peer["S_new"].low, peer["S_new"].high), rel=1e-9
    )
    assert pins.low < 5.32 < pins.high
    assert pins.error == pytest.approx(pins.kappa / 5.32 - 1)
    assert pins.left_out.tolist() == pytest.approx([peer[name].value for name in condition.specimens], rel=1e-9)
    assert set(pins.by_cue) >= {"pins", "travel"}
    assert condition.headline("front") is condition.pins


def test_confidence_and_scatter_of_mountings_are_those_of_the_study(runs: list[RunScores]) -> None:
    usual, sure, alike, apart = (
        calibrated(runs, **settings).pins
        for settings in ({}, {"confidence": 0.99}, {"mounting_sd_percent": 0.0}, {"mounting_sd_percent": 12.9})
    )
    assert usual
    assert sure
    assert alike
    assert apart
    assert sure.kappa == usual.kappa
    assert (sure.low / usual.kappa - 1, sure.high / usual.kappa - 1) == pytest.approx(
        [(1 + each) * 5.32 / usual.kappa - 1 for each in usual.error_interval(0.99)], rel=1e-9
    )
    assert sure.high - sure.low == pytest.approx(1.37 * (usual.high - usual.low), rel=0.05)
    widths = [(each.high - each.low) / each.kappa for each in (alike, usual, apart)]
    assert widths[0] < 0.9 * widths[1] < 0.5 * widths[2]


def test_the_calibration_file_takes_the_fit_of_the_study(runs: list[RunScores], monkeypatch) -> None:
    """What it holds are the known specimens' presses: a further press is told as where they were fitted alone."""
    alone = [run for run in runs if run.specimen != "S_new"]
    (fitted_again,) = online_calibrations(runs, KAPPA, "S_new", (0.5, 7.0), QUICK)
    found = calibrate_runs(runs, KAPPA, "S_new", QUICK, by_pins=[by_pins(runs, KAPPA)])
    monkeypatch.setattr("emg2vsa.calibration.runs_calibration.known_pins", lambda *_: pytest.fail("fitted again"))
    (online,) = online_calibrations(runs, KAPPA, "S_new", (0.5, 7.0), QUICK, found=found)
    assert online.pins is not None
    assert fitted_again.pins is not None
    assert [press.specimen for press in online.pins.sensor.presses] == [
        run.specimen for run in alone for pins in run.pins if pins is not None
    ]
    press = next(each for each in PRESSES if each.specimen == "5.32")
    press = replace(press, specimen="", mounting="new 1", stiffness_n_per_mm=None)
    told, again = (PinsEstimator(each.pins, shipped(), each.settings).judged(press) for each in (online, fitted_again))
    assert told.kappa == pytest.approx(again.kappa, rel=0.005)
    assert told.high - told.low == pytest.approx(again.high - again.low, rel=0.02)


def test_the_true_stiffness_of_the_new_specimen_enters_no_fit(runs: list[RunScores]) -> None:
    unknown = {name: kappa for name, kappa in KAPPA.items() if name != "S_new"}
    (condition,) = calibrate_runs(runs, unknown, "S_new", QUICK, by_pins=[by_pins(runs, unknown)]).conditions
    found = calibrated(runs).pins
    assert condition.pins is not None
    assert found is not None
    assert condition.pins.kappa == found.kappa
    assert np.isnan(condition.pins.error)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        (
            {"camera": {}},
            "S1_0_modular, camera.toml: expected one camera of all presses, as of S5_0_modular, but found none",
        ),
        ({"camera": SEEN | {"depth_mm": 55.0}}, "as of S5_0_modular, but found another"),
        ({"pins": ()}, "presses whose pins can be followed, but found none"),
    ],
)
def test_where_the_pins_tell_none_the_law_through_casr_counts(
    runs: list[RunScores], change: dict[str, object], why: str
) -> None:
    change = {"pins": (None,) * len(runs[0].pins)} if "pins" in change else change
    whose = "S_new" if "pins" in change else "S1"
    changed = [replace(run, **change) if run.specimen == whose else run for run in runs]  # type: ignore[arg-type]
    condition = calibrated(changed)
    assert condition.pins is None
    assert why in condition.no_pins
    assert condition.headline("front") is condition.algorithms["front"].chosen


def test_the_rate_of_frames_tells_no_cameras_apart(runs: list[RunScores]) -> None:
    changed = [replace(run, camera=SEEN | {"frame_rate_hz": 20.1}) if run.specimen == "S1" else run for run in runs]
    assert calibrated(changed).pins is not None


def test_specimens_of_several_heights_are_told(runs: list[RunScores]) -> None:
    condition = calibrated(runs, {run.specimen: Domes("own", 10.0 if run.specimen == "S1" else 25.0) for run in runs})
    assert "specimens of one height, but found 10 to 25 mm" in condition.no_pins


def test_thin_specimens_need_tables_of_their_height(runs: list[RunScores]) -> None:
    thin, usual = ({run.specimen: Domes(None, height) for run in runs} for height in (10.0, 24.0))
    assert "specimens of 25 mm, or tables of their height, but found 10 mm" in calibrated(runs, thin).no_pins
    assert calibrated(runs, usual).pins is not None


def test_a_thin_new_specimen_beside_others_of_no_stated_height_is_refused(runs: list[RunScores]) -> None:
    thin = {"S_new": Domes(None, 10.0)}
    assert "found 10 to 25 mm (25 mm where none is stated)" in calibrated(runs, thin).no_pins
    assert calibrated(runs, {"S_new": Domes(None, 24.0)}).pins is not None


def test_a_specimen_none_of_whose_pins_were_followed_is_as_one_that_nobody_pressed(runs: list[RunScores]) -> None:
    blind = [replace(run, pins=(None,) * len(run.pins)) if run.specimen == "S3" else run for run in runs]
    found, without = calibrated(blind).pins, calibrated([run for run in runs if run.specimen != "S3"]).pins
    assert found is not None
    assert without is not None
    assert (found.kappa, found.low, found.high) == (without.kappa, without.low, without.high)
    assert any("is left out: none of its presses has pins that can be followed" in note for note in found.notes)
    assert np.isnan(found.left_out).sum() == np.isnan(without.left_out).sum() + 1
    few = by_pins([replace(run, pins=()) if run.specimen in ("S3", "S1") else run for run in runs], KAPPA)
    assert few.pins is None
    assert few.no_pins.startswith("expected the new specimen and two known ones with scores, and with pins")


def test_damaged_tables_are_no_word_on_the_presses(runs: list[RunScores], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(DIGESTS, SHIPPED, "0" * 64)
    for cached in (shipped, tables, worlds):
        cached.cache_clear()
    try:
        with pytest.raises(PassingError, match=r"library\.npz: expected the tables that casr was made with"):
            by_pins(runs, KAPPA)
        with pytest.raises(PassingError):
            online_calibrations(runs, KAPPA, "S_new", (0.5, 7.0), QUICK)
    finally:
        for cached in (shipped, tables, worlds):
            cached.cache_clear()
