"""Stiffness while a press goes on: a total interval after every frame, and a reason to stop.

The score of half a press is not the score of a whole one, because A(F) is concave. So the presses of the known
specimens are cut at every force at which the new press may be judged, and all rates are taken between the same two
forces. A cut press has the mean rate of the power law through its frames, as a whole one has (casr.spread). Finished
presses of the new specimen count along, cut alike.

A specimen pressed once shows no noise of its own; that of the known specimens is taken, pooled. The interval is total:
presses, known stiffnesses, mountings, angle and law (``repeats``), widened where the known specimens reject the law.

A press may stop early for two reasons. The interval is as narrow as wanted. Or the rest of the press is expected to
narrow it by less than a tenth: that depends on the calibration and the estimate alone, so it is tabulated beforehand.
The first reason looks at a width that grows with the estimate, so a press that seems soft stops first;
benchmarks/results/online_kappa.md has the coverage at the stop.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats, Ints
from emg2vsa.calibration.calibrate import Calibration, calibrate
from emg2vsa.calibration.forms import HERTZ, specimen_share
from emg2vsa.calibration.left_out import left_out
from emg2vsa.calibration.repeats import RepeatInterval, interval_of, repeat_interval
from emg2vsa.settings import CalibrationSettings

STEP_N = 0.2
"Between two forces at which a press is judged."
_ROUNDING_N = 1e-6
LEAST_FRAMES = 3
REACH = 0.8
"""Share of a force that a press must have reached for its law to be read there: of 20 frames a second the last lies up
to 0.8 N below the peak."""
NARROWS = 0.9
"The rest of a press must be expected to bring the interval below this share of its width, or the press may stop."
WIDTH_REACHED, NO_GAIN = "width reached", "the rest would narrow it by less than a tenth"
_KAPPAS = 25
"Stiffnesses of the table of expected widths."


@dataclass(frozen=True, kw_only=True, eq=False)
class OnlineCalibration:
    """What presses of an unknown specimen are judged by, at one angle and condition.

    specimens : S names. kappa, kappa_se : (S,) N/mm. quantity : whose area, as ``RunScores.algorithm``; area_unit : of
    it. start_n : where all rates begin. forces_n : (G,) at which a press is judged. rates : (S, R, G) in area_unit/N,
    NaN where a press does not reach. mounting : (S, R) number of each press's mounting, from 1. angle_share,
    other_exponent : see ``calibrate``. simulated : an emulated rig pressed. provenance : name to value.
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
    angle_share: float = 0.0
    other_exponent: float = HERTZ
    simulated: bool = False
    provenance: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def calibration(self) -> Calibration:
        """Of every force: d = G."""
        return calibrate(
            np.broadcast_to(self.kappa, (self.forces_n.size, self.kappa.size)),
            np.moveaxis(self.rates, -1, 0),
            self.settings,
            casr_unit=f"{self.area_unit}/N",
            specimens=self.specimens,
            kappa_se=self.kappa_se,
            specimen_share=specimen_share(self.quantity),
            angle_share=self.angle_share,
            mounting_sd=self.settings.mounting_sd_percent / 100,
            mountings=self.mounting,
            other_exponent=self.other_exponent,
        )

    @cached_property
    def widened(self) -> Floats:
        """(G,) factor on the standard error, from the left-out specimens."""
        return left_out(self.calibration).widening(self.settings.confidence)

    @property
    def presses(self) -> int:
        """Presses of the known specimens."""
        return int(np.count_nonzero(np.isfinite(self.rates).any(axis=-1)))

    def judged(self, rates: Floats, at: int | None = None) -> RepeatInterval:
        """Of rates (n, G) of n presses of the new specimen: d = G, or the one at the force of index ``at``."""
        calibration, widened = self.calibration, self.widened
        if at is not None:
            calibration, widened, rates = calibration.only(at), widened[at : at + 1], rates[:, at : at + 1]
        return repeat_interval(calibration, rates.T, own_noise=False, widened=widened)

    @cached_property
    def _expected(self) -> dict[int, Floats]:
        return {}

    @cached_property
    def _kappas(self) -> Floats:
        """Somewhat beyond the known specimens."""
        return np.geomspace(self.kappa.min() / 2, 2 * self.kappa.max(), _KAPPAS)

    def expected_reach(self, kappa: float, presses: int = 1) -> Floats:
        """(G,) half width on the axis of the law that is expected of so many presses, all cut at the same force.

        NaN where the law has no score for this stiffness.
        """
        if presses not in self._expected:
            law = self.calibration.fit
            rates = law.casr(np.broadcast_to(self._kappas, (self.forces_n.size, _KAPPAS)))
            reach = [self.judged(np.tile(rates[:, i], (presses, 1))).reach for i in range(_KAPPAS)]
            self._expected[presses] = np.stack(reach)
        table = self._expected[presses]
        at = np.log(np.clip(kappa, self._kappas[0], self._kappas[-1]))
        return np.array([np.interp(at, np.log(self._kappas), column) for column in table.T])


