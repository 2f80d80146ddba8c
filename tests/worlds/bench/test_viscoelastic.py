"""The world in which bodies creep, skin sticks and slides, and every mounting differs."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.emulated_scatter import scatter_percent, true_rates
from casr.frame_files import open_frames, read_force_log
from emg2vsa.arrays import Floats
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.qbmove.springs import SPRINGS, Springs
from emg2vsa.errors import DataError
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.probe import APART, Touch, WorldSettings
from emg2vsa.worlds.bench.settings import EmulatedSettings, relaxation_at
from emg2vsa.worlds.bench.truth import TRUTH_FILE, TrueLoading, read_truth, true_areas_mm2, truth_text
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.contact import Relaxation
from emg2vsa.worlds.far_ends.camera import EmulatedCamera
from emg2vsa.worlds.tactile import ContactWorld, Scene
from tests.worlds.contact.history_keeping import maxwell

MM_PER_RAD = math.degrees(0.2)
RATE_RAD_PER_S = 5.0 / MM_PER_RAD
LOSSY = Relaxation.of_share(0.2)
REMEMBERS_NOTHING = Relaxation(1.0, (0.0,), (1.0,))
STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
RIG = RigSettings()


def pressed(end_s: float = 2.0, back: bool = False, **settings: Any) -> tuple[Floats, list[Touch]]:
    """Contacts each 5 ms of a press at 5 mm/s from 5 mm above the specimen, and back."""
    world = World(VirtualClock(), WorldSettings(**{"gap_mm": 5.0, "springs": None} | settings))
    times = np.arange(0, 2 * end_s if back else end_s, 0.005)
    touches = []
    for time_s in times.tolist():
        at = RATE_RAD_PER_S * (time_s if time_s <= end_s else 2 * end_s - time_s)
        world.shaft_rad(time_s, (at + 0.4, at - 0.4) if settings.get("springs") else (at, at))
        touches.append(world.touch(time_s))
    return times, touches


def normal_n(touches: list[Touch]) -> Floats:
    return np.array([touch.normal_n for touch in touches])


def test_a_rigid_ramp_on_a_maxwell_body_is_dawsons_function() -> None:
    # R 20 mm, E 0.3 and 0.1 MPa, tau 0.3 s, 5 mm/s: 6.108172512 N after 0.4 s
    relaxation, after_1_s_mpa = maxwell(0.3, 0.1, 0.3)
    contact = ContactWorld(exponent=1 / 3, sensor_modulus_mpa=after_1_s_mpa)
    body = {"contact": contact, "stiffness_n_per_mm": 1e18, "relaxation": relaxation}
    times, touches = pressed(1.5, **body)
    assert touches[round(1.4 / 0.005)].normal_n == pytest.approx(6.108172512, rel=2e-7)
    assert times[280] == pytest.approx(1.4)


@pytest.mark.parametrize("springs", [None, SPRINGS["qbmove-maker-pro"]], ids=["rigid", "springs"])
def test_bodies_that_do_not_creep_are_the_elastic_world(springs: Springs | None) -> None:
    _, elastic = pressed(springs=springs, back=True)
    _, same = pressed(springs=springs, back=True, relaxation=REMEMBERS_NOTHING)
    assert max(touch.normal_n for touch in elastic) > 5
    np.testing.assert_allclose(normal_n(same), normal_n(elastic), rtol=1e-9, atol=1e-9)
    assert all(touch.normal_n == touch.elastic_n for touch in [*elastic, *same])


def test_the_stiffer_the_springs_the_nearer_to_the_rigid_motor() -> None:
    off = []
    for stiffer in (10.0, 1e3, 1e5):
        usual = SPRINGS["qbmove-maker-pro"]
        springs = replace(usual, k1_nm=stiffer * usual.k1_nm, k2_nm=stiffer * usual.k1_nm, a2_per_rad=usual.a1_per_rad)
        _, held = pressed(springs=springs, relaxation=LOSSY, friction_nm=0.0, settling_s=0.0)
        _, rigid = pressed(relaxation=LOSSY)
        off.append(float(np.abs(normal_n(held) / np.maximum(normal_n(rigid), 1e-9) - 1)[220:].max()))
    assert off[0] > off[1] > off[2]
    assert off[2] < 1e-4


def test_area_follows_force_alone_where_nothing_creeps() -> None:
    draws = PressDraws(EmulatedSettings(world="elastic"), "S3", 0.0, SPRINGS["qbmove-maker-pro"], RIG)
    seen, scene = draws.seen(0), draws.scene(0)
    for springs in (None, *SPRINGS.values()):
        _, touches = pressed(springs=springs, end_s=1.6)
        for touch in touches[::40]:
            assert seen.area_mm2(touch) == scene.area_mm2(touch.normal_n)  # bit for bit
            assert seen.state(touch) == scene.skin.state(touch.normal_n)


def test_a_slower_press_has_the_larger_contact_at_a_force() -> None:
    fast, slow = (World(VirtualClock(), WorldSettings(gap_mm=2.0, springs=None, relaxation=LOSSY)) for _ in range(2))
    elastic_n = []
    for world, duration_s in ((fast, 0.5), (slow, 5.0)):
        for k in range(501):
            at = (2.0 + 2.0 * k / 500) / MM_PER_RAD
            world.shaft_rad(k * duration_s / 500, (at, at))
        end = world.touch(duration_s)
        elastic_n.append(end.elastic_n / end.normal_n)
    assert 1.05 < elastic_n[1] / elastic_n[0] < 1.2


def test_a_pressed_specimen_relaxes_at_rest_in_any_steps() -> None:
    forces = []
    for pause_s in ([100.0], [0.001] * 1000 + [99.0], [33.3, 33.3, 33.4]):
        world = World(VirtualClock(), WorldSettings(gap_mm=2.0, springs=None, relaxation=LOSSY))
        at = 4.0 / MM_PER_RAD
        world.shaft_rad(0.0, (0.0, 0.0))
        world.shaft_rad(now := 0.4, (at, at))
        for length_s in pause_s:
            world.shaft_rad(now := now + length_s, (at, at))
        forces.append(world.normal_force_n(0.4) / world.normal_force_n(now))
    # power law t^n: 1000 times as long takes 10^(3 n) off, with 0.8 left from 0.1 to 10 s
    assert forces[0] == pytest.approx(0.8**-1.5, rel=0.08)
    assert forces == pytest.approx([forces[0]] * 3, rel=2e-3)


def test_a_contact_ends_where_nothing_pushes_and_the_next_one_is_new() -> None:
    world = World(VirtualClock(), WorldSettings(gap_mm=5.0, springs=None, relaxation=LOSSY, skin_friction=0.6))
    peaks, last = [], 0.0
    for press in range(2):
        for k in range(801):
            at = RATE_RAD_PER_S * 0.005 * (k if k <= 400 else 800 - k)
            world.shaft_rad(4.0 * press + 0.005 * k, (at, at))
            touch = world.touch(4.0 * press + 0.005 * k)
            assert touch.normal_n >= 0
            if k > 400 and touch == APART:
                last = max(last, at * MM_PER_RAD - 5.0)  # still below the surface
        peaks.append(world.touch(4.0 * press + 2.0))
    assert last > 0.05
    assert peaks[0].normal_n == pytest.approx(peaks[1].normal_n, rel=1e-9)


@pytest.mark.parametrize("relaxation", [REMEMBERS_NOTHING, LOSSY], ids=["elastic", "lossy"])
@pytest.mark.parametrize("angle_deg", [30.0, 45.0])
def test_a_contact_that_sticks_bears_two_thirds_of_the_tangent(angle_deg: float, relaxation: Relaxation) -> None:
    tilt = math.radians(angle_deg)
    _, touches = pressed(angle_deg=angle_deg, relaxation=relaxation, skin_friction=2.0)
    for touch in touches[230::20]:
        assert touch.shear_n / touch.normal_n == pytest.approx(2 / 3 * math.tan(tilt), rel=1e-9)
    world = World(VirtualClock(), WorldSettings(angle_deg=angle_deg, skin_friction=2.0, springs=None))
    world.shaft_rad(0.0, (0.0, 0.0))
    world.shaft_rad(1.0, (0.7, 0.7))
    touch, (across_n, _, along_n) = world.touch(1.0), world.force_n(1.0)
    assert along_n == pytest.approx(touch.normal_n * math.cos(tilt) + touch.shear_n * math.sin(tilt))
    assert across_n == pytest.approx(touch.normal_n * math.sin(tilt) - touch.shear_n * math.cos(tilt))


def test_skin_slides_at_the_friction_and_a_mount_takes_some_of_the_shear() -> None:
    _, touches = pressed(angle_deg=45.0, skin_friction=0.5, friction_drop=0.05, relaxation=LOSSY, back=True)
    share = np.array([touch.shear_n / touch.normal_n for touch in touches if touch.normal_n > 0.01])
    assert np.abs(share).max() <= 0.5 + 1e-12
    assert share[:100].max() == pytest.approx(0.5, abs=0.02)
    assert share.min() < -0.39  # on its way back it is pulled the other way
    assert np.diff(share).min() < -0.05  # in jerks
    stiff, soft = (pressed(angle_deg=45.0, skin_friction=2.0, mount_n_per_mm=k)[1][-1] for k in (math.inf, 20.0))
    assert 0.5 < soft.shear_n / soft.normal_n < 0.62 < stiff.shear_n / stiff.normal_n


def test_a_flat_schedule_is_the_constant(plan: Callable[..., RunPlan], tmp_path: Path) -> None:
    constant = plan("constant-max", specimen="S3", repetitions=1, f_max_n=4.0)
    assert constant.schedule
    flat = replace(constant, condition="modular", schedule=replace(constant.schedule, condition="modular"))
    for name, each in (("constant", constant), ("modular", flat)):
        run_virtual(each, RIG, EmulatedSettings(), tmp_path / name, started=STARTED, run="same")
    for file in ("log.csv", "press-001/frames.tif", TRUTH_FILE):
        assert (tmp_path / "constant" / file).read_bytes() == (tmp_path / "modular" / file).read_bytes()


def test_every_frame_shows_the_contact_of_its_exposure(
    plan: Callable[..., RunPlan], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the times of the frames are exact, their area at the logged force is that of the truth."""
    shown: dict[str, tuple[Scene, Any]] = {}
    exposed = EmulatedCamera.exposed

    def seen(camera: EmulatedCamera) -> list[Any]:
        frames = exposed(camera)
        shown.update({f"{frame.time_s:.6f}": frame._drawn_from[:2] for frame in frames})  # type: ignore[attr-defined]
        return frames

    monkeypatch.setattr(EmulatedCamera, "exposed", seen)
    exact = dict.fromkeys(
        ("camera_latency_sd_s", "camera_jitter_s", "late_frames_share", "force_zero_sd_n", "friction_drop"), 0.0
    )
    emulated = EmulatedSettings(**exact, force_noise_n=0.001)  # type: ignore[arg-type]
    run_virtual(plan(specimen="S5", repetitions=2, angle_deg=45.0), RIG, emulated, tmp_path / "run", started=STARTED)
    for number, truth in enumerate(read_truth(tmp_path / "run"), start=1):
        press = tmp_path / "run" / f"press-{number:03d}"
        times = read_force_log(press / "force.csv").frame_time_s
        force_n = open_frames(press).force_n
        assert times is not None
        assert force_n is not None
        frames = [shown[f"{time_s:.6f}"] for time_s in np.unique(times[np.isfinite(times)])]
        area = np.array([scene.area_mm2(state) for scene, state in frames])
        loading = force_n > 0.5
        assert np.count_nonzero(loading) > 8
        np.testing.assert_allclose(area[loading], truth.area_at(force_n[loading]), rtol=0.005)
        assert frames[-1][1].tangential_mm > 0.2


