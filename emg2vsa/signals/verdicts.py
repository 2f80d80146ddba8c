"""Verdicts on trials by their signals: ok or rejected, and what else is told. A rejected trial stays in the tables."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from emg2vsa.settings import WindowSettings
from emg2vsa.signals.quality import REPEATING, SILENT_DB, RawQuality

MAINS_WARNING = 0.3
"Share of EMG power at the mains and its harmonics."
HELD_WARNING_S = 0.01
"A channel that holds one value for longer lost samples."
HELD_WARNING_SAMPLES = 8
"... and for at least so many samples: a coarse converter repeats a few."
HELD_SHARE = 0.1
"Share of the window above which a held value rejects the trial."


@dataclass(frozen=True)
class Evidence:
    """What is known of one trial. rest_gap_n : tared force before contact, NaN if unknown. emg : by muscle.

    fault : a mistake that spoils the whole record, such as a reversed force; empty if none.
    said : further reasons, each with whether it rejects the trial.
    """

    fault: str
    duration_s: float
    peak_force_n: float
    reached: bool
    at_edge: bool
    covered: bool
    force_missing: int
    falling_share: float
    rest_gap_n: float
    start_force_n: float
    emg_fs_hz: float
    emg: Mapping[str, RawQuality]
    snr_db: Mapping[str, float]
    said: tuple[tuple[bool, str], ...] = ()


def judge(trial: Evidence, window: WindowSettings) -> tuple[str, str]:
    """Verdict and reasons, the rejecting ones first, joined by "; "."""
    if trial.fault:
        return "rejected", trial.fault
    said = [*_on_force(trial, window), *_on_signals(trial, window), *trial.said]
    rejecting = [reason for rejects, reason in said if rejects]
    told = [reason for rejects, reason in said if not rejects]
    return "rejected" if rejecting else "ok", "; ".join(rejecting + told)


def _on_force(trial: Evidence, window: WindowSettings) -> Iterator[tuple[bool, str]]:
    lower_n, upper_n = window.force_n
    if not trial.reached:
        yield True, f"reached {trial.peak_force_n:.3g} of {upper_n:g} N"
    if not trial.covered:
        yield True, "EMG does not cover the whole loading phase"
    if trial.duration_s < window.min_duration_s:
        yield True, f"lasted {trial.duration_s:.2g} s, shorter than {window.min_duration_s:g} s"
    if trial.duration_s > window.max_duration_s:
        yield True, f"lasted {trial.duration_s:.3g} s, longer than {window.max_duration_s:g} s"
    if trial.force_missing:
        yield True, f"force misses {trial.force_missing} samples"
    if trial.falling_share > window.warn_falling_share:
        yield (
            trial.falling_share > window.max_falling_share,
            f"force falls on {100 * trial.falling_share:.1f} % of its path",
        )
    if abs(trial.rest_gap_n) > window.max_gap_force_n:
        yield False, f"force rests at {trial.rest_gap_n:.2f} N before contact"
    if trial.at_edge:
        begins = trial.start_force_n > lower_n * 1.05
        missed = trial.start_force_n > lower_n + window.max_missed_n or not trial.reached
        yield missed, f"record begins at {trial.start_force_n:.3g} N" if begins else "at the edge of the record"


def _on_signals(trial: Evidence, window: WindowSettings) -> Iterator[tuple[bool, str]]:
    for muscle, quality in trial.emg.items():
        if quality.missing:
            most = HELD_SHARE * trial.duration_s * trial.emg_fs_hz
            yield quality.missing > most, f"{muscle} misses {quality.missing} samples"
        if quality.flat:
            yield True, f"{muscle} is flat"
            continue
        if quality.clip_share > window.clip_share:
            yield True, f"{muscle} clips in {100 * quality.clip_share:.2g} % of samples"
        elif quality.repeat_share > REPEATING:
            held = f"as if held from about {(1 - quality.repeat_share) * trial.emg_fs_hz:.3g} Hz"
            yield False, f"{muscle} repeats {100 * quality.repeat_share:.0f} % of its samples, {held}"
        held_s = quality.held_samples / trial.emg_fs_hz
        if held_s > HELD_WARNING_S and quality.held_samples >= HELD_WARNING_SAMPLES:
            yield held_s > HELD_SHARE * trial.duration_s, f"{muscle} holds one value for {1e3 * held_s:.0f} ms"
        if quality.mains_ratio > MAINS_WARNING:
            yield False, f"mains is {100 * quality.mains_ratio:.0f} % of the power of {muscle}"
        snr_db = trial.snr_db[muscle]
        if abs(snr_db) < SILENT_DB:
            yield True, f"{muscle} is as silent as at rest ({snr_db:.1f} dB over it)"
        elif snr_db < window.min_snr_db:
            yield False, f"{muscle} is {snr_db:.1f} dB over rest"
