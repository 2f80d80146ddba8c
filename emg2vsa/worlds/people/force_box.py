"""The Net F/T box under the specimen of an emulated participant."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from emg2vsa.devices.netft.settings import NetFtSettings
from emg2vsa.devices.rig_force.settings import RigForceSettings
from emg2vsa.worlds.far_ends.netft.box import BoxSettings, RdtBox
from emg2vsa.worlds.far_ends.netft.server import RdtServer
from emg2vsa.worlds.people.far_end import Served, Table, check_here
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
