"""The front by the library: against the truth of a dome that it does not hold, and what it says where it cannot."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from benchmarks.tactile.world_scores import without
from casr.camera import Camera, Sensor
from casr.contact_area import follow
from casr.contact_area.follow import contact_front
from casr.contact_area.front import PARTS, ContactFront
from casr.contact_area.front_fit import HeldFit
from casr.contact_area.library_front import FREE_MISFIT, HeldFront, found_fits, length_errors, library_front
from casr.dome.library import SHIPPED, Library, worlds
from casr.errors import CameraError, PinsError
from casr.front_spread import FORCE_ZERO_SD_N, front_doubt, front_spread
from casr.scoring import score
from emg2vsa.worlds.tactile import (
    TACTIP_127,
    ContactWorld,
    PressSettings,
    Scene,
    TabulatedWorld,
    TimelineSettings,
    World,
    simulate_press,
)

Array = NDArray[np.float64]

NOISE_PX = 0.07
ROOT_PITCH_MM = 20 / 6 * 19 / 16
"Of the roots of pins of 3 mm on a sphere of 19 mm, whose tips are 20 px apart at 6 px/mm."
CAMERA = PressSettings().camera
OF_RATE = (
    "scatter", "dome", "misfit", "pin length", "depth", "beyond the tables", "beyond the frames", "narrow window",
    "force zero",
)  # fmt: skip


@dataclass(frozen=True, eq=False)
class Pressed:
    """Pins of T frames of loading with noise, and what is true."""

    rest_px: Array
    pins_px: Array
    force_n: Array
    area_mm2: Array
    skin_log_growth: Array
    casr: float

    @property
    def wide(self) -> NDArray[np.bool_]:
        return np.asarray(self.area_mm2 >= np.pi * (2 * ROOT_PITCH_MM) ** 2)


@cache
def pressed(
    world: World, kappa: float = 3.35, angle_deg: float = 0.0, seed: int = 0, off_px: tuple[float, float] = (0.0, 0.0)
) -> Pressed:
    skin = replace(TACTIP_127, off_px=off_px, mask_radius_px=149.0)
    press = simulate_press(
        PressSettings(world=world, stiffness_n_per_mm=kappa, angle_deg=angle_deg, seed=seed, skin=skin)
    )
    truth, rng = press.truth, np.random.default_rng(seed)
    force = truth.force_n[truth.loading_frames]
    pins = np.array([press.scene.pins_px(each) for each in force.tolist()])
    rest = press.scene.rest_px
    return Pressed(
        rest + NOISE_PX / 4 * rng.standard_normal(rest.shape),
        pins + NOISE_PX * rng.standard_normal(pins.shape),
        force,
        truth.area_mm2[truth.loading_frames],
        truth.skin_log_growth,
        truth.casr_power_mm2_per_n,
    )


def front_of(press: Pressed, camera: Camera | None = CAMERA, library: Library | None = None) -> ContactFront:
    return contact_front(press.rest_px, press.pins_px, camera, library or worlds())


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("kappa", "angle_deg"), [(1.11, 0.0), (3.35, 30.0), (5.32, 45.0), (7.63, 0.0)])
def test_areas_of_a_dome_that_is_not_in_the_library(kappa: float, angle_deg: float, seed: int) -> None:
    press = pressed(TabulatedWorld(), kappa, angle_deg, seed)
    front = front_of(press)
    np.testing.assert_allclose(front.area[press.wide], press.area_mm2[press.wide], rtol=0.08)
    assert front.determined[press.wide].all()
    away = np.log(front.area / press.area_mm2)[press.wide] / front.relative_sd[press.wide]
    assert np.abs(away).max() < 2
    assert front.misfit < 0.04
    assert front.model == "finite elements"


@pytest.mark.parametrize("dome", ["J", "D", "E"])
def test_a_dome_left_out_of_the_library(dome: str) -> None:
    press = pressed(TabulatedWorld(dome=dome, tables=SHIPPED), 3.35)
    front = front_of(press, library=without(dome))
    np.testing.assert_allclose(front.area[press.wide], press.area_mm2[press.wide], rtol=0.08)
    assert dome not in front.log_misfit
    with_it = front_of(press)
    assert with_it.misfit < front.misfit
    assert with_it.dome == dome


@pytest.mark.parametrize(("off_px", "angle_deg"), [((3.0, -2.0), 0.0), ((-14.0, 11.0), 0.0), ((10.0, 6.0), 30.0)])
def test_pins_that_do_not_stand_about_the_axis_of_their_dome(off_px: tuple[float, float], angle_deg: float) -> None:
    press = pressed(TabulatedWorld(), 3.35, angle_deg, off_px=off_px)
    front = front_of(press)
    np.testing.assert_allclose(front.area[press.wide], press.area_mm2[press.wide], rtol=0.08)
    assert front.misfit < 0.025
    assert not any("axis of the dome" in note for note in front.notes)


@pytest.mark.parametrize("angle_deg", [0.0, 45.0])
@pytest.mark.parametrize("kappa", [1.11, 7.63])
def test_a_wrong_principal_point_is_told_and_not_followed(kappa: float, angle_deg: float) -> None:
    press = pressed(TabulatedWorld(), kappa, angle_deg)
    wrong = replace(CAMERA, cx_px=CAMERA.cx_px - 16, cy_px=CAMERA.cy_px + 12)
    told, right = front_of(press, wrong), front_of(press)
    np.testing.assert_allclose(told.area[press.wide], right.area[press.wide], rtol=0.03)
    assert told.misfit < 1.2 * right.misfit
    (note,) = [note for note in told.notes if "axis of the dome" in note]
    assert "not at cx_px and cy_px of camera.toml, (134, 162)" in note
    near = replace(CAMERA, cx_px=CAMERA.cx_px + 4)
    assert not any("axis of the dome" in note for note in front_of(press, near).notes)


def test_a_press_that_goes_on_finds_the_pole_when_it_has_more_frames() -> None:
    press = pressed(TabulatedWorld())
    wrong = replace(CAMERA, cx_px=CAMERA.cx_px + 20)
    so_far = follow.FrontSoFar(wrong, worlds())
    for n in (2, 8, len(press.pins_px)):
        front = so_far.of(press.rest_px, press.pins_px[:n])
    np.testing.assert_allclose(front.area[press.wide], front_of(press).area[press.wide], rtol=0.02)


@pytest.mark.parametrize("length_mm", [1.5, 4.5])
def test_a_wrong_length_of_pins_does_not_make_the_analytic_field_right(length_mm: float) -> None:
    camera = replace(CAMERA, sensor=Sensor(pin_length_mm=length_mm, dome_radius_mm=20.0))
    front = front_of(pressed(TabulatedWorld(), 1.11), camera)
    assert front.misfit > 0.06
    assert front.model == "finite elements"


def test_a_labs_own_dome_explains_its_presses(lab: Path) -> None:
    press = pressed(TabulatedWorld(), 5.32)
    ours, theirs = front_of(press), front_of(press, library=worlds(lab))
    assert theirs.dome == "mine"
    assert theirs.misfit < ours.misfit
    np.testing.assert_allclose(theirs.area[press.wide], press.area_mm2[press.wide], rtol=0.04)


def test_lost_pins_change_little() -> None:
    press = pressed(TabulatedWorld())
    pins, rng = press.pins_px.copy(), np.random.default_rng(5)
    pins[:, rng.permutation(127)[:15]] = np.nan
    pins[rng.random(pins.shape[:2]) < 0.1] = np.nan
    front, whole = contact_front(press.rest_px, pins, CAMERA, worlds()), front_of(press)
    np.testing.assert_allclose(front.area[press.wide], whole.area[press.wide], rtol=0.02)
    assert np.isfinite(front.edge_px).all()


def test_lens_distortion_is_taken_out() -> None:
    press = pressed(TabulatedWorld())
    bent = replace(CAMERA, distortion=(-0.25, 0.08, 0.0, 0.0))
    grid = press.pins_px.reshape(-1, 2)
    seen = replace(press, rest_px=_bent(press.rest_px, bent), pins_px=_bent(grid, bent).reshape(press.pins_px.shape))
    assert np.abs(seen.rest_px - press.rest_px).max() > 1
    straight, flat, ignored = front_of(press), front_of(seen, bent), front_of(seen)
    np.testing.assert_allclose(flat.area, straight.area, rtol=2e-3)
    assert np.abs(np.log(ignored.area / straight.area)[press.wide]).max() > 0.01


def _bent(points_px: Array, camera: Camera) -> Array:
    """By the model of OpenCV: a radius r of the normalised image becomes r (1 + k1 r^2 + k2 r^4)."""
    centre, focal = np.array([camera.cx_px, camera.cy_px]), np.array([camera.fx_px, camera.fy_px])
    flat = (points_px - centre) / focal
    far = (flat**2).sum(axis=-1, keepdims=True)
    k1, k2 = camera.distortion[:2]
    return np.asarray(flat * (1 + k1 * far + k2 * far**2) * focal + centre)


@pytest.mark.parametrize(("pins", "frames"), [(6, 20), (127, 1)])
def test_too_few_pins_or_frames_are_refused(pins: int, frames: int) -> None:
    press = pressed(TabulatedWorld())
    with pytest.raises(PinsError, match="7 pins in every frame, and 2 frames") as refused:
        contact_front(press.rest_px[:pins], press.pins_px[:frames, :pins], CAMERA, worlds())
    assert refused.value.found == f"{pins} pins, {frames} frames"


def test_without_the_length_of_pins_it_is_said_and_the_interval_is_wider() -> None:
    press = pressed(TabulatedWorld())
    known, unknown = front_of(press), front_of(press, replace(CAMERA, sensor=Sensor()))
    assert any(note.startswith("Pin length is not known") for note in unknown.notes)
    assert not any(note.startswith("Pin length") for note in known.notes)
    assert (unknown.parts["dome"] > known.parts["dome"])[press.wide].all()
    away = np.log(unknown.area / press.area_mm2)[press.wide] / unknown.relative_sd[press.wide]
    assert np.abs(away).max() < 2


@pytest.mark.parametrize(
    ("part", "other"),
    [
        ("pin length", replace(CAMERA, sensor=Sensor(pin_length_mm=3.1, dome_radius_mm=20.0))),
        ("depth", replace(CAMERA, depth_mm=1.01 * CAMERA.depth_mm)),
    ],
)
def test_a_camera_that_is_not_as_told_moves_the_area_by_what_its_part_says(part: str, other: Camera) -> None:
    """Beside what another world explains then, which is the dome's part."""
    press = pressed(TabulatedWorld())
    told = front_of(press)
    moved = np.log(front_of(press, other).area / told.area)[press.wide]
    assert moved.min() > 0.015
    beside = np.abs(moved - told.parts[part][press.wide]) / told.parts["dome"][press.wide]
    assert beside.max() < 0.5


