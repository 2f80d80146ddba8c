"""The settings of every stage, as frozen dataclasses with units in the names.

They stand beneath the stages, and import nothing heavy, so that a study file is checked in milliseconds and a step of
the pipeline can be keyed by exactly the settings it uses. The study file has one table per class; defaults are the
choices of a careful analyst, and ``paper`` mode replaces them with what the paper did (see ``PAPER``).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import Annotated, Any, Literal, NamedTuple

from emg2vsa.settings_class import settings_class

Condition = Literal["high-stiffness", "modular", "constant-min", "constant-mean", "constant-max"]
RIGID: Condition = "high-stiffness"
"""How the rig presses (paper, section V): a rigid motor, or the actuator with a whole profile or one level of it."""
Index = Literal["sum", "minimum", "rudolph", "falconer-winter"]
Weights = Literal["inverse-variance", "none"]
Curve = Literal["log", "spline"]
Interpolation = Literal["bracket", "paper", "log-stiffness", "coefficients"]


class Limit(NamedTuple):
    """What a value, or with "length >=" its length, must be."""

    sign: Literal[">", ">=", "<", "<=", "length >="]
    bound: float


Gt, Ge, Lt, Le = partial(Limit, ">"), partial(Limit, ">="), partial(Limit, "<"), partial(Limit, "<=")
MinLen = partial(Limit, "length >=")


class Tagged(NamedTuple):
    """Marks a table whose keys are those of the kind of device that its key ``kind`` names."""

    role: str


LABEL_CHARACTERS = 16
"""Longest name of a channel that EDF and BDF hold."""

GAUGE_AXES = ("Fx", "Fy", "Fz")
"""Forces that the gauges of an ATI transducer give."""

Positive = Annotated[float, Gt(0)]
NonNegative = Annotated[float, Ge(0)]
Fraction = Annotated[float, Gt(0), Le(1)]


@settings_class
class EmgChannelSettings:
    """One muscle's EMG channel."""

    name: Annotated[str, MinLen(1)]
    "Channel name as the file writes it."
    unit: Literal["V", "mV", "uV"] | None = None
    "Unit of the stored values; replaces the file's own statement. Needed where the file states none."
    gain: Positive = 1.0
    "Amplifier gain to divide by (100, 1000 or 10000 for a Bagnoli through a DAQ; 1 for input-referred files)."
    fs_hz: Positive | None = None
    "Sampling rate, Hz, for a file that states none, such as one without a time column; the two must agree."


@settings_class
class ForceChannelSettings:
    """The pressing force channel."""

    name: Annotated[str, MinLen(1)]
    "Channel name as the file writes it; with cal_file the axis to take: Fx, Fy or Fz."
    unit: Annotated[str, MinLen(1)] | None = None
    "Unit of the stored values (N, mN, kN, lbf, kgf, gf, or any other together with newtons_per_unit); of gauges V, mV."
    newtons_per_unit: Positive | None = None
    "Declared newtons per stored unit, for units that are not a force (%MVC, counts, V)."
    sign: Literal[1, -1] = 1
    "-1 where the sensor reports compression as negative."
    tare: Literal["rest", "none"] = "rest"
    "rest: subtract the force of the pre-contact rest; none: the channel is already zeroed."
    delay_s: NonNegative = 0.0
    "Known delay of the sensor's own filter, in seconds; removed from the pairing of force and EMG."
    fs_hz: Positive | None = None
    "Sampling rate, Hz, for a file that states none, such as one without a time column; the two must agree."
    cal_file: Annotated[str, MinLen(1)] | None = None
    "Calibration file (.cal) of an ATI transducer whose six gauges the recording holds; needs gauges."
    gauges: tuple[str, str, str, str, str, str] | None = None
    "Channel names of the six gauges, in the order of the transducer; with cal_file."
    volts_per_unit: Positive | None = None
    "Volts per stored unit of the gauges, where they are counts of a converter; with cal_file."
    trigger: tuple[str, str] | None = None
    "Force in a file of its own: channels of one trigger in the EMG's file and in the force's, for a common clock."


@settings_class
class ChannelSettings:
    """Which channel plays which role."""

    emg: Annotated[dict[str, EmgChannelSettings], MinLen(1)]
    "Muscle role (EDC, FDS, ...) to channel."
    force: ForceChannelSettings
    "The pressing force."


