"""What the calibration stage hands on: plain numbers, one entry for each angle, condition and vision algorithm."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import special

from casr.kappa.posterior import ends
from casr.spread.intervals import student_quantile
from emg2vsa.arrays import Floats
from emg2vsa.calibration.forms import kappa_of
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration.online_pins import KnownPins
from emg2vsa.calibration.repeats import ends_on_law
from emg2vsa.settings import Law


@dataclass(frozen=True)
class OnLaw:
    """A stiffness as a law estimates it: eta with its standard error and degrees of freedom, on the axis of the law
    (``forms``); NaN where there is none. known : N/mm, by plate indentation, NaN where not known."""

    law: Law
    eta: float
    eta_se: float
    df: float
    known: float

    def interval(self, confidence: float) -> tuple[float, float]:
        """low and high of kappa, N/mm; NaN without an estimate, high infinite where it may be rigid."""
        reach = float(special.stdtrit(self.df, 0.5 + 0.5 * confidence)) * self.eta_se
        low, high = ends_on_law(self.law, np.array(self.eta), np.array(reach))
        return float(low), float(high)

    @property
    def error(self) -> float:
        """kappa over the known kappa, minus 1; infinite where the law makes it stiffer than rigid."""
        kappa = float(kappa_of(self.law, np.array(self.eta)))
        return (np.inf if np.isnan(kappa) and self.eta == self.eta else kappa) / self.known - 1

    def error_interval(self, confidence: float) -> tuple[float, float]:
        """low and high of that error."""
        low, high = self.interval(confidence)
        return low / self.known - 1, high / self.known - 1


@dataclass(frozen=True, eq=False)
class LawResult:
    """One law through the known specimens, and the new one by it; NaN where undefined.

    law, minimise, equation : how, and the fit in numbers. parameters : a and b, or p and q, of the equation.
    r2, adj_r2 : of kappa, which on three specimens say next to nothing. kappa, low, high : N/mm, with the interval by
    all of ``on_laws``. bootstrap_low, bootstrap_high : by drawing presses again. error : kappa over the known kappa of
    the new specimen, minus 1; NaN where that is not known. left_out : (S,) N/mm, each specimen as the others say.
    law_p : of the law, from the left-out specimens. notes : for the reader. determined : whether the design promises
    an interval narrower than the calibrated range, and the law is sound. widened : factor on the interval of a law that
    is rejected. serial_correlation, serial_p : of successive presses; effective_presses : independent ones that those
    of the new specimen count as. amplification : percent of kappa for 1 % of CASR. mounting_sd : of CASR from one
    mounting to the next, as a share of it; mounting_freedom : degrees of freedom that it was estimated with, 0 where it
    is assumed. on_laws : the new specimen by this law, then by every other one that the known specimens do not reject;
    fitted_on_law : each known specimen by this law, which was fitted to it as well. Intervals of any confidence follow
    from them.
    """

    law: str
    minimise: str
    equation: str
    parameters: tuple[float, float]
    r2: float
    adj_r2: float
    kappa: float
    low: float
    high: float
    bootstrap_low: float
    bootstrap_high: float
    error: float
    left_out: Floats
    law_p: float
    notes: tuple[str, ...]
    determined: bool = True
    widened: float = 1.0
    serial_correlation: float = 0.0
    serial_p: float = float("nan")
    effective_presses: float = float("nan")
    amplification: float = float("nan")
    mounting_sd: float = float("nan")
    mounting_freedom: float = 0.0
    on_laws: tuple[OnLaw, ...] = ()
    fitted_on_law: tuple[OnLaw, ...] = ()

    def error_interval(self, confidence: float) -> tuple[float, float]:
        """low and high of ``error``, which hold those by all of ``on_laws``; NaN without an estimate."""
        ends = [each.error_interval(confidence) for each in self.on_laws] or [(np.nan, np.nan)]
        return float(np.min([low for low, _ in ends])), float(np.max([high for _, high in ends]))


@dataclass(frozen=True, eq=False)
class FusedResult:
    """Both cues together; kappa, low, high in N/mm, error as in ``LawResult``.

    weight : of the cutaneous cue. correlation : of the two scores of a press. p : of the cues agreeing.
    """

    kappa: float
    low: float
    high: float
    error: float
    weight: float
    correlation: float
    chi2: float
    p: float
    notes: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class AlgorithmResult:
    """One vision algorithm.

    casr : (S, R) scores of the known specimens; new_casr : (R,); NaN where there is none, in casr_unit.
    chosen : by the settings. paper : exponential, least squares of kappa. left_out_rms : law to the root mean square
    error of left-out specimens; best_law : the law with the smallest, '' where none has one.
    fused : with the indentation; None without a log of it.
    """

    casr: Floats
    new_casr: Floats
    casr_unit: str
    chosen: LawResult
    paper: LawResult
    left_out_rms: dict[str, float]
    best_law: str
    fused: FusedResult | None


@dataclass(frozen=True, eq=False)
class PinsResult:
    """The stiffness of the new specimen by the whole field of the pins (``casr.kappa``), N/mm, with its total interval.

    error : kappa over the known kappa, minus 1; NaN before the calibration knows it. determined : whether the design
    promises a half width of at most ``casr.kappa.posterior.DETERMINED``; expected : that half width, as a share of
    kappa. bound_sd : of ln kappa, by the bound of Cramer and Rao for the noise of the pins. efficiency : that over the
    standard error reached.
    by_cue : kappa and standard error of ln kappa by each cue alone. misfit : share of the motion that no dome explains.
    presses : how many of the new specimen count. left_out, left_out_low, left_out_high : (S,) each known specimen as
    the others say, NaN where they are fewer than two. log_sd, freedom, kappa0 : as of ``casr.kappa.posterior.Kappa``,
    from which intervals of any confidence follow. notes : for the reader.
    known : what the presses of the known specimens say, for presses to come.
    """

    kappa: float
    low: float
    high: float
    error: float
    determined: bool
    expected: float
    bound_sd: float
    efficiency: float
    by_cue: dict[str, tuple[float, float]]
    misfit: float
    presses: int
    left_out: Floats
    left_out_low: Floats
    left_out_high: Floats
    log_sd: float
    freedom: float
    kappa0: float
    notes: tuple[str, ...]
    known: KnownPins

    def error_interval(self, confidence: float) -> tuple[float, float]:
        """low and high of ``error``."""
        known = self.kappa / (1 + self.error)
        low, high = ends(self.kappa, self.kappa0, student_quantile(confidence, self.freedom) * self.log_sd)
        return low / known - 1, high / known - 1


@dataclass(frozen=True, eq=False)
class DesignByPins:
    """One angle, degrees, and condition by its pins. pins : None where they tell no kappa, and no_pins says why."""

    angle_deg: float
    condition: str
    pins: PinsResult | None
    no_pins: str = ""


Headline = PinsResult | LawResult
"""Both tell kappa, low, high, error and determined."""


@dataclass(frozen=True, eq=False)
class ConditionResult:
    """One angle and condition.

    specimens : S names. known_kappa : (S,) N/mm. exponent : 1 / p of A ~ F^p as the presses show it, 3/2 for Hertz;
    NaN without curves. algorithms : by name. indentation : kappa by force over indentation alone; None without a log.
    pins : by the pins; None where they tell none, and no_pins says why.
    """

    angle_deg: float
    condition: str
    simulated: bool
    specimens: tuple[str, ...]
    known_kappa: Floats
    exponent: float
    algorithms: dict[str, AlgorithmResult]
    indentation: LawResult | None
    pins: PinsResult | None = None
    no_pins: str = ""

    def headline(self, algorithm: str) -> Headline | None:
        """The one estimate that counts: by the pins; where they tell none, by the law through the scores of the
        study's algorithm; None where there is neither."""
        return self.pins or (self.algorithms[algorithm].chosen if algorithm in self.algorithms else None)


