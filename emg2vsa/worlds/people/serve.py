"""The devices that a study's [session] names, emulated where it says that they are, for one emulated participant."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager

from emg2vsa.errors import SettingError
from emg2vsa.worlds.far_ends.lsl.outlets import served_streams
from emg2vsa.worlds.far_ends.trigno.server import served_trigno
from emg2vsa.worlds.people.far_end import Served, Table, elsewhere
from emg2vsa.worlds.people.force_box import served_box

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
