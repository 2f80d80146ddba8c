"""Events of a recording: rows with a time, a kind and cells of the data set's own columns, and what these mean."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field

from emg2vsa.bids.tables import ABSENT, Column, Json


@dataclass(frozen=True)
class Event:
    """onset_s, duration_s : from the first sample, rounded as they are to be written; None for what has no length.

    cells : by name of the column; one that is left out is not applicable.
    """

    onset_s: float
    duration_s: float | None
    kind: str
    cells: Mapping[str, object] = field(default_factory=dict)


@dataclass(frozen=True)
class EventColumns:
    """What the events of a data set hold. onset, duration : what is said of these times.

    own : columns beyond time and kind. decimals : of times, None: as needed.
    """

    onset: str
    duration: str
    kind: Column
    own: Mapping[str, Column] = field(default_factory=dict)
    decimals: int | None = None

    @property
    def names(self) -> tuple[str, ...]:
        return ("onset", "duration", "trial_type", *self.own)

    def json(self) -> Json:
        columns = (Column(self.onset, "s"), Column(self.duration, "s"), self.kind, *self.own.values())
        return {name: column.json() for name, column in zip(self.names, columns, strict=True)}

    def rows(self, events: Iterable[Event]) -> Iterator[tuple[object, ...]]:
        for event in events:
            own = (event.cells.get(name, ABSENT) for name in self.own)
            yield self._time(event.onset_s), self._time(event.duration_s), event.kind, *own

    def _time(self, time_s: float | None) -> object:
        if time_s is None:
            return ABSENT
        return time_s if self.decimals is None else f"{time_s:.{self.decimals}f}"


@dataclass(frozen=True)
class Screen:
    """What told the participant what to do. software : version of this program. size_px : width and height."""

    software: str
    computer: str | None = None
    size_px: tuple[int, int] | None = None

    def json(self) -> Json:
        """Beside the columns."""
        made: Json = {"SoftwareName": "emg2vsa", "SoftwareVersion": self.software}
        made |= {} if self.computer is None else {"OperatingSystem": self.computer}
        made |= {} if self.size_px is None else {"ScreenResolution": list(self.size_px)}
        return {"StimulusPresentation": made}