def draws(mounting: int = 1, **changes: Any) -> PressDraws:
    return PressDraws(
        EmulatedSettings(**changes), "S1", 45.0, SPRINGS["qbmove-maker-pro"], RIG, "run", mounting=mounting
    )


def test_presses_of_a_mounting_share_what_another_mounting_has_otherwise() -> None:
    worlds = {mounting: [draws(mounting).world(press) for press in range(4)] for mounting in (1, 2, 3)}
    for key in ("angle_deg", "skin_friction", "contact"):
        of_mounting = [{getattr(world, key) for world in each} for each in worlds.values()]
        assert [len(values) for values in of_mounting] == [1, 1, 1]
        assert len(set.union(*of_mounting)) == 3
    assert worlds[2] == [draws(2).world(press) for press in range(4)]
    assert len({world.stiffness_n_per_mm for each in worlds.values() for world in each}) == 12
    assert len({draws(mounting).force_zero_n(0) for mounting in (1, 2, 3)}) == 3
    assert len({draws(mounting).seen(press).latency_s for mounting in (1, 2) for press in (0, 1)}) == 4


def test_a_run_that_goes_on_in_another_folder_presses_the_same_mounting() -> None:
    for mounting in (1, 2):
        first = draws(mounting)
        again = replace(first, run="run-2", mounted="run")
        one, other = first.world(1), again.world(0)
        assert (one.angle_deg, one.skin_friction, one.contact) == (other.angle_deg, other.skin_friction, other.contact)
        assert first.world(0).gap_mm != other.gap_mm
    none = {"stiffness_sd": 0.0, "mounting_stiffness_sd": 0.0, "softening_sd": 0.0}
    assert replace(draws(**none), run="run-2", mounted="run").world(0).stiffness_n_per_mm == pytest.approx(7.63)
    assert replace(draws(), mounted="run").world(0) == draws().world(0)


