"""Who judges the presses of a run: its own process where time is virtual; where it is real a process beside the run,
for which the control loop never waits."""

from __future__ import annotations

import json
import mmap
import os
import pickle
import sys
import tempfile
import time
from collections import deque
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from struct import Struct
from typing import Any, TextIO

import cv2
import numpy as np

from casr.atomic import write_text_atomic
from casr.child_process import Child, Pipes
from casr.frames.force import WINDOW
from emg2vsa.calibration.online import NO_GAIN, WIDTH_REACHED
from emg2vsa.calibration_file import sha256_of
from emg2vsa.devices.device_settings import RATE_HZ
from emg2vsa.devices.protocols import Frame
from emg2vsa.errors import DeviceError
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE as KAPPA_FILE
from emg2vsa.rig.kappa.live_kappa import KAPPA_HEADER, KappaPlan, KappaRow, LiveKappa, Rows, line_of
from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE

HOLD_S = WINDOW / RATE_HZ
"""After a frame, until the readings that tell its force have come."""
_REASONS = (WIDTH_REACHED, NO_GAIN)
_REASON_BITS, _WIDTH_BITS = 4, 20
_OPEN = 2**_WIDTH_BITS - 1
"""In place of a half width that is not finite."""
SLOTS = 16
"""Frames that may wait for the estimator: 0.8 s of them."""
READY_S = 60.0
"""Time in which the estimator must have loaded what it needs."""
END_S = 3.0
"""Time in which the estimator must end by itself; afterwards it is killed."""
_NICE = -10
"""Behind the control loop, and before ordinary programs where the system permits it."""
_MEMORY = "/dev/shm"
"""Files in it are memory, on Linux."""
MOST_READINGS = 2000
"""Most readings that come with a frame; of more readings, the newest."""
_FRAME = Struct("<qqdq")
"""Slot, repetition, time of the frame, how many readings lie in the slot."""
_OVER, _END = b"over", b"end"
_TAKEN, _STOP, _ANSWERED = 0, 1, 2
_WORDS = 8
"""Counters of 8 bytes before the frames, each written by one side alone: slots taken, press to stop, answers."""


class Held:
    """Frames of the press that is recorded, until the readings that tell their force have come."""

    def __init__(self) -> None:
        self._frames: deque[tuple[int, Frame]] = deque()
        self._readings: list[tuple[float, float]] = []

    def frame(self, repetition: int, frame: Frame) -> None:
        """A frame that was kept."""
        self._frames.append((repetition, frame))

    def force(self, time_s: float, force_n: float) -> None:
        """A reading that was kept."""
        self._readings.append((time_s, force_n))

    def ready(self, *, over: bool = False) -> list[tuple[int, Frame, Rows]]:
        """Frames whose force is known now, with the readings since the last of them. over : nothing more comes."""
        newest_s = self._readings[-1][0] if self._readings else -np.inf
        found: list[tuple[int, Frame, Rows]] = []
        while self._frames and (over or self._frames[0][1].time_s + HOLD_S <= newest_s):
            found.append((*self._frames.popleft(), self._readings))
            self._readings = []
        if over:
            self._readings = []
        return found


@dataclass
class Tally:
    """What became of the frames. latencies_s : of those that were answered in real time."""

    frames: int = 0
    dropped: int = 0
    answered: int = 0
    latencies_s: list[float] = field(default_factory=list)
    trouble: str = ""

    def about(self) -> dict[str, Any]:
        """For kappa.json."""
        known = np.array(self.latencies_s) if self.latencies_s else None
        shares = {"median_s": 50, "p95_s": 95, "largest_s": 100}
        latency = None if known is None else {key: float(np.percentile(known, at)) for key, at in shares.items()}
        counts = {"frames": self.frames, "dropped": self.dropped, "answered": self.answered}
        return {**counts, "latency": latency, "trouble": self.trouble}


class _Judge:
    """Keeps the account of what it is shown."""

    def __init__(self) -> None:
        self.tally, self._held = Tally(), Held()

    def frame(self, repetition: int, frame: Frame) -> None:
        self.tally.frames += 1
        self._held.frame(repetition, frame)


class SameProcess(_Judge):
    """Answers each frame before the run goes on: the same run gives the same rows.

    Parameters
    ----------
    plan : how presses are judged. file : where rows go.
    """

    def __init__(self, plan: KappaPlan, file: Path) -> None:
        super().__init__()
        self._kappa, self._word, self._rows = LiveKappa(plan), 0, new_rows(file)

    def force(self, time_s: float, force_n: float) -> None:
        """A reading of the force, N, at ``time_s``, s."""
        self._held.force(time_s, force_n)
        self._answer(over=False)

    def stop(self, repetition: int) -> str:
        return stop_text(self._word, repetition)

    def press_over(self) -> None:
        self._answer(over=True)
        if not self.tally.trouble:
            self._kappa.press_over()

    def close(self) -> None:
        self._rows.close()

    def _answer(self, *, over: bool) -> None:
        for repetition, frame, readings in self._held.ready(over=over):
            if self.tally.trouble:
                return
            try:
                row = self._kappa.frame(repetition, frame.time_s, frame.image, readings)
                self._kappa.settle()
                self._rows.write(line_of(row))
                self._word = stop_word(row) or self._word
            except Exception as error:  # whatever goes wrong here, the press goes on
                self.tally.trouble = f"{type(error).__name__}: {error}"
                return
            self.tally.answered += 1