def test_errors_that_the_camera_file_states_are_those_of_its_parts() -> None:
    press = pressed(TabulatedWorld())
    sensor = replace(CAMERA.sensor, pin_length_sd_mm=0.025)
    usual, stated = front_of(press), front_of(press, replace(CAMERA, depth_sd_mm=0.02 * CAMERA.depth_mm, sensor=sensor))
    np.testing.assert_array_equal(stated.area, usual.area)
    for part, times in (("depth", 2), ("pin length", 1 / 4)):
        np.testing.assert_allclose(stated.parts[part][press.wide], times * usual.parts[part][press.wide], rtol=0.1)
    sensor = replace(sensor, pin_length_mm=None)
    np.testing.assert_array_equal(length_errors(replace(CAMERA, sensor=sensor)), length_errors(None))


def test_without_a_camera_areas_are_in_pixels_and_it_is_said() -> None:
    press = pressed(TabulatedWorld())
    front = front_of(press, None)
    assert any(note.startswith("No camera.toml") for note in front.notes)
    known = front_of(press)
    growth = [np.log(each.area[-1] / each.area[press.wide][0]) for each in (front, known)]
    assert growth[0] == pytest.approx(growth[1], abs=0.15)
    assert (front.relative_sd > known.relative_sd)[press.wide].all()


