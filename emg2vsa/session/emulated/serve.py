"""The devices that a study's [session] names, emulated where it says that they are, for one emulated participant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

import numpy as np

from emg2vsa.devices.clock import FastClock, WallClock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.trigno.driver import places_of
from emg2vsa.errors import SettingError
from emg2vsa.rig.emulated.netft.box import BoxSettings, RdtBox
from emg2vsa.rig.emulated.netft.server import RdtServer
from emg2vsa.session.emulated.lsl.outlets import LslOutlets
from emg2vsa.session.emulated.participant import EmulatedParticipant
from emg2vsa.session.emulated.sensors import felt_n
from emg2vsa.session.emulated.trigno.server import Ports, TrignoServer
from emg2vsa.session_settings import TRIGNO_COMMAND_PORT, EmgSourceSettings, SessionSettings

TORQUE_NOISE_NM = 1e-4
LOOPBACK = ("127.0.0.1", "localhost", "::1")


@dataclass(frozen=True)
class Served:
    """What stands where. lines : for people, a line each. addresses : the same for programs, "emg", "force" or "lsl" to
    its parts. trigno : None where the EMG is no Trigno's."""

    lines: tuple[str, ...]
    addresses: dict[str, dict[str, object]]
    trigno: TrignoServer | None


@contextmanager
def serve(
    participant: EmulatedParticipant,
    settings: SessionSettings,
    force: ForceSettings | None,
    clock: FastClock | WallClock,
    start_delay_s: float,
) -> Iterator[Served]:
    """Serve within a with statement. force : the [force] of the rig file, where session.force.kind is rig.

    SettingError : a device is of a kind that no other process can reach, or is not on this computer.
    """
    _check(settings, force, clock)
    lines: list[str] = []
    addresses: dict[str, dict[str, object]] = {}
    trigno = None
    with ExitStack() as stack:
        if settings.emg.kind == "trigno":
            trigno = stack.enter_context(_trigno(participant, settings.emg, clock, start_delay_s))
            addresses["emg"] = {"kind": "trigno", "hosts": ["127.0.0.1", "::1"], "ports": trigno.ports._asdict()}
            ports = ", ".join(f"{name} {port}" for name, port in trigno.ports._asdict().items())
            lines.append(f"EMG: Trigno server at 127.0.0.1 and ::1, ports {ports.replace('_', ' ')}")
        if force is not None:
            box = force_box(participant, settings.force.axis)
            server = RdtServer(box, clock, rdt_port=force.rdt_port, http_port=force.http_port)
            stack.enter_context(server)
            addresses["force"] = {
                "kind": "net-ft", "host": server.host, "rdt_port": server.rdt_port, "http_port": server.http_port
            }  # fmt: skip
            lines.append(f"force: Net F/T box at {server.host}, RDT {server.rdt_port}, HTTP {server.http_port}")
        if "lsl" in (settings.emg.kind, settings.force.kind):
            assert isinstance(clock, WallClock)
            labels = settings.emg.channels if settings.emg.kind == "lsl" else {}
            outlets = LslOutlets(
                participant,
                labels or {muscle: muscle for muscle in participant.person.muscle_share},
                clock,
                force_label=settings.force.channel or "force",
                names=(settings.emg.stream, settings.force.stream),
            )
            stack.enter_context(outlets)
            addresses["lsl"] = {"streams": list(outlets.names)}
            lines.append(f"LSL streams: {' and '.join(outlets.names)}")
        yield Served(tuple(lines), addresses, trigno)


def _trigno(
    participant: EmulatedParticipant, settings: EmgSourceSettings, clock: FastClock | WallClock, start_delay_s: float
) -> TrignoServer:
    slots = {place.sensor: muscle for muscle, place in places_of(settings.channels).items()}
    usual = Ports() if settings.command_port == TRIGNO_COMMAND_PORT else Ports(0, 0, 0, 0, 0)
    ports = usual._replace(command=settings.command_port, emg=settings.emg_port)
    return TrignoServer(
        participant, slots, clock, ports=ports, start_delay_s=start_delay_s, delay_s=settings.delay_s
    )  # fmt: skip


def _check(settings: SessionSettings, force: ForceSettings | None, clock: FastClock | WallClock) -> None:
    kinds = settings.emg.kind, settings.force.kind
    if kinds[0] in ("ni-daq", "simulated") and kinds[1] == "simulated":
        raise SettingError(
            "session.emg.kind and session.force.kind",
            wanted="a device that another program can reach: trigno or lsl, rig or lsl",
            found=" and ".join(kinds),
            do="For simulated sources run emg2vsa session itself; it needs no emulated device.",
        )
    if kinds[0] == "trigno" and settings.emg.host not in LOOPBACK:
        raise _elsewhere("session.emg.host", settings.emg.host)
    if force is not None and (force.kind != "net-ft" or force.host not in LOOPBACK):
        where = f"{force.kind} at {force.host}" if force.host else force.kind
        raise _elsewhere("force.kind and force.host of the rig file", where)
    if "lsl" in kinds and not isinstance(clock, WallClock):
        do = "Leave --speed out; LSL stamps samples with the computer's own clock."
        raise SettingError("--speed", wanted="1 with streams of LSL", found="another speed", do=do)


def _elsewhere(where: str, found: str) -> SettingError:
    do = 'Emulate with a copy of the file that has host = "127.0.0.1" (of a box: kind = "net-ft", http_port = 8080).'
    return SettingError(where, wanted="a network device on this computer", found=found, do=do)


def force_box(participant: EmulatedParticipant, axis: tuple[float, float, float], rate_hz: float = 1000.0) -> RdtBox:
    """The box under the specimen. axis : direction, in the sensor's axes, in which a pressing finger pushes."""
    direction = np.array(axis) / np.linalg.norm(axis)

    def wrenches(times_s: Sequence[float]) -> list[list[float]]:
        forces_n = felt_n(participant, np.array(times_s))
        return [[*force_n, 0.0, 0.0, 0.0] for force_n in np.outer(forces_n, direction).tolist()]

    noise = participant.person.force_noise_n, TORQUE_NOISE_NM
    return RdtBox(wrenches, BoxSettings(rate_hz=rate_hz, noise=noise, seed=participant.person.seed[0]))
