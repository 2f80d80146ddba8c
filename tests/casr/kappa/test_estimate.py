"""Kappa from presses of one sensor, the dome left out of the tables."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.kappa import CAMERA, Trial, library_without, presses_of
from casr.camera import Camera, Sensor
from casr.dome.library import shipped
from casr.dome.view import DomeView
from casr.errors import CameraError, CasrError, FramesError, PinsError, SettingError
from casr.kappa.discrepancy import Discrepancy
from casr.kappa.estimate import SensorKappa, estimate_kappa
from casr.kappa.family import families
from casr.kappa.field import OWN, SHARED, PressField, State, TableWorld
from casr.kappa.known import KnownSensor
from casr.kappa.posterior import CONTRADICTED, Posterior
from casr.kappa.presses import KappaPress

TRIAL = Trial("H", 1.0, 0.05, 0.0, (1.1, 3.35, 7.63), 5.32, seed=3)


@pytest.fixture(scope="module")
def presses() -> list[KappaPress]:
    return presses_of(TRIAL)


@pytest.fixture(scope="module")
def found(presses: list[KappaPress]) -> SensorKappa:
    return estimate_kappa(presses, CAMERA, library=library_without("H"))


def test_kappa_is_right_and_its_interval_narrow(found: SensorKappa) -> None:
    kappa = found.kappas["5.32"]
    assert kappa.value == pytest.approx(5.32, rel=0.06)
    assert kappa.low < 5.32 < kappa.high
    assert kappa.high / kappa.low < 1.3
    assert kappa.determined
    assert kappa.known is None
    assert found.noise_px == pytest.approx(0.05, rel=0.15)
    assert found.notes == ()


def test_known_specimens_are_told_by_the_others(found: SensorKappa) -> None:
    assert {name: found.kappas[name].known for name in ("1.1", "3.35", "7.63")} == {
        "1.1": 1.1,
        "3.35": 3.35,
        "7.63": 7.63,
    }
    assert found.kappas["3.35"].value == pytest.approx(3.35, rel=0.1)
    assert found.kappas["3.35"].value != pytest.approx(3.35, rel=1e-4)


def test_the_bound_is_below_what_is_reached(found: SensorKappa) -> None:
    kappa = found.kappas["5.32"]
    assert 0 < kappa.bound_sd < kappa.log_sd
    assert kappa.efficiency == pytest.approx(kappa.bound_sd / kappa.log_sd)


def test_a_wrong_stiffness_widens_the_interval(presses: list[KappaPress], found: SensorKappa) -> None:
    wrong = [replace(each, stiffness_n_per_mm=2.0) if each.specimen == "3.35" else each for each in presses]
    kappa = estimate_kappa(wrong, CAMERA, library=library_without("H")).kappas["5.32"]
    usual = found.kappas["5.32"]
    assert np.log(kappa.high / kappa.low) > 1.5 * np.log(usual.high / usual.low)
    assert kappa.low < 5.32 < kappa.high
    assert kappa.expected == pytest.approx(found.kappas["5.32"].expected, rel=0.2)


def test_what_contradicts_itself_is_told_and_not_called_determined(presses: list[KappaPress]) -> None:
    """Labels of two known specimens exchanged; one press of the unknown specimen that is another's."""
    other = {"1.1": 7.63, "7.63": 1.1}
    swapped = [replace(each, stiffness_n_per_mm=other.get(each.specimen, each.stiffness_n_per_mm)) for each in presses]
    soft = next(each for each in presses if each.specimen == "1.1")
    mixed = [*presses, replace(soft, specimen="5.32", stiffness_n_per_mm=None)]
    for pressed in (swapped, mixed):
        found = estimate_kappa(pressed, CAMERA, library=library_without("H"))
        kappa = found.kappas["5.32"]
        assert kappa.contradicted > CONTRADICTED
        assert not kappa.determined
        assert "contradict each other" in found.notes[0]
    stated = estimate_kappa(swapped, CAMERA, library=library_without("H")).notes
    assert any(note.startswith("1.1 is stated as 7.63 N/mm") for note in stated)
    usual = estimate_kappa(presses, CAMERA, library=library_without("H"))
    assert usual.kappas["5.32"].contradicted < 1.3


