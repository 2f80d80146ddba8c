"""The folder of one participant's session: its plan, its journal and its samples, held by one process.

``<BIDS root>/sourcedata/sub-P03/<task>/``, at a visit ``sub-P03/ses-2/<task>/``: plan.json, journal.jsonl, and for each
sitting and stream ``sitting-1_emg.samples``. Nothing in it is ever overwritten.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Callable, Iterator
from dataclasses import fields
from pathlib import Path

from casr.atomic import write_bytes_atomic
from emg2vsa.bids.names import visit_folder
from emg2vsa.devices.streams import StreamInfo
from emg2vsa.durable.sealed_file import SealedFile
from emg2vsa.durable.system import PRIVATE, SYSTEM, OperatingSystem
from emg2vsa.durable.writer import Writer
from emg2vsa.errors import DataError, DeviceError, SettingError
from emg2vsa.held_lock import myself, taken, told
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Event,
    Interrupted,
    Line,
    StreamOpened,
    Told,
    gaps,
    line_bytes,
    now_text,
    read_journal,
)
from emg2vsa.session.plan import PLAN_FILE, Plan, plan_bytes, read_plan
from emg2vsa.session.presses import folded
from emg2vsa.session.raw_files import SampleWriter
from emg2vsa.session_settings import PARTICIPANT_CODE

LOCK_FILE = ".lock"


def check_code(participant: str) -> None:
    """SettingError where a participant's code could be a name: privacy begins with what a file is called."""
    if not re.fullmatch(PARTICIPANT_CODE, participant):
        raise SettingError(
            f"--participant {participant}", wanted="a code: at most four letters and then a number, such as P03",
            found=repr(participant), do="Give a code. Keep the list of codes and names apart from the data, on paper.",
        )  # fmt: skip


class SessionRecord:
    """The folder of a session, open for recording. Methods never wait for the disk, but those that say so.

    plan : as it was drawn. sitting : number of this one. repaired_bytes : of a torn last line that was cut off.
    lines : of the journal so far, of all sittings.
    past : lines of earlier sittings, and those of this one until ``follow`` is set, which is called with each line.
    """

    def __init__(
        self, folder: Path, plan: Plan, lock: int, now_s: Callable[[], float], background: bool, system: OperatingSystem
    ) -> None:
        self.folder, self.plan, self.repaired_bytes = folder, plan, 0
        self._lock, self._now_s = lock, now_s
        self.past: list[Line] = []
        self.follow: Callable[[Line], None] = self.past.append
        path = folder / JOURNAL_FILE
        whole_bytes = self._read(path) if path.exists() else None
        self.lines = self._lines_before = self.past[-1].number if self.past else 0
        self.sitting = max((line.sitting for line in self.past), default=0) + 1
        self._disk = Writer(background=background, system=system)
        self._journal = SealedFile(path, self._disk, whole_bytes)
        self._resume()

    def append(self, event: Event, time_s: float | None = None) -> Line:
        """Add an event to the journal, and hand over its line; ``time_s``, s on the session's clock, where it happened
        before now.

        UnicodeEncodeError : a text of the event cannot be written; no line is used up, and nobody is told.
        """
        time_s = self._now_s() if time_s is None else time_s
        line = Line(self.lines + 1, self.sitting, time_s, now_text(), event)
        content = line_bytes(line)
        self.lines = line.number
        self._journal.seal(content)
        self.follow(line)
        return line

    def open_stream(self, name: str, info: StreamInfo) -> SampleWriter:
        """A file for the samples of a stream that is called so in this sitting, "emg" or "force"; waits a moment.

        A stream that was lost and opened again gets a file of its own, and starts to count anew.
        """
        stem = f"sitting-{self.sitting}_{name}"
        path = self.folder / f"{stem}.samples"
        for n in range(2, 10_000):
            if not path.exists():
                break
            path = self.folder / f"{stem}-{n}.samples"
        writer = SampleWriter(self._disk, path, info)
        opened = {each.name: getattr(info, each.name) for each in fields(StreamInfo)}
        self.append(StreamOpened(name=name, file=path.name, **opened))
        return writer

    @property
    def trouble(self) -> str:
        """Sentence on what the disk refuses; "" while it takes everything. The session pauses meanwhile."""
        return self._disk.trouble

    @property
    def safe_lines(self) -> int:
        """Lines that have reached the disk itself, of all sittings."""
        return self._lines_before + self._disk.sealed_lines

    @property
    def is_safe(self) -> bool:
        """Whether every line has reached the disk itself."""
        return self.safe_lines == self.lines

    def wait(self, timeout_s: float = 30.0) -> bool:
        """Return when everything has reached the disk, or after the time, s; whether everything has."""
        return self._disk.wait(timeout_s)

    def close(self) -> None:
        """Write what waits and give the folder back. DeviceError where the disk does not take it."""
        try:
            self._disk.close()
        finally:
            os.close(self._lock)

    def _read(self, path: Path) -> int:
        """Length of the whole lines."""
        lines, whole_bytes = read_journal(path)
        self.repaired_bytes = path.stat().st_size - whole_bytes
        self.past.extend(lines)
        return whole_bytes

    def _resume(self) -> None:
        if self.repaired_bytes:
            self.append(Told(f"An unfinished line of {self.repaired_bytes} bytes was cut off the journal."))
        known = {line.event.text for line in self.past if isinstance(line.event, Told)}
        for said in gaps(self.past):
            if said not in known:
                self.append(Told(said))
        for open_ in folded(self.past, self.plan.presses).without_verdict:
            self.append(Interrupted(*open_.key))