@settings_class
class ReadingSettings:
    """What the decoder of a binary recording (EDF, C3D, .mat, TDMS, XDF, HDF5) may cost before the file is refused."""

    max_seconds: Annotated[float, Ge(1), Le(3600)] = 10.0
    "Longest time for opening the file and for each decoding, seconds; 1 s more for every 10 MB of the file."
    max_memory_mb: Annotated[float, Ge(200), Le(1_000_000)] = 600.0
    "Most memory of the decoder, MB, and ten times the file's size more; macOS and Windows do not enforce it."


@settings_class
class FilterSettings:
    """Conditioning of EMG and force (paper IV.B)."""

    band_hz: tuple[Positive, Positive] = (10.0, 450.0)
    "EMG band-pass: -3 dB edges of the whole run, both passes. An upper edge at or above fs/2 is dropped (recorded)."
    band_order: Annotated[int, Ge(1), Le(8)] = 2
    "Butterworth order in scipy's and MATLAB's sense (a band-pass of order 2 has four poles)."
    envelope: Literal["fir", "rms"] = "fir"
    "fir: rectify and FIR low-pass; rms: moving root mean square, whose a and b are 25 % larger on Gaussian EMG."
    fir_order: Annotated[int, Ge(2), Le(2000)] = 50
    "Order of the Hamming low-pass (taps - 1); even, so that its delay is a whole number of samples."
    fir_cutoff_hz: Positive = 20.0
    "Cut-off given to the window design (its -6 dB edge is near it only for long filters; the true edge is printed)."
    rms_window_s: Positive = 0.1
    "Length of the moving RMS window."
    phase: Literal["zero-phase", "compensated", "causal"] = "zero-phase"
    "zero-phase: forward and backward; compensated: causal, then shifted by the known delay; causal: as on line."
    force_cutoff_hz: Positive = 5.0
    "Butterworth low-pass on force."
    force_filter: bool = True
    "false: take force as it is (already filtered by the sensor)."
    force_order: Annotated[int, Ge(1), Le(8)] = 2
    "Butterworth order of the force low-pass."
    output_fs_hz: Positive | Literal["native"] = 100.0
    "Rate of the conditioned curves; the nearest whole divisor of the EMG rate is used. native: the EMG rate itself."
    mains: Literal["remove", "keep"] = "remove"
    "remove: hum of 50 or 60 Hz and its harmonics, fitted in the rests, is subtracted from the EMG; keep: it stays."
    rest_level: Literal["subtract", "keep"] = "subtract"
    "subtract: the envelope's lowest level at rest is taken as noise and subtracted in power; keep: it stays."
    align: Literal["stated", "lag"] = "stated"
    "stated: EMG and force share the clock of their files; lag: force is moved by its lag, where that is certain."
    engine: Literal["plain", "compiled"] = "plain"
    "compiled: envelopes by loops that Numba compiles (the extra flow), faster, equal to 13 digits; plain: without it."


@settings_class
class CocontractionSettings:
    """How the envelopes of the muscles become one activity."""

    index: Index = "sum"
    "sum (paper); Rudolph 2000; Falconer and Winter 1985; minimum ('wasted contraction')."
    normalise: Literal["none", "session-max", "mvc"] = "none"
    "none: volts, comparable within one session only; session-max: fraction of the session's largest; mvc: of mvc_v."
    crosstalk: dict[str, dict[str, Fraction]] = field(default_factory=dict)
    "Muscle to the others that its electrode sees, each by a share of its own amplitude; subtracted in power."
    mvc_v: dict[str, Positive] = field(default_factory=dict)
    "Envelope level of the maximum voluntary contraction per muscle, volts; used by normalise = 'mvc'."

    @property
    def needs_session(self) -> bool:
        """Whether a recording's activity depends on the participant's other recordings."""
        return self.normalise == "session-max"