def test_a_camera_that_cannot_be_is_refused(presses: list[KappaPress]) -> None:
    with pytest.raises(CameraError, match="depth_mm"):
        estimate_kappa(presses, replace(CAMERA, depth_mm=500.0), library=library_without("H"))


def test_without_a_known_specimen_kappa_is_wide_but_holds(presses: list[KappaPress]) -> None:
    unknown = [replace(each, stiffness_n_per_mm=None) for each in presses if each.specimen == "5.32"]
    result = estimate_kappa(unknown, CAMERA, library=library_without("H"))
    kappa = result.kappas["5.32"]
    assert kappa.low < 5.32 < kappa.high
    assert kappa.value == pytest.approx(5.32, rel=0.4)
    assert any("0 specimen" in note for note in result.notes)


def _with_travel(presses: list[KappaPress], factor: float = 1.0) -> list[KappaPress]:
    """Of a dome of k_t 2 N/mm in series with the specimens; factor : of specimen 3.35."""
    series = {each.specimen: (1 / 2.0 + 1 / float(each.specimen)) ** (2 / 3) for each in presses}
    series["3.35"] *= factor
    return [replace(each, travel_mm_per_n=0.6 * series[each.specimen]) for each in presses]


def test_travel_is_a_cue_that_narrows_the_interval(presses: list[KappaPress], found: SensorKappa) -> None:
    travelled = [replace(each, mounting=f"{each.mounting}-{k % 2}") for k, each in enumerate(_with_travel(presses))]
    without = [replace(each, travel_mm_per_n=None) for each in travelled]
    joint, usual = (
        estimate_kappa(each, CAMERA, library=library_without("H")).kappas["5.32"] for each in (travelled, without)
    )
    value, sd = joint.by_cue["travel"]
    assert value == pytest.approx(5.32, rel=0.06)
    assert 0.03 < sd < 0.3
    assert joint.expected < usual.expected
    assert "travel" not in found.kappas["5.32"].by_cue


def test_travel_that_contradicts_the_specimens_counts_less(presses: list[KappaPress], found: SensorKappa) -> None:
    wrong = estimate_kappa(_with_travel(presses, 1.5), CAMERA, library=library_without("H")).kappas["5.32"]
    assert wrong.value == pytest.approx(found.kappas["5.32"].value, rel=0.05)
    assert wrong.low < 5.32 < wrong.high


def test_mountings_of_the_specimen_narrow_what_scatters_between_them(presses: list[KappaPress]) -> None:
    apart = [replace(each, mounting=f"{each.mounting}-{k % 2}") for k, each in enumerate(presses)]
    together, two = (
        estimate_kappa(each, CAMERA, library=library_without("H"), discrepancy=Discrepancy(stiffness=0.1)).kappas[
            "5.32"
        ]
        for each in (presses, apart)
    )
    assert two.expected < 0.85 * together.expected


def test_derivatives_are_those_of_the_motion(presses: list[KappaPress]) -> None:
    camera_view = estimate_view()
    field = PressField(presses[4], camera_view, families(shipped())[0])
    ((state, _),) = field.started([TableWorld.of(field.family, 0.3, 0.2)])
    state = State(state.shared, np.array([0.2, 0.4, 0.01, -0.02]), state.radius_mm + 0.1)
    field.seen = field.whitened(field.predicted(state))  # what is left over turns with the pulls that are left out
    residual, by = field.linearised(state)
    change = np.zeros(by.shape[1])
    change[[0, 1, 2, 3]] = 0.004, 0.01, 0.002, 0.1
    change[len(SHARED)], change[len(SHARED) + 2] = 0.004, 0.002
    change[len(SHARED) + len(OWN) :] = 0.01
    change *= 0.3
    values = np.concatenate([state.shared, state.own]) + change[: len(SHARED) + len(OWN)]
    moved = State(values[: len(SHARED)], values[len(SHARED) :], state.radius_mm + change[len(SHARED) + len(OWN) :])
    true = residual - field.left(moved)
    # motion bends at the nodes of the tables' arcs
    assert np.linalg.norm(by @ change - true) < 0.06 * np.linalg.norm(true)


