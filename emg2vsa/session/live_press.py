"""Judging a press on its execution, by the functions of ``emg2vsa check`` and by what only a live session knows.

Never by b, by how well the fit explains the press, or by normality: a press that is done again because of its outcome
would bias the study.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from emg2vsa.arrays import bridge_gaps
from emg2vsa.errors import Emg2vsaError
from emg2vsa.extraction import Trials
from emg2vsa.extraction.extract import extract_trials
from emg2vsa.extraction.remedies import remedies_of
from emg2vsa.fits import Fits, fit_trials
from emg2vsa.recordings import Channel
from emg2vsa.session.journal import Judged, PressEnded, Verdict
from emg2vsa.session.press_cycle import Attempt
from emg2vsa.session.quality import FLAT_V, HUM_V
from emg2vsa.session_settings import SessionSettings
from emg2vsa.settings import CocontractionSettings, FilterSettings, FitSettings, ForceChannelSettings, WindowSettings
from emg2vsa.signals.quality import mains_ratios

MARGIN_S = 0.5
"A press that the filters find belongs to an attempt whose time it touches within this."

Problem = tuple[str, str]
"""What was found, and what to do."""

HUM_SHARE = 0.5
"An electrode that is off has more than this share of its power at the mains."


@dataclass(frozen=True)
class HowJudged:
    """The settings of the study by which ``emg2vsa check`` will judge these presses."""

    filters: FilterSettings
    window: WindowSettings
    force_channel: ForceChannelSettings
    fit: FitSettings


@dataclass(frozen=True)
class FoundPress:
    """A press as ``extract_trials`` found it; times in seconds on the session's clock.

    a_v, b_v : of its fit, NaN where there is none. fitted : the fit is one that ``check`` would use. loose : muscles
    whose electrode is off.
    """

    start_s: float
    stop_s: float
    verdict: str
    reasons: str
    peak_n: float
    a_v: float
    b_v: float
    fitted: bool
    loose: tuple[str, ...] = ()


@dataclass(frozen=True)
class StayJudged:
    """The presses of one stay at a specimen, so far. remarks : on the recording as a whole. failed : why none."""

    presses: tuple[FoundPress, ...] = ()
    remarks: tuple[Problem, ...] = ()
    failed: str = ""


def judge_stay(
    emg: Mapping[str, Channel], force: Channel, participant: str, specimen: str, how: HowJudged
) -> StayJudged:
    """Presses of a stay so far, judged as ``emg2vsa check`` will judge its recording.

    emg : volts by muscle; force : newtons, pressing positive; ``start_s`` of each on the session's clock.
    """
    try:
        trials = extract_trials(
            emg, force, participant=participant, specimen=specimen, filters=how.filters,
            cocontraction=CocontractionSettings(), window=how.window, force_channel=how.force_channel,
        )  # fmt: skip
        fits = fit_trials(trials, how.fit, how.window)
    except Emg2vsaError as error:
        return StayJudged(failed=str(error))
    usable = np.isfinite(fits.b_v) & (fits.verdict != "rejected")
    lost = (fits.cause == "lost samples") & (fits.verdict == "rejected")
    verdicts = np.where(lost, "rejected", trials.verdict)
    presses = tuple(
        FoundPress(*row)
        for row in zip(
            trials.start_s.tolist(), trials.stop_s.tolist(), verdicts.tolist(), _told(trials, fits, lost),
            trials.peak_force_n.tolist(), fits.a_v.tolist(), fits.b_v.tolist(), usable.tolist(),
            (_loose(emg, *span) for span in zip(trials.start_s.tolist(), trials.stop_s.tolist(), strict=True)),
            strict=True,
        )
    )  # fmt: skip
    remarks = [pair for remark in trials.remarks for pair in remedies_of(remark)]
    return StayJudged(presses, tuple(remarks))


def _told(trials: Trials, fits: Fits, lost: NDArray[np.bool_]) -> list[str]:
    """Reasons of each press; of a doubtful one, and of one that misses too many samples, also why it is."""
    doubtful = (fits.verdict == "doubtful") | lost
    return [fits.reason[i] if doubtful[i] else reason for i, reason in enumerate(trials.reasons)]


def _loose(emg: Mapping[str, Channel], start_s: float, stop_s: float) -> tuple[str, ...]:
    """Muscles whose channel holds nothing but hum, or nothing at all, between two times."""
    found = []
    for muscle, channel in emg.items():
        at = (round((time_s - channel.start_s) * channel.fs_hz) for time_s in (start_s, stop_s))
        samples = channel.samples[slice(*at)]
        if 2 * np.count_nonzero(np.isfinite(samples)) <= samples.size:
            continue  # lost, which is said
        samples = bridge_gaps(samples, muscle)[0]
        rms_v = float(np.std(samples))
        (mains,) = mains_ratios([samples], channel.fs_hz).tolist()
        if rms_v < FLAT_V or (mains > HUM_SHARE and rms_v * np.sqrt(mains) > HUM_V):
            found.append(muscle)
    return tuple(found)


def judge_attempt(
    ended: PressEnded,
    attempt: Attempt,
    stay: StayJudged,
    settings: SessionSettings,
    window: WindowSettings,
    samples: Mapping[str, tuple[int, int]],
) -> Judged:
    """The worse of what ``check`` says and what the session knows, as a line of the journal; rejecting problems first.

    samples : as of `emg2vsa.session.journal.Judged`.
    """
    found = press_of(attempt, stay.presses)
    load_s = None if found is None else found.stop_s - found.start_s
    live = [*_of_cycle(attempt, settings), *_of_speed(found, settings, window), *_around(ended, settings)]
    if found is None and attempt.ending not in ("not begun", "aborted", "interrupted"):
        why = stay.failed or "the analysis finds no press here"
        live.append((True, (why, "press from rest to the upper force in one go")))
    for muscle in () if found is None else found.loose:
        live.append((True, (f"the electrode of {muscle} is off", "attach it, look at its signal, then repeat")))
    checked = [] if found is None else remedies_of(found.reasons)
    rejecting = [problem for rejects, problem in live if rejects]
    warning = [problem for rejects, problem in live if not rejects]
    by_check = "ok" if found is None else found.verdict
    verdict: Verdict = "rejected" if rejecting or by_check == "rejected" else "warned" if warning or checked else "ok"
    peak_n = attempt.peak_n if found is None else found.peak_n
    values = {"peak_n": round(peak_n, 4), "load_s": None if load_s is None else round(load_s, 4)}
    if found is not None and found.fitted:
        values |= {"a_v": found.a_v, "b_v": found.b_v}
    return Judged(ended.press, ended.attempt, verdict, (*rejecting, *checked, *warning), values, dict(samples))


def press_of(attempt: Attempt, presses: Sequence[FoundPress]) -> FoundPress | None:
    """The press of an attempt: of those that touch its time the one with the highest peak."""
    assert attempt.end_s is not None
    first_s, last_s = attempt.start_s - MARGIN_S, attempt.end_s + MARGIN_S
    touching = [press for press in presses if press.start_s <= last_s and press.stop_s >= first_s]
    return max(touching, key=lambda press: press.peak_n, default=None)


_Said = Iterator[tuple[bool, Problem]]
"""Whether it rejects, and the problem."""


def _of_cycle(attempt: Attempt, settings: SessionSettings) -> _Said:
    limits = settings.limits
    ending, reaction_s = attempt.ending, attempt.reaction_s
    if ending == "aborted":
        yield True, ("aborted by the operator", "repeat the press")
    elif ending == "interrupted":
        yield True, (f"interrupted: {attempt.why}", "repeat the press")
    elif ending == "not begun":
        yield True, (f"no press within {limits.reaction_s[1]:g} s of START", "explain START again, then repeat")
    if attempt.early:
        yield True, ("pressed before START", "ask to wait for START, then repeat")
    elif reaction_s is not None and reaction_s < limits.early_s:
        yield True, (f"pressed {1e3 * reaction_s:.0f} ms after START: begun before it", "ask to wait for START")
    elif reaction_s is not None and reaction_s > limits.reaction_s[0]:
        yield False, (f"pressed {reaction_s:.1f} s after START", "ask to press as soon as START appears")
    if attempt.stop_s is not None and not attempt.early and attempt.end_s is not None:
        lifted_s = attempt.end_s - attempt.stop_s
        if lifted_s > limits.lift_s:
            yield (
                True,
                (f"not lifted within {limits.lift_s:g} s of STOP", "ask to lift the finger at STOP, then repeat"),
            )
    if attempt.peak_n > limits.peak_n:
        yield False, (f"rose to {attempt.peak_n:.1f} N after STOP", "ask to lift the finger as soon as STOP appears")
    warns_n, rejects_n = limits.zero_n
    if abs(attempt.zero_n) > warns_n:
        do = "place the specimen again, untouched, to take a new zero"
        yield abs(attempt.zero_n) > rejects_n, (f"force was {attempt.zero_n:+.2f} N before START", do)


def _of_speed(found: FoundPress | None, settings: SessionSettings, window: WindowSettings) -> _Said:
    if found is None or found.peak_n < window.force_n[1]:
        return
    load_s, (shortest_s, longest_s) = found.stop_s - found.start_s, settings.load_s
    if window.min_duration_s <= load_s < shortest_s:
        yield False, (f"loaded in {load_s:.2f} s, faster than {shortest_s:g} s", "ask for a slower press")
    elif longest_s < load_s <= window.max_duration_s:
        yield False, (f"loaded in {load_s:.1f} s, slower than {longest_s:g} s", "ask for a faster press")


def _around(around: PressEnded, settings: SessionSettings) -> _Said:
    warns, rejects = settings.limits.lost_share
    if around.lost_share > warns:
        do = "shorten the distance to the radio and free its channel; check cables"
        yield around.lost_share > rejects, (f"{min(100.0, 100 * around.lost_share):.3g} % of the samples are lost", do)
    if around.uneven:
        yield True, ("more samples came than the device states, some twice", "restart the device, then repeat")
    if around.hidden:
        yield True, ("the participant's page was hidden", "bring the page to the front, full screen, then repeat")
    if around.age_ms is not None and around.age_ms > settings.limits.age_ms:
        do = "close other programs; connect the screen to this computer"
        yield False, (f"the page showed the force {around.age_ms:.0f} ms late", do)