@settings_class
class WindowSettings:
    """Which part of a recording is a trial, and which trials are good."""

    force_n: tuple[Positive, Positive] = (0.5, 7.0)
    "Loading phase, lower and upper force in newtons."
    min_duration_s: Positive = 0.5
    "A loading phase shorter than this is rejected."
    max_duration_s: Positive = 20.0
    "A loading phase longer than this is rejected."
    max_falling_share: Fraction = 0.1
    "Largest share of the force path that may fall (beyond noise) before the trial is rejected."
    warn_falling_share: Fraction = 0.03
    "The same, above which it is told."
    max_gap_force_n: Positive = 0.25
    "The rest level must lie this close to zero after taring; else it is told."
    min_snr_db: float = 6.0
    "EMG of the loading phase over EMG of the rest; below it the trial says so."
    clip_share: Fraction = 0.001
    "Share of samples at the extreme value above which a channel counts as clipped and the trial is rejected."
    max_missed_n: Positive = 0.3
    "A press whose record begins further than this above the lower force is rejected; a bin of the fit by default."
    implausible: Literal["reject", "warn"] = "reject"
    "reject: presses of signals that cannot be right (unit, rectified, zero of force lost) are not used; warn: told."
    expected_trials: Annotated[int, Ge(1)] | None = None
    "Number of presses a recording should hold; another number is reported."


MOST_BINS = 1000
"Force bins of a press at most: a fit holds the covariance of every pair, 8 MB an array."


@settings_class
class FitSettings:
    """The logarithmic fit v = a + b log F, equation (6)."""

    points: Literal["bins", "samples"] = "bins"
    "bins: means over force bins, honest standard errors; samples: the paper's fit on the curve itself."
    bin_n: Positive = 0.3
    "Width of the force bins, newtons."
    weights: Weights = "inverse-variance"
    "inverse-variance: samples over v^2 of the fit itself (noise grows with the level); none: ordinary least squares."
    robust: bool = False
    "Huber weights on top, for bursts and artefacts."
    min_adj_r2: Annotated[float, Ge(-1), Lt(1)] = 0.3
    "A press whose bins fit worse (adjusted R squared), with b not known to 0.2 of its level, is rejected; -1: none is."
    max_b_error: NonNegative = 4.0
    "... and one whose interval of b reaches further than so many times b, and than that, to either side; 0: none is."
    max_b_error_ratio: NonNegative = 10.0
    "... and one whose interval is so many times wider than the median of its recording; 0: none is."
    max_bias: NonNegative = 0.1
    "A press whose b is expected to be off by a larger share, or by more than its half width, is doubtful, and "
    "rejected where lost samples are the cause; 0: none is."
    confidence: Annotated[float, Gt(0), Le(0.9999)] = 0.95
    "Level of the intervals."


@dataclass(frozen=True)
class PressJudgement:
    """A person's word on a press, or without ``repetition`` on all of a recording: excluded, or else accepted."""

    participant: str
    specimen: str
    repetition: int | None
    reason: str
    excludes: bool


@settings_class
class HypothesisSettings:
    """The tests on b of section IV.B."""

    alpha: Annotated[float, Gt(0), Le(0.5)] = 0.05
    "Significance level."
    kept_specimens: tuple[str, ...] = ()
    "Specimens among which the worst p is taken (paper: S1, S3, S5); empty: all."
    use: Literal["ok", "ok+doubtful"] = "ok"
    "Verdicts of the trials that enter; doubtful: b is known to be off by more than its interval, or by `max_bias`."
    equivalence_margin_sd: Positive | None = None
    "Participants whose mean slopes differ by less count as equal, in SDs of repetitions; omitted: equality untested."


MEDOID = "medoid"
"""The exemplary participant is the one whose schedules differ least, on average, from those of the others."""


@settings_class
class ProfileSettings:
    """Mean trends and the profile of a new specimen."""

    participant: str | None = None
    "Exemplary participant; medoid: the one whose schedules differ least from the others'; omitted: mean over all."
    specimens: tuple[str, ...] = ()
    "Specimens whose profiles are exported; empty: all."
    new_specimen: str | None = None
    "Name of the specimen to interpolate."
    new_stiffness_n_per_mm: Positive | None = None
    "Its stiffness, N/mm."
    new_height_mm: Positive | None = None
    "Its height, mm, as height_mm of the others: where tables of domes are not for it, kappa by the pins is refused."
    interpolation: Interpolation = "bracket"
    "bracket: linear in stiffness; paper: weight kappa/10; log-stiffness; coefficients: cubic through a and b of all."
    curve: Curve = "log"
    "Schedules and profiles follow log: v = a + b ln F; spline: a monotone spline through the force bins."
    extrapolate: bool = False
    "Allow a new specimen outside the stiffness bracket."
    grid_points: Annotated[int, Ge(2), Le(10000)] = 100
    "Forces at which curves are evaluated."


