"""The rig's part of the methods paragraph, from the settings that ran."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from emg2vsa.report.wording import listed
from emg2vsa.runs import RunScores
from emg2vsa.runs.score_run import score_settings
from emg2vsa.settings import CalibrationSettings, DiscriminationSettings
from emg2vsa.study import Study

_AREA = {
    "edge": "the ellipse at the fold of the pins' displacement field",
    "hexagon": "one hexagon for each pin that moved more than {threshold:g} px (Algorithm 1, pins matched one to one)",
    "circle": "the circle through the outermost pin (previous work)",
    "paper": "Algorithm 1 to the letter, all pairs of pins",
}
_RATE = {
    "power": "the mean slope of a power law A = k Fᵐ through area and force from {low:g} to {high:g} N",
    "slope": "the slope of the line through area and force",
    "paper": "the sum of the quotients of area and force differences, equation (2) as printed",
}
_LAW = {
    "compliance": "1/κ = a + b CASR^1.5 (sensor and specimen in series, Hertz)",
    "exponential": "κ = p exp(q CASR)",
    "power": "κ = p CASR^q",
    "linear-log": "κ = a + b ln CASR",
}

_LEAST = {"casr": "CASR", "kappa": "κ", "ln kappa": "ln κ"}


def runs_methods(study: Study, runs: Sequence[RunScores]) -> Iterable[str]:
    """Sentences on runs, scores, tests and calibration; none for a study without runs."""
    if not runs:
        return
    yield _pressed(runs)
    yield _scored(study)
    yield _tested(study.discrimination)
    if study.profile.new_specimen:
        yield _calibrated(study.calibration)


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
    how = score_settings(study.scoring)
    low, high = study.scoring.force_n
    area = _AREA[study.scoring.algorithm].format(threshold=study.scoring.threshold_px)
    rate = _RATE["paper" if study.scoring.algorithm == "paper" else how.rate_rule].format(low=low, high=high)
    return (
        f"Frames of the loading phase from {low:g} N were scored, with the force at their exposure. The initial area "
        f"was {area}; its growth came from the affine motion of the pins in contact; CASR was {rate}."
    )


def _tested(settings: DiscriminationSettings) -> str:
    return (
        f"Areas and rates were compared between specimens and angles at alpha = {settings.alpha:g} by Kruskal and "
        "Wallis' test with pairs on mean ranks and Bonferroni's correction, beside Welch's ANOVA, exact Mann-Whitney "
        f"tests with Holm's correction, Bayes factors and equivalence within {100 * settings.equivalence_margin:g} %."
    )


def _calibrated(settings: CalibrationSettings) -> str:
    scores = "mean scores" if settings.points == "means" else "all scores"
    return (
        f"{_left_out(settings)}The stiffness of the new specimen was read off {_LAW[settings.law]}, fitted to {scores} "
        f"of the others at each angle of each condition by least squares of {_LEAST[settings.minimise]}. Its "
        f"{100 * settings.confidence:g} % interval joins the scatter of repeated presses, the standard errors of the "
        f"known stiffnesses{_mounting(settings)}."
    )


def _left_out(settings: CalibrationSettings) -> str:
    if settings.outlier_mads == 0:
        return ""
    return (
        f"A press further than {settings.outlier_mads:g} median absolute deviations, scaled to an SD, from the median "
        "of its specimen was left out of the calibration, where the specimen had five presses or more. "
    )


def _mounting(settings: CalibrationSettings) -> str:
    """The terms of the interval that presses of one mounting cannot show."""
    angle = f"an SD of {settings.angle_sd_deg:g}° of the angle from mounting to mounting"
    if settings.law != "compliance":
        return f" and {angle}"
    return f", {angle}, and how far κ moves with the exponent that the contact's growth shows in place of Hertz's 1.5"
