"""The methods paragraph of a paper, written from the settings that ran and nothing else.

The items follow the reporting standards of ISEK (Merletti and Di Torino 1999) and SENIAM; what a study file does not
know (electrodes, amplifier, ethics) is listed for the authors to add, not made up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from emg2vsa.report.wording import count, listed
from emg2vsa.settings import CocontractionSettings, FilterSettings, FitSettings, WindowSettings
from emg2vsa.study import Study
from emg2vsa.trials import Trials

AUTHORS_ADD = (
    "To be added by the authors: electrode type, size, distance and placement; amplifier, its gain, input impedance "
    "and common-mode rejection; resolution of the converter; participants' age, sex and handedness; ethics approval."
)
_FILTER_NOTES = (
    "NYQUIST RULE",
    "EMG band-pass",
    "EMG high-pass",
    "EMG envelope",
    "force low-pass",
    "force: not",
    "delays:",
)
_INDEX = {
    "sum": "the sum of the envelopes",
    "rudolph": "the index of Rudolph et al. (2000)",
    "falconer-winter": "the index of Falconer and Winter (1985)",
    "minimum": "the lowest envelope",
}
_NORMALISED = {
    "none": "not normalised, so that levels compare within a session only",
    "session-max": "normalised to the largest envelope of the session",
    "mvc": "normalised to the maximum voluntary contraction",
}
_INTERPOLATION = {
    "bracket": "linearly in stiffness between its two neighbours",
    "paper": "with weight κ/10 of the softer neighbour",
    "log-stiffness": "linearly in the logarithm of stiffness between its two neighbours",
    "coefficients": "by a monotone cubic (PCHIP) through the coefficients of all exported specimens",
}


def methods_paragraph(study: Study, trials: Sequence[Trials], versions: Mapping[str, str]) -> str:
    """Plain text. ``trials`` supply what was measured of the filters (true edges, delays) as they ran."""
    sentences = [
        *_recording(study, trials),
        *_conditioning(study, trials),
        _cocontraction(study.cocontraction),
        _segmentation(study.window),
        _fit(study.fit, study.window),
        *_tests(study),
        *_export(study),
        f"Software: {listed([f'{name} {version}' for name, version in versions.items()])}." if versions else "",
        AUTHORS_ADD,
    ]
    return " ".join(filter(None, sentences))


def _recording(study: Study, trials: Sequence[Trials]) -> Iterable[str]:
    people, specimens = len(study.participants), len(study.specimens)
    muscles = list(dict.fromkeys(muscle for t in trials for muscle in t.muscles))
    yield (
        f"{count(people, 'participant')} pressed {count(specimens, 'specimen')} while surface EMG"
        f"{' of ' + listed(muscles) if muscles else ''} and the pressing force were recorded."
    )


def _conditioning(study: Study, trials: Sequence[Trials]) -> Iterable[str]:
    settings = list(dict.fromkeys(entry.filters for entry in study.recordings))
    for f in settings:
        yield _filters(f)
    if len(settings) > 1:
        yield "These settings differ between recordings, as listed."
    ran = dict.fromkeys(note for t in trials for note in t.notes if note.startswith(_FILTER_NOTES))
    if ran:
        yield f"As run: {'; '.join(ran)}."


def _filters(f: FilterSettings) -> str:
    if f.envelope == "fir":
        envelope = f"full-wave rectified and smoothed by an FIR low-pass of order {f.fir_order}, {f.fir_cutoff_hz:g} Hz"
    else:
        envelope = f"smoothed by a moving root mean square over {1e3 * f.rms_window_s:g} ms"
    force = (
        f"force was low-pass filtered (Butterworth, order {f.force_order}, {f.force_cutoff_hz:g} Hz)"
        if f.force_filter
        else "force was taken as recorded"
    )
    return (
        f"EMG was band-pass filtered (Butterworth, order {f.band_order}, {f.band_hz[0]:g} to {f.band_hz[1]:g} Hz), "
        f"{envelope}; {force}; phase: {f.phase}."
    )


def _cocontraction(c: CocontractionSettings) -> str:
    return f"Co-contraction was {_INDEX[c.index]}, {_NORMALISED[c.normalise]}."


def _segmentation(w: WindowSettings) -> str:
    low, high = w.force_n
    return (
        f"A trial is the loading phase from {low:g} to {high:g} N; trials shorter than {w.min_duration_s:g} s, longer "
        f"than {w.max_duration_s:g} s, with more than {100 * w.max_falling_share:g} % of the force path falling, or "
        f"with a clipped channel (more than {100 * w.clip_share:g} % of samples) were rejected."
    )


def _fit(f: FitSettings, w: WindowSettings) -> str:
    points = (
        f"the means over force bins of {f.bin_n:g} N from {w.force_n[0]:g} to {w.force_n[1]:g} N"
        if f.points == "bins"
        else "the samples"
    )
    weights = "weighted by the inverse variance (1/v²)" if f.weights == "inverse-variance" else "ordinary"
    robust = " with Huber weights" if f.robust else ""
    return (
        f"Each trial was fitted as v = a + b ln F by {weights} least squares{robust} on {points}, with Student-t "
        f"intervals at {100 * f.confidence:g} %."
    )


def _tests(study: Study) -> Iterable[str]:
    h = study.hypotheses
    kept = f" among {listed(h.kept_specimens)}" if h.kept_specimens else ""
    yield (
        f"On b of the trials with verdict {h.use.replace('+', ' or ')} (alpha = {h.alpha:g}): one-sample "
        "Kolmogorov-Smirnov test of each cluster (participant by specimen), standardised by the cluster's own mean and "
        "SD, and raw against N(0, 1); one-way ANOVA between participants for each specimen; one-way ANOVA between "
        f"specimens for each participant, followed by Fisher's LSD without correction{kept}."
    )


def _export(study: Study) -> Iterable[str]:
    profile, schedule = study.profile, study.schedule
    whose = f"participant {profile.participant}" if profile.participant else "all participants"
    yield f"Profiles are the mean fits of {whose}."
    if profile.new_specimen:
        yield f"The profile of {profile.new_specimen} was interpolated {_INTERPOLATION[profile.interpolation]}."
    low, high = schedule.stiffness_percent
    yield (
        f"Mean co-contraction in force steps of {schedule.step_n:g} N was mapped linearly on {low:g} to {high:g} % of "
        f"the maximum stiffness preset of a {schedule.actuator}, over all exported specimens together."
    )
