"""Whole runs in virtual time: executor, drivers, bytes, emulated devices and the one world behind them."""

from __future__ import annotations

import json
import struct
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest

from benchmarks.kappa_end_to_end import Specimen, fitted, pressed
from benchmarks.rig.fault_case import read_log
from casr.frame_files import open_frames, read_force_log
from casr.scoring import score
from emg2vsa.arrays import Floats
from emg2vsa.devices.protocols import Frame
from emg2vsa.devices.qbmove import packets
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK
from emg2vsa.errors import DeviceError, ScheduleError, SettingError
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.press_counts import peak_forces_n
from emg2vsa.rig.record.run_log import Row
from emg2vsa.rig.rig_settings import GuardSettings, RigSettings
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual
from emg2vsa.worlds.far_ends.camera import EmulatedCamera

STARTED = datetime(2026, 3, 1, 9, 30, tzinfo=UTC)
RIG = RigSettings()
Plan = Callable[..., RunPlan]


def files(folder: Path) -> dict[str, bytes]:
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def test_the_same_inputs_give_the_same_bytes(plan: Plan, tmp_path: Path) -> None:
    for name, seed in (("first", 0), ("again", 0), ("other", 1)):
        run_virtual(
            plan(angle_deg=30.0, f_max_n=2.0, pause_s=0.05),
            RIG,
            EmulatedSettings(seed=seed),
            tmp_path / name,
            started=STARTED,
        )
    first, again, other = (files(tmp_path / name) for name in ("first", "again", "other"))
    assert first == again
    assert {name for name in first if first[name] != other[name]} >= {"log.csv", "press-002/frames.tif"}
    assert first["press-001/frames.tif"] != first["press-002/frames.tif"]


@pytest.mark.parametrize(
    ("condition", "world", "changes"),
    [
        ("plate", "viscoelastic", {}),
        ("modular", "viscoelastic", {}),
        ("high-stiffness", "elastic", {"push_axis": (0.0, -0.6, 0.8), "record_full_rate_force": True}),
        ("modular", "elastic", {"push_sign": -1, "home_deg": 700 * DEG_PER_TICK, "rate_hz": 100.0}),
        ("modular", "viscoelastic", {"guards": GuardSettings(contact_mm=2.5)}),
        ("modular", "viscoelastic", {"guards": GuardSettings(following_deg=40 * DEG_PER_TICK)}),
    ],
)
def test_with_bytes_and_without_the_same_run_comes_out(
    plan: Plan, tmp_path: Path, condition: str, world: str, changes: dict[str, object]
) -> None:
    """All files, byte for byte, as from a run in which every turn is a conversation; also where a guard ends it."""
    rig, found = RigSettings(**changes), {}  # type: ignore[arg-type]
    for exact in (True, False):
        emulated = EmulatedSettings(exact=exact, world=world)  # type: ignore[arg-type]
        kind = {"condition": "high-stiffness", "plate": True} if condition == "plate" else {"condition": condition}
        run_plan = plan(**kind, angle_deg=30.0, f_max_n=2.0, pause_s=0.3)
        ended = run_virtual(run_plan, rig, emulated, tmp_path / str(exact), started=STARTED)
        assert ended.how == ("guard" if "guards" in changes else "completed"), ended.why
        found[exact] = files(tmp_path / str(exact))
        assert found[exact].pop("emulated.json")
    assert found[True] == found[False]
    assert b",approach," in found[True]["log.csv"]


def motors_exchanged(board: Qbmove, command: packets.Command, first: int, second: int) -> None:
    board._talk.tell(packets.frame(board.device_id, command, struct.pack(">hh", second, first)))


def little_endian(board: Qbmove, command: packets.Command, count: int) -> tuple[int, ...]:
    return struct.unpack(f"<{count}h", board._ask(command, 2 * count))


@pytest.mark.parametrize(("place", "wrong"), [("_tell_ticks", motors_exchanged), ("_ask_words", little_endian)])
def test_a_wrong_order_of_bytes_in_the_driver_is_seen_with_bytes_alone(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, place: str, wrong: Callable[..., object]
) -> None:
    monkeypatch.setattr(Qbmove, place, wrong)
    for exact, how in ((False, "completed"), (True, "guard")):
        emulated, folder = EmulatedSettings(exact=exact), tmp_path / str(exact)
        assert run_virtual(plan(repetitions=1, f_max_n=2.0), RIG, emulated, folder, started=STARTED).how == how


@pytest.mark.parametrize("condition", ["high-stiffness", "modular"])
def test_a_press_that_turns_back_earlier_ends_near_f_max(plan: Plan, tmp_path: Path, condition: str) -> None:
    beyond_n = []
    for lead_s in (0.0, 0.04, 0.1):
        folder = tmp_path / f"{lead_s}"
        ended = run_virtual(
            plan(condition, specimen="S1", repetitions=1, lead_s=lead_s),
            RIG,
            EmulatedSettings(),
            folder,
            started=STARTED,
        )
        beyond_n.append(peak_forces_n(folder)[1] - 7.0)
        said = f"press 1 ended at {7 + beyond_n[-1]:.2f} N, short of f_max_n, 7 N: choose a smaller lead_s"
        assert (said in ended.notes) == (beyond_n[-1] < 0)
    assert beyond_n[0] > 0.6
    assert beyond_n[2] < 0
    assert -0.2 < beyond_n[1] < 0.35 * beyond_n[0]