def test_the_first_press_of_a_mounting_is_on_a_stiffer_specimen() -> None:
    none = {"stiffness_sd": 0.0, "mounting_stiffness_sd": 0.0, "softening_sd": 0.0}
    stiffness = [draws(**none).world(press).stiffness_n_per_mm for press in range(3)]
    assert stiffness == pytest.approx([1.02 * 7.63, 7.63, 7.63])


def test_a_sensor_of_another_modulus_is_the_same_contact_at_another_force() -> None:
    # in the power law that can be asked directly
    one = draws(skin="sticking", landing_sd_mm=0.0, adhesion_mj_per_m2=0.0, adhesion_sd_mj_per_m2=0.0, area_sd=0.0)
    world, seen = one.world(1), one.seen(1)
    assert seen.modulus != 1
    expected = world.contact.area_mm2(3.0, world.stiffness_n_per_mm, world.angle_deg)
    assert seen.area_mm2(Touch(3.0, 0.0, 3.0, 0.0)) == pytest.approx(float(expected), rel=1e-12)


@pytest.mark.parametrize(("specimen", "angle_deg", "most_mounting"), [("S1", 0.0, 2.0), ("S5", 45.0, 6.0)])
def test_true_scatter_is_that_of_the_settings(specimen: str, angle_deg: float, most_mounting: float) -> None:
    """A small sample of ``python -m benchmarks.emulated_scatter``, without frames."""
    press, mounting = scatter_percent(true_rates(specimen, angle_deg, 8, 3))
    assert 1.0 < press < 2.2  # the skin is uneven by 1.5 %, and adhesion and stiffness differ
    assert 0.3 < mounting < most_mounting  # stiffness of sensor and specimen; at an angle friction too
    elastic = true_rates(specimen, angle_deg, 2, 3, world="elastic")
    assert scatter_percent(elastic)[0] < 0.8


