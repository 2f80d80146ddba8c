"""Trigger out: a byte, or a pulse of a control line, on a serial port, by which other devices know when it happened."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.serial_line import SerialLine
from emg2vsa.errors import DeviceError
from emg2vsa.session_settings import TriggerMark, TriggerSettings


class TriggerOut:
    """The port of [session.trigger], open and at rest. DeviceError where it cannot be had, or is gone."""

    def __init__(self, settings: TriggerSettings, clock: Clock) -> None:
        self._settings, self._clock = settings, clock
        self._until_s: float | None = None
        with self._named():
            self._line = SerialLine(settings.port, settings.baud)
            if settings.pulse_s:
                self._put(0)

    def send(self, mark: TriggerMark) -> tuple[int, float]:
        """The byte that was written, or 1 for a line that was raised; and when, on the session's clock."""
        code: int = getattr(self._settings, mark) if self._settings.pulse == "byte" else 1
        with self._named():
            self._put(code)
        sent_s = self._clock.now_s()
        self._until_s = sent_s + self._settings.pulse_s if self._settings.pulse_s else None
        return code, sent_s

    def turn(self, now_s: float) -> None:
        """End a pulse that has lasted long enough by ``now_s``, s."""
        if self._until_s is not None and now_s >= self._until_s:
            self._until_s = None
            with self._named():
                self._put(0)

    def close(self) -> None:
        """Give the port back, at rest."""
        try:
            self.turn(float("inf"))
        finally:
            self._line.close()

    def _put(self, code: int) -> None:
        if self._settings.pulse == "byte":
            self._line.write(bytes([code]))
        else:
            self._line.set_control(self._settings.pulse, bool(code))

    @contextmanager
    def _named(self) -> Iterator[None]:
        own = self._settings
        try:
            yield
        except DeviceError as error:
            where, wanted = f"session.trigger.port, {own.port}", f"a serial port that takes a {own.pulse}"
            raise DeviceError(where, wanted=wanted, found=error.found, do=error.do) from error