def test_what_is_left_over_is_least_at_the_label_and_the_label_at_kappa(found: SensorKappa) -> None:
    labels = found.labels
    z = labels.z[-1] + np.linspace(-0.04, 0.04, 9)
    left_px = labels.fields[-1].left_over_px(labels.states[-1], z)
    assert np.argmin(left_px) == 4
    assert left_px[4] == pytest.approx(labels.misfit_px, rel=0.2)
    at = np.log(found.kappas["5.32"].value) + np.linspace(-0.2, 0.2, 81)
    shown = Posterior(KnownSensor.of(labels), found.discrepancy).label(at)
    assert abs(at[np.argmin(np.abs(shown - labels.z[-1]))] - at[40]) < 0.02


def estimate_view() -> DomeView:
    focal, pole = (CAMERA.fx_px, CAMERA.fy_px), (CAMERA.cx_px, CAMERA.cy_px)
    return DomeView(focal_px=focal, pole_px=pole, depth_mm=CAMERA.depth_mm, pin_length_mm=3.0)


def test_a_sensor_of_unknown_pin_length_says_so(presses: list[KappaPress]) -> None:
    camera = replace(CAMERA, sensor=Sensor(dome_radius_mm=20.0))
    assert any("pin_length_mm" in note for note in estimate_kappa(presses[-4:], camera).notes)


def test_errors_that_camera_toml_states_take_the_place_of_the_usual_ones(presses: list[KappaPress]) -> None:
    usual, sharp = (
        estimate_kappa(presses[-2:], camera).labels
        for camera in (
            CAMERA,
            replace(CAMERA, depth_sd_mm=1e-3, sensor=replace(CAMERA.sensor, pin_length_sd_mm=1e-3)),
        )
    )
    sds = [np.sqrt(np.diag(np.linalg.inv(each.precision)))[1:3] for each in (usual, sharp)]
    assert (sds[1] <= [1e-3, 2e-5]).all()
    assert (sds[0] > 10 * sds[1]).all()


@pytest.mark.parametrize(
    ("change", "error", "words"),
    [
        ({"pins_px": np.zeros((8, 3, 2))}, PinsError, "the same pins"),
        ({"pins_px": np.zeros((3, 127, 2)), "force_n": None}, FramesError, "5 loaded frames"),
        ({"force_n": np.ones(7)}, FramesError, "force_n"),
        ({"force_n": np.full(40, np.nan)}, FramesError, "force_n"),
        ({"stiffness_n_per_mm": -1.0}, SettingError, "stiffness_n_per_mm"),
        ({"stiffness_n_per_mm": float("nan")}, SettingError, "stiffness_n_per_mm"),
        ({"travel_mm_per_n": 300.0}, SettingError, "travel_mm.*less than 50 mm/N"),
        ({"travel_mm_per_n": float("nan")}, SettingError, "travel_mm"),
    ],
)  # fmt: skip
def test_a_bad_press_is_refused(
    presses: list[KappaPress], change: dict[str, object], error: type[CasrError], words: str
) -> None:
    with pytest.raises(error, match=words):
        replace(presses[0], **change)  # type: ignore[arg-type]


def test_lost_pins_are_left_out_and_too_many_are_refused(presses: list[KappaPress]) -> None:
    lost = presses[0].pins_px.copy()
    lost[3:, :90] = np.nan
    few = replace(presses[0], pins_px=lost)
    assert PressField(few, estimate_view(), families(shipped())[0]).n_pins == 37
    lost[3:, :110] = np.nan
    with pytest.raises(PinsError, match="30 pins"):
        PressField(replace(presses[0], pins_px=lost), estimate_view(), families(shipped())[0])


def test_two_stiffnesses_of_one_specimen_are_refused(presses: list[KappaPress]) -> None:
    with pytest.raises(SettingError, match=r"1\.1 and 2"):
        estimate_kappa([presses[0], replace(presses[1], stiffness_n_per_mm=2.0)], CAMERA)


def test_no_press_and_a_camera_inside_the_dome_are_refused(presses: list[KappaPress]) -> None:
    with pytest.raises(SettingError, match="one press"):
        estimate_kappa([], CAMERA)
    with pytest.raises(CameraError, match="depth_mm"):
        estimate_kappa(presses, Camera(depth_mm=10.0, sensor=CAMERA.sensor))