def test_a_wrong_dome_raises_the_misfit_and_the_error() -> None:
    press = pressed(TabulatedWorld(dome="C", tables=SHIPPED), 1.11)
    far = _only(("I", "G"))
    wrong, right = (library_front(press.rest_px, press.pins_px, CAMERA, library) for library in (far, worlds()))
    assert right.misfit < FREE_MISFIT < wrong.misfit
    assert not right.parts["misfit"].any()
    assert (wrong.relative_sd > 2 * right.relative_sd).all()


def _only(domes: tuple[str, ...]) -> Library:
    library = worlds()
    kept = np.isin(library.dome, domes)
    arrays = ("dome", "stiffness_n_per_mm", "friction", "computed_mm", "force_n", "edge_arc_mm", "motion")
    return replace(library, **{name: getattr(library, name)[kept] for name in arrays})


def test_skin_that_stretches_is_told_by_the_analytic_field() -> None:
    press = pressed(ContactWorld(), 1.11)
    front = front_of(press)
    assert front.model == "analytic"
    np.testing.assert_allclose(front.area[press.wide], press.area_mm2[press.wide], rtol=0.08)
    assert any("flattened and stretched evenly" in note for note in front.notes)


def test_the_rate_has_a_total_interval_and_its_parts() -> None:
    press = pressed(TabulatedWorld(), 5.32)
    front = front_of(press)
    assert front_doubt(front, press.pins_px, CAMERA) == ""
    assert tuple(front.parts) == PARTS
    spread = front_spread(front, press.skin_log_growth, press.force_n, 0.001)
    assert tuple(spread.interval.parts) == OF_RATE
    assert spread.interval.left_out
    assert spread.interval.low < press.casr < spread.interval.high
    assert spread.rate.value == pytest.approx(press.casr, rel=0.06)
    low, high = spread.interval.low, spread.interval.high
    assert np.sqrt(low * high) == pytest.approx(spread.rate.value, rel=1e-9)
    total = np.sqrt(sum(part**2 for part in spread.interval.parts.values()))
    assert np.log(high / low) / 2 == pytest.approx(1.96 * total, rel=1e-3)
    assert spread.first_n == press.force_n[spread.first]
    assert front.pitches[spread.first] >= 1.5 > (front.pitches[spread.first - 1] if spread.first else 0.0)


