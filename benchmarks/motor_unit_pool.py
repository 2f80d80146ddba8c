"""A muscle whose force and EMG both come from its motor units; no law of EMG against force is put in.

Recruitment, rate coding and force: Fuglevand, Winter and Patla 1993 (J Neurophysiol 70:2470-2488), equations as there.
EMG: each fibre is a line of current, the second derivative of Rosenfalck's action potential (1969, Acta Physiol Scand
Suppl 321) that begins at the end plate and ends at both tendons, in a homogeneous anisotropic half space under skin
that conducts nothing; so in Fuglevand, Winter, Patla and Stashuk 1992 (Biol Cybern 67:143-153) and Merletti and Parker
2004 (Electromyography, chapter 8). Tremor, fatigue, synchrony and synaptic noise are not in it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy import signal

from emg2vsa.arrays import Floats

NORMALISED_RATE = 0.4
"Contraction time over interval, below which twitches add up without gain."
LARGEST_Z = 3.9
"Intervals lie within so many standard deviations."
ALONG_S_PER_M, ACROSS_S_PER_M, INSIDE_S_PER_M = 0.33, 0.063, 1.01
"Conductivities of muscle along and across its fibres, and of the fibres' inside."
FIBRE_M = 55e-6
"Diameter of a fibre."
UNIT_DENSITY = 20.0
"Fibres of one unit per square millimetre of its territory."
SAMPLED_FIBRES = 12
"Fibres of a unit that are computed; each stands for an equal share of all."
GRID_MM = 0.25
ACTION_POTENTIAL_MM = 15.0
"Beyond this distance behind its front, the action potential is over."
LASTS_S = 0.025
"An action potential at the electrodes is over so long after its discharge."


@dataclass(frozen=True, kw_only=True)
class Pool:
    """The motor neurons of a muscle and their twitches. Excitation has the unit of the published model: the first unit
    is recruited at about 1, the last one at ``threshold_range``."""

    units: int = 120
    threshold_range: float = 30.0
    lowest_hz: float = 8.0
    first_peak_hz: float = 35.0
    "Peak rate of the first unit; that of the last is lower by the next."
    peak_fall_hz: float = 10.0
    gain_hz: float = 1.0
    "Growth of every rate with excitation."
    interval_cv: float = 0.2
    force_range: float = 100.0
    "Twitch of the last unit over that of the first."
    longest_s: float = 0.09
    "Contraction time of a unit of twitch force 1."
    time_exponent: float = 4.2
    "Contraction time falls as twitch force to the power of minus one over this: a range of 3."

    @cached_property
    def thresholds(self) -> Floats:
        return np.asarray(np.exp(math.log(self.threshold_range) / self.units * np.arange(1, self.units + 1)))

    @cached_property
    def twitches(self) -> Floats:
        """(units,) peak forces, arbitrary unit."""
        return np.asarray(np.exp(math.log(self.force_range) / self.units * np.arange(1, self.units + 1)))

    @cached_property
    def contraction_s(self) -> Floats:
        return np.asarray(self.longest_s * self.twitches ** (-1 / self.time_exponent))

    @cached_property
    def peaks_hz(self) -> Floats:
        return np.asarray(self.first_peak_hz - self.peak_fall_hz * self.thresholds / self.thresholds[-1])

    @property
    def most(self) -> float:
        """Excitation at which the last unit fires at its peak rate."""
        return float(self.thresholds[-1] + (self.peaks_hz[-1] - self.lowest_hz) / self.gain_hz)

    def rates_hz(self, excitation: Floats) -> Floats:
        """Mean rates (units, n) at constant excitations (n,); 0 below the threshold."""
        above = excitation - self.thresholds[:, None]
        rates = np.minimum(self.lowest_hz + self.gain_hz * above, self.peaks_hz[:, None])
        return np.asarray(np.where(above >= 0, rates, 0.0))

    def static_force(self, excitation: Floats) -> Floats:
        """Mean force (n,) at constant excitations (n,): area of a twitch, times rate, times the mean of its gain."""
        z, weights = np.polynomial.hermite_e.hermegauss(31)
        rates = self.rates_hz(excitation)[..., None]
        normalised = self.contraction_s[:, None, None] * rates / np.maximum(1 + self.interval_cv * z, 0.05)
        gain = twitch_gain(normalised) @ (weights / weights.sum())
        area = math.e * self.twitches * self.contraction_s
        return np.asarray(np.sum(area[:, None] * rates[..., 0] * gain, axis=0))

    def discharges(self, rng: np.random.Generator, excitation: Floats, fs_hz: float) -> list[Floats]:
        """Times in seconds at which each unit fires under the excitation (n,), sampled at ``fs_hz``.

        A unit fires as soon as it is recruited; the next interval follows from the excitation at each discharge.
        """
        found = []
        for threshold, peak_hz in zip(self.thresholds.tolist(), self.peaks_hz.tolist(), strict=True):
            active = np.flatnonzero(excitation >= threshold)
            times: list[float] = []
            at = float(active[0]) if active.size else math.inf
            while at < excitation.size:
                above = excitation[int(at)] - threshold
                if above < 0:
                    later = np.searchsorted(active, at)
                    at = float(active[later]) if later < active.size else math.inf
                    continue
                times.append(at / fs_hz)
                rate_hz = min(self.lowest_hz + self.gain_hz * above, peak_hz)
                z = min(max(rng.standard_normal(), -LARGEST_Z), LARGEST_Z)
                at += fs_hz / rate_hz * (1 + self.interval_cv * z)
            found.append(np.array(times))
        return found

    def force(self, discharges: list[Floats], n: int, fs_hz: float) -> Floats:
        """Sum (n,) of the twitches of all units; each is P t / T exp(1 - t / T) from its discharge on, times its gain.

        The gain belongs to the interval before the discharge; the first of a train has none before and counts as slow.
        """
        total = np.zeros(n)
        for times, twitch, time_s in zip(discharges, self.twitches, self.contraction_s, strict=True):
            if not times.size:
                continue
            gain = np.ones(times.size)
            gain[1:] = twitch_gain(time_s / np.diff(times))
            pulses = np.bincount(np.round(times * fs_hz).astype(np.int64), twitch * gain, minlength=n + 1)[:n]
            step = 1 / (time_s * fs_hz)
            decay = math.exp(-step)
            # samples of (t / T) exp(1 - t / T) are the impulse response of two equal poles
            total += signal.lfilter([0.0, math.e * step * decay], [1.0, -2 * decay, decay**2], pulses)
        return total


def twitch_gain(normalised_rate: Floats) -> Floats:
    """Gain of a twitch at contraction time over interval, 1 up to 0.4: a sigmoid's force over that of a line."""
    x = np.maximum(normalised_rate, NORMALISED_RATE)
    return np.asarray((_sigmoid(x) / x) / (_sigmoid(np.array(NORMALISED_RATE)) / NORMALISED_RATE))


