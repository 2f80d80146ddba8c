"""Everything that goes wrong in the fault matrix, and how a run is to end by it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, NamedTuple

from benchmarks.rig.fault_bench import FaultBench, Strike
from emg2vsa.rig.force.rdt import Command, request_bytes


class End(NamedTuple):
    """How, and for which cause."""

    how: str
    cause: str


@dataclass(frozen=True)
class Fault:
    """One fault.

    end : of a run in which it strikes while the loop goes round. activation : where it strikes before that.
    later : it shows only after a while, perhaps in a later phase.
    harmless_in : phases in which it touches nothing that the run needs.
    probe : retracted; left, the motors could not be told to take it away; unsure, nothing tells whether they have.
    """

    strike: Strike
    end: End
    activation: End | None = None
    later: bool = False
    harmless_in: tuple[str, ...] = ()
    probe: Literal["retracted", "left", "unsure"] = "retracted"

    def ends(self, phase: str) -> End:
        """How the run is to end."""
        if phase == "escape":
            return self.end if self.end == KILLED else STOPPED
        if phase == "activation" and self.activation:
            return self.activation
        return SURVIVED if phase in self.harmless_in else self.end


SURVIVED = End("completed", "")
KILLED = End("killed", "")
"As ended.json says from the start until the end is written."
REFUSED = End("guard", "activation")
STOPPED = End("stopped", "SIGTERM")
LOST_ACTUATOR, STALE, LOST_CAMERA = (
    End("guard", "lost device"),
    End("guard", "stale sensor"),
    End("guard", "lost camera"),
)
RECORDING = End("guard", "recording")
FILES = ("log.csv", "force.csv", "frames.tif", "plan.json", "ended.json")


def _lose(way: str, count: int = 1) -> Strike:
    return lambda bench: bench.emulated.wire.lose(way, at=2, count=count)  # type: ignore[arg-type]


def _corrupt(way: str) -> Strike:
    return lambda bench: bench.emulated.wire.corrupt(way, at=-2)  # type: ignore[arg-type]


def _wire(name: str) -> Strike:
    return lambda bench: setattr(bench.emulated.wire, name, True)


def _box(name: str, value: float) -> Strike:
    return lambda bench: setattr(bench.emulated.box.faults, name, value)


def _camera(name: str, value: int) -> Strike:
    return lambda bench: setattr(bench.emulated.camera.faults, name, value)


def _held_up(duration_s: float) -> Strike:
    return lambda bench: bench.clock.sleep_until(bench.clock.now_s() + duration_s)


def _other_client(bench: FaultBench) -> None:
    bench.emulated.box.request(request_bytes(Command.STOP), lambda data, time_s: None, bench.clock.now_s())


def _interrupted(bench: FaultBench) -> None:
    raise KeyboardInterrupt


def _bench(name: str, value: object) -> Strike:
    return lambda bench: setattr(bench, name, value)


def _line(name: str, value: object) -> Strike:
    return lambda bench: setattr(bench.line, name, value)


ACTUATOR_FAULTS: dict[str, Fault] = {
    "one byte lost to the device": Fault(_lose("to device"), SURVIVED),
    "one byte lost to the host": Fault(_lose("to host"), SURVIVED),
    "eight bytes lost to the device": Fault(_lose("to device", 8), SURVIVED),
    "one byte corrupt to the device": Fault(_corrupt("to device"), SURVIVED),
    "one byte corrupt to the host": Fault(_corrupt("to host"), SURVIVED),
    "every answer corrupt": Fault(_wire("noisy"), LOST_ACTUATOR, REFUSED, probe="unsure"),
    "actuator mute": Fault(_wire("mute"), LOST_ACTUATOR, REFUSED, probe="unsure"),
    "actuator deaf": Fault(_wire("deaf"), LOST_ACTUATOR, REFUSED, probe="left"),
    "serial line gone": Fault(_line("gone", True), LOST_ACTUATOR, REFUSED, probe="left"),
    "actuator reset": Fault(
        lambda bench: bench.emulated.reset_actuator(), LOST_ACTUATOR, SURVIVED, later=True, probe="left"
    ),
    "watchdog expired": Fault(_held_up(0.6), LOST_ACTUATOR, SURVIVED, probe="left"),
}
LOOP_FAULTS: dict[str, Fault] = {
    "loop held up 20 ms": Fault(_held_up(0.02), SURVIVED),
    "loop held up 200 ms": Fault(_held_up(0.2), End("guard", "overrun"), SURVIVED),
}
SENSOR_FAULTS: dict[str, Fault] = {
    "force stuck": Fault(_box("stuck", True), STALE, later=True),
    "ten force records lost": Fault(_box("lose", 10), SURVIVED),
    "hundred force records lost": Fault(_box("lose", 100), STALE, SURVIVED, later=True),
    "force stream stopped": Fault(_other_client, STALE, later=True),
    "force sensor mute": Fault(_box("mute", True), STALE, later=True),
    "force sensor saturated": Fault(_box("saturated", True), End("guard", "untrusted force")),
    "force beyond the limit": Fault(_box("push_n", 12.0), End("guard", "force limit")),
    "force jumps": Fault(_box("push_n", 2.0), End("guard", "force rate"), End("guard", "preload")),
    "three frames lost": Fault(_camera("drop", 3), SURVIVED),
    "forty frames lost": Fault(_camera("drop", 40), LOST_CAMERA, later=True),
    "camera mute": Fault(_camera("mute", True), LOST_CAMERA, later=True),
}
DISK_FAULTS: dict[str, Fault] = {
    "disk full": Fault(_bench("full", FILES), RECORDING),
    "no room for the log": Fault(_bench("full", ("log.csv",)), RECORDING),
    "no room for forces": Fault(
        _bench("full", ("force.csv",)), RECORDING, later=True, harmless_in=("retract", "pause")
    ),
    "no room for frames": Fault(
        _bench("full", ("frames.tif",)), RECORDING, later=True, harmless_in=("retract", "pause")
    ),
    "ended.json not writable": Fault(_bench("broken", ("ended.json",)), KILLED),
}
ENDINGS: dict[str, Fault] = {
    "asked to stop": Fault(_bench("stop", "SIGTERM"), STOPPED),
    "Ctrl-C asleep": Fault(_interrupted, End("interrupted", "Ctrl-C")),
    "Ctrl-C while talking": Fault(_line("error", KeyboardInterrupt()), End("interrupted", "Ctrl-C")),
    "error of the program": Fault(
        _line("error", ZeroDivisionError("division by zero")), End("failed", "ZeroDivisionError")
    ),
}
FAULTS = ACTUATOR_FAULTS | LOOP_FAULTS | SENSOR_FAULTS | DISK_FAULTS | ENDINGS
