"""A session of 16 muscles at 2000 Hz and force at 200 Hz: samples lost, memory, processor, and time to a verdict.

Once with the clock on the wall, pages' views and the judge beside it as in a real session; and once in virtual time,
where each turn follows the last at once and presses are judged within the turn, until its time or a limit of time on
the wall is over. Both run beside each other, the second with a lower priority. The participant is emulated within the
same process; the share of its sensors is measured and told apart. The files are read back and compared with what the
sources handed over: number of samples, and their sum. The slope of the memory is that of a straight line through its
size every 10 s from the third minute on; its standard error takes each minute as one value, for neighbours are alike.
Run: python -m benchmarks.session_load
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import resource
import shutil
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

import numpy as np

from benchmarks.bench.record import keep

RESULT = Path(__file__).parent / "results" / "session_load.json"
MUSCLES = tuple(f"M{n:02d}" for n in range(1, 17))
EMG_HZ, FORCE_HZ = 2000.0, 200.0
SPECIMENS = tuple(f"S{n:02d}" for n in range(1, 41))


class Watched:
    """A source, with what it has handed over and the processor time that this took."""

    def __init__(self, source) -> None:  # type: ignore[no-untyped-def]
        self._source = source
        self.samples, self.total, self.seconds = 0, 0.0, 0.0

    def __getattr__(self, name):  # type: ignore[no-untyped-def]
        return getattr(self._source, name)

    def read(self):  # type: ignore[no-untyped-def]
        begun = time.thread_time()
        blocks = self._source.read()
        self.seconds += time.thread_time() - begun
        for block in blocks:
            self.samples += len(block.samples)
            self.total += float(block.samples.astype(np.float32).sum(dtype=np.float64))
        return blocks


def study_text() -> str:
    specimens = "".join(f'[[specimens]]\nname = "{name}"\nstiffness_n_per_mm = 3.35\n' for name in SPECIMENS)
    channels = "".join(f'[channels.emg.{name}]\nname = "{name}"\n' for name in MUSCLES)
    shares = ", ".join(f"{name} = {1 / len(MUSCLES)}" for name in MUSCLES)
    a_v, b_v = (", ".join(f"{name} = {value}" for name in SPECIMENS) for value in ("280e-6", "130e-6"))
    return f"""\
