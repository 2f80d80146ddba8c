"""Presses as curves, without frames: force and contact area in worlds whose A(F) is not the law's.

Areas are drawn from tables of ln A over ln F and ln kappa that each world gives; a press then has the scatter of the
camera, the force sensor, the landing and the mounting. Frames come at 20 Hz while a probe on springs of middle
stiffness presses at 5 mm/s.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import numpy as np

from casr.specimens import SPECIMENS
from emg2vsa.arrays import Floats
from emg2vsa.calibration.cut_presses import cut_all, cut_forces
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.devices.qbmove.springs import RAD_PER_TICK, SPRINGS
from emg2vsa.dome_contact import PowerLaw
from emg2vsa.settings import CalibrationSettings
from emg2vsa.worlds.contact import Drive, Relaxation, StiffnessSteps, adhesive_force_n, in_series, simulate_presses
from emg2vsa.worlds.tactile import ContactWorld, TabulatedWorld

KNOWN = ("S1", "S3", "S5")
FRAME_HZ, SPEED_MM_PER_S = 20.0, 5.0
START_N, F_MAX_N = 0.5, 7.0
MIDDLE_RAD = 1500 * RAD_PER_TICK
_KAPPA = np.geomspace(0.9, 12.0, 12)
_FORCE_N = np.geomspace(0.01, 9.5, 160)
SENSOR_SHARE = 0.15
RELAXING = {7.63: 0.03, 5.32: 0.04, 3.35: 0.06, 3.12: 0.06, 1.11: 0.12}
"Share that relaxes between 0.1 and 10 s, by stiffness: soft mixtures creep more."


@dataclass(frozen=True)
class World:
    """Tables over (kappa, force): ln area in mm2, seconds since first contact."""

    name: str
    log_area: Floats
    time_s: Floats

    def row(self, table: Floats, kappa: float) -> Floats:
        """Over the forces, at one stiffness."""
        at = np.interp(math.log(kappa), np.log(_KAPPA), np.arange(_KAPPA.size))
        low = min(int(at), _KAPPA.size - 2)
        return np.asarray(table[low] + (at - low) * (table[low + 1] - table[low]))


def _elastic(exponent: float) -> list[PowerLaw]:
    world = ContactWorld(exponent=exponent)
    return [PowerLaw(world.modulus_mpa(k), exponent=exponent) for k in _KAPPA]


def _paths(contact: PowerLaw, relaxation: Relaxation, preset_rad: float) -> tuple[Floats, Floats]:
    """Seconds and ln area over the forces."""
    drive, steps = Drive(springs=SPRINGS["qbmove-maker-pro"]), [StiffnessSteps.constant(preset_rad)]
    path = simulate_presses([contact], relaxation, drive, steps, f_max_n=9.6, step_s=2e-3)
    force = np.maximum.accumulate(path.force_n[1:, 0])
    return tuple(
        np.asarray(np.interp(_FORCE_N, force, values)) for values in (path.time_s[1:], np.log(path.area_mm2[1:, 0]))
    )  # type: ignore[return-value]


@cache
def power_law(exponent: float, preset_rad: float = MIDDLE_RAD) -> World:
    """Elastic; 1/3 is Hertz, in which the compliance law is exact."""
    rows = [_paths(contact, Relaxation.of_share(0.0), preset_rad) for contact in _elastic(exponent)]
    time_s, area = (np.stack(each) for each in zip(*rows, strict=True))
    return World(f"power law, exponent {exponent:.3g}", area, time_s)


@cache
def relaxing(preset_rad: float = MIDDLE_RAD) -> World:
    """Exponent 1/4, sensor and specimens creep, soft ones more."""
    known = sorted(RELAXING)
    shares = np.interp(np.log(_KAPPA), np.log(known), [RELAXING[k] for k in known])
    world, rows = ContactWorld(), []
    for kappa, share, contact in zip(_KAPPA, shares, _elastic(0.25), strict=True):
        e_star = world.modulus_mpa(kappa)
        of_sensor = e_star / world.sensor_modulus_mpa  # of the compliance
        bodies = [(of_sensor, Relaxation.of_share(SENSOR_SHARE)), (1 - of_sensor, Relaxation.of_share(float(share)))]
        rows.append(_paths(contact, in_series(bodies), preset_rad))
    time_s, area = (np.stack(each) for each in zip(*rows, strict=True))
    return World("relaxing bodies, exponent 0.25", area, time_s)


@cache
def finite_elements(friction: str) -> World:
    """The advancing front of a layered dome."""
    world, times = TabulatedWorld(friction=friction), power_law(0.25).time_s
    radius = np.stack([world.radius_mm(_FORCE_N, float(k)) for k in _KAPPA])
    return World(f"finite elements, {friction}", np.log(np.pi * radius**2), times)


WORLDS: tuple[Callable[[], World], ...] = (
    lambda: power_law(1 / 3),
    lambda: power_law(1 / 4),
    relaxing,
    lambda: finite_elements("stick"),
    lambda: finite_elements("frictionless"),
)


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """SDs. Of a press: landing (share of its areas), delay of the camera, force zero, work of adhesion. Of a frame: its
    area (share), its delay, its force. Of a mounting: areas (share), kappa (share), delay."""

    name: str
    landing: float = 0.0
    press_delay_s: float = 0.0
    zero_n: float = 0.0
    adhesion_mj_per_m2: tuple[float, float] = (0.0, 0.0)
    frame_area: float = 0.0
    frame_delay_s: float = 0.0
    force_noise_n: float = 0.0
    mounting_area: float = 0.0
    mounting_kappa: float = 0.0
    mounting_delay_s: float = 0.0


LOW = Scatter(name="low", landing=0.003, frame_area=0.003, force_noise_n=0.002)
DEFAULT = Scatter(
    name="default", landing=0.015, press_delay_s=0.005, zero_n=0.02, adhesion_mj_per_m2=(10.0, 5.0), frame_area=0.01,
    frame_delay_s=0.005, force_noise_n=0.01, mounting_area=0.02, mounting_kappa=0.02, mounting_delay_s=0.005,
)  # fmt: skip


@dataclass(frozen=True)
class Mounting:
    """What presses of one mounting share."""

    area: float
    kappa: float
    delay_s: float


@dataclass(frozen=True, eq=False)
class PressCurves:
    """Of its frames."""

    force_n: Floats
    area_mm2: Floats


@dataclass(frozen=True)
class Bench:
    """Presses in one world with one scatter."""

    world: World
    scatter: Scatter
    rng: np.random.Generator = field(compare=False)

    def mounting(self) -> Mounting:
        own, z = self.scatter, self.rng.standard_normal(3)
        return Mounting(1 + own.mounting_area * z[0], 1 + own.mounting_kappa * z[1], own.mounting_delay_s * z[2])

    def press(self, kappa: float, mounting: Mounting) -> PressCurves:
        """One press up to the force of the end."""
        own, rng, kappa = self.scatter, self.rng, kappa * mounting.kappa
        time_s, log_area = self.world.row(self.world.time_s, kappa), self.world.row(self.world.log_area, kappa)
        end_s = float(np.interp(F_MAX_N, _FORCE_N, time_s))
        at_s = np.arange(rng.uniform(0, 1 / FRAME_HZ), end_s, 1 / FRAME_HZ)
        zero_n = own.zero_n * rng.standard_normal()
        felt = np.interp(at_s, time_s, _FORCE_N) + zero_n + own.force_noise_n * rng.standard_normal(at_s.size)
        late_s = mounting.delay_s + own.press_delay_s * rng.standard_normal()
        seen_s = at_s + late_s + own.frame_delay_s * rng.standard_normal(at_s.size)
        mean, sd = own.adhesion_mj_per_m2
        seen_n = np.vectorize(adhesive_force_n)(
            np.interp(seen_s, time_s, _FORCE_N), max(mean + sd * rng.standard_normal(), 0.0)
        )
        scale = mounting.area * (1 + own.landing * rng.standard_normal())
        area = scale * np.exp(np.interp(np.log(seen_n), np.log(_FORCE_N), log_area))
        area *= 1 + own.frame_area * rng.standard_normal(at_s.size)
        return PressCurves(felt, area)

    def calibration(
        self, mountings: int, presses: int, settings: CalibrationSettings, quantity: str = "edge"
    ) -> OnlineCalibration:
        """Of S1, S3 and S5. quantity : ``front`` adds what domes outside the library leave; curves have none of it."""
        forces = cut_forces(START_N, F_MAX_N)
        kappa = [SPECIMENS[name] for name in KNOWN]
        pressed = []
        for k in kappa:
            mounted = [self.mounting() for _ in range(mountings)]
            pressed.append([self.press(k, each) for each in mounted for _ in range(presses)])
        rates = cut_all([[(p.force_n, p.area_mm2) for p in own] for own in pressed], START_N, forces)
        powers = [_power(p.force_n, p.area_mm2) for own in pressed for p in own]
        labels = np.tile(np.repeat(np.arange(1, mountings + 1), presses), (len(kappa), 1))
        return OnlineCalibration(
            specimens=KNOWN, kappa=np.array(kappa), kappa_se=np.zeros(len(kappa)), quantity=quantity, area_unit="mm2",
            angle_deg=0.0, condition="constant-mean", start_n=START_N, forces_n=forces, rates=rates,
            mounting=labels, settings=settings, growth=float(np.median(powers)), simulated=True,
        )  # fmt: skip


def _power(force_n: Floats, area_mm2: Floats) -> float:
    """p of A ~ F^p in the loading phase."""
    used = force_n >= START_N
    return float(np.polyfit(np.log(force_n[used]), np.log(area_mm2[used]), 1)[0])
