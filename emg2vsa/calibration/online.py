"""Stiffness while a press goes on: a total interval after every frame, and a reason to stop.

Where the pins of the known specimens' presses are known, the pins tell stiffness (``online_pins``). Without a camera
file the area does: presses of the known specimens are cut at every force at which the new press may be judged
(``cut_presses``). Finished presses of the new specimen count along, cut alike; of presses that stopped at different
forces, those are used together, and up to that force, from which the narrowest interval is expected.

A specimen pressed once shows no noise of its own; that of the known specimens is taken, pooled. The interval is total:
presses, known stiffnesses, mountings, angle and law (``repeats``), widened where the known specimens reject the law.

A press may stop early for two reasons. The interval is as narrow as wanted, at two forces in a row. Or the rest of the
press is expected to narrow it by less than a tenth: by the pins, were the label of this press exact; by the area that
depends on the calibration and the estimate alone, so it is tabulated beforehand. The first reason looks at a width that
grows with the estimate, so a press that seems soft stops first; benchmarks/results/online_kappa has the coverage at the
stop.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import special

from casr.dome.library import Library, shipped
from casr.kappa.posterior import Posterior, ends
from casr.kappa.presses import KappaPress
from emg2vsa.arrays import Floats, Ints
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.cut_presses import ROUNDING_N, cut_rates
from emg2vsa.calibration.forms import casr_angle_share, casr_exponent, eta_of, kappa_slope, specimen_share
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.online_pins import KnownPins, PinsEstimator
from emg2vsa.calibration.repeats import interval_of, repeat_interval
from emg2vsa.settings import CalibrationSettings

NARROWS = 0.9
"The rest of a press must be expected to bring the interval below this share of its width, or the press may stop."
WIDTH_REACHED, NO_GAIN = "width reached", "the rest would narrow it by less than a tenth"
AREA = "area"
_KAPPAS = 13
"Stiffnesses of the table of expected widths."


@dataclass(frozen=True)
class Judged:
    """A specimen by its scores so far; (d,). kappa, low, high : N/mm. reach : half of the interval, on the axis of the
    law."""

    kappa: Floats
    low: Floats
    high: Floats
    reach: Floats


@dataclass(frozen=True, kw_only=True, eq=False)
class OnlineCalibration:
    """What presses of an unknown specimen are judged by, at one angle and condition.

    specimens : S names. kappa, kappa_se : (S,) N/mm. quantity : whose area, as ``RunScores.algorithm``; area_unit : of
    it. start_n : where all scores begin. forces_n : (G,) at which a press is judged. rates : (S, R, G) in area_unit/N,
    NaN where a press does not reach. mounting : (S, R) number of each press's mounting, from 1. pins : what the pins of
    these presses say; None where they say nothing. growth : p of A ~ F^p, see ``growth_power``. simulated : an emulated
    rig pressed. provenance : name to value.
    """

    specimens: tuple[str, ...]
    kappa: Floats
    kappa_se: Floats
    quantity: str
    area_unit: str
    angle_deg: float
    condition: str
    start_n: float
    forces_n: Floats
    rates: Floats
    mounting: Ints
    settings: CalibrationSettings = field(default_factory=CalibrationSettings)
    growth: float = float("nan")
    simulated: bool = False
    provenance: Mapping[str, str] = field(default_factory=dict)
    pins: KnownPins | None = None

    @property
    def domes(self) -> str:
        """Name of the folder of a sensor's own tables of domes, by which areas were found; empty without one."""
        return self.provenance.get("domes", "")

    @cached_property
    def calibration(self) -> Calibration:
        """Calibration from CASR at every force: d = G."""
        return calibrate(
            self._kappa_at_every_force,
            np.moveaxis(self.rates, -1, 0),
            self.settings,
            casr_unit=f"{self.area_unit}/N",
            specimens=self.specimens,
            kappa_se=self.kappa_se,
            specimen_share=specimen_share(self.quantity),
            angle_share=casr_angle_share(self.quantity, self.angle_deg, self.settings.angle_sd_deg),
            mounting_sd=self.settings.mounting_sd_percent / 100,
            mountings=self.mounting,
            other_exponent=casr_exponent(self.growth),
        )

    @property
    def presses(self) -> int:
        """Presses of the known specimens."""
        return int(np.count_nonzero(np.isfinite(self.rates).any(axis=-1)))

    @property
    def rises(self) -> bool:
        """CASR is greater on softer specimens at the largest force, as contact mechanics has it; mixed up stiffnesses
        turn that round."""
        last = self.rates[:, :, -1]
        there = np.isfinite(last)
        means = np.sum(np.where(there, last, 0.0), axis=1) / np.count_nonzero(there, axis=1)
        compliance = -np.log(self.kappa)
        return bool(np.sum((compliance - compliance.mean()) * means) > 0)

    def judged(self, rates: Floats, at: Ints, mountings: Ints | None = None) -> Judged:
        """Kappa by the area: from rates (n, d) of n presses of the new specimen, by the laws at these (d,) of the
        forces.

        mountings : (n,) number of each press's mounting; None: one.
        """
        law = self.calibration.take(at)
        c = repeat_interval(law, rates.T, mountings=mountings, own_noise=False, widened=self._widened)
        return Judged(c.kappa, c.low, c.high, c.reach)

    def expected_reach(self, kappa: Floats, presses: int = 1) -> Floats:
        """(G, K) ``Judged.reach`` that is expected at stiffnesses (K,) of so many presses, all cut at the same force.

        NaN where the law has no score for this stiffness.
        """
        if presses not in self._expected:
            at = np.repeat(np.arange(self.forces_n.size), _KAPPAS)
            self._expected[presses] = self._reach_at(self._kappas, at, presses, 1).reshape(-1, _KAPPAS)
        inside = np.log(np.clip(kappa, self._kappas[0], self._kappas[-1]))
        return np.stack([np.interp(inside, np.log(self._kappas), row) for row in self._expected[presses]])

    def _reach_at(self, kappa: Floats, at: Ints, presses: int, mountings: int) -> Floats:
        """``Judged.reach`` at every one of ``at``, for stiffnesses (K,) over and over."""
        scores = self.calibration.fit.casr(np.broadcast_to(kappa, (self.forces_n.size, kappa.size)))
        rates = scores[at, np.arange(at.size) % kappa.size]
        labels = 1 + np.arange(presses) % min(mountings, presses)
        return self.judged(np.tile(rates, (presses, 1)), at, labels).reach

    def log_sd(self, kappa: Floats, presses: int, mountings: int) -> Floats:
        """(K,) standard error of ln kappa that is expected of whole presses, shared alike by so many mountings."""
        if self.posterior:
            return self.posterior.expected_log_sd(kappa, presses, mountings)
        reach = self._reach_at(kappa, np.full(kappa.size, self.forces_n.size - 1), presses, mountings)
        slope = np.abs(kappa_slope(self.settings.law, kappa)) / kappa
        return np.asarray(slope * reach / special.ndtri(0.5 + self.settings.confidence / 2))

    def axis(self, kappa: Floats) -> Floats:
        """Place of kappa (n,), N/mm, on the axis on which intervals are even."""
        return self.posterior.z(kappa) if self.posterior else np.asarray(eta_of(self.settings.law, kappa))

    def half_width(self, kappa: float, reach: float) -> float:
        """Half width, as a share of kappa, of an interval with this ``Judged.reach``."""
        low, high = interval_of(self.settings.law, kappa, reach)
        return (high - low) / (2 * kappa)

    @cached_property
    def posterior(self) -> Posterior | None:
        """Posterior by the pins before the new specimen is pressed; None where the pins say nothing."""
        return self.pins.posterior(self.settings) if self.pins else None

    @property
    def _kappa_at_every_force(self) -> Floats:
        return np.broadcast_to(self.kappa, (self.forces_n.size, self.kappa.size))

    @cached_property
    def _widened(self) -> float:
        """Factor on the standard errors, from the left-out specimens: the largest of all forces.

        The law is the same one at every force, and a factor that came and went with the chance of a cut would stop
        presses where it happens to be missing.
        """
        return float(left_out(self.calibration).widening(self.settings.confidence).max())

    @cached_property
    def _expected(self) -> dict[int, Floats]:
        return {}

    @cached_property
    def _kappas(self) -> Floats:
        """Somewhat beyond the known specimens."""
        return np.geomspace(self.kappa.min() / 2, 2 * self.kappa.max(), _KAPPAS)