def _sigmoid(x: Floats) -> Floats:
    return np.asarray(-np.expm1(-2 * x**3))


@dataclass(frozen=True, kw_only=True)
class Electrode:
    """A bipolar electrode over a muscle of parallel fibres; millimetres."""

    spacing_mm: float = 20.0
    from_end_plate_mm: float = 20.0
    "Distance of its middle along the fibres from the middle of the end plates."
    depth_mm: float = 3.0
    "Skin and fat between electrode and muscle."
    radius_mm: float = 8.0
    "Of the muscle's round cross-section."
    fibre_mm: float = 80.0
    fibres: int = 30_000
    "Of the whole muscle; a unit has its share by twitch force."
    end_plates_mm: float = 5.0
    "End plates lie so far to either side of their middle, and tendons likewise."


def fibre_potential(
    time_s: Floats, velocity: float, end_plate_mm: float, ends_mm: tuple[float, float], away_mm: float, at_mm: float
) -> Floats:
    """Potential (n,) in volts of one fibre at a point ``away_mm`` from its axis, ``at_mm`` along it.

    velocity : m/s. end_plate_mm, ends_mm : places along the fibre. What flows out of the fibre is the second derivative
    of the action potential along it, and the steps of its first derivative where it begins and ends.
    """
    first, last = ends_mm
    edges = np.linspace(first, last, max(2, math.ceil((last - first) / GRID_MM)) + 1)
    z, width = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    behind = 1e3 * velocity * time_s[:, None] - np.abs(z - end_plate_mm)
    slope = np.where(z > end_plate_mm, -1.0, 1.0) * _action_potential_slope(behind)
    reach = ALONG_S_PER_M / ACROSS_S_PER_M * away_mm**2 + (z - at_mm) ** 2
    # by parts: the current along the fibre times the slope of 1 / distance; twice, for skin insulates
    current = INSIDE_S_PER_M * math.pi * FIBRE_M**2 / 4
    return np.asarray(2e6 * current / (4 * math.pi * ACROSS_S_PER_M) * slope @ (width * (z - at_mm) / reach**1.5))