@dataclass(frozen=True)
class OnlineState:
    """What is known after a frame; kappa, low, high in N/mm, NaN before the first force of the calibration.

    force_n : largest force of this press so far. judged_at_n : force up to which areas were used. presses : that count.
    low, high : total interval; high is infinite where the specimen may be rigid. half_width : of the interval, as a
    share of kappa. stop : why the press may stop now: "", ``WIDTH_REACHED`` or ``NO_GAIN``. reachable : half width that
    is expected at the end of this press, as a share of kappa. amplification : percent of kappa for 1 % of the score.
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
    amplification: float = float("nan")


class OnlineEstimator:
    """Judges a new specimen frame by frame.

    Parameters
    ----------
    calibration : of ``online_calibrations`` or ``emg2vsa.calibration_file``.
    wanted : half width of the interval on kappa, as a share of kappa, at which to stop; 0: none.
    """

    def __init__(self, calibration: OnlineCalibration, wanted: float = 0.0) -> None:
        self._calibration, self._wanted = calibration, wanted
        self._finished: list[Floats] = []
        self._curve: list[tuple[float, float]] = []
        self._reached, self._state = -1, OnlineState()

    def push(self, force_n: float, area: float) -> OnlineState:
        """The next frame of the press: its force, N, and contact area; NaN where it is not determined."""
        self._curve.append((force_n, area))
        largest_n = max(self._state.force_n, force_n) if np.isfinite(force_n) else self._state.force_n
        reached = int(np.searchsorted(self._calibration.forces_n, largest_n + _ROUNDING_N, side="right")) - 1
        if reached > self._reached:
            self._reached, self._state = reached, self._judged(reached)
        self._state = replace(self._state, force_n=largest_n)
        return self._state

    def finish_press(self) -> None:
        """The press is over; the next frame belongs to another one."""
        self._finished.append(self._rates())
        self._curve = []
        self._reached, self._state = -1, OnlineState(presses=len(self._finished))

    def _rates(self) -> Floats:
        force, area = np.array(self._curve, dtype=np.float64).reshape(-1, 2).T
        return cut_rates(force, area, self._calibration.start_n, self._calibration.forces_n)

    def _judged(self, at: int) -> OnlineState:
        own = self._calibration
        scores = np.stack([*self._finished, self._rates()])
        judged_at_n, presses = float(own.forces_n[at]), int(np.count_nonzero(np.isfinite(scores[:, at])))
        found = own.judged(scores, at)
        kappa, low, high = float(found.kappa[0]), float(found.low[0]), float(found.high[0])
        if not np.isfinite(kappa) or not np.isfinite(scores[-1, at]):
            return OnlineState(judged_at_n=judged_at_n, presses=presses)
        half_width = (high - low) / (2 * kappa)
        expected = own.expected_reach(kappa, presses)
        rest = float(np.nanmin(expected[at:])) / float(expected[at])
        stop = WIDTH_REACHED if half_width <= self._wanted else NO_GAIN if rest > NARROWS else ""
        return OnlineState(
            judged_at_n=judged_at_n,
            presses=presses,
            kappa=kappa,
            low=low,
            high=high,
            half_width=half_width,
            stop=stop,
            reachable=half_width_of(own, kappa, rest * float(found.reach[0])),
            amplification=abs(float(found.score_share[0])),
        )


def half_width_of(calibration: OnlineCalibration, kappa: float, reach: float) -> float:
    """Half width, as a share of kappa, of an interval that reaches so far on the axis of the law."""
    low, high = interval_of(calibration.settings.law, kappa, reach)
    return (high - low) / (2 * kappa)


def reachable_width(calibration: OnlineCalibration, kappa: float | None = None, presses: int = 1) -> float:
    """Half width, as a share of kappa, that so many whole presses are expected to reach, before the first of them.

    kappa : N/mm; None takes the stiffness between the softest and the stiffest known specimen where the width is the
    smallest, so that a smaller one cannot be reached anywhere.
    """
    known = calibration.kappa
    tried = np.geomspace(known.min(), known.max(), _KAPPAS) if kappa is None else np.array([kappa])
    widths = [
        half_width_of(calibration, k, float(np.nanmin(calibration.expected_reach(k, presses)))) for k in tried.tolist()
    ]
    return float(np.min(widths))


def cut_forces(start_n: float, stop_n: float) -> Floats:
    """(G,) forces at which a press is judged, from two steps above ``start_n``; the last is ``stop_n``."""
    count = int((stop_n - start_n) / STEP_N + _ROUNDING_N)
    return np.asarray(stop_n - STEP_N * np.arange(max(count - 1, 1), dtype=np.float64)[::-1])


def cut_rates(force_n: ArrayLike, area: ArrayLike, start_n: float, stop_n: Floats) -> Floats:
    """Mean rate (G,) from ``start_n`` to each of ``stop_n`` (G,) of the power law through the frames up to there.

    Frames weigh their force, as in ``casr.spread``. NaN where there are fewer than three frames, or none near the
    force. Frames below an earlier force are left out: going down, a contact keeps more of its area than it had.
    """
    force, areas = rising(np.asarray(force_n, dtype=np.float64), np.asarray(area, dtype=np.float64))
    used = (force >= start_n) & (areas > 0)
    force, areas = force[used], areas[used]
    count = np.searchsorted(force, stop_n + _ROUNDING_N, side="right")
    x, y = np.log(force), np.log(areas)
    sums = np.cumsum(np.stack([force, force * x, force * y, force * x * x, force * x * y]), axis=1)
    rates = np.full(stop_n.shape, np.nan)
    good = count >= LEAST_FRAMES
    good[good] = force[count[good] - 1] >= REACH * stop_n[good]
    w, wx, wy, wxx, wxy = sums[:, count[good] - 1]
    exponent = (w * wxy - wx * wy) / (w * wxx - wx**2)
    level, stop = (wy - exponent * wx) / w, stop_n[good]
    rates[good] = np.exp(level) * (stop**exponent - start_n**exponent) / (stop - start_n)
    return rates


def rising(force_n: Floats, area: Floats) -> tuple[Floats, Floats]:
    """The frames whose force is larger than every force before."""
    known = np.isfinite(force_n) & np.isfinite(area)
    force, areas = force_n[known], area[known]
    before = np.maximum.accumulate(np.concatenate([[-np.inf], force]))[:-1]
    return force[force > before], areas[force > before]


def cut_presses(curves: Sequence[Sequence[tuple[Floats, Floats]]], start_n: float, forces_n: Floats) -> Floats:
    """(S, R, G) ``cut_rates`` of the presses (force, area) of each specimen, padded with NaN."""
    rates = np.full((len(curves), max(map(len, curves), default=0), forces_n.size), np.nan)
    for s, each in enumerate(curves):
        for r, (force_n, area) in enumerate(each):
            rates[s, r] = cut_rates(force_n, area, start_n, forces_n)
    return rates
