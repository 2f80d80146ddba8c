"""Everything that goes wrong in the fault matrix, and how a run may end by it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, NamedTuple

from benchmarks.rig.fault_bench import Built, FaultBench, Strike
from emg2vsa.devices.netft import box as rdt
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.faults import put


class End(NamedTuple):
    """How, and for which cause."""

    how: str
    cause: str


@dataclass(frozen=True)
class Fault:
    """One fault.

    ends : of a run in which it strikes while the loop goes round; any of them tells the truth.
    activation : where it strikes before that.
    springs_only : a rigid motor has nothing that could go wrong so.
    later : it shows only after a while, perhaps in a later phase.
    harmless_in : phases in which it touches nothing that the run needs.
    unseen_in : phases in which it may come too late to show.
    probe : retracted; free of the specimen, perhaps not at home; left, the motors could not be told to take it away;
        unsure, nothing tells whether they have.
    """

    strike: Strike
    ends: tuple[End, ...]
    activation: End | None = None
    springs_only: bool = False
    later: bool = False
    harmless_in: tuple[str, ...] = ()
    unseen_in: tuple[str, ...] = ()
    probe: Literal["retracted", "free", "left", "unsure"] = "retracted"

    def ends_in(self, phase: str) -> tuple[End, ...]:
        """How the run may end."""
        if phase == "escape":
            return self.ends if KILLED in self.ends else (STOPPED,)
        if phase == "activation" and self.activation:
            return (self.activation,)
        if phase in self.harmless_in:
            return (SURVIVED,)
        return (*self.ends, SURVIVED) if phase in self.unseen_in else self.ends


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
RECORDING, OVERRUN, SLOW_LINE = End("guard", "recording"), End("guard", "overrun"), End("guard", "slow line")
LIMIT, RATE, TRAVEL, UNTRUSTED, PRELOAD = (
    End("guard", "force limit"), End("guard", "force rate"), End("guard", "travel"), End("guard", "untrusted force"),
    End("guard", "preload"),
)  # fmt: skip
FOLLOWING, CURRENT, LATERAL, SPRINGS, FROZEN, WAY_HOME, NO_CONTACT, PAST_CONTACT, OVERLOAD, SPECIMEN, UNFELT = (
    End("guard", "following"), End("guard", "motor current"), End("guard", "lateral force"),
    End("guard", "spring limit"), End("guard", "frozen force"), End("guard", "way home"), End("guard", "no contact"),
    End("guard", "past contact"), End("guard", "sensor overload"), End("guard", "specimen"),
    End("guard", "unfelt contact"),
)  # fmt: skip
REJECTED, NOT_RETRACTED = End("rejected", "press"), End("rejected", "not retracted")
MOTION = (FOLLOWING, CURRENT)
JUMP = (*MOTION, SPRINGS, UNTRUSTED, SPECIMEN, PAST_CONTACT, NO_CONTACT, TRAVEL, WAY_HOME)
BLIND = (LATERAL, SPRINGS, UNTRUSTED, SPECIMEN, RATE, LIMIT, NO_CONTACT, PAST_CONTACT, PRELOAD, WAY_HOME, UNFELT)
AFTER = ("retract", "pause")
"""Of the one press of a case: nothing is measured any more."""
FILES = ("log.csv", "force.csv", "frames.tif", "plan.json", "ended.json")


def words(line: str) -> Strike:
    """As `put` understands it."""
    return lambda bench: put_all(bench, line)


def put_all(bench: FaultBench, lines: str) -> None:
    """Faults by their words, parted by semicolons."""
    for line in lines.split(";"):
        put(bench.emulated, line)


def _lose(way: str, count: int = 1) -> Strike:
    return lambda bench: bench.emulated.wire.lose(way, at=2, count=count)  # type: ignore[arg-type]


def _corrupt(way: str) -> Strike:
    return lambda bench: bench.emulated.wire.corrupt(way, at=-2)  # type: ignore[arg-type]


def _noisy(bench: FaultBench) -> None:
    bench.emulated.wire.noisy = True


def _held_up(duration_s: float) -> Strike:
    return lambda bench: bench.clock.sleep_until(bench.clock.now_s() + duration_s)


def _other_client(bench: FaultBench) -> None:
    bench.emulated.box.request(rdt.request_bytes(rdt.Command.STOP), lambda data, time_s: None, bench.clock.now_s())


def _interrupted(bench: FaultBench) -> None:
    raise KeyboardInterrupt


def _bench(name: str, value: object) -> Strike:
    return lambda bench: setattr(bench, name, value)


def _line(name: str, value: object) -> Strike:
    return lambda bench: setattr(bench.line, name, value)


def actuator_fault(line: str, *ends: End, **more: object) -> Fault:
    """That lasts, shows only after a while, and perhaps never once the press is over."""
    return Fault(words(line), ends, later=True, unseen_in=AFTER, **more)  # type: ignore[arg-type]


def _watchdog_frame_lost(bench: FaultBench) -> None:
    # as the device leaves the factory, without a watchdog
    bench.emulated.reset_actuator()
    bench.line.loses = bench.emulated.wire.frames.watchdog_commands


LINE_FAULTS: dict[str, Fault] = {
    "one byte lost to the device": Fault(_lose("to device"), (SURVIVED,)),
    "one byte lost to the host": Fault(_lose("to host"), (SURVIVED,)),
    "eight bytes lost to the device": Fault(_lose("to device", 8), (SURVIVED,)),
    "one byte corrupt to the device": Fault(_corrupt("to device"), (SURVIVED,)),
    "one byte corrupt to the host": Fault(_corrupt("to host"), (SURVIVED,)),
    "every answer corrupt": Fault(_noisy, (LOST_ACTUATOR,), REFUSED, probe="unsure"),
    "1 % of bytes lost": actuator_fault(
        "bytes-lost 1", LOST_ACTUATOR, REFUSED, SURVIVED, REJECTED, *MOTION, OVERRUN, probe="unsure"
    ),
    "10 % of bytes lost": actuator_fault("bytes-lost 10", LOST_ACTUATOR, REFUSED, *MOTION, probe="unsure"),
    "1 % of bytes wrong": actuator_fault(
        "bits-wrong 1", LOST_ACTUATOR, REFUSED, SURVIVED, REJECTED, *MOTION, OVERRUN, probe="unsure"
    ),
    "replies doubled": Fault(words("doubled"), (SURVIVED,)),
    "replies 4 ms late": Fault(words("late 4"), (SURVIVED, REJECTED, OVERRUN, SLOW_LINE, *MOTION), later=True),
    "replies 30 ms late": Fault(words("late 30"), (LOST_ACTUATOR, OVERRUN, SLOW_LINE), probe="unsure"),
    "answers of another id": Fault(words("stranger"), (LOST_ACTUATOR,), REFUSED, probe="unsure"),
    "actuator's line flooded": Fault(words("flood"), (LOST_ACTUATOR,), REFUSED, probe="unsure"),
    "actuator mute": Fault(words("mute"), (LOST_ACTUATOR,), REFUSED, probe="unsure"),
    "actuator deaf": Fault(words("deaf"), (LOST_ACTUATOR,), REFUSED, probe="left"),
    "serial line gone": Fault(_line("gone", True), (LOST_ACTUATOR,), REFUSED, probe="left"),
    "actuator reset": Fault(words("reset"), (LOST_ACTUATOR, *MOTION), SURVIVED, later=True),
    "watchdog expired": Fault(_held_up(0.6), (OVERRUN, LOST_ACTUATOR), SURVIVED),
}
MOTOR_FAULTS: dict[str, Fault] = {
    "commands ignored 0.5 s": actuator_fault("ignore for 0.5 s", *MOTION, SURVIVED, probe="free"),
    "commands ignored 1.0 s": actuator_fault("ignore for 1.0 s", *MOTION, probe="free"),
    "commands ignored 1.5 s": actuator_fault("ignore for 1.5 s", *MOTION, probe="free"),
    "commands ignored 2.1 s": actuator_fault("ignore for 2.1 s", *MOTION, probe="free"),
    "commands ignored for ever": actuator_fault("ignore", *MOTION, probe="left"),
    "gear jammed": actuator_fault("jam", *MOTION, probe="left"),
    "gear jammed 1 s": actuator_fault("jam for 1 s", *MOTION, probe="left"),
    "24 V lost, USB on": actuator_fault("brown-out", *MOTION, probe="left"),
    "24 V lost for 1 s": actuator_fault("brown-out for 1 s", *MOTION, probe="free"),
    "motors weak": actuator_fault("weak 0.02", *MOTION, probe="left"),
    "encoder of motor 1 frozen": actuator_fault("frozen-motor-1", *JUMP, probe="left"),
    "encoder of motor 2 frozen": actuator_fault("frozen-motor-2", *JUMP, probe="left", springs_only=True),
    "encoder of the shaft frozen": actuator_fault("frozen-shaft", SPRINGS, *MOTION, UNTRUSTED, springs_only=True),
    "both motor encoders frozen": actuator_fault("frozen-motor-1;frozen-motor-2", *JUMP, probe="left"),
    "motor 1 reads 9000 more": actuator_fault("jumped-motor-1", *JUMP, probe="left"),
    "motor 2 reads 9000 more": actuator_fault("jumped-motor-2", *JUMP, probe="left", springs_only=True),
    "motor 1 reads 9000 less": actuator_fault("jumped-motor-1 -9000", *JUMP, probe="left"),
    "both motors read 4096 less": actuator_fault("jumped-motor-1 -4096;jumped-motor-2 -4096", *JUMP, probe="left"),
    "shaft reads 9000 more": actuator_fault("jumped-shaft", SPRINGS, *MOTION, UNTRUSTED, springs_only=True),
    "currents of 6 A": Fault(words("current"), (CURRENT,), unseen_in=AFTER, later=True),
}
LOOP_FAULTS: dict[str, Fault] = {
    "loop held up 20 ms": Fault(_held_up(0.02), (SURVIVED,)),
    "loop held up 200 ms": Fault(_held_up(0.2), (OVERRUN,), SURVIVED),
    "loop held up 2 s": Fault(_held_up(2.0), (OVERRUN, LOST_ACTUATOR), SURVIVED),
}
FORCE_FAULTS: dict[str, Fault] = {
    "force stuck": Fault(words("stuck"), (FROZEN, STALE, UNTRUSTED, SPECIMEN), later=True, unseen_in=("pause",)),
    "ten force records lost": Fault(words("gap 10"), (SURVIVED, REJECTED)),
    "hundred force records lost": Fault(words("gap 100"), (STALE,), SURVIVED, later=True),
    "5 % of force records lost": Fault(words("thinned 5"), (SURVIVED, REJECTED)),
    "50 % of force records lost": Fault(words("thinned 50"), (SURVIVED, REJECTED, STALE), later=True),
    "force records doubled": Fault(words("twice"), (SURVIVED,)),
    "force records reordered": Fault(words("shuffled 4"), (SURVIVED, REJECTED)),
    "force records 20 ms late": Fault(words("delayed 20"), (SURVIVED, STALE), later=True),
    "force records 100 ms late": Fault(
        words("delayed 100"), (STALE, SPECIMEN, UNTRUSTED, UNFELT, LIMIT), later=True, probe="unsure"
    ),
    "force lags 20 ms": Fault(words("lag 20"), (SURVIVED, *BLIND), later=True),
    "force lags 100 ms": Fault(words("lag 100"), (SURVIVED, *BLIND), later=True, probe="unsure"),
    "force records cut short": Fault(words("cut"), (STALE,), later=True),
    "one force record for ever": Fault(words("replayed"), (STALE, FROZEN), later=True),
    "force stream stopped": Fault(_other_client, (STALE,), later=True),
    "force sensor mute": Fault(words("silent"), (STALE,), later=True),
    "force sensor saturated": Fault(words("saturated"), (UNTRUSTED,)),
    "largest counts": Fault(words("overflow"), (LIMIT, UNTRUSTED, RATE, LATERAL, OVERLOAD)),
    "force beyond the limit": Fault(words("push 12"), (LIMIT, RATE), probe="unsure"),
    "force jumps": Fault(words("push 2"), (RATE,), PRELOAD, probe="unsure"),
    "force drifts down": Fault(words("drift -2"), (SURVIVED, NOT_RETRACTED, *BLIND), later=True, probe="unsure"),
    "force has the wrong sign": Fault(words("turned"), BLIND, later=True, unseen_in=AFTER),
    "force has the wrong axis": Fault(words("swapped"), BLIND, later=True, unseen_in=AFTER),
    "force axis dead": Fault(words("dead"), BLIND, later=True, unseen_in=AFTER),
    "force a fifth": Fault(words("gain 0.2"), (*BLIND, *MOTION), later=True, unseen_in=AFTER),
    "force sensor's line flooded": Fault(words("swamp"), (STALE,)),
    "flood of strange sequences": Fault(words("garbage"), (SURVIVED, REJECTED, STALE, UNTRUSTED), later=True),
    "one strange record": Fault(words("trash"), (SURVIVED, LIMIT, RATE, LATERAL, UNTRUSTED, STALE), later=True),
}
CAMERA_FAULTS: dict[str, Fault] = {
    "three frames lost": Fault(words("drop 3"), (SURVIVED,)),
    "forty frames lost": Fault(words("drop 40"), (LOST_CAMERA,), later=True),
    "camera mute": Fault(words("dark"), (LOST_CAMERA,), later=True),
    "half the frames": Fault(words("few-frames"), (SURVIVED, REJECTED)),
    "pictures 0.4 s old": Fault(words("old-frames"), (SURVIVED,)),
}
DISK_FAULTS: dict[str, Fault] = {
    "disk full": Fault(_bench("full", FILES), (RECORDING,)),
    "no room for the log": Fault(_bench("full", ("log.csv",)), (RECORDING,)),
    "no room for forces": Fault(_bench("full", ("force.csv",)), (RECORDING,), later=True, harmless_in=AFTER),
    "no room for frames": Fault(_bench("full", ("frames.tif",)), (RECORDING,), later=True, harmless_in=AFTER),
    "ended.json not writable": Fault(_bench("broken", ("ended.json",)), (KILLED,)),
}
ENDINGS: dict[str, Fault] = {
    "asked to stop": Fault(_bench("stop", "SIGTERM"), (STOPPED,)),
    "Ctrl-C asleep": Fault(_interrupted, (End("interrupted", "Ctrl-C"),)),
    "Ctrl-C while talking": Fault(_line("error", KeyboardInterrupt()), (End("interrupted", "Ctrl-C"),)),
    "error of the program": Fault(
        _line("error", ZeroDivisionError("division by zero")), (End("failed", "ZeroDivisionError"),)
    ),
    "program killed": Fault(FaultBench.kill, (KILLED,), probe="left"),
    "program killed, watchdog frame lost": Fault(FaultBench.kill, (KILLED,), probe="left"),
}
BEFORE: dict[str, Strike] = {"program killed, watchdog frame lost": _watchdog_frame_lost}
"""What went wrong already as the run began."""
FAULTS = LINE_FAULTS | MOTOR_FAULTS | LOOP_FAULTS | FORCE_FAULTS | CAMERA_FAULTS | DISK_FAULTS | ENDINGS

_TRUE = RigSettings()
REFUSED_FILE, REFUSED_SCHEDULE = End("refused", "SettingError"), End("refused", "ScheduleError")
WRONG_RIGS: dict[str, tuple[Built, tuple[End, ...]]] = {
    "push_axis along x": (Built(told=replace(_TRUE, push_axis=(1.0, 0.0, 0.0))), BLIND),
    "push_axis upside down": (Built(told=replace(_TRUE, push_axis=(0.0, 0.0, -1.0))), BLIND),
    "push_sign upside down": (Built(told=replace(_TRUE, push_sign=-1)), (TRAVEL, NO_CONTACT, *MOTION, SPRINGS)),
    "home 9 mm too deep": (Built(told=replace(_TRUE, home_deg=45.0)), (WAY_HOME, PRELOAD, SPRINGS)),
    "home 4 mm too deep": (Built(told=replace(_TRUE, home_deg=20.0)), (WAY_HOME, PRELOAD, SPRINGS)),
    "gear of 0.1 for 0.2": (Built(told=replace(_TRUE, gear_mm_per_degree=0.1)), (REFUSED_FILE, REFUSED_SCHEDULE)),
    "gear of 0.1 for 0.2 (rigid)": (
        Built(rigid=True, told=replace(_TRUE, gear_mm_per_degree=0.1)), (SPECIMEN, REFUSED_FILE),
    ),
    "gear of 0.4 for 0.2 (rigid)": (
        Built(rigid=True, told=replace(_TRUE, gear_mm_per_degree=0.4)), (SPECIMEN, NO_CONTACT),
    ),
    "push_axis along x (rigid)": (Built(rigid=True, told=replace(_TRUE, push_axis=(1.0, 0.0, 0.0))), BLIND),
    "home 9 mm too deep (rigid)": (
        Built(rigid=True, told=replace(_TRUE, home_deg=45.0)), (WAY_HOME, PRELOAD, SPRINGS),
    ),
    "filter of 2000 samples": (Built(told=replace(_TRUE, filter_samples=2000)), (REFUSED_FILE, LIMIT, SPRINGS)),
    "loop at 1000 Hz": (Built(told=replace(_TRUE, rate_hz=1000.0)), (SURVIVED, REFUSED_FILE)),
}  # fmt: skip
"""What the program is told of the rig, against what it is."""
