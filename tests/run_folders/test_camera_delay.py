"""The delay of a camera, measured on an emulated one whose delay is known."""

from __future__ import annotations

from datetime import UTC, datetime

import numpy as np
import pytest

from benchmarks.rig.plans import SPECIMEN, modular_plan
from emg2vsa.cli import main
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.protocols import Devices, Frame
from emg2vsa.errors import RecordingError
from emg2vsa.rig.executor.execute import execute
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.run_folders.camera_delay import SYSTEMATIC_S, measure_delay, shift_of
from emg2vsa.worlds.bench.bench import EmulatedRig
from emg2vsa.worlds.bench.settings import EmulatedSettings

LATE_S = 0.043


class LateCamera:
    """Frames of the emulated camera, ``LATE_S`` after their exposure and timed then."""

    delay_s = 0.0

    def __init__(self, camera, clock):
        self.name, self.shape = camera.name, camera.shape
        self._camera, self._clock, self._on_their_way = camera, clock, []

    def frames(self):
        self._on_their_way += self._camera.exposed()
        there = [frame for frame in self._on_their_way if frame.time_s + LATE_S <= self._clock.now_s()]
        del self._on_their_way[: len(there)]
        return [Frame(frame.time_s + LATE_S, frame.image, frame.dropped) for frame in there]


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder, clock, rig = tmp_path_factory.mktemp("runs") / "late", VirtualClock(), RigSettings()
    bench = EmulatedRig(EmulatedSettings(world="elastic"), SPECIMEN, 0.0, rigid=False, clock=clock, rig=rig)
    opened = bench.devices()
    devices = Devices(opened.actuator, opened.force, LateCamera(bench.camera, clock))
    facts = {"camera": {"delay_s": 0.0}}
    plan = modular_plan(4, f_max_n=4.0)
    execute(plan, rig, devices, folder, clock, started=datetime.now(UTC), facts=facts)
    return folder


def test_the_delay_lies_within_the_interval(run):
    found = measure_delay([run])
    assert len(found.by_press_s) == 4
    assert found.left_out == ()
    assert abs(found.delay_s - LATE_S) <= found.half_width_s + SYSTEMATIC_S
    assert found.half_width_s < 0.006


def test_the_command_offers_the_line(run, capsys):
    assert main(["rig", "camera-delay", str(run)]) == 0
    line = capsys.readouterr().out.splitlines()[-1]
    name, _, value = line.partition(" = ")
    assert name == "delay_s"
    assert float(value) == pytest.approx(LATE_S, abs=0.01)


@pytest.mark.parametrize("power", [0.8, 1.0, 1.5])
@pytest.mark.parametrize("shift_s", [-0.02, 0.0, 0.043, 0.2])
def test_a_shift_is_found_whatever_the_law(power, shift_s):
    rng = np.random.default_rng(4)
    force_s = np.arange(-0.5, 2.5, 1 / 200)
    force_n = 2 * np.maximum(force_s - 0.5, 0) ** 1.3
    taken_s = np.arange(0.02, 1.5, 1 / 20)  # up to 2 N
    motion = 5 * np.interp(taken_s, force_s, force_n) ** power + rng.normal(0, 0.01, taken_s.size)
    noisy_n = force_n + rng.normal(0, 0.01, force_n.size)
    assert shift_of(taken_s + shift_s, motion, force_s, noisy_n) == pytest.approx(shift_s, abs=0.006)


def test_pins_that_do_not_move_tell_nothing():
    force_s = np.arange(0, 1.5, 1 / 200)
    with pytest.raises(RecordingError, match="pins that move with the force"):
        shift_of(np.arange(0, 1.3, 1 / 20), np.linspace(1, 0, 26), force_s, np.maximum(force_s - 0.5, 0))


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda path: None, "expected the folder of a run, or a rig file, but found neither"),
        (lambda path: path.mkdir(), "expected the plan of a run"),
        (lambda path: path.write_text("[rig]\nspeed = 1\n"), "rig.speed"),
    ],
)
def test_what_is_no_run_is_refused(tmp_path, capsys, make, said):
    make(tmp_path / "run")
    assert main(["rig", "camera-delay", str(tmp_path / "run")]) == 2
    assert said in capsys.readouterr().err


def test_too_few_presses(run, tmp_path):
    (tmp_path / "plan.json").write_text((run / "plan.json").read_text())
    (tmp_path / "press-001").symlink_to(run / "press-001")
    with pytest.raises(RecordingError, match=r"3 presses or more.*found 1"):
        measure_delay([tmp_path])


def test_runs_of_two_delays(run, tmp_path):
    (tmp_path / "plan.json").write_text('{"devices": {"camera": {"delay_s": 0.1}}}')
    with pytest.raises(RecordingError, match=r"one delay_s of all runs, but found 0 s, 0.1 s"):
        measure_delay([run, tmp_path])
