"""The methods of a paper under their headings, from the settings that ran; ``[@key]`` cites a work of ``references``.

The items follow the reporting standards of ISEK (Merletti and Di Torino 1999) and SENIAM; what a study file does not
know (electrodes, amplifier, ethics) is listed for the authors to add, not made up.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from emg2vsa.calibration.presses import MOST_OUTLIERS
from emg2vsa.calibration.results import CalibrationResults, LawResult
from emg2vsa.devices.joints import export_of
from emg2vsa.exemplary import Choice
from emg2vsa.extraction import Trials
from emg2vsa.report.wording import count, listed
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import (
    MEDOID,
    CalibrationSettings,
    CocontractionSettings,
    DiscriminationSettings,
    FilterSettings,
    FitSettings,
    HypothesisSettings,
    RunSettings,
    WindowSettings,
)
from emg2vsa.study import Person, RecordingEntry, Study

AUTHORS_ADD = (
    "Electrode type, size, distance and placement; amplifier, its gain, input impedance "
    "and common-mode rejection; resolution of the converter; {}ethics approval."
)
_FILTER_NOTES = (
    "NYQUIST RULE",
    "EMG band-pass",
    "EMG high-pass",
    "EMG envelope",
    "force low-pass",
    "delays:",
)
_PHASE = {
    "zero-phase": "the Butterworth filters were run forward and backward and the {envelope} was centred, so that "
    "nothing is delayed (zero phase)",
    "compensated": "all filters were causal, and the difference of their known delays was removed when EMG and force "
    "were paired",
    "causal": "all filters were causal, as on line, and their delays were left in",
}
_INDEX = {
    "sum": "the sum of the envelopes",
    "rudolph": "the index (lower / higher envelope) × their sum [@rudolph]",
    "falconer-winter": "twice the lower envelope over the sum of both [@falconer]",
    "minimum": "the lowest envelope at each instant",
}
_NORMALISED = {
    "none": "in volts and not normalised, so that levels compare within a session only",
    "session-max": "each envelope first divided by the muscle's largest in the trials of the session that were not "
    "rejected",
    "mvc": "each envelope first divided by the muscle's level at maximum voluntary contraction (the largest mean over "
    "0.5 s, where that was recorded)",
}
_INTERPOLATION = {
    "bracket": "linearly in stiffness between its two neighbours",
    "paper": "between its two neighbours in stiffness, with the new stiffness over 10 N/mm as the weight of the softer",
    "log-stiffness": "linearly in the logarithm of stiffness between its two neighbours",
    "coefficients": "by monotone cubics in stiffness through a and b of all exported specimens [@fritsch]",
}
_FEW = 3
RMS_READS_MORE = " (which reads 25 % more than a rectified mean of the same Gaussian signal, in a and b alike)"


@dataclass(frozen=True)
class Paragraph:
    """One heading of the methods, and its text with citations as ``[@key]``."""

    heading: str
    text: str


def methods(
    study: Study,
    trials: Sequence[Trials],
    versions: Mapping[str, str],
    simulated: bool = False,
    runs: Sequence[RunScores] = (),
    calibration: CalibrationResults | None = None,
    choice: Choice | None = None,
    exported: bool = True,
) -> list[Paragraph]:
    """``trials`` supply what was measured of the filters (true edges, delays) as they ran.

    calibration : of the runs. choice : how far the participants are apart. exported : there are profiles.

    Of a study without recordings, nothing is said of people, and of one without runs nothing of the rig.
    """
    people: dict[str, list[str]] = {
        "Participants and recordings": [_recording(study, trials, simulated)],
        "Signal processing": [
            *_by_recording(study, lambda entry: _filters(entry.filters)),
            *_by_recording(study, lambda entry: _tare(entry.channels.force.tare)),
            _cocontraction(study.cocontraction),
        ],
        "Presses and fits": [
            *_by_recording(study, lambda entry: _segmentation(entry.window)),
            _fit(study.fit, study.window),
        ],
        "Statistical analysis": list(_tests(study)),
        "Stiffness schedules": list(_export(study, choice)) if exported else [],
    }
    rig: dict[str, list[str]] = {
        "Tactile presses": [_pressed(runs)],
        "Contact area spread rate": [_scored(study)],
        "Tests of areas and rates": [_tested(study.discrimination)],
        "Stiffness calibration": [_calibrated(study, calibration)] if study.profile.new_specimen else [],
    } if runs else {}  # fmt: skip
    software = [f"{listed([f'{name} {version}' for name, version in versions.items()])}."] if versions else []
    add = [_authors_add(study)] if study.recordings and not simulated else []
    every = (people if study.recordings else {}) | rig | {"Software": software, "To be added by the authors": add}
    return [Paragraph(heading, " ".join(texts)) for heading, texts in every.items() if texts]


def filters_as_run(trials: Sequence[Trials]) -> list[str]:
    """What the filters did to these recordings, as their notes say: true edges and delays."""
    return list(dict.fromkeys(note for t in trials for note in t.notes if note.startswith(_FILTER_NOTES)))


def _authors_add(study: Study) -> str:
    """What the study does not know."""
    known = {key for key in ("age", "sex", "handedness") if any(getattr(person, key) for person in study.people)}
    missing = [key for key in ("age", "sex", "handedness") if key not in known]
    return AUTHORS_ADD.format(f"participants' {listed(missing)}; " if missing else "")


def _recording(study: Study, trials: Sequence[Trials], simulated: bool) -> str:
    people, specimens = count(len(study.participants), "participant"), count(len(study.specimens), "specimen")
    muscles = list(dict.fromkeys(muscle for t in trials for muscle in t.muscles))
    emg = f"surface EMG{' of ' + listed(muscles) if muscles else ''}"
    if simulated:
        return f"Recordings of {people} pressing {specimens}, with {emg} and the pressing force, were simulated."
    about = f" ({_about(study.people)})" if study.people else ""
    return f"{people}{about} pressed {specimens} while {emg} and the pressing force were recorded."


_SEX = {"f": "female", "female": "female", "m": "male", "male": "male", "o": "other", "other": "other"}
_HAND = {
    "r": "right",
    "right": "right",
    "l": "left",
    "left": "left",
    "a": "ambidextrous",
    "ambidextrous": "ambidextrous",
}


def _about(people: Sequence[Person]) -> str:
    """Sex, age and handedness as far as the table of participants tells them: "6 female, 8 male; aged 21 to 34 ..."."""
    said = []
    for words, names in (
        ([person.sex for person in people], _SEX),
        ([person.handedness for person in people], _HAND),
    ):
        counts = Counter(names.get(word.lower(), word) or "not stated" for word in words)
        if set(counts) - {"not stated"}:
            said.append(", ".join(f"{n} {kind}" for kind, n in sorted(counts.items())))
    years = [float(person.age.rstrip("+")) for person in people if person.age]
    if years:
        mean, n = sum(years) / len(years), len(years)
        sd = math.sqrt(sum((age - mean) ** 2 for age in years) / (n - 1)) if n > 1 else 0.0
        known = f" ({n} of {len(people)})" if n < len(people) else ""
        said.append(f"aged {min(years):g} to {max(years):g} years, mean {mean:.1f}, SD {sd:.1f}{known}")
    return "; ".join(said)


def _by_recording(study: Study, sentence_of: Callable[[RecordingEntry], str]) -> Iterable[str]:
    """A sentence for all recordings, or one for each group of recordings that have it in common."""
    groups: dict[str, list[str]] = {}
    for entry in study.recordings:
        groups.setdefault(sentence_of(entry), []).append(entry.key)
    for sentence, keys in groups.items():
        whose = listed(keys) if len(keys) <= _FEW else f"{len(keys)} of {len(study.recordings)} recordings"
        yield sentence if len(groups) == 1 else f"In {whose}: {sentence}"


def _filters(f: FilterSettings) -> str:
    if f.envelope == "fir":
        smoother = "FIR filter"
        low_pass = f"FIR low-pass (Hamming, order {f.fir_order}, {f.fir_cutoff_hz:g} Hz)"
        how = f", full-wave rectified and smoothed by an {low_pass}"
    else:
        smoother = "moving window"
        how = f" and smoothed by a moving root mean square over {1e3 * f.rms_window_s:g} ms{RMS_READS_MORE}"
    force = (
        f"force was low-pass filtered (Butterworth, order {f.force_order}, {f.force_cutoff_hz:g} Hz)"
        if f.force_filter
        else "force was not filtered"
    )
    return (
        f"EMG was band-pass filtered (Butterworth, order {f.band_order}, {f.band_hz[0]:g} to {f.band_hz[1]:g} Hz)"
        f"{how}; {force}; {_PHASE[f.phase].format(envelope=smoother)}.{_noise(f)}"
    )


def _noise(f: FilterSettings) -> str:
    hum = " Mains hum and its harmonics, fitted at rest, were subtracted from the EMG." if f.mains == "remove" else ""
    if f.rest_level == "subtract":
        hum += " The lowest level of each envelope at rest was subtracted in power."
    if f.align == "lag":
        hum += " Force was moved by the lag at which it followed the EMG, estimated for each recording, where certain."
    return hum


def _tare(tare: str) -> str:
    return "The force at rest was subtracted." if tare == "rest" else "Force was not tared."


def _cocontraction(c: CocontractionSettings) -> str:
    scale = _NORMALISED[c.normalise]
    if c.index == "falconer-winter" and c.normalise == "none":
        scale = "of envelopes in volts"
    return f"Co-contraction was {_INDEX[c.index]}, {scale}."


def _segmentation(w: WindowSettings) -> str:
    low, high = w.force_n
    return (
        f"A trial is the loading phase from {low:g} to {high:g} N. It was rejected if it did not reach {high:g} N, "
        f"lasted less than {w.min_duration_s:g} s or more than {w.max_duration_s:g} s, if force fell on more than "
        f"{100 * w.max_falling_share:g} % of its path, or if a channel was clipped (more than {100 * w.clip_share:g} % "
        f"of samples), flat or incomplete; it was marked with a warning if, among others, force fell on more than "
        f"{100 * w.warn_falling_share:g} % of its path, EMG was less than {w.min_snr_db:g} dB above rest, or force "
        f"rested more than {w.max_gap_force_n:g} N from zero."
    )


def _fit(f: FitSettings, w: WindowSettings) -> str:
    bins = f.points == "bins"
    points = (
        f"the means over force bins of {f.bin_n:g} N from {w.force_n[0]:g} to {w.force_n[1]:g} N"
        if bins
        else "the samples"
    )
    if f.weights == "inverse-variance":
        over = "number of samples in the bin over the squared fitted level" if bins else "one over the squared level"
        how = f"least squares weighted by inverse variance ({over})"
    else:
        how = "unweighted least squares" if f.robust else "ordinary least squares"
    robust = ", with Huber's weights against outliers [@huber]," if f.robust else ""
    errors = (
        "their standard errors allow for the correlation of neighbouring samples"
        if bins
        else "their standard errors take neighbouring samples as independent, and are therefore too small"
    )
    return (
        f"Each trial was fitted as v = a + b ln F (F in newtons) by {how}{robust} on {points}; intervals of a and b "
        f"are at {100 * f.confidence:g} % (Student's t), and {errors}."
    )


def _tests(study: Study) -> Iterable[str]:
    h = study.hypotheses
    tests = [
        "a one-sample Kolmogorov-Smirnov test of each cluster (participant by specimen), both on values standardised "
        "by the cluster's own mean and SD and on raw values against N(0, 1)"
    ]
    if len(study.participants) > 1:
        tests.append("a one-way ANOVA between participants for each specimen")
    if len(study.specimens) > 1:
        tests.append(f"a one-way ANOVA between specimens for each participant, followed by {_pairs(h)}")
    yield (
        f"The slopes b of the trials judged {h.use.replace('+', ' or ')} were tested at alpha = {h.alpha:g}: "
        f"{'; '.join(tests)}."
    )
    yield from _companions(study)


def _companions(study: Study) -> Iterable[str]:
    """What was run beside the tests of the paper."""
    h, several = study.hypotheses, min(len(study.participants), len(study.specimens)) > 1
    beside = ["Lilliefors' test [@lilliefors] and the Shapiro-Wilk test [@shapiro] of each cluster"]
    if max(len(study.participants), len(study.specimens)) > 1:
        beside.append(
            "Welch's ANOVA [@welch], the Kruskal-Wallis test [@kruskal], the Brown-Forsythe test [@brown] and JZS "
            "Bayes factors [@rouder]"
        )
    if len(study.specimens) > 1:
        beside.append(
            "for the pairs of a participant Holm's correction [@holm], the false discovery rate [@benjamini], Tukey's "
            "HSD, the Games-Howell test [@games], Dunn's test on mean ranks with Bonferroni's correction [@dunn] and "
            "exact Mann-Whitney tests [@mann] with Holm's correction"
        )
    if several:
        beside.append(
            "over participants a linear mixed model (specimen fixed, participant and participant by specimen random; "
            "REML [@patterson] with profile-likelihood intervals of its standard deviations), a repeated-measures "
            "ANOVA of the means with the Greenhouse-Geisser correction [@greenhouse] and Friedman's test [@friedman]"
        )
    if h.equivalence_margin_sd is not None and len(study.participants) > 1:
        beside.append(
            f"two one-sided tests [@schuirmann] of equality of every pair of participants within "
            f"{h.equivalence_margin_sd:g} SD of their repetitions"
        )
    yield f"Companion tests were {'; '.join(beside)}. No test was chosen by the outcome of another."
    yield (
        "Intervals of ω² come from the noncentral F distribution [@steiger]. A trend of b over the repetitions was "
        "tested by Student's t of the participants' slopes. The logarithmic law was compared with a power law and a "
        "straight line by errors of prediction, leaving out one press or one force bin at a time. Claims that rest on "
        "a p were corrected together [@holm]."
    )


def _pairs(h: HypothesisSettings) -> str:
    among = f" among {listed(h.kept_specimens)}" if h.kept_specimens else ""
    return f"Fisher's LSD without correction for the number of pairs, whose largest p{among} is reported"


_WHOSE = {
    None: "all participants",
    MEDOID: "one participant, the medoid: the one whose schedules differ least, on average, from those of the others",
}


def _whose(study: Study, choice: Choice | None) -> str:
    asked = study.profile.participant
    if asked == MEDOID and len(study.participants) == 1:
        return f"the one participant, {study.participants[0]}"
    if asked != MEDOID or choice is None:
        return _WHOSE.get(asked, f"participant {asked}")
    near = int(np.count_nonzero(choice.to_others == choice.to_others.min()))
    tied = f", the first of {near} equally near" if near > 1 else ""
    return f"{_WHOSE[asked]} ({choice.medoid}{tied})"


def _export(study: Study, choice: Choice | None) -> Iterable[str]:
    profile, schedule = study.profile, study.schedule
    whose = _whose(study, choice)
    yield f"A specimen's profile is the mean of the fits of {whose}."
    if profile.new_specimen:
        yield f"The profile of {profile.new_specimen} was interpolated {_INTERPOLATION[profile.interpolation]}."
    low, high = schedule.stiffness_percent
    maximum = "maximum stiffness preset" if schedule.scale == "preset" else "maximum stiffness at zero load"
    yield (
        f"Mean co-contraction in force steps of {schedule.step_n:g} N was mapped linearly on {low:g} to {high:g} % of "
        f"the {maximum} of a {schedule.actuator}, over all exported specimens together."
    )
    if remark := export_of(schedule.actuator).remark:
        yield remark


_FRONT = (
    "that within the contact front in every frame, found by comparing the motion of the pins with that of "
    "finite-element contacts"
)
_AREA = {
    "edge": "the ellipse at the fold of the pins' displacement field",
    "hexagon": "one hexagon for each pin that moved more than {threshold:g} px (Algorithm 1, pins matched one to one)",
    "circle": "the circle through the outermost pin (previous work)",
    "paper": "one hexagon for each pin whose whole-pixel centroid moved more than {threshold:g} px (Algorithm 1, pins "
    "matched one to one)",
}
_FORCE = {"exposure": "the force at their exposure", "mean": "the mean of the forces logged while each was the last"}
_FLOW = {
    "pin-affine": "the affine motion of the pins in contact",
    "horn-schunck": "dense optical flow [@horn]",
    "dis": "dense optical flow [@kroeger]",
}
_GROWTH = {"contact": "its divergence over the contact", "image": "its mean divergence over the whole image"}
_AREA_LAW = {
    "ode": "the exponential of its sum",
    "paper": "equation (1) as printed, which multiplies its sum over the whole press by force",
}
_RATE = {
    "power": "the mean slope of a power law A = k Fᵐ through area and force from {low:g} to {high:g} N",
    "slope": "the slope of the line through area and force",
    "paper": "the sum of the quotients of area and force differences, equation (2) as printed",
}
_LAW = {
    "compliance": "1/κ = a + b CASR^1.5 (sensor and specimen in series, contact after Hertz [@hertz])",
    "exponential": "κ = p exp(q CASR)",
    "power": "κ = p CASR^q",
    "linear-log": "κ = a + b ln CASR",
}

_LEAST = {"casr": "CASR", "kappa": "κ", "ln kappa": "ln κ"}


def _pressed(runs: Sequence[RunScores]) -> str:
    specimens = listed(list(dict.fromkeys(run.specimen for run in runs)))
    angles: dict[str, set[float]] = {}
    for run in runs:
        angles.setdefault(run.condition, set()).add(run.angle_deg)
    alike: dict[str, list[str]] = {}
    for condition, own in angles.items():
        alike.setdefault(listed([f"{angle:g}°" for angle in sorted(own)]), []).append(condition)
    designs = "; ".join(f"{listed(conditions)} at {at}" for at, conditions in alike.items())
    presses = sum(len(run.verdicts) for run in runs)
    rig = "an emulated rig" if any(run.simulated for run in runs) else "a rig"
    return f"{presses} presses on {specimens} were made by {rig}: {designs}."


def _scored(study: Study) -> str:
    start_n, force = study.scoring.force_n[0], _FORCE[study.scoring.recipe.force_rule]
    return f"Frames of the loading phase from {start_n:g} N were scored, with {force}. {_measured(study.scoring)}"


def _measured(settings: RunSettings) -> str:
    recipe = settings.recipe
    low, high = settings.force_n
    rate = _RATE[recipe.rate].format(low=low, high=high)
    if settings.algorithm == "front":
        return f"The area was {_FRONT}; CASR was {rate}."
    return (
        f"The initial area was {_AREA[recipe.area_rule].format(threshold=settings.threshold_px)}; its growth came from "
        f"{_FLOW[recipe.engine]}, as {_GROWTH[recipe.region]}; areas followed from it by {_AREA_LAW[recipe.law]}; CASR "
        f"was {rate}."
    )


def _tested(settings: DiscriminationSettings) -> str:
    return (
        f"Areas and rates were compared between specimens and angles at alpha = {settings.alpha:g} by the "
        "Kruskal-Wallis test [@kruskal] with pairs on mean ranks and Bonferroni's correction [@dunn]. Companion tests "
        "were Welch's ANOVA [@welch], exact Mann-Whitney tests [@mann] with Holm's correction [@holm], Bayes factors "
        f"[@rouder] and equivalence within {100 * settings.equivalence_margin:g} % [@schuirmann]. One model of "
        "ln(area) and one of ln(CASR) with condition, angle and specimen (type II [@yates]) gave partial ω² with "
        "intervals from the noncentral F distribution [@steiger]."
    )


def _calibrated(study: Study, found: CalibrationResults | None) -> str:
    settings = study.calibration
    mounting = _mounting(settings, _laws_of(study, found))
    scores = "mean scores" if settings.points == "means" else "all scores"
    return (
        f"{_left_out(settings)}The stiffness of the new specimen was read off {_LAW[settings.law]}, fitted to {scores} "
        f"of the others at each angle of each condition by least squares of {_LEAST[settings.minimise]}. Its "
        f"{100 * settings.confidence:g} % interval joins the scatter of repeated presses, the standard errors of the "
        f"known stiffnesses{mounting}. Presses that are serially correlated count as fewer, and where the "
        "left-out specimens reject the law its interval is widened until theirs hold. No stiffness is given where CASR "
        "does not follow κ in one direction, and one whose interval is wider than the calibrated range is called not "
        "determined."
    )


def _left_out(settings: CalibrationSettings) -> str:
    if settings.outlier_mads == 0:
        return ""
    return (
        f"A press further than {settings.outlier_mads:g} median absolute deviations, scaled to an SD, from the median "
        "of its specimen was left out of the calibration, where the specimen had five presses or more and no more than "
        f"{MOST_OUTLIERS:.0%} of them lay so far off. "
    )


def _laws_of(study: Study, found: CalibrationResults | None) -> list[LawResult]:
    """By the algorithm and law of the study, of every design."""
    name = study.scoring.algorithm
    return [each.algorithms[name].chosen for each in found.conditions if name in each.algorithms] if found else []


def _mounting(settings: CalibrationSettings, laws: Sequence[LawResult]) -> str:
    """The terms of the interval that presses of one mounting cannot show, or that repeated mountings do."""
    said, shown = [], [100 * law.mounting_sd for law in laws if law.mounting_freedom > 0]
    if shown:
        between = f"{min(shown):.2g}" if min(shown) == max(shown) else f"{min(shown):.2g} to {max(shown):.2g}"
        where = f" in {len(shown)} of {len(laws)} designs" if len(shown) < len(laws) else ""
        said.append(f"the SD of the score between mountings found from repeated ones ({between} %{where})")
    if len(shown) < max(len(laws), 1):
        other = "in the others " if shown else ""
        said.append(f"{other}an assumed SD of {settings.angle_sd_deg:g}° of the angle from mounting to mounting")
        if settings.mounting_sd_percent:
            said.append(f"an assumed SD of {settings.mounting_sd_percent:g} % of the score from mounting to mounting")
    angle = ", ".join(said)
    if settings.law != "compliance":
        return f" and {angle}"
    return f", {angle}, and how far κ moves with the exponent that the contact's growth shows in place of Hertz's 1.5"