def test_a_resting_level_that_nobody_measured_counts_for_more() -> None:
    press = pressed(TabulatedWorld(), 5.32)
    front = front_of(press)
    exact, measured, unknown = (
        front_spread(front, press.skin_log_growth, press.force_n, sd_n) for sd_n in (0.0, 0.005, None)
    )
    parts = [each.interval.parts["force zero"] for each in (exact, measured, unknown) if each.interval]
    assert parts[0] == 0
    assert 0 < parts[1] < parts[2]
    told = front_spread(front, press.skin_log_growth, press.force_n, FORCE_ZERO_SD_N)
    assert told.interval.parts["force zero"] == parts[2]


@pytest.mark.parametrize(("world", "skin_too"), [(TabulatedWorld(), False), (ContactWorld(), True)])
def test_the_ratio_of_skin_to_front_tells_the_worlds_apart(world: World, skin_too: bool) -> None:
    press = pressed(world, 1.11)
    ratio, low, high = front_spread(front_of(press), press.skin_log_growth, None, None).skin_over_front
    first = front_spread(front_of(press), press.skin_log_growth, None, None).first
    true = np.exp(press.skin_log_growth[first:].sum()) * press.area_mm2[first] / press.area_mm2[-1]
    assert low < true < high
    assert low < ratio < high
    assert (low < 1 < high) == skin_too


