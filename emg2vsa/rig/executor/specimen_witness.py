"""The specimen as a witness: is force over depth of a press that of the specimen which the plan names?

Depth is that of the shaft, behind springs and motors, and force that of the sensor, before the friction of the shaft.
With the force N along the normal of the specimen's surface, the contact of `emg2vsa.dome_contact` makes N^(1 - n) a
straight line over depth, whose slope tells the modulus of dome and specimen in series, wherever contact was.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Collection, Mapping

import numpy as np

from emg2vsa.dome_contact import ElasticDome, PowerLaw
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.press_counts import PressKappa
from emg2vsa.rig.rig_settings import RigSettings

_FROM_N, _LEAST_TURNS, _LEAST_SPAN = 1.0, 20, 2.0
"""Least force and turns of a loading that tells kappa, and its largest force over the smallest."""
_LEAST_MM = 0.6
"""Least way after contact from which the stiffness is told: on less, noise of 0.1 N looks like another specimen."""
_CREEP = 0.025
"""Power of time with which contacts of rubber relax: 11 % between 0.1 and 10 s, of silicone less and of the printed
dome more (Petet et al. 2021). Stiffness is that after 1 s, and a press meets the bodies stiffer."""
_RAMP = 1.13
"""Times that power: what a force that grows with depth^(4/3) has not yet lost of that."""
_PRESS_SD, _ANGLE_SD_RAD, _STATED_SD = 0.012, math.radians(0.5), 0.03
"""Relative errors of a press's modulus by creep and timing, of the angle as it was set, and of a specimen's stiffness
between mountings, a first press among them (guesses, as are those of the emulated rig)."""
_OTHER_SDS = 3.0
"""A press so many standard deviations away is of another specimen: 0.3 % of good ones."""
_SLACK_S = 0.012
"""Between force and depth of one turn, at most, with what the shaft goes on at first."""


class SpecimenWitness:
    """Watches the loadings of one run; a plate measures the specimen, and has no witness in it."""

    def __init__(self, plan: RunPlan, rig: RigSettings) -> None:
        self._plan = plan
        self._dome = ElasticDome(sensor_modulus_mpa=rig.dome_modulus_mpa)
        self._dome_sd = rig.dome_modulus_sd_percent / 100
        tilt_rad = math.radians(plan.angle_deg)
        self._sin, self._cos = math.sin(tilt_rad), math.cos(tilt_rad)
        self._power = 1 - self._dome.exponent
        self._per_mm = PowerLaw(1.0, self._dome.tip_radius_mm, self._dome.exponent).per_mm
        self._slack_mm = self._cos * plan.ramp_mm_per_s * _SLACK_S
        self._named_mpa = plan.stiffness_n_per_mm and self._dome.modulus_mpa(plan.stiffness_n_per_mm)
        self._rest: list[tuple[float, float]] = []
        self._at_rest: tuple[float, float] | None = None
        "Their mean, once they are all there."
        self._mean_of = rig.filter_samples
        self._newest: deque[tuple[float, float]] = deque(maxlen=self._mean_of)
        self._turns: list[tuple[float, float]] = []
        self._loaded_s = 0.0
        self._enough = (_FROM_N * _LEAST_SPAN) ** self._power

    def read(self, force_n: float, across_n: float, depth_mm: float, loaded_s: float | None) -> float | None:
        """One turn in contact: force along and across the push axis, depth of the shaft, and for how long the probe has
        been loading, None before. The modulus of this press so far over the named one's, less 1: 0 within the slack;
        None where nothing is known to compare with."""
        if self._plan.plate:
            return None
        # friction and elasticity of the skin change the direction of the force, not its part along the normal
        normal = max(0.0, force_n * self._cos + across_n * self._sin) ** self._power
        along_mm = depth_mm * self._cos
        if loaded_s is None:
            if self._newest:  # of the press before
                self._rest, self._turns = [], []
                self._newest.clear()
            self._rest.append((along_mm, normal))
            self._at_rest = None
            return None
        self._loaded_s = loaded_s
        self._newest.append((along_mm, normal))
        if force_n >= _FROM_N:
            self._turns.append((along_mm, normal))
        if self._named_mpa is None or not self._rest or len(self._newest) < self._mean_of:
            return None
        # noise of one sample is no other specimen; means of depth and force of the same turns are of the same curve
        (rest_mm, rest), (now_mm, now) = self._at_rest, _ = self._at_rest or _means(self._rest), _means(self._newest)
        per_mm = self._per_mm * (self._named_mpa * self._stiffer()) ** self._power
        gone_mm, named_mm = now_mm - rest_mm, (now - rest) / per_mm
        least_mm = gone_mm - math.copysign(self._slack_mm, gone_mm - named_mm)
        short = max(gone_mm, named_mm) < _LEAST_MM or max(now, rest + least_mm * per_mm) < _FROM_N**self._power
        if short or abs(gone_mm - named_mm) <= self._slack_mm:
            return 0.0
        return math.inf if least_mm <= 0 else max(0.0, named_mm / least_mm) ** (1 / self._power) - 1

    def kappa(self) -> PressKappa | None:
        """Kappa by the loading that is over; None if it is too short to tell."""
        modulus_mpa = self._modulus_mpa()
        if modulus_mpa is None:
            return None
        spread = 2 * self._sd(modulus_mpa)
        return PressKappa(*(self._dome.stiffness_n_per_mm(modulus_mpa * math.exp(at)) for at in (0.0, -spread, spread)))

    def doubt(self) -> str | None:
        """Doubt about a loading that does not press like the specimen of the plan."""
        modulus_mpa, named = self._modulus_mpa(), self._plan.stiffness_n_per_mm
        if modulus_mpa is None or named is None or self._far(modulus_mpa, named) <= _OTHER_SDS:
            return None
        like = _nearest({name: self._far(modulus_mpa, kappa) for name, kappa in self._plan.others_n_per_mm.items()})
        own = f"{self._plan.specimen}, {named:g} N/mm"
        return (
            f"this presses like {like or 'another specimen'} ({self.kappa()}), not {own}: look at the specimen, "
            "then at the calibration of the force sensor, the gear and rig.dome_modulus_mpa"
        )

    def _modulus_mpa(self) -> float | None:
        """Modulus of dome and specimen in series, after 1 s."""
        turns = self._turns
        if len(turns) < _LEAST_TURNS or turns[-1][1] < self._enough:
            return None
        along_mm, normal = np.array(turns).T
        mm_per = float(np.polyfit(normal, along_mm, 1)[0])
        if mm_per <= 0:
            return math.inf
        return float((1 / (self._per_mm * mm_per)) ** (1 / self._power) / self._stiffer())

    def _stiffer(self) -> float:
        """Factor by which the bodies are stiffer in a press of this length."""
        return float((1 + _RAMP * _CREEP) * max(self._loaded_s, 0.05) ** -_CREEP)

    def _sd(self, modulus_mpa: float) -> float:
        """Relative error of the modulus of a press on a specimen of this one."""
        dome = min(1.0, modulus_mpa / self._dome.sensor_modulus_mpa)
        angle = _ANGLE_SD_RAD * self._sin / self._cos / self._power
        return math.hypot(self._dome_sd * dome, _PRESS_SD, angle, _STATED_SD * (1 - dome))

    def _far(self, modulus_mpa: float, kappa: float) -> float:
        """Distance from a specimen of this stiffness, in standard deviations."""
        named_mpa = self._dome.modulus_mpa(kappa)
        return abs(math.log(modulus_mpa / named_mpa)) / self._sd(named_mpa)


def _nearest(far: Mapping[str, float]) -> str:
    """The name that is nearest, if it is near enough; of several as near, all."""
    least = min(far.values(), default=math.inf)
    return " or ".join(name for name, each in far.items() if each == least) if least <= _OTHER_SDS else ""


def _means(turns: Collection[tuple[float, float]]) -> tuple[float, float]:
    many, first, second = len(turns), 0.0, 0.0
    for one, other in turns:
        first, second = first + one, second + other
    return first / many, second / many