def stop_word(row: KappaRow) -> int:
    """Repetition, reason and half width in one number of 8 bytes, which is written at once; 0 while a press goes on."""
    if row.stop not in _REASONS:
        return 0
    permille: int = min(round(1000 * row.half_width), _OPEN - 1) if np.isfinite(row.half_width) else _OPEN
    return (row.repetition << _REASON_BITS | _REASONS.index(row.stop)) << _WIDTH_BITS | permille


def stop_text(word: int, repetition: int) -> str:
    """Why this press stops, with the width it has reached; empty for another press, or none."""
    head, permille = divmod(word, 2**_WIDTH_BITS)
    number, reason = divmod(head, 2**_REASON_BITS)
    if word == 0 or number != repetition:
        return ""
    return f"{_REASONS[reason]}, kappa " + ("open to rigid" if permille == _OPEN else f"to {permille / 10:g} %")


def new_rows(file: Path) -> TextIO:
    """A new kappa.csv. OSError where there is one."""
    rows = file.open("x", encoding="utf-8", newline="")
    rows.write(f"{KAPPA_HEADER}\n")
    return rows


def write_about(folder: Path, plan: KappaPlan, tally: Tally) -> None:
    """kappa.json beside kappa.csv: by which calibration, and what became of the frames."""
    own = plan.calibration
    document = {
        "calibration": plan.name, "sha256": sha256_of(own), "specimens": list(own.specimens),
        "known_presses": own.presses,
        **{name: getattr(own, name) for name in ("quantity", "area_unit", "angle_deg", "condition", "simulated")},
        "stop_at": plan.stop_at, **tally.about(),
    }  # fmt: skip
    write_text_atomic(folder / KAPPA_ABOUT_FILE, json.dumps(document, indent=2) + "\n")


class OwnProcess(_Judge):
    """Hands frames and readings to a process beside the run; the control loop never waits for that.

    Frames and their readings go through shared memory, ``SLOTS`` at most at a time; short messages of one size say
    which. Where all slots are taken a frame is dropped, for the estimator alone, and counted; its readings go with the
    next one. A process that hangs or dies ends no press: it goes on to its full force.

    Parameters
    ----------
    plan : how presses are judged. file : where the process writes its rows. shape : (height, width) of the frames, px.
    zero_s : ``time.perf_counter`` at 0 s of the run's clock; None where that is not real time.

    Raises
    ------
    DeviceError : the process could not be started, or there is no memory for the frames.
    """

    def __init__(self, plan: KappaPlan, file: Path, shape: tuple[int, int], zero_s: float | None = None) -> None:
        super().__init__()
        self._sent, self._closed = 0, False
        self._unsent: list[tuple[float, float]] = []
        self._path, self._memory = _new_memory(shape)
        self._words, self._readings, self._images = _views(self._memory, shape)
        self._words[:] = 0
        self._child = Child("emg2vsa.rig.kappa.judges", "work", quiet=False, nice=_NICE)
        self._gone = False
        ready: object = "no answer"
        try:
            self._child.pipes.send(pickle.dumps((plan, file, shape, zero_s, self._path)))
            if self._child.pipes.readable(READY_S):
                ready = pickle.loads(self._child.pipes.receive().data)
        except (EOFError, OSError):
            ready = "it ended at once"
        with suppress(OSError):  # Windows removes no file that is in use
            self._path.unlink()
        if sys.platform != "win32":
            os.set_blocking(self._child.pipes.to_other.fileno(), False)
        if ready is not None:
            ready = ready[1] if isinstance(ready, tuple) else ready
            self.close()
            do = "Start the run again, or leave out --calibration."
            raise DeviceError("the estimator", wanted="a process that starts", found=str(ready), do=do)

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._child.pid

    def force(self, time_s: float, force_n: float) -> None:
        """A reading of the force, N, at ``time_s``, s."""
        self._held.force(time_s, force_n)
        self._hand_over(over=False)

    def stop(self, repetition: int) -> str:
        return stop_text(int(self._words[_STOP]), repetition)

    def press_over(self) -> None:
        self._hand_over(over=True)
        self._unsent = []
        self._send(_OVER)

    def close(self) -> None:
        """End the process, and give the memory back. ``tally`` is whole then."""
        if self._closed:
            return
        self._closed = True
        self._send(_END)
        with suppress(EOFError, OSError):
            if self._child.pipes.readable(END_S):
                self.tally.latencies_s, self.tally.trouble = pickle.loads(self._child.pipes.receive().data)
        status = self._child.close(0.0 if self._gone else END_S)
        if status is None:
            self.tally.trouble = self.tally.trouble or "it did not end, and was ended"
        elif status:
            self.tally.trouble = self.tally.trouble or f"its process ended with status {status}"
        self.tally.answered = int(self._words[_ANSWERED])
        del self._words, self._readings, self._images
        self._memory.close()
        with suppress(OSError):
            self._path.unlink()

    def _hand_over(self, *, over: bool) -> None:
        for repetition, frame, readings in self._held.ready(over=over):
            self._unsent = [*self._unsent, *readings][-MOST_READINGS:]
            if self._gone or self._sent - int(self._words[_TAKEN]) >= SLOTS:
                self.tally.dropped += 1
                continue
            slot, n_readings = self._sent % SLOTS, len(self._unsent)
            self._images[slot] = frame.image
            self._readings[slot, :n_readings] = np.array(self._unsent).reshape(-1, 2)
            if self._send(_FRAME.pack(slot, repetition, frame.time_s, n_readings)):
                self._sent += 1
                self._unsent = []
            else:
                self.tally.dropped += 1

    def _send(self, message: bytes) -> bool:
        """Never waits. A message shorter than a page goes into the pipe whole, or not at all."""
        if self._gone:
            return False
        try:
            self._child.pipes.send(message)
        except BlockingIOError:  # the end of a press is told by the next one too, and a process that hangs is ended
            return False
        except OSError:
            self.tally.trouble = "its process ended while presses went on"
            self._gone = True
            return False
        return True


