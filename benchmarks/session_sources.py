"""Times of samples against the truth of simulated devices, and whole streams from emulated devices in another process.

Run with ``python -m benchmarks.session_sources [--tries N] [--minutes M]``.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import time
from collections.abc import Iterable
from itertools import pairwise
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import WallClock, undisturbed
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.streams import Source
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.session.open_session import source_makers
from emg2vsa.session.sample_clock import SampleClock
from emg2vsa.session_settings import SessionSettings

FRAME_HZ = 1 / 0.0135
POLL_S = 0.005
DELAY_S = 0.002
MODE, MODE_HZ = 134, 32 * FRAME_HZ
"Of the emulated sensors: 2370 Hz."
FORCE_HZ = 200.0
TURN_S = 0.005


def arrivals(
    seed: int,
    duration_s: float,
    fs_hz: float,
    *,
    frame: int = 26,
    jitter_s: float = 1e-3,
    busy: Iterable[tuple[float, float]] = (),
    lost: Iterable[tuple[float, float]] = (),
    wander: float = 0.0,
) -> tuple[list[tuple[int, int, float]], NDArray[np.float64]]:
    """Blocks (first, n, arrived_s), and (index, true time) of the last sample of each.

    Samples are sent in frames, delayed by ``DELAY_S`` and an exponential jitter, in order, and read by a program that
    looks every 5 ms. busy, lost : (start, length), s, in which it does not look; of frames that never come. wander :
    how far the device's clock, which keeps its rate in the mean, is off in the middle.
    """
    rng = np.random.default_rng(seed)
    ends = np.arange(1, int(duration_s * fs_hz / frame) + 1) * frame - 1
    true_s = ends / fs_hz
    true_s = true_s + wander * np.sin(np.pi * true_s / duration_s)
    sent_s = np.maximum.accumulate(true_s + DELAY_S + rng.exponential(jitter_s, len(ends)))
    looks_s = np.arange(0, duration_s + 5, POLL_S)
    looks_s = looks_s + np.abs(rng.normal(0, 2e-4, len(looks_s)))
    for start_s, length_s in busy:
        looks_s[(looks_s > start_s) & (looks_s < start_s + length_s)] = start_s + length_s
    looks_s = np.unique(looks_s)
    came = np.ones(len(ends), dtype=bool)
    for start_s, length_s in lost:
        came &= (true_s <= start_s) | (true_s > start_s + length_s)
    look = np.searchsorted(looks_s, sent_s)[came]
    starts = np.flatnonzero(np.diff(look, prepend=-1))
    blocks = [
        (int(a * frame), int((b - a) * frame), float(looks_s[look[a]])) for a, b in pairwise([*starts, len(look)])
    ]
    last = np.array([*starts[1:], len(look)]) - 1
    return blocks, np.column_stack([(last + 1) * frame - 1, true_s[came][last]])


SCENES: dict[str, dict[str, object]] = {
    "bursts of 13.5 ms, jitter 1 ms": {},
    "and jitter 5 ms": {"jitter_s": 5e-3},
    "and a computer busy for 300 ms, ten times": {"busy": [(6.0 * n, 0.3) for n in range(1, 11)]},
    "and 80 ppm of drift": {"ppm": 80.0},
    "and a clock that wanders by 1 ms": {"wander": 1e-3},
    "a frame lost": {"lost": [(31.0, 1 / FRAME_HZ)]},
    "five times three frames lost": {"lost": [(10.0 * n, 3 / FRAME_HZ) for n in range(1, 6)]},
    "0.5 s lost after 1 s": {"lost": [(1.0, 37 / FRAME_HZ)]},
    "26 samples stated as 27": {"stated": 27},
}


def clocks(tries: int, duration_s: float = 70.0) -> None:
    """A line for each scene: time errors outside of the first 3 s, and what was said of the stream."""
    print(f"Times of samples, {tries} streams of {duration_s:g} s each\n")
    print(
        f"{'':<44}{'largest error, ms':>18}{'stated se':>11}{'rate, ppm':>11}{'stated se':>11}{'lost':>7}{'found':>9}"
    )
    for name, scene in SCENES.items():
        options = dict(scene)
        fs_hz = 26 * FRAME_HZ * (1 + 1e-6 * float(str(options.pop("ppm", 0.0))))
        stated_hz = float(str(options.pop("stated", 26))) * FRAME_HZ
        worst, se_s, rates, rate_ses, found = [], [], [], [], []
        lost = sum(round(length_s * FRAME_HZ) * 26 for _, length_s in options.get("lost", ()))  # type: ignore[attr-defined]
        for seed in range(tries):
            blocks, truth = arrivals(seed, duration_s, fs_hz, **options)  # type: ignore[arg-type]
            clock = SampleClock(stated_hz, quantum=26)
            for block in blocks:
                clock.add(*block)
            report = clock.report()
            errors_s = clock.time_s(truth[:, 0].astype(np.int64)) - truth[:, 1] - DELAY_S
            worst.append(np.abs(errors_s[truth[:, 1] > 3.0]).max())
            se_s.append(report.se_s)
            rates.append(1e6 * ((report.rate_hz or np.nan) / fs_hz - 1))
            rate_ses.append(1e6 * (report.rate_se_hz or np.nan) / fs_hz)
            found.append(report.missing)
        right = sum(each == lost for each in found)
        print(
            f"{name:<44}{1e3 * max(worst):>18.2f}{1e3 * float(np.mean(se_s)):>11.2f}"
            f"{float(np.sqrt(np.mean(np.square(rates)))):>11.2f}{float(np.mean(rate_ses)):>11.2f}"
            f"{lost:>7}{f'{right}/{tries}':>9}"
        )
    print("\nlost: samples that never came and that nobody told. Found: streams in which exactly these were counted.\n")


def serve(pipe: Connection) -> None:
    """The emulated devices: 16 sensors and a box, until the pipe says so."""
    from emg2vsa.worlds.far_ends.netft_server import RdtServer
    from emg2vsa.worlds.far_ends.serve import force_box
    from emg2vsa.worlds.far_ends.trigno_server import TrignoServer
    from emg2vsa.worlds.people.participant import EmulatedParticipant
    from emg2vsa.worlds.people.person import Person, Response

    clock = WallClock()
    slots = {slot: f"M{slot}" for slot in range(1, 17)}
    shares = dict.fromkeys(slots.values(), 1 / 16)
    person = EmulatedParticipant(Person(name="P1", responses={"S1": Response(4e-5, 2e-5, 7.6)}, muscle_share=shares))
    box = force_box(person, (0.0, 0.0, -1.0), FORCE_HZ)
    with TrignoServer(person, slots, clock, start_delay_s=0.3) as server, RdtServer(box, clock) as rdt:
        for sensor in server.base.sensors.values():
            sensor.mode = MODE
        pipe.send((server.ports.command, server.ports.emg, rdt.host, rdt.rdt_port, rdt.http_port))
        pipe.recv()
        times = os.times()
        pipe.send((times.user + times.system, server.lost_frames))


def streams(minutes: float) -> None:
    """A line for each stream: samples wanted, come, lost; and what it cost."""
    here, there = multiprocessing.Pipe()
    process = multiprocessing.get_context("spawn").Process(target=serve, args=(there,))
    process.start()
    command_port, emg_port, host, rdt_port, http_port = here.recv()
    channels = {f"M{slot}": str(slot) for slot in range(1, 17)}
    settings = SessionSettings(
        emg=TrignoSettings(channels=channels, command_port=command_port, emg_port=emg_port),
        force=RigForceSettings(rig="-"),
    )
    box = NetFtSettings(host=host, rdt_port=rdt_port, http_port=http_port)
    clock = WallClock()
    sources = [make() for make in source_makers(settings, tuple(channels), clock, rig_force=box)]
    with undisturbed() as real_time:
        for source in sources:
            source.start()
        lines, cpu, memory_mb = _listen(sources, clock, 60 * minutes)
    for source in sources:
        source.close()
    here.send("end")
    emulator_s, frames = here.recv()
    process.join()
    scheduling = "real-time" if real_time else "ordinary"
    print(f"Streams of {minutes:g} minutes, {scheduling} scheduling, load average {os.getloadavg()[0]:.1f}\n")
    print("\n".join(lines))
    print(f"frames that the emulated server could not send: {frames}")
    print(f"processor: this program {cpu:.0%} of a core, emulators {emulator_s / (60 * minutes):.0%}")
    print(f"memory: {memory_mb[0]:.1f} MB after 10 s, {memory_mb[1]:.1f} MB at the end")


def _listen(sources: list[Source], clock: WallClock, seconds: float) -> tuple[list[str], float, tuple[float, float]]:
    clocks = [SampleClock(each.info.fs_hz, quantum=each.info.frame) for each in sources]
    came = [0] * len(sources)
    begin_s, cpu_s = clock.now_s(), time.process_time()
    turn_s, memory_mb = begin_s, 0.0
    while turn_s < begin_s + seconds:
        turn_s += TURN_S
        clock.sleep_until(turn_s)
        if not memory_mb and turn_s > begin_s + min(10.0, seconds / 2):
            memory_mb = _memory_mb()
        for k, source in enumerate(sources):
            for block in source.read():
                clocks[k].add(block.first, len(block.samples), block.arrived_s)
                came[k] += len(block.samples)
    spent = (time.process_time() - cpu_s) / seconds
    lines = [
        f"{'':<8}{'channels':>9}{'rate, Hz':>10}{'measured':>11}{'se':>9}{'come':>10}{'lost':>6}{'gaps':>6}"
        f"{'longest, ms':>13}"
    ]
    for source, times, n in zip(sources, clocks, came, strict=True):
        info, report = source.info, times.report()
        lost = source.counts().lost + report.missing
        lines.append(
            f"{info.kind:<8}{len(info.channels):>9}{info.fs_hz:>10.2f}{report.rate_hz or 0:>11.3f}"
            f"{report.rate_se_hz or 0:>9.4f}{n:>10}{lost:>6}{report.gaps:>6}{1e3 * report.longest_gap_s:>13.0f}"
        )
    return lines, spent, (memory_mb, _memory_mb())


def _memory_mb() -> float:
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def main() -> None:
    """Both tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--tries", type=int, default=50)
    parser.add_argument("--minutes", type=float, default=2.0)
    arguments = parser.parse_args()
    clocks(arguments.tries)
    streams(arguments.minutes)


if __name__ == "__main__":
    main()
