"""Methods as a journal prints them, from the settings that ran; ``[@key]`` cites a work of ``references``.

The items follow the reporting standards of ISEK (Merletti and Di Torino 1999) and SENIAM. What nothing tells is listed
for the authors to add, not made up: ``facts``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from functools import cache

import numpy as np
from jinja2 import Environment, StrictUndefined, Template

from casr.kappa.discrepancy import Discrepancy
from casr.kappa.posterior import DETERMINED
from emg2vsa.calibration.presses import MOST_OUTLIERS
from emg2vsa.calibration.results import LawResult
from emg2vsa.claims.claim import OF_A_STUDY, confidence_of
from emg2vsa.companions.law_misfit import MATTERS
from emg2vsa.devices.joints import export_of
from emg2vsa.exemplary import Choice
from emg2vsa.fits import CERTAIN, WIDE, Fits, usable
from emg2vsa.report.facts import by_hand, facts_of
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.people import about_people
from emg2vsa.report.wording import count, listed, unwrapped
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import MEDOID, CalibrationSettings
from emg2vsa.statistics.whole_curve import DRAWS
from emg2vsa.study import RecordingEntry, Study

_CHOICES: dict[str, dict[str, str]] = {}
for _line in unwrapped("""
phase, zero-phase: The Butterworth filters were run forward and backward and the {envelope} was centred, so that
  nothing is delayed (zero phase)
phase, compensated: All filters were causal, and the difference of their known delays was removed when EMG and force
  were paired
phase, causal: All filters were causal, as on line, and their delays were left in
index, sum: the sum of the envelopes
index, rudolph: the index (lower / higher envelope) × their sum [@rudolph]
index, falconer-winter: twice the lower envelope over the sum of both [@falconer]
index, minimum: the lowest envelope at each instant
normalise, none: in volts and not normalised, so that levels compare within a session only
normalise, session-max: each envelope first divided by the muscle's largest in the trials of the session that were not
  rejected
normalise, mvc: each envelope first divided by the muscle's level at maximum voluntary contraction (the largest mean
  over 0.5 s, where that was recorded)
interpolation, bracket: linearly in stiffness between its two neighbours
interpolation, paper: between its two neighbours in stiffness, with the new stiffness over 10 N/mm as the weight of
  the softer
interpolation, log-stiffness: linearly in the logarithm of stiffness between its two neighbours
interpolation, coefficients: by monotone cubics in stiffness through a and b of all exported specimens [@fritsch]
area_rule, edge: the ellipse at the fold of the pins' displacement field
area_rule, hexagon: one hexagon for each pin that moved more than {threshold:g} px (Algorithm 1, pins matched one to
  one)
area_rule, circle: the circle through the outermost pin (previous work)
area_rule, paper: one hexagon for each pin whose whole-pixel centroid moved more than {threshold:g} px (Algorithm 1,
  pins matched one to one)
