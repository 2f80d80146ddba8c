"""What a recording costs from its samples to its fits, part by part, against another revision; and the memory of an
hour of it.

``python -m benchmarks.record_to_fit [REVISION]``, kept by ``benchmarks.bench.record``: some minutes; REVISION is the
commit before this one where none is given, and may lack parts. Processor time of one thread: a process of each revision
answers in turn, round by round. Memory (Linux) is that of the whole tree of processes, the one that decodes files too,
sampled every two milliseconds; it counts pages that both share twice.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from benchmarks.bench.child import SOURCE
from benchmarks.bench.compare import product_of
from benchmarks.bench.measure import machine, one_thread_environment, revision
from benchmarks.bench.tables import table
from benchmarks.laboratory import Laboratory, simulate_session
from emg2vsa.errors import DataError
from emg2vsa.recordings import Channel
from emg2vsa.settings import (
    ChannelSettings,
    CocontractionSettings,
    EmgChannelSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    WindowSettings,
)

FloatArray = NDArray[np.float64]

ROUNDS, CALLS = 30, 4
"Rounds of both revisions, and calls of each in a round."
MUSCLES = ("EDC", "FDS")
CLEAN = Laboratory()
BIT_V, BIT_N = 10e-3 / 2**16, 40 / 2**16
RECORDS: dict[str, tuple[Laboratory, bool]] = {
    "as simulated": (CLEAN, False),
    "stored in 16 bits": (CLEAN, True),
    "16 bits, hum 5 uV at rest and 10 uV at the touch": (replace(CLEAN, hum_v=5e-6, touch_hum_v=10e-6), True),
    "16 bits, artefacts 150 uV at contact": (replace(CLEAN, artefact_v=150e-6), True),
}
SHOWN = "stored in 16 bits"
"The record whose parts are shown."
PARTS: dict[str, tuple[str, ...]] = {
    "force: filter, rests, presses": ("_conditioned",),
    "hum": ("remove_hum", "remove_touch_hum", "touch_hum"),
    "gaps and spikes": ("bridge",),
    "movement": ("movement",),
    "lag": ("estimate_lag",),
    "envelopes": ("Chain.envelopes",),
    "rest level": ("press_levels", "subtract_floor", "floor_change", "rests_differ", "_rests_differ"),
    "quality of raw samples": ("record_qualities",),
    "plausibility": ("plausibility",),
    "overview": ("emg_overview",),
    "traits": ("traits_of",),
}
"Part to functions that the modules of ``emg2vsa.extraction`` use."
READ, FIT, OTHER, WHOLE = "reading the file", "fits", "all else", "whole"
HOUR_S, HOUR_HZ, HOUR_CHANNELS, HOUR_PRESSES = 3600, 2000, 17, 640
HOURS = {"without hum": 0.0, "hum 5 uV": 5e-6}
SAMPLED_S = 0.002


def in_turn(pairs: int, *ways: Callable[[], Any]) -> Iterator[list[Any]]:
    """What each way gives, round by round; every other round in the opposite order."""
    for turn in range(pairs):
        order = range(len(ways)) if turn % 2 == 0 else reversed(range(len(ways)))
        given = {number: ways[number]() for number in order}
        yield [given[number] for number in range(len(ways))]


class Answering:
    """A process of one revision that times a record by its name."""

    def __init__(self, product: Path | None) -> None:
        self._process = started(product, "times")

    def times_ms(self, name: str) -> dict[str, float]:
        """Part to milliseconds."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write(name + "\n")
        self._process.stdin.flush()
        line = self._process.stdout.readline()
        if not line:
            raise DataError("the process that times", wanted="an answer", found="none", do="See what it says above.")
        found: dict[str, float] = json.loads(line)
        return found

    def end(self) -> None:
        self._process.communicate()


def started(product: Path | None, *words: str) -> subprocess.Popen[str]:
    """This module in a process of its own, with the packages of another revision where ``product`` names them."""
    environment = one_thread_environment()
    environment["PYTHONPATH"] = os.pathsep.join(str(folder) for folder in (product, SOURCE) if folder)
    command = [sys.executable, "-P", "-W", "ignore", "-m", "benchmarks.record_to_fit", "--child", *words]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=environment)


