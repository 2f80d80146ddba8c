"""What a loss of power leaves of a session: every order in which a disk may have kept what it was given.

Run as ``python -m benchmarks.session_power_loss [--cuts 4000] [--seed 1]``; it prints a Markdown table. A session of
six presses is recorded, and every call that it makes of the operating system is written down: open, write, truncate,
fsync, rename. The power is cut after a random call, or within it. What was synced before is on the disk. Of the writes
since a file's last fsync each sector of 512 bytes is kept, lost (as zeros, or as the file's end), or kept while earlier
ones are lost, at random: all of them, none, or each by itself (as in ALICE, Pillai et al., OSDI 2014). A new name that
was not synced may be gone. The session is then resumed as ``emg2vsa session --resume`` does.

Rules: ``kill`` keeps everything that was written (kill -9); ``torn`` keeps the writes of a file up to one of them, or
within it; ``any`` keeps any of them. Lost is a press whose verdict is not there. A fault is anything else: a line or a
sample gone that a later line of the journal stands behind, a file that cannot be read, a press counted wrongly.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import random
import shutil
import tempfile
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple
from unittest import mock

import numpy as np

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.streams import Block, StreamInfo
from emg2vsa.durable.system import OperatingSystem
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Begun,
    Interrupted,
    Judged,
    Line,
    PressBegun,
    PressEnded,
    Told,
    read_journal,
)
from emg2vsa.session.journal import line_bytes as journal_line
from emg2vsa.session.plan import PLAN_FILE, Plan, draw_presses
from emg2vsa.session.presses import folded
from emg2vsa.session.raw_files import SampleFile
from emg2vsa.session.record import SessionRecord, new_session, resume_session
from emg2vsa.session_settings import SessionSettings

SECTOR = 512
RULES = ("torn", "kill", "any")
SETTINGS = SessionSettings(emg=SimulatedEmgSettings(), force=SimulatedForceSettings(), repetitions=2)
EMG = StreamInfo("emg", ("EDC", "FDS"), "V", 200.0)
FORCE = StreamInfo("force", ("force",), "N", 100.0)


class Call(NamedTuple):
    """One call of the operating system. kind : "open", "write", "truncate", "sync" or "rename"."""

    kind: str
    name: str
    offset: int = 0
    content: bytes = b""
    to: str = ""


@dataclass
class WritingDown(OperatingSystem):
    """The operating system without its fsyncs, and every call of it."""

    calls: list[Call] = field(default_factory=list)
    names: dict[int, str] = field(default_factory=dict)

    def open(self, path: Path) -> int:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
        self.names[handle] = path.name
        self.calls.append(Call("open", path.name))
        return handle

    def write(self, handle: int, offset: int, piece: bytes) -> None:
        super().write(handle, offset, piece)
        self.calls.append(Call("write", self.names[handle], offset, piece))

    def truncate(self, handle: int, size: int) -> None:
        super().truncate(handle, size)
        self.calls.append(Call("truncate", self.names[handle], size))

    def sync(self, handle: int) -> None:
        self.calls.append(Call("sync", self.names[handle]))

    @contextlib.contextmanager
    def of_atomic(self) -> Iterator[None]:
        """Calls of `casr.atomic`, which asks the operating system itself: a file is written once, before its fsync."""
        replace = os.replace

        def sync(handle: int) -> None:
            path = Path(os.readlink(f"/proc/self/fd/{handle}"))
            if path.is_file():
                written = Call("write", path.name, 0, path.read_bytes())
                self.calls += [Call("open", path.name), written, Call("sync", path.name)]

        def rename(path: str, to: Path) -> None:
            replace(path, to)
            self.calls.append(Call("rename", Path(path).name, to=to.name))

        with mock.patch("os.fsync", sync), mock.patch("os.replace", rename):
            yield


class Promised(NamedTuple):
    """What the session was told, for comparison: number of calls then made, and lines and samples so far."""

    calls: int
    lines: int
    samples: tuple[int, int]


def record_session(folder: Path) -> tuple[list[Call], list[Promised], list[bytes]]:
    """A session of six presses: its calls; after each line what was handed over; and the lines."""
    system = WritingDown()
    presses = draw_presses("power", "P01", ("S1", "S2", "S3"), SETTINGS)
    clock = [0.0]
    plan = Plan("power", "P01", 1, "2026-11-23T10:00:00", presses)
    with system.of_atomic():
        record = new_session(folder, plan, lambda: clock[0], background=False, system=system)
    written: list[bytes] = []
    told: list[Promised] = []
    sent = [0, 0]

    def say(event: object, record: SessionRecord = record) -> None:
        line: Line = record.append(event)  # type: ignore[arg-type]
        written.append(journal_line(line))
        told.append(Promised(len(system.calls), len(written), (sent[0], sent[1])))

    say(Begun("P01", "power", "0", "none"))
    writers = []
    for info in (EMG, FORCE):
        writers.append(record.open_stream(info.kind, info))
        written.append(b"")
        told.append(Promised(len(system.calls), len(written), (sent[0], sent[1])))
    rng = np.random.default_rng(3)

    def measure(seconds: float) -> None:
        for _ in range(round(seconds / 0.05)):
            clock[0] += 0.05
            for i, (writer, info) in enumerate(zip(writers, (EMG, FORCE), strict=True)):
                n = round(0.05 * info.fs_hz)
                writer.append(Block(rng.normal(size=(n, len(info.channels))), sent[i], clock[0]))
                sent[i] += n

    for press in presses:
        measure(0.5)
        say(PressBegun(press.number, 1, press.specimen, press.phase, press.repetition, press.stay))
        measure(1.0)
        say(PressEnded(press.number, 1, clock[0] - 1, clock[0]))
        measure(0.2)
        say(Judged(press.number, 1, "ok"))
    record.close()
    return system.calls, told, written


def after_power_loss(calls: Sequence[Call], rule: str, rng: random.Random) -> dict[str, bytes]:
    """The files that the disk may hold when the power is cut after these calls."""
    safe: dict[str, bytearray] = {}
    since: dict[str, list[Call]] = {}
    for i, call in enumerate(calls):
        if call.kind == "open":
            safe.setdefault(call.name, bytearray())
            since.setdefault(call.name, [])
        elif call.kind == "sync":
            for earlier in since[call.name]:
                _apply(safe[call.name], earlier, range(len(earlier.content)))
            since[call.name] = []
        elif call.kind == "rename":
            if i + 1 < len(calls) or rule == "kill" or rng.random() < 0.5:
                safe[call.to], since[call.to] = safe.pop(call.name), since.pop(call.name)
        else:
            since[call.name].append(call)
    for name, pending in since.items():
        fate = (
            "all" if rule == "kill" else "prefix" if rule == "torn" else rng.choice(("all", "none", "some", "prefix"))
        )
        stop = rng.randrange(len(pending) + 1)
        for number, call in enumerate(pending):
            whole = fate == "all" or (fate == "prefix" and number < stop)
            if call.kind == "truncate":
                if whole or (fate == "some" and rng.random() < 0.5):
                    _apply(safe[name], call, range(0))
                continue
            sectors = range(0, len(call.content) + call.offset % SECTOR, SECTOR)
            for sector in sectors:
                kept = whole or (fate == "some" and rng.random() < 0.5) or (fate == "prefix" and number == stop)
                if fate == "prefix" and number == stop and sector >= rng.randrange(len(sectors) * SECTOR):
                    kept = False
                low = max(0, sector - call.offset % SECTOR)
                high = min(len(call.content), sector - call.offset % SECTOR + SECTOR)
                if kept:
                    _apply(safe[name], call, range(low, high))
                elif rng.random() < 0.3 and fate == "some":  # the file has grown, its content has not come
                    at = call.offset + high
                    safe[name].extend(bytes(max(0, at - len(safe[name]))))
    return {name: bytes(content) for name, content in safe.items()}


def _apply(content: bytearray, call: Call, part: range) -> None:
    if call.kind == "truncate":
        del content[call.offset :]
        return
    start, stop = call.offset + part.start, call.offset + part.stop
    content.extend(bytes(max(0, stop - len(content))))
    content[start:stop] = call.content[part.start : part.stop]


def cut_at(calls: Sequence[Call], rng: random.Random) -> tuple[list[Call], int]:
    """Calls until the cut, the last one perhaps in part, and how many of them were done."""
    n = rng.randrange(1, len(calls) + 1)
    last = calls[n - 1]
    if last.kind == "write" and rng.random() < 0.5:
        part = last._replace(content=last.content[: rng.randrange(len(last.content))])
        return [*calls[: n - 1], part], n - 1
    return list(calls[:n]), n


class Outcome(NamedTuple):
    """What a resumed session has lost. fault : what should not have happened; "" for nothing."""

    fault: str
    presses_lost: int
    presses_done: int


def resumed(folder: Path, done: int, told: Sequence[Promised], written: Sequence[bytes]) -> Outcome:
    """Resume what is left after ``done`` calls, and compare it with what the session was told until then."""
    if not (folder / PLAN_FILE).exists():
        return Outcome("" if not told or done < told[0].calls else "the plan is gone", 0, 0)
    promised = max((each for each in told if each.calls <= done), key=lambda each: each.lines, default=None)
    lines_promised = promised.lines if promised else 0
    kept = read_journal(folder / JOURNAL_FILE)[0] if (folder / JOURNAL_FILE).exists() else ()
    record = resume_session(folder, lambda: 0.0, background=False)
    record.close()
    lines, _ = read_journal(folder / JOURNAL_FILE)
    if len(kept) < lines_promised:
        return Outcome(f"{lines_promised - len(kept)} lines of the journal are gone", 0, 0)
    for line, true in zip(kept, written, strict=False):
        if true and journal_line(line)[:-20] != true[:-20]:
            return Outcome(f"line {line.number} is another one", 0, 0)
    judged = sum(isinstance(line.event, Judged) for line in kept)
    begun = sum(isinstance(line.event, PressBegun) for line in kept)
    complete = sum(tried.counts for tried in folded(lines, record.plan.presses).tried)
    interrupted = sum(isinstance(line.event, Interrupted) for line in lines)
    if complete != judged or interrupted != begun - judged:
        return Outcome(f"{complete} presses done and {interrupted} interrupted", 0, 0)
    before = told[len(kept) - 1].samples if kept else (0, 0)
    for i, name in enumerate(("emg", "force")):
        path = folder / f"sitting-1_{name}.samples"
        if before[i]:
            file = SampleFile(path)
            if file.blocks.first[0] != 0 or np.isnan(file.read(0, before[i])).any():
                return Outcome(f"samples of {name} before the last line are gone", 0, 0)
    if any(isinstance(line.event, Told) and "cut off" not in line.event.text for line in lines):
        return Outcome("an unexpected message", 0, 0)
    return Outcome("", interrupted, complete)


def try_cuts(cuts: int, seed: int, rule: str) -> list[Outcome]:
    """Outcomes of ``cuts`` losses of power."""
    rng = random.Random(f"{seed} {rule}")
    outcomes = []
    with tempfile.TemporaryDirectory() as temporary:
        calls, told, written = record_session(Path(temporary) / "session")
        for _ in range(cuts):
            some, done = cut_at(calls, rng)
            folder = Path(temporary) / "left"
            folder.mkdir()
            for name, content in after_power_loss(some, rule, rng).items():
                (folder / name).write_bytes(content)
            outcomes.append(resumed(folder, done, told, written))
            shutil.rmtree(folder)
    return outcomes


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cuts", type=int, default=4000)
    parser.add_argument("--seed", type=int, default=1)
    arguments = parser.parse_args()
    print("| rule | cuts | faults | resumed with no press lost | with the running press lost | with more lost |")
    print("|---|---|---|---|---|---|")
    faults: Counter[str] = Counter()
    for rule in RULES:
        outcomes = try_cuts(arguments.cuts, arguments.seed, rule)
        faults.update(outcome.fault for outcome in outcomes if outcome.fault)
        lost = Counter(min(outcome.presses_lost, 2) for outcome in outcomes)
        bad = sum(bool(outcome.fault) for outcome in outcomes)
        print(f"| {rule} | {len(outcomes)} | {bad} | {lost[0] - bad} | {lost[1]} | {lost[2]} |")
    for fault, count in faults.most_common():
        print(f"\n{count} times: {fault}")


if __name__ == "__main__":
    main()