@dataclass(frozen=True, eq=False)
class CalibrationResults:
    """The stage's product.

    known_kappa_new : N/mm of the new specimen, NaN where not known. conditions : in the order of the runs.
    notes : which angles and conditions could not be calibrated, and why. online : what presses of an unknown specimen
    are judged by, for every angle and condition with known specimens. algorithm : the vision algorithm that counts.
    """

    new_specimen: str
    known_kappa_new: float
    conditions: tuple[ConditionResult, ...]
    notes: tuple[str, ...]
    online: tuple[OnlineCalibration, ...] = ()
    algorithm: str = ""

    def find(self, angle_deg: float, condition: str) -> ConditionResult | None:
        """The entry of one angle, degrees, and condition; None where there is none."""
        return next(
            (each for each in self.conditions if (each.angle_deg, each.condition) == (angle_deg, condition)), None
        )

    def headline(self, condition: str, angle_deg: float, algorithm: str) -> Headline | None:
        """``ConditionResult.headline`` of this condition and angle, degrees; None where it was not calibrated."""
        design = self.find(angle_deg, condition)
        return design.headline(algorithm) if design else None

    def law(self, condition: str, angle_deg: float, algorithm: str) -> LawResult | None:
        """The law of the study through the scores of a vision algorithm, at an angle in degrees; None where these were
        not calibrated."""
        design = self.find(angle_deg, condition)
        return design.algorithms[algorithm].chosen if design and algorithm in design.algorithms else None