@pytest.mark.parametrize(
    ("condition", "angle_deg", "springs"),
    [
        ("high-stiffness", 45.0, "qbmove-maker-pro"),
        ("modular", 30.0, "qbmove-maker-pro"),
        ("modular", 0.0, "qbmove-advanced"),
        ("constant-min", 0.0, "qbmove-advanced"),
        ("constant-max", 0.0, "qbmove-maker-pro"),
    ],
)
def test_a_run_of_every_kind(plan: Plan, tmp_path: Path, condition: str, angle_deg: float, springs: str) -> None:
    emulated = EmulatedSettings(world="elastic", springs=springs)  # type: ignore[arg-type]
    run_plan = plan(condition, angle_deg=angle_deg, repetitions=1)
    ended = run_virtual(run_plan, RIG, emulated, tmp_path / "run", started=STARTED)
    assert (ended.how, ended.repetitions_done, ended.retracted, ended.deactivated) == ("completed", 1, True, True)
    rows = read_log(tmp_path / "run" / "log.csv")
    pressed_n = max(row.force_n or 0 for row in rows)
    assert 7.0 <= pressed_n < RIG.guards.force_n
    deepest = max(rows, key=lambda row: row.position_deg or 0)
    yielded_mm = RIG.depth_at(deepest.position_deg or 0) - RIG.depth_at(shaft_deg(deepest))
    # the rigid shaft lags behind its command, springs yield as well
    assert (yielded_mm < 0.25) == (condition == "high-stiffness")


@pytest.mark.parametrize("condition", ["high-stiffness", "modular"])
def test_a_rig_built_the_other_way_round(plan: Plan, tmp_path: Path, condition: str) -> None:
    axes = {"tilted": (0.0, -0.6, 0.8), "down": (0.0, 0.0, -1.0), "sideways": (1.0, 0.0, 0.0)}
    mirrored = {
        name: RigSettings(push_sign=-1, push_axis=axis, home_deg=700 * DEG_PER_TICK) for name, axis in axes.items()
    }
    found = {}
    for name, rig in {"usual": RIG, **mirrored}.items():
        emulated = EmulatedSettings(world="elastic", force_noise_n=0.002)
        ended = run_virtual(plan(condition, repetitions=1), rig, emulated, tmp_path / name, started=STARTED)
        assert (ended.how, ended.retracted) == ("completed", True)
        load = [row for row in read_log(tmp_path / name / "log.csv") if row.phase == "load"]
        found[name] = depth_at_n([1.0, 2.0, 4.0, 6.0], load, rig)
    encoder_mm = 0.2 * 360 / 4096  # rounds to different sides in the two mountings, as the motors' loop does
    for name in mirrored:
        np.testing.assert_allclose(found[name], found["usual"], atol=2 * encoder_mm, err_msg=name)


def shaft_deg(row: Row) -> float:
    return row.at.shaft_deg if row.at else 0.0


def depth_at_n(force_n: list[float], load: list[Row], rig: RigSettings) -> Floats:
    """Depth of the shaft, mm, at forces of a loading phase."""
    return np.interp(force_n, [row.force_n or 0 for row in load], [rig.depth_at(shaft_deg(row)) for row in load])


def test_the_softer_specimen_spreads_faster(plan: Plan, tmp_path: Path) -> None:
    rates = []
    for specimen in ("S1", "S5"):
        folder = tmp_path / specimen
        run_virtual(
            plan("constant-max", specimen=specimen, repetitions=1), RIG, EmulatedSettings(), folder, started=STARTED
        )
        scores = [score(open_frames(press)) for press in sorted(folder.glob("press-*"))]
        assert len(scores) == 1
        rates.append(np.mean([found.rate.value for found in scores if found.rate is not None]))
    assert rates[1] > 1.2 * rates[0]


@pytest.mark.parametrize("delay_s", [0.0, 0.0625, 0.1625])
def test_the_force_of_a_frame_is_that_under_which_it_was_drawn(
    plan: Plan, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, delay_s: float
) -> None:
    drawn_n: dict[str, float] = {}
    exposed = EmulatedCamera.exposed

    def seen(camera: EmulatedCamera) -> list[Frame]:
        frames = exposed(camera)
        for frame in frames:
            drawn_n[f"{frame.time_s:.6f}"] = frame._drawn_from[1].normal_n  # type: ignore[attr-defined]
        return frames

    monkeypatch.setattr(EmulatedCamera, "exposed", seen)
    stiff = plan("high-stiffness", specimen="S1", repetitions=1)
    exact = EmulatedSettings(world="elastic", angle_sd_deg=0.0).as_used()
    late = replace(exact, world="viscoelastic", camera_latency_s=delay_s)
    ended = run_virtual(stiff, RIG, late, tmp_path / "run", started=STARTED)
    assert ended.how == "completed"
    press = tmp_path / "run" / "press-001"
    frame_s = read_force_log(press / "force.csv").frame_time_s
    logged_n = open_frames(press).force_n
    assert frame_s is not None
    assert logged_n is not None
    true_n = [drawn_n[f"{time_s:.6f}"] for time_s in np.unique(frame_s[np.isfinite(frame_s)])]
    np.testing.assert_allclose(logged_n, true_n, atol=0.03)  # of a force that rises by 38 N/s
    assert np.mean(logged_n - true_n) == pytest.approx(0, abs=0.005)
    # the last one is that before the turn, however late it came
    turn_s = next(row.time_s for row in read_log(tmp_path / "run" / "log.csv") if row.phase == "retract")
    assert 0 <= turn_s - frame_s[-1] < 1 / 20