force_rule, exposure: the force at their exposure
force_rule, mean: the mean of the forces logged while each was the last
engine, pin-affine: the affine motion of the pins in contact
engine, horn-schunck: dense optical flow [@horn]
engine, dis: dense optical flow [@kroeger]
region, contact: its divergence over the contact
region, image: its mean divergence over the whole image
area_law, ode: the exponential of its sum
area_law, paper: equation (1) as printed, which multiplies its sum over the whole press by force
rate, power: the mean slope of a power law that bends, A = k F^(m + c ln F), from {low:g} to {high:g} N
rate, slope: the slope of the line through area and force
rate, paper: the sum of the quotients of area and force differences, equation (2) as printed
law, compliance: 1/κ = a + b CASR^1.5 (sensor and specimen in series, contact after Hertz [@hertz])
law, exponential: κ = p exp(q CASR)
law, power: κ = p CASR^q
law, linear-log: κ = a + b ln CASR
minimise, casr: CASR
minimise, kappa: κ
minimise, ln kappa: ln κ
"""):
    (_setting, _value), _said = _line.partition(": ")[0].split(", "), _line.partition(": ")[2]
    _CHOICES.setdefault(_setting, {})[_value] = _said
"""What a setting says, by its value."""

_CONDITIONS = {
    "high-stiffness": "a rigid motor pressed",
    "modular": "stiffness followed the schedule over force",
    "constant-min": "stiffness stayed at the lowest of the schedule",
    "constant-mean": "stiffness stayed at the mean of the schedule over force",
    "constant-max": "stiffness stayed at the highest of the schedule",
}

_TEMPLATE = """
# Specimens
{{ said.specimens }}
{% if study.recordings %}
# Participants and recordings
{% set people, specimens = study.participants | counted("participant"), study.specimens | counted("specimen") %}
{% if simulated %}Recordings of {{ people }} pressing {{ specimens }}, with {{ emg }} and the pressing force, were
simulated.{% else %}{{ people }}{% if about %} ({{ about }}){% endif %} pressed {{ specimens }} while {{ emg }} and
the pressing force were recorded.{% endif %} {{ said.people }}
# Signal processing
{% macro filters(entry) %}
{% set f, fir = entry.filters, entry.filters.envelope == "fir" %}
EMG was band-pass filtered (Butterworth, order {{ f.band_order }}, {{ f.band_hz[0] | g }} to {{ f.band_hz[1] | g }}
Hz) {%- if fir %}, full-wave rectified and smoothed by an FIR low-pass (Hamming, order {{ f.fir_order }},
{{ f.fir_cutoff_hz | g }} Hz).{% else %} and smoothed by a moving root mean square over
{{ (1000 * f.rms_window_s) | g }} ms (which reads 25 % more than a rectified mean of the same Gaussian signal, in a
and b alike).{% endif %} {% if f.force_filter %}Force was low-pass filtered (Butterworth, order {{ f.force_order }},
{{ f.force_cutoff_hz | g }} Hz).{% else %}Force was not filtered.{% endif %}
{{ choices.phase[f.phase].format(envelope="FIR filter" if fir else "moving window") }}.
{% if f.mains == "remove" %}Mains hum and its harmonics, fitted at rest, were subtracted from the EMG.{% endif %}
{% if f.rest_level == "subtract" %}The lowest level of each envelope at rest was subtracted in power.{% endif %}
{% if f.align == "lag" %}Force was moved by the lag at which it followed the EMG, estimated for each recording, where
certain.{% endif %}
{% endmacro %}
{% macro tare(entry) %}
{{ "The force at rest was subtracted." if entry.channels.force.tare == "rest" else "Force was not tared." }}
{% endmacro %}
{% set c = study.cocontraction %}
{{ by_recording(filters) }} {{ by_recording(tare) }} Co-contraction was {{ choices.index[c.index] }},
{% if c.index == "falconer-winter" and c.normalise == "none" -%} of envelopes in
volts.{% else %}{{ choices.normalise[c.normalise] }}.{% endif %}
# Presses and fits
{% macro segmentation(entry) %}
{% set w, high = entry.window, entry.window.force_n[1] | g %}
A trial is the loading phase of a press, from {{ w.force_n[0] | g }} to {{ high }} N. A trial was rejected if it did
not reach {{ high }} N, if it lasted less than {{ w.min_duration_s | g }} s or more than {{ w.max_duration_s | g }} s,
if force fell on more than {{ (100 * w.max_falling_share) | g }} % of its path, or if a channel was clipped (more than
{{ (100 * w.clip_share) | g }} % of the samples), flat, as silent as at rest or incomplete. A trial at the edge of a
record was rejected if its record began more than {{ w.max_missed_n | g }} N above {{ w.force_n[0] | g }} N.
{% if w.implausible == "reject" %}Trials were rejected too if a signal cannot be right: its unit, its rectification or
its zero.{% endif %} Moments in which an electrode moved were left out (power below 25 Hz, more than 14 times its usual
share), and so were bursts, and EMG that was held or missing for 10 ms or more; spikes and shorter gaps were bridged.
{% endmacro %}
{% set f, w, bins = study.fit, study.window, study.fit.points == "bins" %}
{{ by_recording(segmentation) }} Each trial was fitted as v = a + b ln F (F in newtons) by
{% if f.weights == "inverse-variance" %} least squares weighted by inverse variance
({{ "number of samples in the bin over the squared fitted level" if bins else "one over the squared level" }})
{%- else %}{{ "unweighted" if f.robust else "ordinary" }} least squares{% endif %}
{%- if f.robust %}, with Huber's weights against outliers [@huber],{% endif %} on {% if bins %}the means over force
bins of {{ f.bin_n | g }} N from {{ w.force_n[0] | g }} to {{ w.force_n[1] | g }} N{% else %}the samples{% endif %}.
Each trial has a budget of bias: by how much rest level, hum, movement, crosstalk, lag, clocks and drift of the level
change b, with standard errors.{% if f.max_bias %} A trial was doubtful
{{- "" if "doubtful" in study.hypotheses.use else " and entered no test" }} if the bias that is left and its error
exceed {{ (100 * f.max_bias) | g }} % of b or the half-width of its interval.{% endif %} Recordings that are unlike the
others of the study, in gain, band, clock or unit, were doubtful too; copies were left out.
Intervals of a and b are at {{ (100 * f.confidence) | g }} % (Student's t); that of b holds the bias that is left.
{% if bins %}Their standard errors allow for the correlation of neighbouring samples. Where the trials of a recording
agree on a curve other than the logarithm, b is the slope of the best line over the forces, and its error that of
noise about the curve.{% else %}Their standard errors
take neighbouring samples as independent, and are therefore too small.{% endif %}
{% set wide = "more than " ~ (WIDE | g) ~ " of the mean fitted level" %}
{% if f.min_adj_r2 > -1 or f.max_b_error or f.max_b_error_ratio %}Let e be the half-width of the interval of b. A
fitted trial was rejected {% if f.min_adj_r2 > -1 %}if its adjusted R² on force bins was less than
{{ f.min_adj_r2 | g }} and e was {{ wide }}{{ "; " if f.max_b_error or f.max_b_error_ratio }}{% endif %}
{% if f.max_b_error_ratio %}if e was more than {{ f.max_b_error_ratio | g }} times the median of its recording and more
than {{ (100 * CERTAIN) | g }} % of b{{ "; " if f.max_b_error }}{% endif %}
{% if f.max_b_error %}if e was more than {{ f.max_b_error | g }} times b and {{ wide }}{% endif %}.{% endif %}
{{ by_hand }}
# Statistical analysis
{% set h, many_people, many_specimens = study.hypotheses, study.participants[1:], study.specimens[1:] %}
The slopes b of the trials judged {{ h.use.replace("+", " or ") }}{{ tested }} were tested at α = {{ h.alpha | g }}.
A one-sample Kolmogorov-Smirnov test examined each cluster (participant by specimen), both on values standardised by
the cluster's own mean and SD and on raw values against N(0, 1). {% if many_people %}A one-way ANOVA compared
participants on each specimen.{% endif %}
{% if many_specimens %}A one-way ANOVA compared specimens for each participant; Fisher's LSD
without correction for the number of pairs followed, and its largest p{% if h.kept_specimens %} among
{{ h.kept_specimens | listed }}{% endif %} is reported.{% endif %} Companion tests of each cluster were Lilliefors'
test [@lilliefors] and the Shapiro-Wilk test [@shapiro]. {% if many_people or many_specimens %}Companions of the ANOVA
were Welch's ANOVA [@welch], the Kruskal-Wallis test [@kruskal], the Brown-Forsythe test [@brown] and JZS Bayes
factors [@rouder].{% endif %} {% if many_specimens %}Companions of the pairs were Holm's correction [@holm], the false
discovery rate [@benjamini], Tukey's HSD, the Games-Howell test [@games], Dunn's test on mean ranks with Bonferroni's
correction [@dunn] and exact Mann-Whitney tests [@mann] with Holm's correction.{% endif %}
{% if many_people and many_specimens %}Over participants, the means were compared by a repeated-measures ANOVA with
the Greenhouse-Geisser correction [@greenhouse], by a linear mixed model (specimen fixed, participant and participant
by specimen random; REML [@patterson] with profile-likelihood intervals of its standard deviations) and by Friedman's
test [@friedman]. The mean over the presses of a person has an interval whose variance is moderated over all recordings
[@smyth] and holds the correlation of successive presses. Whole curves of co-contraction against force were compared
between specimens by rotation tests over participants [@langsrud] with {{ DRAWS }} draws: the largest statistic of all
forces and pairs gave the threshold, and neighbouring forces beyond the threshold form a cluster, as in statistical
parametric mapping [@pataky].{% endif %}
{% if study.visits %}The presses of a person at all {{ study.visits | length }} visits were pooled: each visit's mean
of a person on a specimen was replaced by the mean over the visits, so that scatter and trend of presses are those
within visits; differences between visits are in table visits. Presses of a visit that lacked a specimen which the
person pressed at another visit were doubtful.{% endif %}
{% if h.equivalence_margin_sd is not none and many_people %}Two one-sided tests [@schuirmann] examined whether each
pair of participants is equal within {{ h.equivalence_margin_sd | g }} SD of their repetitions.{% endif %} No test was
chosen by the outcome of another. Intervals of ω² come from the noncentral F distribution [@steiger]. A trend of b
over the repetitions was tested by Student's t of the participants' slopes. The logarithmic law was compared with a
power law and a straight line by errors of prediction, leaving out one press or one force bin at a time. Whether each
of the three fits was tested over presses by Hotelling's T² [@hotelling] of the three smoothest shapes over ln F that
the law cannot take; a law does not fit where the interval of the root mean square distance lies above
{{ (100 * MATTERS) | g }} % of the level.
{% if many_people and many_specimens %}Where the order of specimens differed between participants, a linear drift of b
over the session was taken out of the comparisons of specimens. Elsewhere the trend within recordings widened the
intervals of these comparisons.{% endif %}
{% if exported %}
# Stiffness schedules
{% set profile, schedule = study.profile, study.schedule %}
A specimen's profile is the mean of the fits of {{ whose }}. {% if profile.curve == "spline" %}Profiles and schedules
follow monotone cubic splines [@ramsay] in ln F through the force bins, in place of these fits.{% endif %}
{% if profile.new_specimen %}The profile of {{ profile.new_specimen }} was interpolated
{{ choices.interpolation[profile.interpolation] }}.{% endif %} Mean
co-contraction in force steps of {{ schedule.step_n | g }} N was mapped linearly on
{{ schedule.stiffness_percent[0] | g }} to {{ schedule.stiffness_percent[1] | g }} % of the maximum stiffness
{{ "preset" if schedule.scale == "preset" else "at zero load" }} of a {{ schedule.actuator }}, over all exported
specimens together. {{ export_of(schedule.actuator).remark }} The schedules move the probe by
{{ schedule.gear_mm_per_degree | g }} mm for each degree of the output shaft.
{% endif %}
{% endif %}
{% if runs %}
{% set s, recipe, k = study.scoring, study.scoring.recipe, study.calibration %}
# Tactile presses
{{ "An emulated rig" if emulated else "A rig" }} made {{ presses }} presses on {{ pressed | listed }}: {{ designs }}.
{{ conditions }}
{{ said.rig }}
# Contact area spread rate
Frames of the loading phase from {{ s.force_n[0] | g }} N were scored, with
{{ choices.force_rule[recipe.force_rule] }}. {% if s.algorithm == "front" %}The area was the area within the contact
front in every frame; the front was found by comparing the motion of the pins with the motion in finite-element
contacts.{% else %}The initial area was {{ choices.area_rule[recipe.area_rule].format(threshold=s.threshold_px) }}.
Its growth came from {{ choices.engine[recipe.engine] }}, as {{ choices.region[recipe.region] }}. Later areas followed
by {{ choices.area_law[recipe.law] }}.{% endif %} CASR was {{ rate }}. {% if others %}For comparison, the same frames
were also scored by {{ others | listed }}.{% endif %}
# Tests of areas and rates
Specimens, angles and conditions were compared by the logarithms of areas and rates, averaged within each mounting.
The error of a difference is the scatter between mountings, pooled over the cells of the designs compared
{%- if once %} (taken as {{ k.mounting_sd_percent | g }} %, as specimens were mounted once){% else %}, with the pooled
degrees of freedom, or with those of Welch and Satterthwaite where a cell scatters more than the others (F test at
1 %), where cells differ in their number of mountings, or where a mounting has less than half the presses of
another{% endif %}. The distance
of two specimens is that difference over the SD of presses within mountings. Intervals of differences of distances
recover the variance at each end of both intervals [@zou]. The paper's tests by presses stand beside them:
Kruskal-Wallis [@kruskal] and pairs on mean ranks with Bonferroni's correction [@dunn]. {% if not once %}One model of
ln(area) and one of ln(CASR) with condition, angle and specimen (type II [@yates]) gave partial ω² with intervals from
the noncentral F distribution [@steiger].{% endif %}
{% if study.profile.new_specimen %}
# Stiffness calibration
{% if by_pins %}The stiffness κ of the new specimen was estimated from the places of the pins and the forces in all
presses of an angle and condition at once. Tabulated finite-element contacts of layered domes on specimens of known
stiffness, with and without friction, were interpolated by cubic splines; one dome, pin length, depth and pole were
shared by all presses, κ by those of a specimen, and friction, place and contact radii were free in each. What the
labels of this sensor differ by from the truth was a line, which the other specimens told, and a smooth Gaussian curve
[@kennedy]; mountings, forces and depths scatter by stated sizes, κ by
{{ kappa_scatter | round(1) | g }} % from mounting to mounting. The interval is of {{ (100 * k.confidence) | g }} % and
total, and wider by how far these statements contradict each other. κ is called determined where the design promises a
half width of {{ (100 * DETERMINED) | g }} % or less. Beside it, κ was read off CASR.{% endif %}
{% if k.outlier_mads %}A press further than {{ k.outlier_mads | g }} median absolute deviations, scaled to an SD, from
the median of its specimen was left out of the calibration, where the specimen had five presses or more and no more
than {{ (100 * MOST_OUTLIERS) | g }} % of them lay so far off.{% endif %}
{{ "By CASR, the" if by_pins else "The" }} stiffness of the new specimen was read off {{ choices.law[k.law] }}. This
law was fitted to {{ "mean scores" if k.points == "means" else "all scores" }} of the other specimens at each angle
under each condition by least squares of {{ choices.minimise[k.minimise] }}. Its {{ (100 * k.confidence) | g }} %
interval joins the scatter of repeated presses, the standard errors of the known stiffnesses{% if k.law ==
"compliance" %}, {{ mounting }}, and how far κ moves with the exponent that the contact's growth shows in place of
Hertz's 1.5{% else %} and {{ mounting }}{% endif %}. Presses that are serially correlated count as fewer. Where the
left-out specimens reject the law, the interval was widened until theirs hold. The interval also holds the κ of every
other law that the specimens do not reject. No stiffness is given where CASR does not follow κ in one direction. κ by
CASR is called determined where presses and mountings promise an interval narrower than the calibrated range, by a law
that falls and has an adjusted R² of 0 or more.
{% endif %}
{% endif %}
# Verdicts on claims
{% set m = study.claims %}
A claim that one value is larger holds where the interval of the difference lies above 0, and is refuted where it lies
below the smallest difference that matters. A claim that a size stays within a margin holds where its interval lies
below the margin, and is refuted where it lies above it. Intervals of {{ level }} % give any false verdict among
{{ OF_A_STUDY }} claims a chance of {{ m.false_verdict_percent | g }} % at most (Bonferroni).
{% if paths %}Every claim was judged again along {{ paths }} other paths of analysis, which differ from this one in
{{ kinds | listed }}.{% endif %}
{% if study.recordings %}Intervals on people are over participants. What matters is {{ m.slope_percent | g }} % of the
mean for b between specimens, {{ m.people_f | g }} SD of presses for b between people, {{ m.cluster_shape | g }} for the
skewness and half of the excess kurtosis of clusters, {{ m.law_percent | g }} % of the error of prediction for the law
of force, and {{ m.profile_percent | g }} % of the level with {{ m.neighbour_percent | g }} % of the difference of the
neighbours for the interpolated profile.{% endif %}
{% if runs %}Intervals on presses of the rig are over mountings. What matters is {{ m.area_percent | g }} % of an area,
{{ m.casr_percent | g }} % of CASR, {{ m.contrast_percent | g }} % of a ratio of CASR, {{ m.separation | g }} SD of a
press for a distance of specimens, {{ m.kappa_error_percent | g }} % for an error of κ and
{{ m.reduction_points | g }} percentage points for a cut of that error.{% endif %}
# Registration
{{ said.plan }}
{% if versions %}
# Software
The analysis ran with {{ versions | listed }}.
{% endif %}
{% if missing %}
# To be added by the authors
These facts stand in no file of the study: {{ missing | join("; ") }}.
{% endif %}
"""


@cache
def _template() -> Template:
    plain = Environment(undefined=StrictUndefined)
    plain.filters |= {"g": "{:g}".format, "listed": listed, "counted": lambda all_of, noun: count(len(all_of), noun)}
    plain.globals |= {
        "choices": _CHOICES,
        "export_of": export_of,
        "DRAWS": DRAWS,
        "MATTERS": MATTERS,
        "MOST_OUTLIERS": MOST_OUTLIERS,
        "DETERMINED": DETERMINED,
    }
    plain.globals |= {"WIDE": WIDE, "CERTAIN": CERTAIN, "OF_A_STUDY": OF_A_STUDY}
    return plain.from_string(_TEMPLATE)


def methods(results: StudyResults) -> list[tuple[str, str]]:
    """Heading and text of each paragraph, with citations as ``[@key]``.

    Of a study without recordings, nothing is said of people, and of one without runs nothing of the rig.
    """
    study, people, runs = results.study, results.people, results.runs.scores if results.runs else ()
    trials, choice = (people.trials, people.choice) if people else ((), None)
    exported = people is None or people.profiles is not None
    said, missing = facts_of(results)
    muscles = list(dict.fromkeys(muscle for t in trials for muscle in t.muscles))
    (low, high), algorithm = study.scoring.force_n, study.scoring.algorithm
    calibration = results.runs.calibration if results.runs else None
    by_algorithm = [each.algorithms for each in calibration.conditions] if calibration else []
    text = _template().render(
        study=study,
        simulated=people is not None and people.truth is not None,
        runs=runs,
        exported=exported,
        said=said,
        missing=missing,
        emg=f"surface EMG{' of ' + listed(muscles) if muscles else ''}",
        about=about_people(study.people),
        by_recording=lambda sentence_of: _by_recording(study, sentence_of),
        whose=_whose(study, choice) if exported and study.recordings else "",
        presses=sum(len(run.verdicts) for run in runs),
        pressed=list(dict.fromkeys(run.specimen for run in runs)),
        emulated=any(run.simulated for run in runs),
        once=all(run.mounting.max(initial=1) == 1 for run in runs),
        designs=_designs(runs),
        by_hand=by_hand(study),
        others=list(dict.fromkeys(name for of in by_algorithm for name in of if name != algorithm)),
        paths=results.paths.name.size if results.paths else 0,
        kinds=results.paths.shares()[0] if results.paths else (),
        conditions=_conditions(runs),
        tested=_tested(people.fits, study) if people else "",
        level=f"{100 * confidence_of((), study.claims.false_verdict_percent / 100, OF_A_STUDY):.4g}",
        rate=_CHOICES["rate"][study.scoring.recipe.rate].format(low=low, high=high),
        kappa_scatter=100 * Discrepancy().mounted(study.calibration.mounting_sd_percent / 100).stiffness,
        by_pins=any(each.pins for each in calibration.conditions) if calibration else False,
        mounting=_mounting(study.calibration, [of[algorithm].chosen for of in by_algorithm if algorithm in of]),
        versions=[f"{name} {version}" for name, version in results.provenance.items() if " of " not in name],
    )
    parts = [part.partition("\n") for part in re.split(r"^# ", text, flags=re.M)[1:]]
    return [(heading, told) for heading, _, body in parts if (told := _one_line(body))]


def _one_line(text: str) -> str:
    return re.sub(r"[ \n]+", " ", text).strip()


def _by_recording(study: Study, sentence_of: Callable[[RecordingEntry], str]) -> str:
    """A sentence for all recordings, or one for each group of recordings that have it in common."""
    groups: dict[str, list[str]] = {}
    for entry in study.recordings:
        groups.setdefault(_one_line(sentence_of(entry)), []).append(entry.key)
    if len(groups) == 1:
        return next(iter(groups))
    all_of = f" of {len(study.recordings)} recordings"
    whose = {text: listed(keys) if len(keys) <= 3 else f"{len(keys)}{all_of}" for text, keys in groups.items()}
    return " ".join(f"In {whose[text]}: {text}" for text in groups)


def _whose(study: Study, choice: Choice | None) -> str:
    asked = study.profile.participant
    if asked != MEDOID:
        return "all participants" if asked is None else f"participant {asked}"
    if len(study.participants) == 1:
        return f"the one participant, {study.participants[0]}"
    medoid = "one participant, the medoid: the one whose schedules differ least, on average, from those of the others"
    if choice is None:
        return medoid
    near = int(np.count_nonzero(choice.to_others == choice.to_others.min()))
    tied = f", the first of {near} equally near" if near > 1 else ""
    return f"{medoid} ({choice.medoid}{tied})"


def _tested(fits: Fits, study: Study) -> str:
    used = usable(fits, study.hypotheses.use)
    people = count(len(set(fits.participant[used].tolist())), "participant")
    return f" ({np.count_nonzero(used)} of {used.size}, of {people})" if used.size else ""


def _conditions(runs: Sequence[RunScores]) -> str:
    there = {run.condition: _CONDITIONS[run.condition] for run in runs if run.condition in _CONDITIONS}
    return " ".join(f"Under {condition}, {said}." for condition, said in there.items())


def _designs(runs: Sequence[RunScores]) -> str:
    """``modular at 0° and 30°; ...``: conditions of the same angles together."""
    alike: dict[str, list[str]] = {}
    for condition in dict.fromkeys(run.condition for run in runs):
        own = sorted({run.angle_deg for run in runs if run.condition == condition})
        alike.setdefault(listed([f"{angle:g}°" for angle in own]), []).append(condition)
    return "; ".join(f"{listed(conditions)} at {at}" for at, conditions in alike.items())


def _mounting(settings: CalibrationSettings, laws: Sequence[LawResult]) -> str:
    """The terms of the interval that presses of one mounting cannot show, or that repeated mountings do."""
    said, shown = [], [100 * law.mounting_sd for law in laws if law.mounting_freedom > 0]
    if shown:
        between = f"{min(shown):.2g}" if min(shown) == max(shown) else f"{min(shown):.2g} to {max(shown):.2g}"
        where = f" in {len(shown)} of {len(laws)} designs" if len(shown) < len(laws) else ""
        said.append(f"the SD of the score between mountings that those of all designs show ({between} %{where})")
    if len(shown) < max(len(laws), 1):
        other = "in the others " if shown else ""
        said.append(f"{other}an assumed SD of {settings.angle_sd_deg:g}° of the angle from mounting to mounting")
        if settings.mounting_sd_percent:
            said.append(f"an assumed SD of {settings.mounting_sd_percent:g} % of the score from mounting to mounting")
    return ", ".join(said)
