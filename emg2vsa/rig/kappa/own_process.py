"""A process beside the run that judges its presses: the control loop hands frames over and never waits for it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from multiprocessing.connection import Connection
from multiprocessing.shared_memory import SharedMemory
from pathlib import Path
from struct import Struct
from typing import Any, TextIO

import cv2
import numpy as np

from casr.one_thread import VARIABLES
from emg2vsa.errors import DeviceError
from emg2vsa.rig.devices import Frame
from emg2vsa.rig.kappa.judges import new_rows, stop_text, stop_word
from emg2vsa.rig.kappa.live_kappa import Held, KappaPlan, LiveKappa, Rows, Tally, line_of

SLOTS = 16
"""Frames that may wait for the estimator: 0.8 s of them."""
READY_S = 60.0
"""In which the estimator must have loaded what it needs."""
END_S = 3.0
"""In which it must have ended; then it is ended."""
_NICE = -10
MOST_READINGS = 2000
"""That come with a frame; of more, the newest."""
_FRAME = Struct("<qqdq")
"""Slot, repetition, time of the frame, how many readings lie in the slot."""
_OVER, _END = b"over", b"end"
_TAKEN, _STOP, _ANSWERED = 0, 1, 2
_WORDS = 8
"""Counters of 8 bytes before the frames, each written by one side alone: slots taken, press to stop, answers."""


class OwnProcess:
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
        self.tally = Tally()
        self._held, self._sent, self._closed = Held(), 0, False
        self._unsent: list[tuple[float, float, float]] = []
        self._memory = _new_memory(shape)
        self._words, self._readings, self._images = _views(self._memory, shape)
        self._words[:] = 0
        context = multiprocessing.get_context("spawn")
        there, to = context.Pipe(duplex=False)
        if sys.platform != "win32":
            os.set_blocking(to.fileno(), False)
        self._to: Any = to  # a connection, of another type on Windows; None once the process has gone
        self._answers, from_there = context.Pipe(duplex=False)
        self._process = context.Process(
            target=_work, args=(plan, file, shape, zero_s, self._memory.name, there, from_there), daemon=True
        )
        with _one_thread():
            self._process.start()
        there.close()
        from_there.close()
        try:
            ready = self._answers.recv() if self._answers.poll(READY_S) else "no answer"
        except EOFError:
            ready = "it ended at once"
        if ready is not None:
            ready = ready[1] if isinstance(ready, tuple) else ready
            self.close()
            do = "Start the run again, or leave out --calibration."
            raise DeviceError("the estimator", wanted="a process that starts", found=str(ready), do=do)

    @property
    def pid(self) -> int | None:
        """Number of the process."""
        return self._process.pid

    def force(self, time_s: float, force_n: float, depth_mm: float) -> None:
        self._held.force(time_s, force_n, depth_mm)
        self._hand_over(over=False)

    def frame(self, repetition: int, frame: Frame) -> None:
        self.tally.frames += 1
        self._held.frame(repetition, frame)

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
            if self._answers.poll(END_S):
                self.tally.latencies_s, self.tally.trouble = self._answers.recv()
        self._process.join(END_S if self._to is not None else 0.0)
        if self._process.is_alive():
            self._process.kill()
            self._process.join(END_S)
            self.tally.trouble = self.tally.trouble or "it did not end, and was ended"
        elif self._process.exitcode:
            self.tally.trouble = self.tally.trouble or f"its process ended with status {self._process.exitcode}"
        self.tally.answered = int(self._words[_ANSWERED])
        del self._words, self._readings, self._images
        self._memory.close()
        with suppress(FileNotFoundError):
            self._memory.unlink()

    def _hand_over(self, *, over: bool) -> None:
        for repetition, frame, readings in self._held.ready(over=over):
            self._unsent = [*self._unsent, *readings][-MOST_READINGS:]
            if self._to is None or self._sent - int(self._words[_TAKEN]) >= SLOTS:
                self.tally.dropped += 1
                continue
            slot, n_readings = self._sent % SLOTS, len(self._unsent)
            self._images[slot] = frame.image
            self._readings[slot, :n_readings] = np.array(self._unsent).reshape(-1, 3)
            if self._send(_FRAME.pack(slot, repetition, frame.time_s, n_readings)):
                self._sent += 1
                self._unsent = []
            else:
                self.tally.dropped += 1

    def _send(self, message: bytes) -> bool:
        """Never waits. A message shorter than a page goes into the pipe whole, or not at all."""
        if self._to is None:
            return False
        try:
            self._to.send_bytes(message)
        except BlockingIOError:  # the end of a press is told by the next one too, and a process that hangs is ended
            return False
        except OSError:
            self.tally.trouble = "its process ended while presses went on"
            self._to = None
            return False
        return True


def _new_memory(shape: tuple[int, int]) -> SharedMemory:
    """Shared memory that is all there: writing where there is none would end this process. DeviceError."""
    size_bytes = 8 * _WORDS + SLOTS * (24 * MOST_READINGS + shape[0] * shape[1])
    memory = None
    try:
        memory = SharedMemory(create=True, size=size_bytes)
        if sys.platform == "linux":
            descriptor = os.open(f"/dev/shm/{memory.name}", os.O_RDWR)
            try:
                os.posix_fallocate(descriptor, 0, size_bytes)
            finally:
                os.close(descriptor)
    except OSError as error:
        if memory is not None:
            memory.close()
            memory.unlink()
        raise DeviceError(
            "the estimator", wanted=f"{size_bytes / 1e6:.0f} MB of shared memory for {SLOTS} frames",
            found=error.strerror or str(error), do="Make /dev/shm larger, or leave out --calibration.",
        ) from error  # fmt: skip
    return memory


def _views(memory: SharedMemory, shape: tuple[int, int]) -> tuple[Any, Any, Any]:
    """Counters; readings (SLOTS, MOST_READINGS, 3) as ``Rows``; images (SLOTS, height, width)."""
    readings_at = 8 * _WORDS
    images_at = readings_at + 24 * SLOTS * MOST_READINGS
    return (
        np.ndarray(_WORDS, np.int64, memory.buf),
        np.ndarray((SLOTS, MOST_READINGS, 3), np.float64, memory.buf, offset=readings_at),
        np.ndarray((SLOTS, *shape), np.uint8, memory.buf, offset=images_at),
    )


@contextmanager
def _one_thread() -> Iterator[None]:
    """A process that is started within leaves the other cores to the control loop."""
    before = {name: os.environ.get(name) for name in VARIABLES}
    os.environ.update(dict.fromkeys(VARIABLES, "1"))
    try:
        yield
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value


def _work(
    plan: KappaPlan, file: Path, shape: tuple[int, int], zero_s: float | None, memory_name: str,
    messages: Connection, answers: Connection,
) -> None:  # fmt: skip
    """The process beside the run: it ends with it, also where that is killed, for its pipe ends then."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the run ends this process
    _behind()
    memory = SharedMemory(memory_name)
    words, read, images = _views(memory, shape)
    latencies_s: list[float] = []
    trouble = ""
    try:
        kappa = LiveKappa(plan)
        answers.send(None)
        _answer_all(kappa, messages, words, read, images, file, zero_s, latencies_s)
    except Exception as error:
        trouble = f"{type(error).__name__}: {error}"
    with suppress(OSError):
        answers.send((latencies_s, trouble))
    del words, read, images
    memory.close()


def _behind() -> None:
    """On one core, behind the control loop, and before ordinary programs where the system permits it."""
    cv2.setNumThreads(1)
    if sys.platform == "linux":
        with suppress(OSError):
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
            os.nice(_NICE)


def _answer_all(
    kappa: LiveKappa,
    messages: Connection,
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
        if not messages.poll(0):
            kappa.settle()
    if rows is not None:
        rows.close()


def _next(messages: Connection) -> bytes:
    try:
        return messages.recv_bytes()
    except (EOFError, OSError):  # the run is no more
        return _END