@settings_class
class ScheduleSettings:
    """Mapping (7) of co-contraction to actuator stiffness, and the ramp of (8)."""

    stiffness_percent: tuple[NonNegative, Annotated[float, Gt(0), Le(100)]] = (20.0, 80.0)
    "Stiffness at the smallest and the largest co-contraction, percent of the device's maximum on ``scale``."
    scale: Literal["preset", "stiffness"] = "preset"
    "preset (paper): linear in the preset that is commanded; stiffness: linear in N m/rad at zero load."
    step_n: Positive = 0.3
    "Force step, newtons; a shorter last step is kept and marked."
    actuator: str = "qbmove-advanced"
    "Model that states the stiffness in N m/rad at zero load: qbmove-advanced, qbmove-maker-pro, dynamixel."
    max_preset_ticks: Annotated[int, Gt(0)] = 3000
    "qbmove: largest stiffness preset of the device, in its ticks (32768 a turn); read from the device before a run."
    full_stiffness_nm_per_rad: Positive | None = None
    "dynamixel: stiffness at the full gain, N m/rad, as emg2vsa rig commission measures it."
    probe_speed_mm_per_s: Positive = 5.0
    "Speed of the probe along the specimen's vertical axis."
    gear_mm_per_degree: Positive = 0.2
    "Probe travel per degree of the output shaft."
    travel_mm: Positive = 15.0
    "Length of the position ramp."
    conditions: tuple[Literal["modular", "constant-min", "constant-mean", "constant-max"], ...] = (
        "modular",
        "constant-min",
        "constant-mean",
        "constant-max",
    )
    "Conditions exported."


@settings_class
class SimulationSettings:
    """The synthetic study: continuous recordings whose truth is known (``emg2vsa tools simulate``)."""

    seed: Annotated[int, Ge(0)] = 1
    "Same seed, same bytes."
    repetitions: Annotated[int, Ge(1), Le(1000)] = 10
    "Presses per recording."
    fs_hz: Positive = 1000.0
    "Sampling rate of EMG and force."
    a_v: dict[str, float] = field(default_factory=dict)
    "True intercept of the co-contraction per specimen, volts."
    b_v: dict[str, float] = field(default_factory=dict)
    "True slope per specimen, volts per natural-log newton."
    muscle_share: dict[str, Fraction] = field(default_factory=lambda: {"EDC": 0.4, "FDS": 0.6})
    "Share of each muscle in the co-contraction; the shares sum to one."
    participant_sd: NonNegative = 0.0
    "Relative spread of b between participants."
    repetition_sd: NonNegative = 0.05
    "Relative spread of b between the repetitions of one cell."
    emg_noise_v: NonNegative = 1.2e-6
    "Sensor noise, volts rms."
    mains_v: NonNegative = 5e-7
    "Mains hum at mains_hz, volts rms."
    mains_hz: Positive = 50.0
    "Mains frequency."
    force_noise_n: NonNegative = 0.02
    "Force sensor noise, newtons rms per sample."
    force_offset_n: float = 0.35
    "Largest bias of the force sensor (drawn per recording), newtons."
    loading_s: tuple[Positive, Positive] = (2.0, 3.0)
    "Shortest and longest loading phase, seconds."
    rest_s: tuple[Positive, Positive] = (1.5, 2.5)
    "Shortest and longest rest between presses, seconds."


Algorithm = Literal["front", "edge", "hexagon", "circle", "paper"]


class Recipe(NamedTuple):
    """Every step from frames to a spread rate; ``RunSettings`` explains the keys."""

    engine: str
    force_rule: str
    area_rule: str
    law: str
    rate: str
    region: str = "contact"


RECIPES: dict[str, Recipe] = {
    "front": Recipe("pin-affine", "exposure", "edge", "ode", "power"),
    "edge": Recipe("pin-affine", "exposure", "edge", "ode", "power"),
    "hexagon": Recipe("pin-affine", "exposure", "hexagon", "ode", "power"),
    "circle": Recipe("pin-affine", "exposure", "circle", "ode", "power"),
    "paper": Recipe("horn-schunck", "mean", "paper", "paper", "paper"),
}
"""What an algorithm sets of the keys that a study leaves out (paper: sections III.A, IV.A and VI.A)."""
PAPER_BESIDE = RECIPES["paper"]._replace(engine="pin-affine")
"""The paper's beside another algorithm: with the flow of the pins, as dense flow needs numba, which is an extra."""