def test_the_error_of_the_ratio_holds_what_the_length_of_the_pins_changes_over_the_press() -> None:
    """Not what it changes at both ends alike: growth does not mind that."""
    front = front_of(pressed(TabulatedWorld()))
    still = dict.fromkeys(PARTS, np.zeros(len(front.area)))
    reach = []
    for first, last in ((0.0, 0.0), (0.2, 0.2), (0.1, 0.3)):
        lengths = np.full(len(front.area), first)
        lengths[-1] = last
        even = replace(front, parts=still | {"pin length": lengths}, candidates=front.area[None],
                       weight=np.ones(1), spread_weight=np.ones(1))  # fmt: skip
        ratio, _, high = front_spread(even, np.zeros(len(front.area) - 1), None, None).skin_over_front
        reach.append(np.log(high / ratio) / 1.959964)
    assert reach[1] == pytest.approx(reach[0])
    assert reach[2] == pytest.approx(np.hypot(reach[0], 0.2))


def test_a_press_that_goes_on_keeps_its_worlds_until_it_has_four_times_the_frames(monkeypatch) -> None:
    asked: list[tuple[int, str]] = []

    class Held:
        front = replace(front_of(pressed(TabulatedWorld())), misfit=0.0)

        def __init__(self, rest_px: Array, pins_px: Array, *_: object) -> None:
            self.n_frames = len(pins_px)

        def __len__(self) -> int:
            return self.n_frames

        def add(self, pins_px: Array) -> None:
            asked.append((len(pins_px), "added"))
            self.n_frames += len(pins_px)

    def fits(rest_px: Array, pins_px: Array, *_: object, near: object, looks: int) -> list[str]:
        asked.append((len(pins_px), f"found by {looks} looks"))
        return ["fits"]

    monkeypatch.setattr(follow, "found_fits", fits)
    monkeypatch.setattr(follow, "HeldFront", Held)
    so_far, rest_px = follow.FrontSoFar(None, worlds()), np.zeros((9, 2))
    for n in (2, 3, 5, 5, 8, 31):
        so_far.of(rest_px, np.zeros((n, 9, 2)))
    so_far.settle(rest_px, np.zeros((15, 9, 2)))
    so_far.settle(rest_px, np.zeros((16, 9, 2)))
    so_far.of(rest_px, np.zeros((17, 9, 2)))
    assert asked == [
        (2, "found by 2 looks"), (1, "added"), (2, "added"), (8, "found by 2 looks"), (23, "added"),
        (16, "found by 1 looks"), (1, "added"),
    ]  # fmt: skip


def test_frames_that_come_one_by_one_have_the_front_of_all_at_once() -> None:
    """About the centre and by the worlds that were found in the same frames; pins that are lost for a while return."""
    press = pressed(TabulatedWorld(), 3.35, 30.0)
    pins_px = press.pins_px.copy()
    pins_px[5:9, [3, 40]] = np.nan
    fits = [found_fits(press.rest_px, pins_px, CAMERA, worlds()) for _ in range(2)]
    at_once = HeldFront(press.rest_px, pins_px, CAMERA, worlds(), fits[0])
    again = [HeldFit(f.view, worlds(), press.rest_px, f.axis, f.worlds, sheared=f.sheared) for f in fits[1]]
    for fit in again:
        fit.add(pins_px[:4])
    one_by_one = HeldFront(press.rest_px, pins_px[:4], CAMERA, worlds(), again)
    for frame in range(4, len(pins_px)):
        one_by_one.add(pins_px[frame : frame + 1])
    assert len(one_by_one) == len(pins_px)
    for name in ("area", "candidates", "weight", "misfit"):
        np.testing.assert_allclose(getattr(one_by_one.front, name), getattr(at_once.front, name), rtol=1e-9)
    for name in ("pitches", "pins_inside"):
        # edges are those of the world that was best when their frames came
        np.testing.assert_allclose(getattr(one_by_one.front, name)[8:], getattr(at_once.front, name)[8:], rtol=0.02)


