"""The devices that a study's [session] names, emulated where it says that they are, for one emulated participant."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager

import numpy as np

from emg2vsa.devices.netft.settings import NetFtSettings
from emg2vsa.devices.rig_force.settings import RigForceSettings
from emg2vsa.errors import SettingError
from emg2vsa.worlds.far_ends.lsl.outlets import served_streams
from emg2vsa.worlds.far_ends.netft.box import BoxSettings, RdtBox
from emg2vsa.worlds.far_ends.netft.server import RdtServer
from emg2vsa.worlds.far_ends.table import Served, Table, check_here, elsewhere
from emg2vsa.worlds.far_ends.trigno.server import served_trigno
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import felt_n

TORQUE_NOISE_NM = 1e-4


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
