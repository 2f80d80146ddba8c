"""A reference of known stiffness on the emulated bench: a sound rig agrees with it, a wrong scale does not."""

from __future__ import annotations

from dataclasses import replace
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.errors import DeviceError
from emg2vsa.rig.commissioning.hand_motion import HandMotion
from emg2vsa.rig.commissioning.reference import (
    MOST_N,
    ReferenceProof,
    press_reference,
    read_reference,
    write_reference,
)
from emg2vsa.rig.record.press_counts import verdicts
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.faults import put
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.far_ends.qbmove.far_end import MOTOR_CURRENT_MA, MOTOR_TORQUE_NM

RIG = RigSettings()
LEFT_N = 0.1
A_PER_N = MOTOR_CURRENT_MA / 1000 / MOTOR_TORQUE_NM * RIG.lever_m
NOW = datetime(2026, 3, 1, 12, tzinfo=UTC)
PROOF = ReferenceProof(
    NOW.isoformat(), 5.0, 5.2, 0.02, ((2.0, 0.05), (5.0, 0.06)), 1, "QBMMP v6.1.0", {"force": "FT1"}, 0.2,
    RIG.push_axis, 700, 10.0,
)  # fmt: skip


def pressed(
    stated: float = 5.0, *, rigid: bool = True, fault: str = "", reach_deg: float = 45.0
) -> tuple[float, dict[float, float]]:
    spring = EmulatedSettings(world="elastic", stiffness_n_per_mm={"spring": stated})
    bench = EmulatedRig(spring, "spring", 0.0, rigid, VirtualClock(), rig=RIG, plate=True)
    if fault:
        put(bench, fault)
    hand = HandMotion(bench.devices(), RIG, bench.clock)
    most_n, sleep_until = 0.0, bench.clock.sleep_until

    def watched(time_s: float) -> None:
        nonlocal most_n
        sleep_until(time_s)
        most_n = max(most_n, bench.probe()[1])

    bench.clock.sleep_until = watched  # type: ignore[method-assign]
    try:
        found, a_per_n = press_reference(hand, RIG, [5.0], reach_deg, lambda text: None)
    finally:
        assert most_n < MOST_N + 2.0
        assert bench.probe()[1] < LEFT_N  # it is left free
    return found.n_per_mm, a_per_n


@pytest.mark.parametrize("stated", [1.0, 5.0, 6.0])
def test_a_sound_rig_finds_stiffness_and_current(stated: float) -> None:
    found, a_per_n = pressed(stated)
    assert found == pytest.approx(stated, rel=0.03)
    assert a_per_n == {5.0: pytest.approx(A_PER_N, rel=0.1)}


def test_springs_have_no_current_of_a_newton() -> None:
    found, a_per_n = pressed(rigid=False)
    assert found == pytest.approx(5.0, rel=0.03)
    assert a_per_n == {}


@pytest.mark.parametrize("gain", [0.8, 1.2])
def test_a_wrong_gain_is_found(gain: float) -> None:
    assert pressed(fault=f"gain {gain}")[0] == pytest.approx(5 * gain, rel=0.05)


@pytest.mark.parametrize(
    ("fault", "reach_deg", "why"),
    [
        ("", 5.0, "within its reach"),
        ("turned", 45.0, "along push_axis"),
        ("drift 0.2", 45.0, "when the probe is free again"),
        ("jumped-motor-1 -3000 at 2 N", 45.0, "degrees off"),
    ],
)
def test_what_is_wrong_is_told(fault: str, reach_deg: float, why: str) -> None:
    with pytest.raises(DeviceError, match=why):
        pressed(fault=fault, reach_deg=reach_deg)


def test_what_a_proof_holds_for() -> None:
    hour = timedelta(hours=1)
    assert PROOF.refused(NOW + hour, RIG) == ""
    assert "12 h ago" in PROOF.refused(NOW + 13 * hour, RIG)
    assert "12 h ago" in PROOF.refused(NOW - hour, RIG)  # of a clock that was set back
    assert "changed" in PROOF.refused(NOW, replace(RIG, gear_mm_per_degree=0.1))
    assert "5.6 N/mm were found" in replace(PROOF, found_n_per_mm=5.6).refused(NOW, RIG)
    assert (PROOF.a_per_n(5.0), PROOF.a_per_n(3.0)) == (0.06, None)


@pytest.mark.parametrize(
    ("device_id", "sensor", "sequence", "why"),
    [
        (1, "FT1", 1300, ""), (1, "FT1", None, ""), (1, "FT1", 699, "switched off"), (1, "FT1", 800, "switched off"),
        (2, "FT1", 1300, "another device"), (1, "FT2", 1300, "another [force]"),
    ],
)  # fmt: skip
def test_which_devices_a_proof_holds_for(device_id: int, sensor: str, sequence: int | None, why: str) -> None:
    class Info:
        firmware = "QBMMP v6.1.0"

    Info.device_id = device_id  # type: ignore[attr-defined]
    said = PROOF.refused_by(Info(), {"force": sensor}, sequence, NOW + timedelta(minutes=1))  # type: ignore[arg-type]
    assert why in said
    assert bool(why) == bool(said)


def test_a_proof_is_kept_and_read_back(tmp_path: Path) -> None:
    file = tmp_path / "rig.toml"
    assert read_reference(file) is None
    path = write_reference(file, PROOF)
    assert read_reference(file) == PROOF
    assert read_reference(file, virtual=True) is None
    whole = path.read_text()
    for spoilt in ("{}", whole.replace("+00:00", ""), whole.replace("2026-", "x"), whole.replace("0.06", "0.0")):
        path.write_text(spoilt)
        with pytest.raises(DeviceError, match=r"rig\.reference\.json.*Delete it"):
            read_reference(file)


def test_a_plate_press_is_ok_only_with_the_reference(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "rig.toml"
    file.write_text(
        '[actuator]\nkind = "qbmove"\n[motor]\n[force]\nkind = "net-ft"\n[experiment]\nspecimens = ["X"]\n'
        "repetitions = 1\nangles_deg = { high-stiffness = [0] }\n[plate]\ntrials = 1\n"
        '[emulated]\nworld = "elastic"\nstiffness_n_per_mm = { X = 5.0 }\n'
    )

    def said_of_a_press(out: str) -> list[str]:
        assert main(["rig", "run", str(file), "--virtual", "--plate", "X", "--out", str(tmp_path / out)]) == 0
        return [why for _, why in verdicts(tmp_path / out / "X").values()]

    assert [why for why in said_of_a_press("before") if "nothing but the sensor" in why]
    assert main(["rig", "commission", str(file), "--reference", "5", "--motor", "--virtual"]) == 0
    assert "at 1 mm/s the motor draws" in capsys.readouterr().out
    assert said_of_a_press("after") == [""]


@pytest.mark.parametrize(("given", "wanted"), [("0", "1 to 6 N/mm"), ("20", "1 to 6 N/mm"), ("nan", "1 to 6")])
def test_a_reference_that_cannot_be_is_refused(given: str, wanted: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["rig", "commission", "studies/palpation/rig.toml", "--reference", given, "--motor", "--virtual"]) == 2
    assert wanted in capsys.readouterr().err
