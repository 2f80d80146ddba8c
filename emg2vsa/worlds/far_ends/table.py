"""What a far end is told of the table that it stands at, and what it says of where it stands."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Protocol

from emg2vsa.devices.clock import FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.errors import SettingError
from emg2vsa.session_settings import SessionSettings
from emg2vsa.worlds.people.participant import EmulatedParticipant

_LOOPBACK = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True)
class Table:
    """Where a participant sits. force : the [force] of the rig file, where session.force.kind is rig."""

    participant: EmulatedParticipant
    settings: SessionSettings
    force: ForceSettings | None
    clock: FastClock | WallClock
    start_delay_s: float


class Radio(Protocol):
    """What can go wrong with wireless sensors; `TrignoServer` says what each is."""

    def drop(self, frames: int) -> None: ...
    def stall(self, seconds: float) -> None: ...
    def disconnect(self) -> None: ...
    def unpair(self, slot: int) -> None: ...


@dataclass(frozen=True)
class Served:
    """What stands where. lines : for people, a line each. addresses : the same for programs, "emg", "force" or "lsl" to
    its parts. trigno : None where the EMG is no Trigno's."""

    lines: tuple[str, ...] = ()
    addresses: dict[str, dict[str, object]] = field(default_factory=dict)
    trigno: Radio | None = None


def check_here(where: str, host: str | None, found: str) -> None:
    """SettingError where a device is not on this computer."""
    if host not in _LOOPBACK:
        raise elsewhere(where, found)


def elsewhere(where: str, found: str) -> SettingError:
    do = 'Emulate with a copy of the file that has host = "127.0.0.1" (of a box: kind = "net-ft", http_port = 8080).'
    return SettingError(where, wanted="a network device on this computer", found=found, do=do)