def new_session(
    folder: Path, plan: Plan, now_s: Callable[[], float], *, background: bool = True, system: OperatingSystem = SYSTEM
) -> SessionRecord:
    """The folder of a new session, its plan on the disk itself before anything else.

    now_s : time on the session's clock. background : write in a thread of its own; false for virtual time.
    DataError : there is a session already, or another process holds it. DeviceError : the disk does not take it.
    """
    check_code(plan.participant)
    lock = _held(folder)
    with _given_back(lock):
        if (folder / PLAN_FILE).exists():
            raise DataError(
                folder, wanted="a participant without a session of this task", found="a session of " + _about(folder),
                do="Go on with it: --resume. Or give another participant's code, or visit.",
            )  # fmt: skip
        try:
            write_bytes_atomic(folder / PLAN_FILE, plan_bytes(plan), on_disk=True, mode=PRIVATE)
        except OSError as error:
            raise DeviceError(
                folder, wanted="a folder with room for the session", found=error.strerror or str(error),
                do="Free some disk space, or check the folder's permissions.",
            ) from error  # fmt: skip
        return SessionRecord(folder, plan, lock, now_s, background, system)


def resume_session(
    folder: Path, now_s: Callable[[], float], *, background: bool = True, system: OperatingSystem = SYSTEM
) -> SessionRecord:
    """The folder of a session that was begun, opened for its next sitting; arguments as of ``new_session``.

    A torn last line of the journal is cut off, and a press that was running is marked as interrupted.
    DataError : there is no session, another process holds it, or its plan or its journal is damaged.
    """
    if not (folder / PLAN_FILE).exists():
        raise DataError(
            folder, wanted="a session to resume", found="none" if not folder.exists() else "a folder without plan.json",
            do="Begin without --resume, or check the participant's code.",
        )  # fmt: skip
    lock = _held(folder)
    with _given_back(lock):
        return SessionRecord(folder, read_plan(folder / PLAN_FILE), lock, now_s, background, system)


def saved(folder: Path, lines: int, trouble: str, safe: bool) -> str:
    """How much of a session is on the disk, in a sentence."""
    on_disk = "everything is on the disk" if safe else "the last events are being written"
    return f"{folder}: {lines} events; {trouble.rstrip('.') or on_disk}."


def session_folder(root: Path, participant: str, task: str, visit: str = "") -> Path:
    """Where the session of a participant is, or will be, below the root of the data set."""
    return visit_folder(root / "sourcedata", participant, visit) / task


def _held(folder: Path) -> int:
    """The lock of the folder, as an open file."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        handle = os.open(folder / LOCK_FILE, os.O_RDWR | os.O_CREAT, PRIVATE)
    except OSError as error:
        raise DeviceError(
            folder, wanted="a folder to record to", found=error.strerror or str(error),
            do="Check the folder, its permissions and the disk.",
        ) from error  # fmt: skip
    if not taken(handle):
        os.close(handle)
        raise DataError(
            folder, wanted="a session that no other process records", found=f"held by {told(folder / LOCK_FILE)}",
            do="End the other process first: its operator's page has a button for that.",
        )  # fmt: skip
    with contextlib.suppress(OSError):  # a full disk; the lock holds without the name of its holder
        os.ftruncate(handle, 0)
        os.lseek(handle, 0, os.SEEK_SET)
        os.write(handle, json.dumps(myself()).encode())
    return handle


@contextlib.contextmanager
def _given_back(lock: int) -> Iterator[None]:
    """Close the lock where opening fails."""
    try:
        yield
    except BaseException:
        os.close(lock)
        raise


def _about(folder: Path) -> str:
    try:
        return read_plan(folder / PLAN_FILE).drawn_at[:10]
    except DataError:
        return "unknown date"
