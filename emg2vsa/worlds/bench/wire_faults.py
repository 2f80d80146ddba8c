"""Faults of the wire of any actuator, by the name that is typed."""

from __future__ import annotations

from typing import Any

from emg2vsa.worlds.bench.fault import Fault, Strike, of_part


def _lose(bench: Any, count: float) -> None:
    bench.wire.lose("to host", at=-int(count), count=int(count))


def _corrupt(bench: Any, count: float) -> None:
    for _ in range(int(count)):
        bench.wire.corrupt("to host", at=-1)


def _ignore(which: str) -> Strike:
    def strike(bench: Any, on: float) -> None:
        commands = getattr(bench.wire.frames, which)
        bench.wire.ignored = bench.wire.ignored | commands if on else bench.wire.ignored - commands

    return strike


def _share(percent: float) -> float:
    return percent / 100


WIRE_FAULTS = {
    "lose": Fault("the next reply of the actuator lacks its last N bytes", _lose),
    "corrupt": Fault("the next N replies of the actuator have a wrong byte", _corrupt),
    "reset": Fault("the actuator's power goes off and on", lambda bench, _: bench.reset_actuator()),
    "mute": Fault("the actuator hears but does not answer", of_part("wire", "mute"), "switch"),
    "deaf": Fault("the actuator hears nothing", of_part("wire", "deaf"), "switch"),
    "ignore": Fault("no position command reaches the actuator, all else does", _ignore("position_commands"), "switch"),
    "no-watchdog": Fault("no command of the watchdog reaches the actuator", _ignore("watchdog_commands"), "switch"),
    "late": Fault(
        "replies of the actuator come N ms late", of_part("wire", "late_s", lambda n: n / 1000), "amount", 4, 0, 0, 1000
    ),
    "bytes-lost": Fault(
        "N % of the bytes of both ways are lost", of_part("wire", "lost_share", _share), "amount", 1, 0, 0, 100
    ),
    "bits-wrong": Fault(
        "N % of the bytes of both ways have a wrong bit", of_part("wire", "wrong_share", _share), "amount", 1, 0, 0, 100
    ),
    "doubled": Fault("every reply of the actuator comes twice", of_part("wire", "doubled"), "switch"),
    "stranger": Fault("the actuator answers with the next id", of_part("wire", "id_shift", int), "switch"),
}
