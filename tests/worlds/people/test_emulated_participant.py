"""The emulated participant obeys its page, does what was planned, and is what its truth says."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from emg2vsa.devices.clock import FastClock, VirtualClock
from emg2vsa.errors import SettingError
from emg2vsa.session.views import Command, ForceMessage, ParticipantState
from emg2vsa.study_file import load_study
from emg2vsa.worlds import VERSION
from emg2vsa.worlds.people.mistakes import parse_mistakes
from emg2vsa.worlds.people.participant import Affliction, EmulatedParticipant, TruePress
from emg2vsa.worlds.people.person import Person, Response, person_of
from emg2vsa.worlds.people.sensors import EmgSampler, SimulatedSource, felt_n, simulated_emg, simulated_force

PALPATION = Path(__file__).parents[3] / "studies" / "palpation" / "study.toml"
PERSON = Person(
    name="P03",
    responses={"S1": Response(42e-6, 20e-6, 7.63), "S5": Response(16e-6, 7e-6, 1.11)},
    muscle_share={"EDC": 0.4, "FDS": 0.6},
    seed=(7, 2),
)
FS_HZ = 2000.0


class Table:
    """A page that says START, and STOP at 7 N, turn by turn of 5 ms; and the samples that came."""

    def __init__(self, mistakes: Sequence[str] = (), person: Person = PERSON, specimen: str = "S1") -> None:
        self.clock = VirtualClock()
        self.person = EmulatedParticipant(person, mistakes=parse_mistakes(mistakes, person.muscle_share))
        self.person.watch(self)
        self.person.place(specimen)
        self.command: Command = "wait"
        self.phase: Literal["quality", "main"] = "main"
        self.press = 0
        self.emg: list[NDArray[np.float64]] = []
        self.force_samples: list[NDArray[np.float64]] = []
        self.sources = [
            simulated_emg(self.person, tuple(person.muscle_share), FS_HZ, self.clock),
            simulated_force(self.person, self.clock),
        ]
        for source in self.sources:
            source.start()

    def participant(self) -> ParticipantState:
        return ParticipantState(
            self.command, "", self.phase, self.press, 10, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en"
        )

    def force(self) -> ForceMessage:
        return ForceMessage(0, self.clock.now_s(), self.newest_n, "none", "", self.command)

    @property
    def newest_n(self) -> float:
        return float(self.force_samples[-1][-1, 0]) if self.force_samples else 0.0

    def turns(self, seconds: float, until_n: float = math.inf) -> None:
        end_s = self.clock.now_s() + seconds
        while self.clock.now_s() < end_s and self.newest_n < until_n:
            self.clock.sleep_until(self.clock.now_s() + 0.005)
            for source, samples in zip(self.sources, (self.emg, self.force_samples), strict=True):
                samples += [block.samples for block in source.read()]

    def one_press(self, stop_s: float = 3.0) -> TruePress:
        self.press += 1
        for command, seconds, until_n in (
            ("ready", 1.0, math.inf), ("start", 15.0, 7.0), ("stop", stop_s, math.inf), ("rest", 1.0, math.inf)
        ):  # fmt: skip
            self.command = command  # type: ignore[assignment]
            self.turns(seconds, until_n)
        return self.person.presses[-1]


def test_a_press_follows_the_commands_after_a_reaction() -> None:
    table = Table()
    press = table.one_press()
    assert len(table.person.presses) == 1
    assert 1.25 <= press.begun_s <= 1.36
    assert press.begun_s < press.onset_s < press.stop_s < press.lifted_s
    assert 1.5 < press.stop_s - press.onset_s < 4.0
    # a reaction to STOP at 2 to 3 N/s
    assert 7.4 < press.peak_force_n < 8.3
    assert (press.specimen, press.mistake, press.attempt) == ("S1", "", 1)


def test_truth_is_what_the_sensor_shows() -> None:
    table = Table()
    press = table.one_press()
    force_n = np.concatenate(table.force_samples)[:, 0]
    time_s = np.arange(len(force_n)) / 1000.0
    smooth = signal.sosfiltfilt(signal.butter(2, 20, fs=1000, output="sos"), force_n)
    above = np.flatnonzero(smooth >= 7.0)
    assert time_s[above[0]] == pytest.approx(press.stop_s, abs=0.02)
    assert smooth.max() == pytest.approx(press.peak_force_n, abs=0.05)
    rising = smooth[(time_s > press.onset_s) & (time_s < press.stop_s)]
    assert np.max(np.maximum.accumulate(rising) - rising) < 0.15


@pytest.mark.parametrize(
    ("mistake", "wrong"),
    [
        ("too-fast", lambda p: p.stop_s - p.onset_s < 1.0),
        ("too-slow", lambda p: p.stop_s - p.onset_s > 5.0),
        ("aborted", lambda p: math.isnan(p.stop_s) and 3.9 < p.peak_force_n < 4.3),
        ("overshoot", lambda p: p.peak_force_n > 9.0),
        ("never-lifts", lambda p: p.lifted_s - p.stop_s > 5.0),
        ("early", lambda p: p.begun_s < 1.0),
    ],
)
def test_mistakes_of_the_hand(mistake: str, wrong: object) -> None:
    table = Table([f"{mistake}@1"])
    press = table.one_press(9.0 if mistake == "never-lifts" else 3.0)
    assert press.mistake == mistake
    assert wrong(press)  # type: ignore[operator]
    table.press -= 1
    again = table.one_press()
    assert (again.press, again.attempt, again.mistake) == (1, 2, "")
    assert 1.5 < again.stop_s - again.onset_s < 4.0


def test_a_mistake_waits_for_its_press_to_begin() -> None:
    table = Table(["aborted@1"])
    table.press = 1
    for command in ("ready", "rest", "ready", "wait"):
        table.command = command  # type: ignore[assignment]
        table.turns(0.5)
    table.press = 0
    assert table.one_press().mistake == "aborted"


def test_a_dip_is_a_fall_of_about_a_newton() -> None:
    table = Table(["dips@1"])
    press = table.one_press()
    force_n = table.person.force_n(np.arange(press.onset_s, press.stop_s, 0.005))
    assert 0.9 < np.max(np.maximum.accumulate(force_n) - force_n) < 1.2


def test_mistakes_of_sensors_last_for_one_press() -> None:
    table = Table(["electrode-off:FDS@1", "clipping@2", "mains@3", "sensor-offset@4"])
    for _ in range(5):
        table.one_press()
    emg_v, force_n = np.concatenate(table.emg), np.concatenate(table.force_samples)[:, 0]
    spans = [(wrong.kind, wrong.start_s, wrong.end_s) for wrong in table.person.afflictions]
    assert [kind for kind, _, _ in spans] == ["electrode-off", "clipping", "mains", "sensor-offset"]

    def during(kind: str, samples: NDArray[np.float64], fs_hz: float) -> NDArray[np.float64]:
        start_s, end_s = next(span[1:] for span in spans if span[0] == kind)
        return samples[int(start_s * fs_hz) + 1 : int(end_s * fs_hz)]

    off = during("electrode-off", emg_v, FS_HZ)
    assert np.sqrt(np.mean(off**2, axis=0))[1] == pytest.approx(1.5e-3, rel=0.02)
    assert np.sqrt(np.mean(off[:1000] ** 2, axis=0))[0] < 20e-6
    assert np.mean(np.abs(during("clipping", emg_v, FS_HZ)) == 11e-3) > 0.02
    hum, frequency = during("mains", emg_v, FS_HZ), 50.0
    time_s = np.arange(len(hum)) / FS_HZ
    amplitude = np.abs(np.exp(-2j * np.pi * frequency * time_s) @ hum) * 2 / len(hum)
    assert np.all(amplitude > 25e-6)
    assert np.mean(during("sensor-offset", force_n, 1000.0)[:800]) == pytest.approx(0.25, abs=0.01)
    assert np.mean(force_n[-500:]) == pytest.approx(0.0, abs=0.01)


def test_a_maximum_contraction_lifts_no_force() -> None:
    table = Table()
    table.turns(1.0)
    rest = np.concatenate(table.emg)
    table.phase, table.command = "quality", "start"
    table.turns(3.0)
    pulling = np.concatenate(table.emg)[len(rest) + 2000 :]
    assert np.abs(pulling).mean(axis=0).sum() == pytest.approx(PERSON.contraction_v, rel=0.05)
    assert np.abs(rest).mean() < 0.05 * np.abs(pulling).mean()
    assert table.person.cocontraction_v(np.array([3.5, 3.9])) == pytest.approx([PERSON.contraction_v] * 2)
    assert not table.person.presses
    assert np.concatenate(table.force_samples).max() < 0.2
    table.command = "wait"
    table.turns(2.0)
    assert np.abs(table.emg[-1]).mean() < 0.1 * np.abs(pulling).mean()


def test_the_same_seed_gives_the_same_samples_however_they_are_taken() -> None:
    def taken(sizes: list[int]) -> NDArray[np.float64]:
        person = EmulatedParticipant(PERSON)
        sampler = EmgSampler(person, ("EDC", "FDS", "none"), FS_HZ)
        return np.concatenate([sampler.take(n) for n in sizes])

    once = taken([2700])
    assert np.array_equal(once, taken([27] * 100))
    assert np.abs(once[:, 2]).max() < 20e-6


def test_a_sensor_is_wrong_between_its_times_within_one_block() -> None:
    person = EmulatedParticipant(PERSON)
    person.afflictions += [Affliction("electrode-off", "EDC", 0.5, 1.0), Affliction("sensor-offset", "", 0.5, 1.0)]
    lifted = np.abs(EmgSampler(person, ("EDC", "FDS"), FS_HZ).take(3000)) > 100e-6
    assert np.flatnonzero(lifted.any(axis=1))[[0, -1]] == pytest.approx([1000, 1999], abs=3)
    assert not lifted[:, 1].any()
    assert felt_n(person, np.array([0.49, 0.5, 0.99, 1.0])).tolist() == [0.0, 0.25, 0.25, 0.0]


def test_two_sessions_of_one_seed_are_one() -> None:
    first, second = Table(["dips@1"]), Table(["dips@1"])
    assert first.one_press() == second.one_press()
    assert np.array_equal(np.concatenate(first.emg), np.concatenate(second.emg))


def test_emg_holds_a_and_b() -> None:
    table = Table(specimen="S5")
    presses = [table.one_press() for _ in range(6)]
    # independent of the package's estimator: mean rectified EMG of slices of time against ln F
    emg_v = np.abs(np.concatenate(table.emg)).sum(axis=1)
    slopes = []
    for press in presses:
        times_s = np.arange(press.onset_s, press.stop_s - 0.1, 0.1)
        level = [emg_v[int(t * FS_HZ) : int((t + 0.1) * FS_HZ)].mean() for t in times_s]
        log_n = np.log(table.person.force_n(times_s + 0.05))
        slopes.append(np.polyfit(log_n, level, 1)[0] - press.b_v)
    assert abs(np.mean(slopes)) < 3 * np.std(slopes) / math.sqrt(len(slopes))
    assert np.mean([press.b_v for press in presses]) == pytest.approx(7e-6, rel=0.06)


def test_electromechanical_delay_lets_the_force_come_later() -> None:
    late = replace(PERSON, electromechanical_delay_s=0.05)
    times_s = np.arange(0, 4, 0.005)
    forces = []
    for person in (PERSON, late):
        table = Table(person=person)
        table.one_press()
        forces.append(table.person.force_n(times_s))
    # STOP comes later by the delay too: only the way up is the same
    up = (times_s > 1.7) & (times_s < 3.0)
    assert forces[1][up] == pytest.approx(np.interp(times_s[up] - 0.05, times_s, forces[0]), abs=1e-9)


def test_truth_is_written_as_json(tmp_path: Path) -> None:
    table = Table(["aborted@1"])
    table.one_press()
    table.person.write_truth(tmp_path / "truth.json")
    truth = json.loads((tmp_path / "truth.json").read_text())
    assert truth["specimens"]["S5"]["b_v"] == 7e-6
    assert truth["world"] == VERSION
    assert truth["presses"][0]["mistake"] == "aborted"
    assert truth["presses"][0]["stop_s"] is None


def test_simulated_sources_lose_nothing_and_keep_their_rate() -> None:
    table = Table()
    table.turns(10.0)
    emg, force = table.sources
    assert isinstance(emg, SimulatedSource)
    assert (emg.counts().samples, force.counts().samples) == (20_000, 10_000)
    assert (emg.info.unit, emg.info.channels, force.info.unit) == ("V", ("EDC", "FDS"), "N")


def test_the_participant_of_a_study_is_that_of_simulate() -> None:
    study = load_study(PALPATION)
    person = person_of(study, "P07")
    assert person.responses["S3"] == Response(28e-6, 13e-6, 3.35)
    assert PERSON.usual == pytest.approx((29e-6, 13.5e-6, 3.0))
    with pytest.raises(SettingError, match=r"P99.*P01, P02"):
        person_of(study, "P99")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("dips", "KIND"),
        ("falls@3", "KIND one of too-fast"),
        ("dips@0", "numbers of presses from 1"),
        ("dips@5-3", "in rising order"),
        ("electrode-off:biceps@3", "one of EDC, FDS"),
        ("dips:FDS@3", "only for electrode-off"),
    ],
)
def test_words_that_are_no_mistake(words: str, said: str) -> None:
    with pytest.raises(SettingError, match=said):
        parse_mistakes([words], PERSON.muscle_share)


def test_mistakes_of_several_presses() -> None:
    mistakes = parse_mistakes(["electrode-off:FDS@21-23", "early@training-2"], PERSON.muscle_share)
    assert [(m.kind, m.press, m.phase) for m in mistakes] == [
        ("electrode-off", 21, "main"), ("electrode-off", 22, "main"), ("electrode-off", 23, "main"),
        ("early", 2, "training"),
    ]  # fmt: skip


def test_a_fast_clock_runs_faster() -> None:
    begun_s = time.perf_counter()
    clock = FastClock(20.0)
    clock.sleep_until(1.0)
    now_s = clock.now_s()
    assert 1.0 <= now_s <= 20.0 * (time.perf_counter() - begun_s)