@settings_class
class RunSettings:
    """How the presses of the rig are scored (paper III.A, IV.A).

    ``algorithm`` sets engine, force_rule, area_rule, law, rate and region, unless a key says otherwise: see
    ``RECIPES``.
    """

    algorithm: Algorithm = "front"
    "front: contact area frame by frame; edge, hexagon, circle: first contact, grown by its skin; paper: the paper's."
    engine: Literal["pin-affine", "horn-schunck", "dis"] | None = None
    "Flow that growth comes from: of the pins, or dense (paper: horn-schunck); omitted: as the algorithm has it."
    force_rule: Literal["exposure", "mean"] | None = None
    "Force of a frame: at exposure, or mean of the rows with its index (paper); omitted: as the algorithm has it."
    area_rule: Literal["edge", "hexagon", "circle", "paper"] | None = None
    "Initial area; differs from the algorithm only for algorithm = 'paper'; omitted: as the algorithm has it."
    law: Literal["ode", "paper"] | None = None
    "Area from growth: ode, exp(sum of growth); paper: equation (1) as printed; omitted: as the algorithm has it."
    rate: Literal["power", "slope", "paper"] | None = None
    "CASR: mean rate on a power law, slope, or equation (2) as printed (paper); omitted: as the algorithm has it."
    region: Literal["contact", "image"] | None = None
    "Where growth is measured; image: mean divergence of the whole image, by a dense engine; omitted: contact."
    force_n: tuple[Positive, Positive] = (0.5, 7.0)
    "Loading phase that is scored, in newtons: CASR is the mean rate between the two (paper: over the frames between)."
    threshold_px: Positive = 2.0
    "A pin that moved further than this from rest is in contact (hexagon, paper)."

    @property
    def recipe(self) -> Recipe:
        """The algorithm's, with the keys that are set."""
        given = {name: getattr(self, name) for name in Recipe._fields}
        return RECIPES[self.algorithm]._replace(**{name: value for name, value in given.items() if value is not None})

    def recipe_of(self, algorithm: str) -> Recipe:
        """Recipe of an algorithm on the same presses. A recipe of the skin differs from the chosen one by its
        initial area.
        """
        if algorithm == self.algorithm:
            return self.recipe
        if algorithm == "front":
            return RECIPES["front"]
        return PAPER_BESIDE if algorithm == "paper" else self.recipe._replace(area_rule=algorithm)


@settings_class
class DiscriminationSettings:
    """The comparisons of the presses of the rig (paper VI)."""

    alpha: Annotated[float, Gt(0), Le(0.5)] = 0.05
    "Error of each interval that stands alone, and of the paper's tests."
    old_algorithm: Algorithm = "circle"
    "Vision algorithm that the one of the runs is compared with."


Law = Literal["compliance", "exponential", "power", "linear-log"]
Minimise = Literal["casr", "kappa", "ln kappa"]


@settings_class
class CalibrationSettings:
    """From scores to stiffness: which law, how it is fitted, and how its intervals are made (paper VI)."""

    law: Law = "compliance"
    "compliance: 1/kappa = a + b CASR^1.5 (Hertz); exponential (paper): p exp(q CASR); power: p CASR^q; linear-log."
    minimise: Minimise = "casr"
    "Errors of CASR (errors in x: the noise is in the score), of kappa (paper), or of ln kappa; see the law."
    points: Literal["means", "repetitions"] = "means"
    "means: one point a specimen; repetitions: every press, which are repeats and not more specimens."
    angle_sd_deg: NonNegative = 0.5
    "How well the angle of a mounting is repeated, degrees (guess: by hand); presses of one mounting do not show it."
    mounting_sd_percent: Annotated[float, Ge(0), Lt(50)] = 4.3
    """SD of a score between mountings, in percent of it, where repeats do not tell (guess: the emulated rig's).
    0: none. By the pins it always counts, as 0.8 times as much of kappa."""
    outlier_mads: NonNegative = 5.0
    "A press this many median absolute deviations (scaled to SDs) from its median is left out; if over 20 % are, none."
    confidence: Annotated[float, Gt(0), Lt(1)] = 0.95
    "Confidence of intervals of kappa, by the pins and by CASR."
    resamples: Annotated[int, Ge(1)] = 2000
    "Resamples of the bootstrap over repetitions."
    seed: Annotated[int, Ge(0)] = 0
    "Same seed, same bootstrap."


