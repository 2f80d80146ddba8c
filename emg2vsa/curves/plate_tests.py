"""Specimens pressed by a flat plate: every trial with its fits, and kappa, modulus and law of each specimen."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.curves.force_range import RangeFit, fit_range, loading, t_975
from emg2vsa.curves.plate import PAPER_WINDOW, HookeFit, fit_plate, smoothed
from emg2vsa.curves.press_time import PressTime, press_time
from emg2vsa.curves.rubber import Cylinder, Ends, LawFit, Rubber, fit_rubber
from emg2vsa.curves.specimen_kappa import LEVELS, NestedMean, Spread, nested_mean


@dataclass(frozen=True, eq=False)
class PlateTrial:
    """depth_mm : (n,) way of the plate from its retracted position. force_n : (n,) along the push axis, as measured.
    time_s : (n,), where it is known.

    casting : which of its recipe; None where the specimen is the one that the study presses, so that no other casting
    matters. mounting : within which nothing was moved but the plate. diameter_mm, height_mm : of a cylinder, where they
    are known.
    """

    specimen: str
    trial: str
    depth_mm: Floats
    force_n: Floats
    casting: str | None = None
    mounting: str = ""
    diameter_mm: float | None = None
    height_mm: float | None = None
    ends: Ends = "frictionless"
    time_s: Floats | None = None

    @property
    def cylinder(self) -> Cylinder | None:
        return Cylinder(self.diameter_mm, self.height_mm, self.ends) if self.diameter_mm and self.height_mm else None


@dataclass(frozen=True, eq=False)
class SpecimenPlates:
    """What the trials of one specimen say that are not unusable.

    kappa : secants, N/mm. level : the further ones for which its interval holds, ``mountings`` of the specimen or
    ``castings`` of its recipe. range_n : that all trials reach. change : of kappa over it, a share, by the upper part.
    of_rubber : what a Neo-Hookean cylinder of this height would, 0 where none is known. bend, bend_se, bend_dof : of
    the tangents over it, first contact included. nonlinear : trials. modulus : in kPa, None where no size is known.
    laws : of each name the mean over trials, the best first. times : of the trials whose log has a clock.
    """

    name: str
    trials: int
    kappa: NestedMean
    level: str
    range_n: tuple[float, float]
    change: float
    of_rubber: float
    bend: float
    bend_se: float
    bend_dof: float
    nonlinear: int
    adj_r2: float
    modulus: NestedMean | None
    laws: tuple[LawFit, ...]
    cylinder: Cylinder | None
    times: tuple[PressTime, ...]

    @property
    def half(self) -> float:
        """Half the width of the 95 % interval of kappa, N/mm."""
        return self.kappa.half(self.level)

    @property
    def bend_half(self) -> float:
        """Half the width of the 95 % interval of the bend."""
        return t_975(self.bend_dof) * self.bend_se

    @property
    def error(self) -> float:
        """Standard error of kappa, N/mm."""
        return float(self.kappa.error[LEVELS.index(self.level)])


@dataclass(frozen=True, eq=False)
class PlateTests:
    """d trials and their fits. curves : of each trial depth (m,) in mm and force (m,) in N, smoothed, up to its deepest
    point or the end of the range. rubbers : None where the size of the specimen is not known. simulated : whether an
    emulated rig made any."""

    trials: tuple[PlateTrial, ...]
    fit: HookeFit
    curves: tuple[tuple[Floats, Floats], ...]
    simulated: bool
    ranges: tuple[RangeFit, ...]
    rubbers: tuple[Rubber | None, ...]
    times: tuple[PressTime | None, ...]
    spread: Spread

    @property
    def specimens(self) -> tuple[str, ...]:
        """Names, in the order of the trials."""
        return tuple(dict.fromkeys(trial.specimen for trial in self.trials))

    def of(self, specimen: str) -> list[int]:
        """Places of the trials on a specimen that are not unusable."""
        places = enumerate(zip(self.trials, self.ranges, strict=True))
        return [i for i, (trial, own) in places if trial.specimen == specimen and own.rating != "unusable"]

    def specimen(self, name: str) -> SpecimenPlates | None:
        """None where none of its trials can say."""
        if not (own := self.of(name)):
            return None
        ranges, trials = [self.ranges[i] for i in own], [self.trials[i] for i in own]
        rubbers = [rubber for i in own if (rubber := self.rubbers[i])]
        moduli = np.array([(rubber.modulus_kpa, rubber.modulus_se_kpa) for rubber in rubbers])
        return SpecimenPlates(
            name, len(own), self._mean(own, [(each.secant, each.secant_se) for each in ranges]),
            self._level(trials),
            (ranges[0].from_n, min(each.to_n for each in ranges)), float(np.mean([each.change for each in ranges])),
            float(np.nan_to_num(np.mean([each.of_rubber for each in ranges]))), *self._bend(own),
            sum(each.nonlinear for each in ranges), float(self.fit.adj_r2[own].min()),
            self._mean(own, moduli) if len(rubbers) == len(own) and np.isfinite(moduli).all() else None,
            _laws(rubbers) if len(rubbers) == len(own) else (), trials[0].cylinder,
            tuple(time for i in own if (time := self.times[i])),
        )  # fmt: skip

    def _level(self, trials: Sequence[PlateTrial]) -> str:
        castings = {trial.casting for trial in trials} - {None}
        return "castings" if len(castings) > 1 or (castings and self.spread.castings > 0) else "mountings"

    def _bend(self, own: Sequence[int]) -> tuple[float, float, float]:
        """Mean over presses, its standard error and degrees of freedom: those within the presses, and where the presses
        of all specimens scatter by more, that."""
        squares, dof = 0.0, 0
        for name in self.specimens:
            each = np.array([(self.ranges[i].bend, self.ranges[i].bend_se) for i in self.of(name)]).reshape(-1, 2)
            if each.size:
                within = max(float(np.mean(each[:, 1] ** 2)), np.finfo(np.float64).tiny)
                squares += float(np.sum((each[:, 0] - each[:, 0].mean()) ** 2)) / within
            dof += max(len(each) - 1, 0)
        ranges = [self.ranges[i] for i in own]
        within = float(np.mean([each.bend_se**2 for each in ranges]))
        error = np.sqrt(within * max(squares / dof if dof else 1.0, 1.0) / len(own))
        return float(np.mean([each.bend for each in ranges])), float(error), float(dof or ranges[0].dof)

    def _mean(self, own: Sequence[int], values: Sequence[tuple[float, float]] | Floats) -> NestedMean:
        value, error = np.array(values, dtype=np.float64).T
        trials = [self.trials[i] for i in own]
        return nested_mean(
            value, error, [each.casting or "" for each in trials], [each.mounting for each in trials], self.spread
        )

    def tangent(self, name: str) -> tuple[Floats, Floats, Floats]:
        """Forces (g,) that all trials on a specimen reach, kappa there, and half the width of its 95 % interval: that
        of the trials, and what the specimen's own interval holds beside, as a share."""
        own, whole = [self.ranges[i] for i in self.of(name)], self.specimen(name)
        assert whole is not None
        force_n = np.linspace(*whole.range_n, own[0].force_n.size)
        tangents = np.array([np.interp(force_n, each.force_n, each.tangent) for each in own])
        errors = np.array([np.interp(force_n, each.force_n, each.half_width(each.tangent_se)) for each in own])
        kappa = tangents.mean(axis=0)
        return force_n, kappa, np.hypot(np.sqrt(np.mean(errors**2, axis=0)), kappa * whole.half / whole.kappa.mean)

    def worst_adj_r2(self) -> dict[str, float]:
        """Specimen to the smallest adjusted R2 of its trials; NaN where the force of one of them does not rise."""
        r2 = np.where(self.fit.kappa > 0, self.fit.adj_r2, np.nan)
        names = np.array([trial.specimen for trial in self.trials])
        return {name: float(r2[names == name].min()) for name in self.specimens}