@pytest.mark.parametrize(("stiffness", "share"), [(0.2, 0.12), (1.11, 0.12), (5.32, 0.04), (7.63, 0.03), (50, 0.03)])
def test_relaxation_of_other_specimens_goes_by_their_stiffness(stiffness: float, share: float) -> None:
    assert relaxation_at(stiffness) == pytest.approx(share)
    settings = EmulatedSettings(stiffness_n_per_mm={"S_new": stiffness, "S1": 1.0}, relaxation={"S1": 0.5})
    assert settings.relaxation_of("S_new") == pytest.approx(share)
    assert settings.relaxation_of("S1") == 0.5


def test_the_truth_is_read_as_it_was_written(tmp_path: Path) -> None:
    force = np.linspace(0.1, 8, 400)
    (tmp_path / "press-001").mkdir()
    (tmp_path / "press-003").mkdir()
    loadings = [TrueLoading(force, 50 * force**0.5), TrueLoading(force[:9], force[:9]), TrueLoading(force, 2 * force)]
    (tmp_path / TRUTH_FILE).write_text(truth_text(loadings))
    found = read_truth(tmp_path)
    assert found[0].a_c0_mm2 == pytest.approx(50 * 0.5**0.5, rel=1e-6)
    rounding = 1e-4 / 6.5  # of two areas in the file
    assert found[0].casr_mm2_per_n == pytest.approx(50 * (7**0.5 - 0.5**0.5) / 6.5, abs=rounding)
    assert found[2].casr_mm2_per_n == pytest.approx(2.0, abs=rounding)
    assert math.isnan(found[1].casr_mm2_per_n)
    np.testing.assert_allclose(true_areas_mm2([tmp_path], [4.0, 3.0]), [100.0, 6.0], rtol=1e-5)
    np.testing.assert_array_equal(true_areas_mm2([tmp_path], [math.nan, 9.0]), [math.nan, math.nan])


@pytest.mark.parametrize(("force", "area"), [([0.0, 1.0, 4.0], [1.0, 2.0, 4.0]), ([0.5, 1.0, 4.0], [0.0, 2.0, 4.0])])
@pytest.mark.filterwarnings("error")
def test_a_point_of_a_loading_without_force_or_area_counts_as_none(force, area):
    loading = TrueLoading(np.array(force), np.array(area))
    np.testing.assert_allclose(loading.area_at([2.0, 0.7]), [math.sqrt(8.0), math.nan], rtol=1e-12)
    nothing = TrueLoading(np.array([0.0, 1.0]), np.zeros(2))
    assert math.isnan(nothing.casr_mm2_per_n)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        (
            None,
            r"truth\.json: expected the truth of an emulated run, but found No such file.*\. Emulate the run again\.",
        ),
        ("{", "expected forces and areas of each press"),
        ('{"presses": [{"force_n": [1, 2]}]}', "expected forces and areas of each press, but found KeyError"),
        ('{"presses": [{"force_n": [2, 1], "area_mm2": [1, 2]}]}', "expected rising forces, each with its area"),
        ('{"presses": [{"force_n": [1, 2], "area_mm2": [1]}]}', "expected rising forces, each with its area"),
    ],
)
def test_a_broken_truth_is_one_clear_line(text: str | None, says: str, tmp_path: Path) -> None:
    if text is not None:
        (tmp_path / TRUTH_FILE).write_text(text)
    with pytest.raises(DataError, match=says):
        read_truth(tmp_path)
