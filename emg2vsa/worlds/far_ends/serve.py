"""What stands at an emulated participant's table: the devices that a study's [session] names, where it says that they
are, for programs that run elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.devices.clock import FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.lsl import LslEmgSettings, LslForceSettings
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.trigno import COMMAND_PORT, TrignoSettings
from emg2vsa.devices.trigno.driver import places_of
from emg2vsa.errors import SettingError
from emg2vsa.session_settings import SessionSettings
from emg2vsa.worlds.far_ends.lsl import LslOutlets
from emg2vsa.worlds.far_ends.netft_box import BoxSettings, RdtBox
from emg2vsa.worlds.far_ends.netft_server import RdtServer
from emg2vsa.worlds.far_ends.trigno_server import ANY_PORTS, Ports, TrignoServer
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import felt_n

TORQUE_NOISE_NM = 1e-4
_LOOPBACK = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True)
class Table:
    """Where a participant sits. force : the [force] of the rig file, where session.force.kind is rig."""

    participant: EmulatedParticipant
    settings: SessionSettings
    force: ForceSettings | None
    clock: FastClock | WallClock
    start_delay_s: float


@dataclass(frozen=True)
class Served:
    """What stands where. lines : for people, a line each. addresses : the same for programs, "emg", "force" or "lsl" to
    its parts. trigno : None where the EMG is no Trigno's."""

    lines: tuple[str, ...] = ()
    addresses: dict[str, dict[str, object]] = field(default_factory=dict)
    trigno: TrignoServer | None = None


def check_here(where: str, host: str | None, found: str) -> None:
    """SettingError where a device is not on this computer."""
    if host not in _LOOPBACK:
        raise elsewhere(where, found)


def elsewhere(where: str, found: str) -> SettingError:
    do = 'Emulate with a copy of the file that has host = "127.0.0.1" (of a box: kind = "net-ft", http_port = 8080).'
    return SettingError(where, wanted="a network device on this computer", found=found, do=do)


@contextmanager
def served_trigno(at: Table) -> Iterator[Served]:
    """The system where the study says. SettingError where that is another computer; DeviceError for a port in use."""
    emg = at.settings.emg
    assert isinstance(emg, TrignoSettings)
    check_here("session.emg.host", emg.host, emg.host)
    slots = {place.sensor: muscle for muscle, place in places_of(emg.channels).items()}
    usual = Ports() if emg.command_port == COMMAND_PORT else ANY_PORTS
    ports = usual._replace(command=emg.command_port, emg=emg.emg_port)
    with TrignoServer(
        at.participant, slots, at.clock, ports=ports, start_delay_s=at.start_delay_s, delay_s=emg.delay_s
    ) as server:
        said = ", ".join(f"{name} {port}" for name, port in server.ports._asdict().items()).replace("_", " ")
        address: dict[str, object] = {"kind": "trigno", "hosts": ["127.0.0.1", "::1"], "ports": server.ports._asdict()}
        yield Served((f"EMG: Trigno server at 127.0.0.1 and ::1, ports {said}",), {"emg": address}, server)


@contextmanager
def served_streams(at: Table) -> Iterator[Served]:
    """Both streams, whichever of them the session takes. SettingError on a clock that is not LSL's."""
    if not isinstance(at.clock, WallClock):
        do = "Leave --speed out; LSL stamps samples with the computer's own clock."
        raise SettingError("--speed", wanted="1 with streams of LSL", found="another speed", do=do)
    emg = at.settings.emg if isinstance(at.settings.emg, LslEmgSettings) else None
    force = at.settings.force if isinstance(at.settings.force, LslForceSettings) else LslForceSettings()
    labels = emg.channels if emg else {muscle: muscle for muscle in at.participant.person.muscle_share}
    names = emg.stream if emg else None, force.stream
    outlets = LslOutlets(at.participant, labels, at.clock, force_label=force.channel or "force", names=names)
    with outlets:
        yield Served((f"LSL streams: {' and '.join(outlets.names)}",), {"lsl": {"streams": list(outlets.names)}})


@contextmanager
def served_box(at: Table) -> Iterator[Served]:
    """The box where the rig file says. SettingError where that is another computer."""
    force, own = at.force, at.settings.force
    assert isinstance(force, NetFtSettings)
    assert isinstance(own, RigForceSettings)
    found = f"{force.kind} at {force.host}" if force.host else force.kind
    check_here("force.kind and force.host of the rig file", force.host, found)
    box = force_box(at.participant, own.axis)
    with RdtServer(box, at.clock, rdt_port=force.rdt_port, http_port=force.http_port) as server:
        ports = {"rdt_port": server.rdt_port, "http_port": server.http_port}
        line = f"force: Net F/T box at {server.host}, RDT {server.rdt_port}, HTTP {server.http_port}"
        yield Served((line,), {"force": {"kind": "net-ft", "host": server.host, **ports}})


def force_box(participant: EmulatedParticipant, axis: tuple[float, float, float], rate_hz: float = 1000.0) -> RdtBox:
    """The box under the specimen. axis : direction, in the sensor's axes, in which a pressing finger pushes."""
    direction = np.array(axis) / np.linalg.norm(axis)

    def wrenches(times_s: Sequence[float]) -> list[list[float]]:
        forces_n = felt_n(participant, np.array(times_s))
        return [[*force_n, 0.0, 0.0, 0.0] for force_n in np.outer(forces_n, direction).tolist()]

    noise = participant.person.force_noise_n, TORQUE_NOISE_NM
    return RdtBox(wrenches, BoxSettings(rate_hz=rate_hz, noise=noise, seed=participant.person.seed[0]))


FAR_ENDS: dict[tuple[str, str], Callable[[Table], AbstractContextManager[Served]]] = {
    ("emg", "trigno"): served_trigno,
    ("force", "net-ft"): served_box,
    ("emg", "lsl"): served_streams,
    ("session-force", "lsl"): served_streams,
}
"""By role and kind of the device; no other process reaches the others. One that plays two roles is served once."""


@contextmanager
def serve(at: Table) -> Iterator[Served]:
    """Serve within a with statement.

    SettingError : a device is of a kind that no other process can reach, or is not on this computer.
    """
    wanted = {("emg", at.settings.emg.kind), ("session-force", at.settings.force.kind)}
    if at.force is not None:
        wanted.add(("force", at.force.kind))
        if ("force", at.force.kind) not in FAR_ENDS:
            raise elsewhere("force.kind and force.host of the rig file", at.force.kind)
    ends = dict.fromkeys(end for device, end in FAR_ENDS.items() if device in wanted)
    if not ends:
        raise SettingError(
            "session.emg.kind and session.force.kind",
            wanted="a device that another program can reach: trigno or lsl, rig or lsl",
            found=f"{at.settings.emg.kind} and {at.settings.force.kind}",
            do="For simulated sources run emg2vsa session itself; it needs no emulated device.",
        )
    with ExitStack() as stack:
        served = [stack.enter_context(end(at)) for end in ends]
        yield Served(
            tuple(line for each in served for line in each.lines),
            {name: parts for each in served for name, parts in each.addresses.items()},
            next((each.trigno for each in served if each.trigno), None),
        )
