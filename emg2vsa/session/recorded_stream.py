"""A source with its file and its clock: samples are on their way to the disk before anything else is made of them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from typing import Literal, NamedTuple

from emg2vsa.arrays import Floats
from emg2vsa.devices.streams import Source, StreamCounts
from emg2vsa.errors import DeviceError, Emg2vsaError
from emg2vsa.session.journal import ClockFitted, SamplesLost
from emg2vsa.session.liveness import Liveness
from emg2vsa.session.raw_files import SampleWriter
from emg2vsa.session.record import SessionRecord
from emg2vsa.session.sample_clock import SampleClock
from emg2vsa.session.views import DEVICE_NAMES, DeviceView

SILENT_S, LOST_S = 0.3, 1.5
"A device that sends nothing for so long is doubtful; and is taken for lost."
AGAIN_S = 2.0
"A lost device is asked again after so long."


class Arrived(NamedTuple):
    """Samples (n, channels) from number ``first``, the last one measured at ``newest_s`` on the session's clock."""

    first: int
    samples: Floats
    newest_s: float


def device_view(
    stream: str, clock: SampleClock, signs: Iterable[str], samples: int, lost: int, silent_s: float, lost_why: str
) -> DeviceView:
    """A stream as the operator's page shows it; arguments as what `RecordedStream` knows of its own."""
    report, problems = clock.report(), [*signs, *clock.problems()]
    if lost and not report.missing:
        problems.append(f"{lost} samples were lost.")
    name = DEVICE_NAMES[stream]
    state: Literal["good", "doubtful", "lost"] = "good"
    text = f"{name}: {clock.fs_hz:.6g} samples a second."
    if lost_why:
        state, text = "lost", f"{name}: {lost_why}"
    elif silent_s > SILENT_S:
        state, text = "doubtful", f"{name}: nothing for {silent_s:.1f} s."
    elif problems:
        state, text = "doubtful", f"{name}: {' '.join(problems)}"
    return DeviceView(name, state, text, clock.fs_hz, report.rate_hz, report.se_s, samples, lost)


class RecordedStream:
    """``read`` never waits. A lost device is opened again by itself, until it answers.

    info : as the source states it; of the last one while the device is lost. clock : number of a sample to its time.
    next_index : number of the sample that comes next.
    """

    def __init__(
        self, name: str, source: Source, make: Callable[[], Source], record: SessionRecord, now_s: float, beside: bool
    ) -> None:
        """name : "emg" or "force". source : started. make : opens it anew. beside : wait for that in a thread."""
        self.name = name
        self._make, self._record, self._beside = make, record, beside
        self._source: Source | None = None
        self._again: threading.Thread | None = None
        self._opened: Source | None = None
        self._next_try_s = 0.0
        self._heard_s = 0.0
        self._given_up = self.next_index = 0
        self._lost_before = 0
        self.lost_why = ""
        "Why the device is lost; empty while it delivers."
        self.epoch = 0
        "Counts how often it was opened; sample numbers begin anew."
        self._take(source, now_s)

    @property
    def lost_samples(self) -> int:
        """Since the session began: told by the source, missing by the clock, or given up by a full disk."""
        counts = StreamCounts() if self._source is None else self._source.counts()
        return self._lost_before + counts.lost + self.clock.report().missing + self._given_up

    def read(self, now_s: float) -> Iterator[Arrived]:
        """What has come by ``now_s``, s; nothing while the device is lost."""
        if self._source is None:
            self._look_again(now_s)
            return
        try:
            blocks = self._source.read()
        except DeviceError as error:
            self._lose(now_s, str(error))
            return
        for block in blocks:
            n = len(block.samples)
            if n == 0:
                continue
            if not self._writer.append(block):
                self._given_up += n
                self._record.append(SamplesLost(self.name, block.first, n, "the disk does not take them"))
            if block.first > self.next_index:
                gone = block.first - self.next_index
                self._record.append(SamplesLost(self.name, self.next_index, gone, "the device lost them"))
            self.clock.add(block.first, n, block.arrived_s)
            self.next_index = block.first + n
            self._heard_s = now_s
            self._liveness.take(block.samples, now_s)
            yield Arrived(block.first, block.samples, float(self.clock.time_s(self.next_index - 1)))
        if now_s - self._heard_s > LOST_S:
            self._lose(now_s, f"no samples for {now_s - self._heard_s:.1f} s")

    def tell_clock(self) -> None:
        """A line of the journal with the clock as it is fitted now."""
        if self.next_index == 0 or self.lost_why:
            return
        _, start_s, fs_hz, _ = self.clock.timing(0, self.next_index)
        self._record.append(ClockFitted(self.name, start_s, fs_hz, self.clock.report().se_s or 0.0, self.next_index))

    def view(self, now_s: float) -> DeviceView:
        """The stream as the operator's page shows it."""
        samples = 0 if self._source is None else self._source.counts().samples
        signs, silent_s = self._liveness.problems(now_s), now_s - self._heard_s
        return device_view(self.name, self.clock, signs, samples, self.lost_samples, silent_s, self.lost_why)

    def close(self) -> None:
        """Give the device back."""
        if self._source is not None:
            self.tell_clock()
            self._source.close()
            self._source = None
        if self._again is not None:
            self._again.join(10.0)
            if self._opened is not None:
                self._opened.close()

    def _take(self, source: Source, now_s: float) -> None:
        self.info = source.info
        self._writer: SampleWriter = self._record.open_stream(self.name, source.info)
        self.clock = SampleClock(
            source.info.fs_hz, delay_s=source.info.delay_s, quantum=source.info.frame, stamped=source.info.stamped
        )
        self._liveness = Liveness(source.info, now_s)
        self._source, self.next_index, self._heard_s = source, 0, now_s
        self.lost_why = ""
        self.epoch += 1

    def _lose(self, now_s: float, why: str) -> None:
        self.tell_clock()
        self._lost_before = self.lost_samples
        self._given_up = 0
        self.lost_why = why
        source, self._source = self._source, None
        if source is not None:
            source.close()
        self._next_try_s = now_s + AGAIN_S

    def _look_again(self, now_s: float) -> None:
        if self._opened is not None:
            self._take(self._opened, now_s)
            self._opened = self._again = None
        elif now_s >= self._next_try_s and (self._again is None or not self._again.is_alive()):
            self._next_try_s = now_s + AGAIN_S
            if self._beside:
                self._again = threading.Thread(target=self._try, name=f"{self.name} again", daemon=True)
                self._again.start()
            else:
                self._try()

    def _try(self) -> None:
        source: Source | None = None
        try:
            source = self._make()
            source.start()
            self._opened = source
        except Emg2vsaError as error:
            self.lost_why = str(error)
            if source is not None:
                source.close()