def plate_tests(
    trials: Sequence[PlateTrial], range_n: tuple[float, float], *, whole: bool = False, window: int = PAPER_WINDOW,
    simulated: bool = False, spread: Spread | None = None,
) -> PlateTests:  # fmt: skip
    """Every trial fitted. The line of the paper ends where the range of force does.

    range_n : as for ``fit_range``, N. whole : as there. window : as for ``fit_plate``.
    spread : between presses, mountings and castings where there is one.
    """
    alone = tuple(fit_range(each.depth_mm, each.force_n, range_n, each.height_mm, whole=whole) for each in trials)
    ranges = _common(trials, alone)
    pressed, rubbers, times = [], [], []
    for each, own, of_range in zip(trials, alone, ranges, strict=True):
        x, y, _ = loading(each.depth_mm, each.force_n)
        beyond = np.flatnonzero((x > own.depth_to) & (own.to_n == range_n[1]))
        end = int(beyond[0]) if beyond.size else x.size
        pressed.append((x[:end], y[:end]))
        rubbers.append(fit_rubber(x, y, each.cylinder, of_range) if each.cylinder else None)
        told = None
        if each.time_s is not None and of_range.rating != "unusable":
            told = press_time(each.depth_mm, each.force_n, each.time_s)
        times.append(told)
    return PlateTests(
        tuple(trials), fit_plate(pressed, window), tuple(smoothed(*each, window) for each in pressed), simulated,
        ranges, tuple(rubbers), tuple(times), spread or Spread(),
    )  # fmt: skip


def _common(trials: Sequence[PlateTrial], ranges: tuple[RangeFit, ...]) -> tuple[RangeFit, ...]:
    """The presses on a specimen over the forces that all of them reach."""
    reach: dict[str, float] = {}
    for trial, own in zip(trials, ranges, strict=True):
        if own.rating != "unusable":
            reach[trial.specimen] = min(own.to_n, reach.get(trial.specimen, np.inf))
    return tuple(
        fit_range(trial.depth_mm, trial.force_n, (own.from_n, reach[trial.specimen]), trial.height_mm)
        if own.rating != "unusable" and own.to_n > reach[trial.specimen]
        else own
        for trial, own in zip(trials, ranges, strict=True)
    )


def _laws(rubbers: Sequence[Rubber]) -> tuple[LawFit, ...]:
    """Mean of each law over presses, by the sum of their criteria. Its error is that of a press: presses are no
    witnesses of each other."""
    if not all(rubber.laws for rubber in rubbers):
        return ()
    found = [
        replace(
            each[0], **{
                key: float(np.mean([getattr(own, key) for own in each]))
                for key in ("modulus_kpa", "modulus_se_kpa", "second", "left_n", "aicc")
            },
        )
        for each in zip(*(rubber.laws for rubber in rubbers), strict=True)
    ]  # fmt: skip
    return tuple(sorted(found, key=lambda each: each.aicc))