def reachable_width(
    calibration: OnlineCalibration, kappa: float | None = None, presses: int = 1, f_max_n: float = math.inf
) -> float:
    """Half width, as a share of kappa, that so many whole presses are expected to reach, before the first of them.

    kappa : N/mm; None takes the stiffness between the softest and the stiffest known specimen where the width is the
    smallest, so that a smaller one cannot be reached anywhere. f_max_n : presses turn back here; NaN below the first
    force of the calibration.
    """
    judged = int(np.searchsorted(calibration.forces_n, f_max_n + ROUNDING_N, side="right"))
    if judged == 0:
        return math.nan
    known, by_pins = calibration.kappa, calibration.posterior
    tried = np.geomspace(known.min(), known.max(), _KAPPAS) if kappa is None else np.array([kappa])
    if by_pins:
        reaches = by_pins.reach * calibration.log_sd(tried, presses, 1)
        every = [ends(k, by_pins.kappa0, r) for k, r in zip(tried.tolist(), reaches.tolist(), strict=True)]
        return float(min((high - low) / (2 * k) for (low, high), k in zip(every, tried, strict=True)))
    reaches = calibration.expected_reach(tried, presses)[judged - 1]
    widths = [calibration.half_width(*each) for each in zip(tried.tolist(), reaches.tolist(), strict=True)]
    return float(np.fmin.reduce(widths))