def test_a_press_is_kept_up_to_its_turning_point(plan: Plan, tmp_path: Path) -> None:
    run_virtual(plan(), RIG, EmulatedSettings(world="elastic"), tmp_path / "run", started=STARTED)
    rows = read_log(tmp_path / "run" / "log.csv")
    for repetition in (1, 2):
        press = tmp_path / "run" / f"press-{repetition:03d}"
        kept = np.genfromtxt(press / "force.csv", delimiter=",", skip_header=1)
        loading = [row for row in rows if row.repetition == repetition and row.phase in ("approach", "contact", "load")]
        turn = next(row for row in rows if row.repetition == repetition and row.phase == "retract")
        np.testing.assert_array_equal(kept[:, 0], [row.force_time_s for row in [*loading, turn]])
        assert kept[-1, 2] == turn.frame_index == len(open_frames(press)) - 1
    after = [row for row in rows if row.phase in ("retract", "pause") and row.filtered_n is not None]
    assert {row.frame_index for row in after if row.filtered_n is not None and row.filtered_n < 7} == {-1}


@pytest.mark.parametrize("exact", [True, False])
def test_it_says_that_no_hardware_made_it_and_whether_bytes_were_sent(plan: Plan, tmp_path: Path, exact: bool) -> None:
    emulated = EmulatedSettings(seed=5, exact=exact)
    run_virtual(plan(repetitions=1, f_max_n=1.0), RIG, emulated, tmp_path / "run", started=STARTED)
    told = json.loads((tmp_path / "run" / "emulated.json").read_text())
    assert (told["seed"], told["over_bytes"]) == (5, exact)


def test_another_run_is_neither_overwritten_nor_marked(plan: Plan, tmp_path: Path) -> None:
    (tmp_path / "log.csv").write_text("measured")
    with pytest.raises(DeviceError, match="new folder"):
        run_virtual(plan(), RIG, EmulatedSettings(), tmp_path, started=STARTED)
    assert files(tmp_path) == {"log.csv": b"measured"}


@pytest.mark.parametrize(
    ("changes", "rig", "emulated", "error", "says"),
    [
        ({"f_max_n": 12.0}, RIG, EmulatedSettings(), SettingError, "guard"),
        ({}, RIG, EmulatedSettings(stiffness_n_per_mm={"S1": 7.6}), SettingError, "stiffness of the specimen"),
        (
            {"angle_deg": 45.0},
            RIG,
            EmulatedSettings(stiffness_n_per_mm={"S3": 0.05}),
            SettingError,
            "as the tables reach",
        ),
        ({}, RigSettings(full_preset=1000 * DEG_PER_TICK), EmulatedSettings(), ScheduleError, "stiffness preset"),
    ],
)
def test_what_cannot_be_makes_no_folder(plan, tmp_path, changes, rig, emulated, error, says):
    with pytest.raises(error, match=says):
        run_virtual(plan(**changes), rig, emulated, tmp_path / "run", started=STARTED)
    assert not (tmp_path / "run").exists()


def test_a_plate_tells_kappa_of_a_specimen_that_stiffens(tmp_path: Path) -> None:
    specimen = Specimen("S5", 10.0)
    of = fitted(specimen, pressed(specimen, "elastic", 1, tmp_path)).specimen("S5")
    assert of is not None
    assert (of.trials, of.nonlinear) == (5, 5)
    assert of.kappa.mean == pytest.approx(specimen.secant(of.range_n), rel=0.02)
    assert of.kappa.mean > 1.4 * specimen.kappa


def test_a_height_moves_no_other_specimen_and_no_dome(plan: Plan, tmp_path: Path) -> None:
    usual, high = EmulatedSettings(), EmulatedSettings(height_mm={"S3": 10.0})
    assert (high.of("S1") == usual.of("S1"), high.of("S3") == usual.of("S3")) == (True, False)
    for name, emulated in (("usual", usual), ("high", high)):
        run_virtual(plan(repetitions=1), RIG, emulated, tmp_path / name, started=STARTED)
        plate = plan("high-stiffness", specimen="S1", repetitions=1, plate=True)
        run_virtual(plate, RIG, emulated, tmp_path / f"plate-{name}", started=STARTED)
    for one, other in (("usual", "high"), ("plate-usual", "plate-high")):
        assert (tmp_path / one / "log.csv").read_bytes() == (tmp_path / other / "log.csv").read_bytes()
