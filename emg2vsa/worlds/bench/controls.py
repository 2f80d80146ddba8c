"""Control worlds, whose answer is known: what the key ``control`` makes of bench and experiment.

An analysis that finds an effect in N1 or N2, or misses those of P1, P2 and P4, is wrong. What is true in each world
stands in docs/how-to/controls.md. P1 and P4 have an artificial effect of stiffness on the area of the contact.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from emg2vsa.rig.experiment import schedule_for
from emg2vsa.worlds.bench.settings import VISCOELASTIC_KEYS, EmulatedSettings

if TYPE_CHECKING:
    from emg2vsa.schedules import Schedule

ARTIFICIAL = ("P1", "P4")
_NOISE_SD, _NOISE_GROWTH, _FURTHEST = 0.01, 4.0, 1.5
"""P4: noise of the area in a frame where the stiffness is right, its growth with ln of the wrong one's ratio, and the
most that counts; the rigid motor is as wrong as that."""


def fixed_keys(emulated: EmulatedSettings) -> dict[str, Any]:
    """Keys of [emulated] that the control sets, with their values; none without a control."""
    usual = EmulatedSettings()
    honest = {"world": "viscoelastic"} | {key: getattr(usual, key) for key in VISCOELASTIC_KEYS}
    every = emulated.stiffness_n_per_mm
    stiff = honest | {"relaxation": dict.fromkeys(every, 0.0), "sensor_relaxation": 0.0}
    timing = dict.fromkeys(VISCOELASTIC_KEYS, 0.0) | {
        "relaxation": dict.fromkeys(every, 0.05),
        "sensor_relaxation": 0.1,
        **{key: getattr(usual, key) for key in ("mount_n_per_mm", "camera_latency_s", "camera_latency_sd_s")},
        **{key: getattr(usual, key) for key in ("preset_latency_s", "camera_jitter_s")},
    }
    return {
        "none": {}, "N1": stiff, "N2": honest, "N3": honest, "P1": {"world": "elastic"},
        "P2": {"world": "viscoelastic"} | timing, "P3": stiff, "P4": {"world": "elastic"},
    }[emulated.control]  # fmt: skip


def controlled(emulated: EmulatedSettings) -> EmulatedSettings:
    """The bench with what its control sets."""
    return replace(emulated, **fixed_keys(emulated))


def counterparts(specimens: Sequence[str], stiffness_n_per_mm: Mapping[str, float]) -> dict[str, str]:
    """Specimen to the one with which it swaps schedules in N3, by stiffness, N/mm: the stiffest with the softest, and
    so on inwards."""
    by_stiffness = sorted(specimens, key=lambda name: stiffness_n_per_mm[name])
    pairs = zip(by_stiffness, reversed(by_stiffness), strict=True)
    return {one: other for one, other in pairs if one != other}


def contradictions(emulated: EmulatedSettings, told: Mapping[str, Any]) -> Iterator[tuple[str, str, str]]:
    """Key of [emulated], what is wanted and what to do, for each that contradicts the control. told : as written."""
    control = f'control = "{emulated.control}"'
    for key, value in fixed_keys(emulated).items():
        if key in told and getattr(emulated, key) != value:
            yield key, f"no {key} beside {control}, which sets it", "Leave it out, or choose another control."
    for key, owner in (("control_exponent", "P1"), ("control_specimen", "P4")):
        if key in told and emulated.control != owner:
            yield key, f'control = "{owner}" beside it', "Leave it out, or set the control."
    if emulated.control == "P4" and emulated.control_specimen not in emulated.stiffness_n_per_mm:
        known = ", ".join(emulated.stiffness_n_per_mm)
        wanted = f"a specimen of the bench ({known}) beside {control}"
        yield "control_specimen", wanted, "Name the specimen whose modular schedule is right."


@dataclass(frozen=True)
class ArtificialEffect:
    """How an actuator's stiffness changes the contact's area, by the schedule that presses.

    exponent : of P1; None for P4. schedule : None under the rigid motor. right : P4's modular schedule of the specimen
    whose stiffness is right.
    """

    exponent: float | None
    schedule: Schedule | None
    right: Schedule | None = None

    def factor(self, force_n: float) -> float:
        """P1: of the area of a contact under that force, N, on average over frames."""
        if self.schedule is None or self.exponent is None:
            return 1.0
        return math.pow(stiffness_at(self.schedule, force_n), -self.exponent)

    def noise_sd(self, force_n: float) -> float:
        """P4: relative standard deviation of the area from frame to frame under that force, N."""
        if self.exponent is not None:
            return 0.0
        off = _FURTHEST
        if self.schedule is not None and self.right is not None:
            ratio = stiffness_at(self.schedule, force_n) / stiffness_at(self.right, force_n)
            off = min(_FURTHEST, abs(math.log(ratio)))
        return _NOISE_SD * (1 + _NOISE_GROWTH * off)


def stiffness_at(schedule: Schedule, force_n: float) -> float:
    """Stiffness at zero load of the step that holds ``force_n``, N m/rad; beyond the schedule that of its end."""
    step = int(schedule.step_force_n.searchsorted(force_n, side="right")) - 1
    return float(schedule.stiffness_nm_per_rad[min(max(step, 0), schedule.stiffness_nm_per_rad.size - 1)])


def effect_of(
    emulated: EmulatedSettings, schedule: Schedule | None, schedules: Sequence[Schedule]
) -> ArtificialEffect | None:
    """The effect of P1 or P4 in a run with ``schedule``; None in other worlds.

    schedules : one of them is P4's right one. ScheduleError where it is absent.
    """
    if emulated.control == "P1":
        return ArtificialEffect(emulated.control_exponent, schedule)
    if emulated.control == "P4":
        right = None if schedule is None else schedule_for(schedules, emulated.control_specimen, "modular")
        return ArtificialEffect(None, schedule, right)
    return None