def _new_memory(shape: tuple[int, int]) -> tuple[Path, mmap.mmap]:
    """A file of memory that is all there, for writing where there is none would end this process. DeviceError."""
    size_bytes = 8 * _WORDS + SLOTS * (16 * MOST_READINGS + shape[0] * shape[1])
    path = None
    try:
        handle, name = tempfile.mkstemp(dir=_MEMORY if os.path.isdir(_MEMORY) else None, prefix="emg2vsa.")
        path = Path(name)
        try:
            if sys.platform == "linux":
                os.posix_fallocate(handle, 0, size_bytes)
            else:
                os.ftruncate(handle, size_bytes)
            return path, mmap.mmap(handle, size_bytes)
        finally:
            os.close(handle)
    except OSError as error:
        if path is not None:
            path.unlink()
        raise DeviceError(
            "the estimator", wanted=f"{size_bytes / 1e6:.0f} MB of shared memory for {SLOTS} frames",
            found=error.strerror or str(error), do="Make /dev/shm larger, or leave out --calibration.",
        ) from error  # fmt: skip


def _views(memory: mmap.mmap, shape: tuple[int, int]) -> tuple[Any, Any, Any]:
    """Counters; readings (SLOTS, MOST_READINGS, 2) as ``Rows``; images (SLOTS, height, width)."""
    readings_at = 8 * _WORDS
    images_at = readings_at + 16 * SLOTS * MOST_READINGS
    return (
        np.ndarray(_WORDS, np.int64, memory),
        np.ndarray((SLOTS, MOST_READINGS, 2), np.float64, memory, offset=readings_at),
        np.ndarray((SLOTS, *shape), np.uint8, memory, offset=images_at),
    )


def work(run: Pipes) -> None:
    """The process beside the run, on one core."""
    cv2.setNumThreads(1)
    plan, file, shape, zero_s, path = pickle.loads(run.receive().data)
    with path.open("r+b") as shared:
        memory = mmap.mmap(shared.fileno(), 0)
    words, read, images = _views(memory, shape)
    latencies_s: list[float] = []
    trouble = ""
    try:
        kappa = LiveKappa(plan)
        run.send(pickle.dumps(None))
        _answer_all(kappa, run, words, read, images, file, zero_s, latencies_s)
    except Exception as error:
        trouble = f"{type(error).__name__}: {error}"
    run.send(pickle.dumps((latencies_s, trouble)))


def _answer_all(
    kappa: LiveKappa,
    messages: Pipes,
    words: Any,
    read: Any,
    images: Any,
    file: Path,
    zero_s: float | None,
    latencies_s: list[float],
) -> None:
    rows: TextIO | None = None  # the folder of the run is there with its first frame
    while (message := _next(messages)) != _END:
        if message == _OVER:
            kappa.press_over()
            continue
        slot, repetition, time_s, n_readings = _FRAME.unpack_from(message)
        readings: Rows = [tuple(row) for row in read[slot, :n_readings].tolist()]
        image = images[slot].copy()
        words[_TAKEN] += 1
        row = kappa.frame(repetition, time_s, image, readings)
        words[_STOP] = stop_word(row) or words[_STOP]
        if zero_s is not None:
            row = replace(row, latency_s=time.perf_counter() - zero_s - time_s)
            latencies_s.append(row.latency_s)
        words[_ANSWERED] += 1
        rows = rows or new_rows(file)
        rows.write(line_of(row))
        rows.flush()
        if not messages.readable():
            kappa.settle()
    if rows is not None:
        rows.close()


def _next(messages: Pipes) -> bytes:
    try:
        return messages.receive().tobytes()
    except (EOFError, OSError):  # the run is no more
        return _END