def test_without_forces_there_is_a_ratio_and_no_rate() -> None:
    press = pressed(TabulatedWorld())
    spread = front_spread(front_of(press), press.skin_log_growth, None, None)
    assert (spread.rate, spread.interval) == (None, None)
    assert np.isnan(spread.first_n)


def test_a_contact_that_stays_small_is_doubted() -> None:
    press = pressed(TabulatedWorld(), 7.63)
    light = press.force_n < 0.7
    front = front_of(replace(press, pins_px=press.pins_px[light]))
    assert "too small for the pitch of the pins" in front_doubt(front, press.pins_px, CAMERA)
    assert any("is not determined there" in note for note in front.notes)


def test_pins_that_move_like_no_contact_are_doubted() -> None:
    press = pressed(TabulatedWorld())
    swirl = np.deg2rad(np.linspace(0.5, 8, 20))
    about = press.rest_px - press.rest_px.mean(axis=0)
    turned = [about @ np.array([[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]) + 149.5 for a in swirl]
    front = contact_front(press.rest_px, np.array(turned), CAMERA, worlds())
    assert "do not move as on a dome" in front_doubt(front, turned, CAMERA)


def test_pins_that_would_meet_are_refused() -> None:
    camera = replace(CAMERA, sensor=Sensor(pin_length_mm=12.0, dome_radius_mm=20.0))
    with pytest.raises(
        CameraError,
        match=r"sensor.pin_length_mm: expected 9.5 mm or less in a dome of 20 mm, but "
        r"found 12",
    ):
        front_of(pressed(TabulatedWorld()), camera)


@pytest.mark.parametrize("peak_n", [1.3, 2.0, 3.0])
def test_a_press_that_ends_early_has_an_interval_that_holds_the_rate_of_the_whole_window(peak_n: float) -> None:
    made = simulate_press(PressSettings(stiffness_n_per_mm=1.11, timeline=TimelineSettings(peak_n=peak_n)))
    found = score(made.sequence())
    assert found.interval.parts["beyond the frames"] > 0.05
    assert found.interval.low < made.truth.casr_power_mm2_per_n < found.interval.high


@pytest.mark.parametrize("depth_mm", [40.0, 55.0, 75.0])
def test_a_camera_at_another_depth_is_doubted(depth_mm: float) -> None:
    made = simulate_press(PressSettings(stiffness_n_per_mm=1.11))
    wrong = replace(made.sequence(), camera=replace(made.settings.camera, depth_mm=depth_mm))
    found = score(wrong)
    assert found.doubts or found.front_doubt


def test_friction_on_a_slope_does_not_move_the_front() -> None:
    """Skin that is pulled along the surface, otherwise than the fit has it, as the contact has grown meanwhile."""
    scene = Scene(PressSettings(angle_deg=45.0, stiffness_n_per_mm=3.35, centre_sd_mm=0.0))
    states = [scene.skin.state(force_n) for force_n in np.linspace(0.5, 5.0, 8).tolist()]
    pulled = [replace(state, tangential_mm=0.7 * state.normal_n / 5) for state in states]
    noise_px = np.random.default_rng(1).normal(0, NOISE_PX, (8, len(scene.rest_px), 2))
    pins_px = [np.array([scene.pins_px(state) for state in each]) + noise_px for each in (states, pulled)]
    fronts = [library_front(scene.rest_px, each, CAMERA, worlds()) for each in pins_px]
    true = np.array([scene.area_mm2(state) for state in states])
    free, held = (np.diff(np.log(front.area[[2, -1]]))[0] / np.diff(np.log(true[[2, -1]]))[0] for front in fronts)
    assert fronts[1].misfit < fronts[1].usual_misfit
    assert held == pytest.approx(free, abs=0.05)
    assert front_doubt(fronts[1], pins_px[1], CAMERA) == ""