def watched(note: Callable[[str], None], clock: Callable[[], float]) -> dict[str, float]:
    """Seconds by part, that grow as the wrapped functions run; ``note`` is told of the part that begins."""
    from emg2vsa.extraction import extract

    modules = {module for name, module in sys.modules.items() if name.startswith("emg2vsa.extraction.")}
    spent = dict.fromkeys(PARTS, 0.0)

    def wrapped(part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        def run(*given: Any, **named: Any) -> Any:
            note(part)
            begin = clock()
            found = function(*given, **named)
            spent[part] += clock() - begin
            note(OTHER)
            return found

        return run

    for part, names in PARTS.items():
        for name in names:
            *owner, last = name.split(".")
            for where in {getattr(extract, owner[0])} if owner else modules:
                if hasattr(where, last):  # the other revision may not have it
                    setattr(where, last, wrapped(part, getattr(where, last)))
    return spent


def answer_times() -> None:
    """The child that times: a name a line, an answer a line."""
    from emg2vsa.extraction import extract
    from emg2vsa.fits import fit_trials

    records = {name: channels_of(*record) for name, record in RECORDS.items()}
    spent = watched(lambda part: None, time.process_time)
    for line in sys.stdin:
        emg, force = records[line.strip()]
        for part in spent:
            spent[part] = 0.0
        begin, fitting = time.process_time(), 0.0
        for _ in range(CALLS):
            trials = extract.extract_trials(
                emg, force, participant="P", specimen="S", filters=FilterSettings(),
                cocontraction=CocontractionSettings(), window=WindowSettings(),
                force_channel=ForceChannelSettings(name="Fz"),
            )  # fmt: skip
            fit_begin = time.process_time()
            fit_trials(trials, FitSettings(), WindowSettings())
            fitting += time.process_time() - fit_begin
        whole = time.process_time() - begin
        found = {**spent, FIT: fitting, OTHER: whole - sum(spent.values()) - fitting, WHOLE: whole}
        print(json.dumps({part: 1e3 * seconds / CALLS for part, seconds in found.items()}), flush=True)


def channels_of(laboratory: Laboratory, stored: bool) -> tuple[dict[str, Channel], Channel]:
    """EMG by muscle, and force; ``stored``: in steps of a converter."""
    session = simulate_session(laboratory, 1)
    emg_v, force_n = session.emg_v, session.force_n
    if stored:
        emg_v, force_n = np.round(emg_v / BIT_V) * BIT_V, np.round(force_n / BIT_N) * BIT_N
    emg = {
        muscle: Channel(muscle, row, "V", laboratory.fs_hz, 0.0, "V")
        for muscle, row in zip(MUSCLES, emg_v, strict=True)
    }
    return emg, Channel("Fz", force_n, "N", laboratory.force_fs_hz, 0.0, "N")


def write_hour(path: Path, hum_v: float) -> None:
    """An EDF of seventeen channels, of which three are used; the others hold noise."""
    import edfio

    laboratory = replace(CLEAN, presses=HOUR_PRESSES, fs_hz=HOUR_HZ, force_fs_hz=HOUR_HZ, hum_v=hum_v)
    session = simulate_session(laboratory, 1)
    n, rng = HOUR_S * HOUR_HZ, np.random.default_rng(0)

    def whole(samples: FloatArray) -> FloatArray:
        return np.pad(samples, (0, max(0, n - samples.size)), mode="edge")[:n]

    rows = [(muscle, "uV", 2000.0, 1e6 * whole(x)) for muscle, x in zip(MUSCLES, session.emg_v, strict=True)]
    rows.append(("Fz", "N", 20.0, whole(session.force_n)))
    rows += [(f"other {k}", "uV", 100.0, rng.standard_normal(n)) for k in range(HOUR_CHANNELS - len(rows))]
    edfio.Edf(
        [
            edfio.EdfSignal(x, HOUR_HZ, label=label, physical_dimension=unit, physical_range=(-top, top))
            for label, unit, top, x in rows
        ]
    ).write(path)


def read_and_fit(path: Path) -> None:
    """The child whose memory is sampled: it prints what it does."""
    from emg2vsa.fits import fit_trials
    from emg2vsa.pipeline.stages.trials import trials_of

    def note(part: str) -> None:
        print(part, flush=True)

    watched(note, time.perf_counter)
    note(READ)
    trials = trials_of(
        path, None, "P", "S",
        channels=ChannelSettings(
            emg={muscle: EmgChannelSettings(name=muscle) for muscle in MUSCLES}, force=ForceChannelSettings(name="Fz")
        ),
        filters=FilterSettings(), window=WindowSettings(), cocontraction=CocontractionSettings(),
    )  # fmt: skip
    note(FIT)
    fit_trials(trials, FitSettings(), WindowSettings())


def peaks_mb(path: Path, product: Path | None) -> dict[str, float]:
    """Part to the most memory of the tree of processes while it ran."""
    peaks: dict[str, float] = {}
    with started(product, "memory", str(path)) as child:
        assert child.stdout is not None
        os.set_blocking(child.stdout.fileno(), False)
        part = ""
        while child.poll() is None:
            with contextlib.suppress(TypeError, OSError):  # nothing new
                part = ([part, *child.stdout.read().split("\n")[:-1]])[-1]
            peaks[part] = max(peaks.get(part, 0.0), sum(map(resident_mb, tree(child.pid))))
            time.sleep(SAMPLED_S)
        if child.returncode:
            raise DataError(
                "the process that reads", wanted="fits", found=f"exit status {child.returncode}",
                do="See what it says above.",
            )  # fmt: skip
    return {**peaks, WHOLE: max(peaks.values())}


def tree(pid: int) -> list[int]:
    """A process and all below it."""
    try:
        below = Path(f"/proc/{pid}/task/{pid}/children").read_text().split()
    except OSError:
        return []
    return [pid, *(each for child in below for each in tree(int(child)))]


def resident_mb(pid: int) -> float:
    try:
        pages = int(Path(f"/proc/{pid}/statm").read_text().split()[1])
    except (OSError, IndexError):
        return 0.0
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


def timed(other: Path) -> Iterator[str]:
    """Both tables of processor time."""
    there, here = Answering(other), Answering(None)
    rounds: dict[str, list[list[dict[str, float]]]] = {name: [] for name in RECORDS}
    for name in RECORDS:
        for way in (there, here):
            way.times_ms(name)
    for turn in in_turn(
        ROUNDS, *(lambda way=way: {name: way.times_ms(name) for name in RECORDS} for way in (there, here))
    ):
        for name, found in rounds.items():
            found.append([each[name] for each in turn])
    for way in (there, here):
        way.end()
    head = ("", "there, ms", "here, ms", "here / there (5 to 95 % of the rounds)")
    yield from table(("record", *head[1:]), [_row(name, found, WHOLE) for name, found in rounds.items()])
    yield f"\n## Parts of the record {SHOWN}\n"
    yield from table(("part", *head[1:]), [_row(part, rounds[SHOWN], part) for part in rounds[SHOWN][0][0]])


def _row(label: str, rounds: Sequence[Sequence[dict[str, float]]], part: str) -> list[str]:
    there, here = np.array([[each[part] for each in turn] for turn in rounds]).T
    row = [label, f"{np.median(there):.2f}", f"{np.median(here):.2f}"]
    if not there.all():
        return [*row, "not there"]
    low, middle, high = np.quantile(here / there, (0.05, 0.5, 0.95))
    return [*row, f"{middle:.2f} ({low:.2f} to {high:.2f})"]


def remembered(other: Path) -> Iterator[str]:
    """The table of memory."""
    found: dict[tuple[str, str], dict[str, float]] = {}
    with TemporaryDirectory(prefix="emg2vsa-hour-") as folder:
        path = Path(folder) / "hour.edf"
        for name, hum_v in HOURS.items():
            write_hour(path, hum_v)
            found |= {(name, "there"): peaks_mb(path, other), (name, "here"): peaks_mb(path, None)}
    parts = [READ, *PARTS, FIT, OTHER, WHOLE]
    rows = [[part, *(f"{peaks[part]:.0f}" if part in peaks else "" for peaks in found.values())] for part in parts]
    yield from table(("peak, MB", *(f"{name}: {where}" for name, where in found)), rows)


def page(asked: str) -> Iterator[str]:
    about = machine()
    with product_of(asked) as other:
        yield "# From a record to its fits\n"
        yield f"`python -m benchmarks.record_to_fit {asked}`: {asked} is `there`, {revision()} `here`. Python"
        yield f"{about['python']}, NumPy {about['libraries']['numpy']}, {about['processor']}, load {about['load']}.\n"
        yield "Ten presses in a minute, two muscles, 1000 Hz. Processor time, one thread; medians of"
        yield f"{ROUNDS} rounds in turn.\n"
        yield from timed(other)
        if sys.platform == "linux":
            yield "\n## Memory of an hour\n"
            yield f"{HOUR_CHANNELS} channels at {HOUR_HZ} Hz in one EDF of 245 MB, three of them used, {HOUR_PRESSES}"
            yield "presses; the process and the one that decodes together, by what ran. The samples of the three"
            yield "channels take 173 MB.\n"
            yield from remembered(other)


def main() -> None:
    match sys.argv[1:]:
        case ["--child", "times"]:
            answer_times()
        case ["--child", "memory", path]:
            read_and_fit(Path(path))
        case given:
            for line in page(given[0] if given else "HEAD~1"):
                print(line, flush=True)


if __name__ == "__main__":
    main()