@settings_class
class ClaimSettings:
    """The smallest differences that matter: by these and by its interval a claim is judged."""

    false_verdict_percent: Annotated[float, Ge(0.01), Le(25)] = 10.0
    "Chance that a report has any false verdict, at most: 10 % over some 20 claims gives each an interval of 99 %."
    slope_percent: Positive = 10.0
    "Difference of b between specimens that matters, % of their mean (presses of one person scatter by 10 to 20 %)."
    people_f: Positive = 0.25
    "SD of b between people over that of presses: Cohen's f, the effect that the paper planned for."
    cluster_shape: Positive = 0.5
    "Skewness of b of one person on one specimen, and half of its excess kurtosis (0.5 is called moderate)."
    law_percent: Positive = 5.0
    "Share by which another law may predict better than the logarithm (force bins scatter by more)."
    profile_percent: Positive = 10.0
    "Error of the interpolated profile, % of the measured level (mean slopes of people are known no better)."
    neighbour_percent: Positive = 50.0
    "The same, % of the difference of its neighbours: beyond half of it, a neighbour would do as well."
    area_percent: Positive = 5.0
    "Difference of contact areas that matters (the area of one mounting is known no better)."
    casr_percent: Positive = 2.0
    "Difference of CASR that matters (2 % of CASR are some 20 % of kappa)."
    contrast_percent: Positive = 5.0
    "Change that matters in the ratio of CASR of two specimens, from condition to condition."
    separation: Positive = 1.0
    "Change that matters in the distance of two specimens between conditions, in SDs of a press."
    kappa_error_percent: Positive = 20.0
    "Error of kappa (the specimens of the paper lie 60 % apart)."
    reduction_points: Positive = 5.0
    "Cut of the error of kappa by a step that matters, percentage points (the paper claims 3 to 24)."


@settings_class
class StageSettings:
    """The settings of all stages: a table of the study file and a field of the study for each."""

    reading: ReadingSettings = field(default_factory=ReadingSettings)
    "What the decoder of a binary recording may cost."
    filters: FilterSettings = field(default_factory=FilterSettings)
    "Conditioning of EMG and force."
    cocontraction: CocontractionSettings = field(default_factory=CocontractionSettings)
    "How muscles become one activity."
    window: WindowSettings = field(default_factory=WindowSettings)
    "What is a trial, and which trials are good. All recordings share its forces, and may differ in the rest."
    fit: FitSettings = field(default_factory=FitSettings)
    "The logarithmic fit."
    hypotheses: HypothesisSettings = field(default_factory=HypothesisSettings)
    "The tests on its slope."
    profile: ProfileSettings = field(default_factory=ProfileSettings)
    "Mean trends and the new specimen."
    schedule: ScheduleSettings = field(default_factory=ScheduleSettings)
    "From co-contraction to actuator stiffness."
    discrimination: DiscriminationSettings = field(default_factory=DiscriminationSettings)
    "The tests on contact areas and spread rates."
    calibration: CalibrationSettings = field(default_factory=CalibrationSettings)
    "From spread rate to stiffness."
    claims: ClaimSettings = field(default_factory=ClaimSettings)
    "What differences matter."
    simulation: SimulationSettings | None = None
    "The synthetic study; omitted: the study cannot be simulated."


PAPER: dict[str, dict[str, Any]] = {
    "filters": {
        "band_hz": (10.0, 500.0),
        "phase": "causal",
        "output_fs_hz": "native",
        "mains": "keep",
        "rest_level": "keep",
    },
    "window": {"max_missed_n": 1000.0, "implausible": "warn"},
    "fit": {
        "points": "samples",
        "weights": "none",
        "robust": False,
        "min_adj_r2": -1.0,
        "max_b_error": 0.0,
        "max_b_error_ratio": 0.0,
        "max_bias": 0.0,
    },
    "profile": {"interpolation": "paper"},
    "runs": {"algorithm": "paper"},
    "calibration": {"law": "exponential", "minimise": "kappa", "outlier_mads": 0.0},
}
"""What ``mode = "paper"`` sets, unless the study says otherwise (docs/method.md)."""