[study]
name = "load"
title = "A session of many muscles"
[participants]
ids = ["P01"]
{specimens}[recordings]
layout = "bids"
root = "data"
task = "press"
{channels}[channels.force]
name = "Fz"
[session]
emg.kind = "simulated"
force.kind = "simulated"
pause_s = 1.0
[simulation]
seed = 3
muscle_share = {{ {shares} }}
a_v = {{ {a_v} }}
b_v = {{ {b_v} }}
"""


def play(minutes: float, longest_s: float, at_once: bool) -> dict[str, str]:
    """A session until so many minutes have passed on its clock, or so many seconds on the wall."""
    from emg2vsa.devices.clock import Clock, VirtualClock, WallClock
    from emg2vsa.session.open_session import folder_of, open_session
    from emg2vsa.session.raw_files import SampleFile
    from emg2vsa.study_file import load_study
    from emg2vsa.worlds.people.pages import EmulatedOperator
    from emg2vsa.worlds.people.participant import EmulatedParticipant
    from emg2vsa.worlds.people.person import person_of
    from emg2vsa.worlds.people.sensors import simulated_emg, simulated_force

    if at_once and hasattr(os, "nice"):
        os.nice(10)
    clock: Clock = VirtualClock() if at_once else WallClock()
    work = Path(tempfile.mkdtemp())
    path = work / "study.toml"
    path.write_text(study_text(), encoding="utf-8")
    study = load_study(path)
    person = EmulatedParticipant(person_of(study, "P01"))
    emg = Watched(simulated_emg(person, MUSCLES, EMG_HZ, clock))
    force = Watched(simulated_force(person, clock, FORCE_HZ))
    memory: list[tuple[float, float]] = []
    lost = 0
    with open_session(study, "P01", clock, (lambda: emg, lambda: force), at_once=at_once) as desk:
        person.watch(desk)
        operator = EmulatedOperator(desk, person.place)
        begun, used, children = time.perf_counter(), time.process_time(), _children_s()

        def beside(now_s: float) -> None:
            operator.turn(now_s)
            desk.traces(0) if not at_once and int(now_s * 200) % 10 == 0 else None
            if not memory or now_s >= memory[-1][0] + 10:
                memory.append((now_s, _memory_mb()))
            if now_s >= 60 * minutes or time.perf_counter() - begun > longest_s:
                desk.session.end("ended", "the time is over")

        timing = _run(desk, clock, beside)
        session_s = desk.session.now_s
        wall_s, used_s = time.perf_counter() - begun, time.process_time() - used
        lost = desk.session.emg.lost_samples + desk.session.force.lost_samples
        presses = sum(bool(press.verdict) for press in desk.operator()[1].presses)
        delays = desk.session.verdict_delays_s
    children_s = _children_s() - children
    folder = folder_of(study, "P01")
    same = True
    for name, source in (("emg", emg), ("force", force)):
        file = SampleFile(folder / f"sitting-1_{name}.samples")
        total, read = 0.0, 0
        for first in range(0, file.stop, 500_000):
            piece = file.read(first, min(first + 500_000, file.stop))
            total, read = total + float(piece.sum()), read + len(piece)
        same &= read == source.samples and bool(np.isclose(total, source.total, rtol=1e-9, atol=1e-9))
    shutil.rmtree(work)
    settled = [(at_s, mb) for at_s, mb in memory if at_s >= 120] or memory
    sizes_mb = [mb for _, mb in settled]
    emulator_s = emg.seconds + force.seconds
    return {
        "minutes on its clock": f"{session_s / 60:.1f}",
        "seconds on the wall": f"{wall_s:.0f}",
        "samples of EMG x muscles": f"{emg.samples} x {len(MUSCLES)}",
        "samples of force": f"{force.samples}",
        "samples lost": f"{lost}",
        "files hold exactly what the sources handed over": "yes" if same else "NO",
        "presses judged": f"{presses}",
        "end of a press to its verdict, median / longest": f"{_quantile(delays, 0.5)} / {_quantile(delays, 1)} s",
        "memory after two minutes, smallest / largest": f"{min(sizes_mb):.0f} / {max(sizes_mb):.0f} MB",
        "slope of the memory then, with its standard error": _slope(settled),
        "processor, of one core, per second on its clock": f"{100 * (used_s - emulator_s) / session_s:.0f} %",
        "... of the emulated sensors, beside": f"{100 * emulator_s / session_s:.0f} %",
        "... of the judge's process": f"{100 * children_s / session_s:.0f} %" if not at_once else "(within)",
        "turns begun half a period late or more": f"{100 * timing.late / timing.turns:.2f} %" if not at_once else "-",
        "turn late, longest": f"{1e3 * timing.latest_s:.0f} ms" if not at_once else "-",
    }


def _run(desk, clock, beside: Callable[[float], None]):  # type: ignore[no-untyped-def]
    """As ``SessionDesk.run``, with the timing of its beat."""
    from contextlib import nullcontext

    from emg2vsa.devices.clock import VirtualClock, undisturbed

    with nullcontext() if isinstance(clock, VirtualClock) else undisturbed():
        return desk.run(clock, beside)


def _memory_mb() -> float:
    for line in Path("/proc/self/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS"):
            return int(line.split()[1]) / 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def _slope(memory: list[tuple[float, float]]) -> str:
    """Of the memory, MB an hour."""
    minutes = sorted({int(at_s // 60) for at_s, _ in memory})
    if len(minutes) < 4:
        return "-"
    at_h = np.array(minutes) / 60
    size_mb = np.array([np.mean([mb for at_s, mb in memory if int(at_s // 60) == minute]) for minute in minutes])
    about_h = at_h - at_h.mean()
    slope = float(about_h @ size_mb / (about_h @ about_h))
    left = size_mb - size_mb.mean() - slope * about_h
    error = float(np.sqrt(left @ left / (len(minutes) - 2) / (about_h @ about_h)))
    return f"{slope:+.1f} +- {error:.1f} MB an hour"


def _children_s() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def _quantile(values: list[float], share: float) -> str:
    return f"{float(np.quantile(values, share)):.2f}" if values else "-"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--real-minutes", type=float, default=10.0)
    parser.add_argument("--virtual-minutes", type=float, default=60.0)
    parser.add_argument("--virtual-seconds", type=float, default=3600.0, help="on the wall, at most")
    arguments = parser.parse_args()
    with ProcessPoolExecutor(2, mp_context=multiprocessing.get_context("spawn")) as pool:
        real_run = pool.submit(play, arguments.real_minutes, np.inf, False)
        virtual_run = pool.submit(play, arguments.virtual_minutes, arguments.virtual_seconds, True)
        real, virtual = real_run.result(), virtual_run.result()
    rows = "\n".join(f"| {name} | {value} | {virtual[name]} |" for name, value in real.items())
    head = " ".join((__doc__ or "").partition("Run:")[0].split())
    text = f"# The load of a session\n\n{head}\n\n| | on the wall | virtual |\n|---|---|---|\n{rows}\n"
    keep(RESULT, text)
    print(text)


if __name__ == "__main__":
    main()