def _action_potential_slope(behind_mm: Floats) -> Floats:
    """Slope in V/mm, against the distance behind the front, of Rosenfalck's 96 z^3 exp(-z) - 90 mV."""
    z = np.clip(behind_mm, 0.0, ACTION_POTENTIAL_MM)
    return np.asarray(0.096 * (3 * z**2 - z**3) * np.exp(-z) * (behind_mm < ACTION_POTENTIAL_MM))


@dataclass(frozen=True)
class Muscle:
    """A pool under an electrode; ``seed``: where its units and their fibres lie."""

    seed: int
    pool: Pool = field(default_factory=Pool)
    electrode: Electrode = field(default_factory=Electrode)
    fs_hz: float = 2000.0

    @cached_property
    def action_potentials(self) -> Floats:
        """(units, n) volts at ``fs_hz``, from the discharge on."""
        rng, electrode = np.random.default_rng(self.seed), self.electrode
        time_s = np.arange(0, LASTS_S, 1 / self.fs_hz)
        found = np.zeros((self.pool.units, time_s.size))
        numbers = electrode.fibres * self.pool.twitches / self.pool.twitches.sum()
        for row, number in zip(found, numbers.tolist(), strict=True):
            velocity = rng.normal(4.0, 0.3)
            territory_mm = min(math.sqrt(number / UNIT_DENSITY / math.pi), electrode.radius_mm)
            centre = _in_disc(rng, electrode.radius_mm - territory_mm)
            for _ in range(SAMPLED_FIBRES):
                across, deep = centre + _in_disc(rng, territory_mm)
                away_mm = math.hypot(across, electrode.depth_mm + electrode.radius_mm + deep)
                spread = electrode.end_plates_mm * rng.uniform(-1, 1, 3)
                half = electrode.fibre_mm / 2
                ends = (-half + spread[1], half + spread[2])
                for side in (-1, 1):
                    at_mm = electrode.from_end_plate_mm + side * electrode.spacing_mm / 2
                    row += side * fibre_potential(time_s, velocity, spread[0], ends, away_mm, at_mm)
            row *= number / SAMPLED_FIBRES
        return found

    def emg_v(self, discharges: list[Floats], n: int) -> Floats:
        """(n,) volts."""
        total = np.zeros(n)
        for times, potential in zip(discharges, self.action_potentials, strict=True):
            if times.size:
                pulses = np.bincount(np.round(times * self.fs_hz).astype(np.int64), minlength=n + 1)[:n]
                total += signal.oaconvolve(pulses.astype(np.float64), potential)[:n]
        return total


def _in_disc(rng: np.random.Generator, radius: float) -> Floats:
    """(2,) a point anywhere in a disc."""
    r, angle = radius * math.sqrt(rng.uniform()), rng.uniform(0, 2 * math.pi)
    return np.array([r * math.cos(angle), r * math.sin(angle)])