@dataclass(frozen=True)
class OnlineState:
    """What is known after a frame; kappa, low, high in N/mm, NaN before the first force of the calibration.

    force_n : largest force of this press so far. judged_at_n : force up to which areas were used. presses : that count.
    low, high : total interval; high is infinite where the specimen may be rigid. half_width : of the interval, as a
    share of kappa. stop : why the press may stop now: "", ``WIDTH_REACHED`` or ``NO_GAIN``. reachable : half width that
    is expected at the end of this press, as a share of kappa. cues : that kappa is told by. doubt : why the estimate
    may be wrong, "" where nothing says so; then no press stops.
    """

    force_n: float = float("-inf")
    judged_at_n: float = float("nan")
    presses: int = 0
    kappa: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")
    half_width: float = float("nan")
    stop: str = ""
    reachable: float = float("nan")
    cues: str = AREA
    doubt: str = ""


class OnlineEstimator:
    """Judges a new specimen frame by frame.

    Parameters
    ----------
    calibration : of ``online_calibrations`` or ``emg2vsa.calibration_file``.
    wanted : half width of the interval on kappa, as a share of kappa, at which to stop; 0: none.
    library : tables of domes, for pins; None: those of casr. DataError : the calibration was made with others.
    """

    def __init__(self, calibration: OnlineCalibration, wanted: float = 0.0, library: Library | None = None) -> None:
        self._calibration, self._wanted = calibration, wanted
        pins = calibration.pins
        self._pins = PinsEstimator(pins, library or shipped(), calibration.settings) if pins else None
        self._finished: list[Floats] = []
        self._mountings: list[int] = [1]
        self._curve: list[tuple[float, float]] = []
        self._reached, self._state = -1, OnlineState()

    @property
    def mounting(self) -> str:
        """Name of the present one."""
        return f"new {self._mountings[-1]}"

    def push(self, force_n: float, area: float) -> OnlineState:
        """The next frame of the press: its force, N, and contact area; NaN where it is not determined."""
        self._curve.append((force_n, area))
        return self._looked_at(force_n, None)

    def follow(self, force_n: Floats, area: Floats) -> OnlineState:
        """The press so far, force (T,), N, and area (T,) of its frames, in place of what was pushed: the areas of
        earlier frames change a little while a front is followed."""
        self._curve = list(zip(force_n.tolist(), area.tolist(), strict=True))
        return self._looked_at(float(force_n.max(initial=-np.inf)), None)

    def follow_pins(self, press: KappaPress) -> OnlineState:
        """The press so far, of specimen ``online_pins.NEW`` in ``mounting``, where the calibration has pins."""
        assert press.force_n is not None
        return self._looked_at(float(press.force_n.max()), press)

    def _looked_at(self, force_n: float, press: KappaPress | None) -> OnlineState:
        largest_n = max(self._state.force_n, force_n) if np.isfinite(force_n) else self._state.force_n
        reached = int(np.searchsorted(self._calibration.forces_n, largest_n + ROUNDING_N, side="right")) - 1
        if reached > self._reached:
            self._reached = reached
            new = self._judged(reached) if press is None else self._judged_by_pins(reached, press)
            # at two forces in a row, as one may be so by chance; NaN before the first is not narrow
            narrow = new.half_width <= self._wanted and self._state.half_width <= self._wanted
            stop = "" if new.doubt else WIDTH_REACHED if narrow else new.stop
            self._state = replace(new, stop=stop)
        self._state = replace(self._state, force_n=largest_n)
        return self._state

    def finish_press(self, *, remounted: bool = False) -> None:
        """The press is over; the next frame belongs to another one, of another mounting where ``remounted``."""
        self._finished.append(self._scores())
        self._mountings.append(self._mountings[-1] + remounted)
        if self._pins:
            self._pins.finish()
        self._curve = []
        self._reached, self._state = -1, OnlineState(presses=len(self._finished))

    def _judged_by_pins(self, at: int, press: KappaPress) -> OnlineState:
        assert self._pins is not None
        found = self._pins.judged(press)
        half_width, reachable = (
            (high - low) / (2 * found.kappa) for low, high in ((found.low, found.high), found.reachable)
        )
        return OnlineState(
            judged_at_n=float(self._calibration.forces_n[at]), presses=found.presses, kappa=found.kappa, low=found.low,
            high=found.high, half_width=half_width, stop=NO_GAIN if reachable > NARROWS * half_width else "",
            reachable=reachable, cues=found.cues, doubt=found.doubt,
        )  # fmt: skip

    def _scores(self) -> Floats:
        own = self._calibration
        force, area = np.array(self._curve, dtype=np.float64).reshape(-1, 2).T
        return cut_rates(force, area, own.start_n, own.forces_n)

    def _judged(self, at: int) -> OnlineState:
        own = self._calibration
        rates = np.stack([*self._finished, self._scores()])
        counts = np.count_nonzero(np.isfinite(rates), axis=0)

        def judged_at(cut: int) -> Judged:
            return own.judged(rates[:, [cut]], np.array([cut]), np.array(self._mountings))

        found = judged_at(at)
        if not np.isfinite(found.kappa[0]) or not np.isfinite(rates[-1, at]):
            return OnlineState(judged_at_n=float(own.forces_n[at]), presses=int(counts[at]))
        # presses that stopped earlier count only below the force where they stopped: more of them may tell more there
        used, _ = self._narrowest(float(found.kappa[0]), counts[: at + 1])
        if used != at and np.isfinite((lower := judged_at(used)).kappa[0]):
            found = lower
        else:
            used = at
        kappa, low, high = float(found.kappa[0]), float(found.low[0]), float(found.high[0])
        _, now = self._narrowest(kappa, counts[: at + 1])
        presses = int(counts[used])
        counts[at + 1 :] = 1 + np.count_nonzero(np.isfinite(rates[:-1, at + 1 :]), axis=0)
        rest = self._narrowest(kappa, counts)[1] / now
        return OnlineState(
            judged_at_n=float(own.forces_n[used]), presses=presses, kappa=kappa, low=low, high=high,
            half_width=(high - low) / (2 * kappa), stop=NO_GAIN if rest > NARROWS else "",
            reachable=own.half_width(kappa, rest * float(found.reach[0])),
        )  # fmt: skip

    def _narrowest(self, kappa: float, counts: Ints) -> tuple[int, float]:
        """Index of a force, and the reach that is expected there: the last force, or an earlier one that more presses
        have reached, of ``counts``, and where the interval is expected to be narrower."""
        best, reach = counts.size - 1, math.inf
        for cut in range(counts.size - 1, -1, -1):
            if cut == counts.size - 1 or counts[cut] > counts[-1]:
                there = self._calibration.expected_reach(np.array([kappa]), int(counts[cut]))[cut, 0]
                if there < reach or cut == counts.size - 1:
                    best, reach = cut, float(there)
        return best, reach
