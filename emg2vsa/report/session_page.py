"""The page of one participant: whether the session is good, and what every press looks like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape
from pathlib import Path

import numpy as np

from casr import html
from casr.atomic import write_text_atomic
from emg2vsa.companions.person_slopes import person_slopes
from emg2vsa.extraction import Trials
from emg2vsa.figures.palette import ActivityScale, activity_scale
from emg2vsa.fits import Fits, by_recording
from emg2vsa.report.failures import Failure, ShortPaths
from emg2vsa.report.session_plots import (
    LEGEND,
    activity_plot,
    budget_plot,
    emg_trace,
    force_trace,
    median_frequencies,
    spectra,
)
from emg2vsa.report.table import Column, Table, activity_column, table_of
from emg2vsa.report.wording import NO_BREAK, number, percent
from emg2vsa.session_verdict import Doubts, SessionVerdict, doubts_between, judge_session
from emg2vsa.signals.bias import muscle_error_s
from emg2vsa.study import RecordingEntry, Study

VERDICT_TEXT = {
    "good": "Every press can be used.",
    "usable": "The session can be used. Read the remarks below.",
    "repeat": "Repeat the recordings listed below while the participant is still here.",
    "unreadable": "A recording cannot be used. Read the reason below, then correct the recording or the study file.",
}


def write_session_page(
    study: Study,
    participant: str,
    trials: Sequence[Trials],
    fits: Fits | None,
    failures: Sequence[Failure],
    folder: Path,
) -> list[Path]:
    """Write ``folder/participants/<participant>.html``; the files written.

    ``study`` may be reduced to this participant and the own recordings. ``fits`` are this participant's, None where no
    recording could be fitted: the page then says why.
    """
    entries = {entry.specimen: entry for entry in study.recordings if entry.participant == participant}
    short = ShortPaths(replace(study, recordings=tuple(entries.values())))
    failures = short.failures(failure for failure in failures if failure.participant == participant)
    by_specimen = {t.specimen: t for t in trials}
    fitted = by_recording(fits) if fits else {}
    doubts = doubts_between(trials, fitted, study.judgements)
    verdict = session_verdict(participant, list(entries.values()), trials, fitted, failures, doubts)
    scale = activity_scale(fits.activity_unit, fits.v_max_v) if fits else activity_scale("V", [])
    of_person = {}
    if fits:
        slopes = person_slopes(fits, study.hypotheses.use)
        of_person = dict(zip(slopes.specimen.tolist(), slopes.said(fits.activity_unit), strict=True))
    sections = []
    for place, judged in enumerate(verdict.specimens):
        body = ""
        if recording := by_specimen.get(judged.specimen):
            own = fitted.get((participant, judged.specimen))
            # what people said of a press, and its fit, count in every picture
            recording = recording if own is None else replace(recording, verdict=own.verdict)
            body = _recording(recording, own, entries[judged.specimen].window.force_n, scale, f"r{place}")
            if said := of_person.get(judged.specimen):
                body += html.paragraph(said)
            body += html.details("Processing", html.bullets(map(short.text, recording.notes)))
        faults = html.bullets(map(str, judged.told))
        wanted = f" of {judged.wanted}" if judged.wanted is not None else ""
        heading = f"{judged.specimen}: usable presses {judged.ok}{wanted}"
        sections.append(html.section(f"r{place}", heading, faults, body))
    top = html.statement(verdict.verdict, verdict.verdict.capitalize() + ".", VERDICT_TEXT[verdict.verdict])
    steps = "".join(
        html.paragraph(f"{f.stage} failed for {f.key}: {f.message}") for f in failures if f.stage != "trials"
    )
    header = f'<h1>{escape(participant)}</h1><p class="sub">{escape(study.title)}</p>'
    nav = [("../index.html", "Study report"), *((f"#r{i}", s.specimen) for i, s in enumerate(verdict.specimens))]
    body = top + html.bullets(map(str, verdict.advice)) + steps + LEGEND + "".join(sections)
    path = folder / "participants" / f"{participant}.html"
    write_text_atomic(path, html.page(f"{participant}: {study.title}", header, nav, body, "<p></p>"))
    return [path]


def session_verdict(
    participant: str,
    entries: Sequence[RecordingEntry],
    trials: Sequence[Trials],
    fits: Mapping[tuple[str, str], Fits],
    failures: Sequence[Failure],
    doubts: Doubts,
) -> SessionVerdict:
    """The verdict on one participant's recordings; entries, trials and failures are this participant's."""
    keys = [(participant, entry.specimen) for entry in entries]
    own = {key[1]: fits[key] for key in keys if key in fits}
    beside = {key[1]: doubts[key] for key in keys if key in doubts}
    missed = {failure.key.partition("/")[2]: failure.message for failure in failures}
    wanted = {e.specimen: e.wanted_presses for e in entries}
    return judge_session(participant, trials, own, wanted, missed, beside)


def _recording(trials: Trials, own: Fits | None, window_n: tuple[float, float], scale: ActivityScale, name: str) -> str:
    """Force and raw EMG over time; spectra, median frequencies and fits; a table of the presses."""
    body = html.heading("Signal quality") + html.bullets(_quality(trials))
    muscles = range(len(trials.muscles)) if trials.overviews else ()
    traces = [force_trace(trials, window_n, f"{name}f"), *(emg_trace(trials, m, f"{name}e{m}") for m in muscles)]
    raw = " Grey is raw EMG; red is the mean of rectified EMG." if trials.overviews else ""
    said = f"{trials.specimen}: force and EMG over time. Loading phases are shaded and numbered.{raw}"
    body += html.figure("".join(traces), said)
    drawn = [f"<figure>{each}</figure>" for m in muscles if (each := spectra(trials, m, f"{name}s{m}"))]
    if trials.overviews and (frequencies := median_frequencies(trials, f"{name}m")):
        drawn.append(f"<figure>{frequencies}</figure>")
    if own is not None and np.isfinite(own.bin_v).any():
        said = f"{trials.specimen}: means of the force bins, and the fit v = a + b ln F of each press. {_CURVES}."
        drawn.append(html.figure(activity_plot(own, scale, f"{name}v"), said))
    else:
        body += html.paragraph("No press has co-contraction within the force window, so no curve can be drawn.")
    body += html.pictures(drawn)
    if own is not None and own.b_v.size:
        said = (
            f"{trials.specimen}: budget of bias. Each dot is what one cause, corrected where it can be, is expected to "
            "leave in b of a press, with its standard error; the cross is their sum; grey is the half width of the "
            "interval of b. A press whose sum passes the grey, or 10 % (dashed), is doubtful and enters no test. So is "
            "every press of a recording that is unlike the others of the study."
        )
        body += html.figure(budget_plot(trials, own, f"{name}b"), said)
    return body + (_table(trials, own, scale).html() if own is not None and own.b_v.size else "")


_CURVES = "Curves: solid = ok, dashed = doubtful (!), dotted = rejected (×), thick = unlike the other presses"


def _table(trials: Trials, fits: Fits, scale: ActivityScale) -> Table:
    columns = (
        Column("repetition", "Press"), Column("start_s", "Start (s)", digits=4), Column("duration_s", "Duration (s)"),
        Column("peak_force_n", "Peak (N)"), Column("falling_share", "Falling force (%)", 100.0, 2),
        Column("snr_db", "SNR (dB)"), activity_column("a_v", "a", scale), activity_column("b_v", "b", scale),
        activity_column("b_lo_v", "b low", scale), activity_column("b_hi_v", "b high", scale),
        Column("b_bias", "Bias of b left (%)", 100.0, 2),
        Column("cause", "Largest cause"), Column("adj_r2_bins", "adj. R², bins"),
        Column("adj_r2_samples", "adj. R², samples"), Column("verdict", "Verdict"), Column("reason", "Reason"),
    )  # fmt: skip
    values = {c: np.asarray(getattr(fits if hasattr(fits, c.key) else trials, c.key)) for c in columns}
    interval = f"{100 * fits.confidence:g}{NO_BREAK}%"
    caption = f"Presses on {trials.specimen}; b low and b high are the limits of the {interval} interval of b"
    return table_of("presses", caption, values)


def _quality(trials: Trials) -> list[str]:
    measured = (trials.rest_envelope_v, trials.mains_ratio, trials.clip_share)
    said = [
        f"{muscle}: {number(rest * 1e6)} µV at rest, {percent(mains, 2)} of the power from mains, "
        f"{percent(clip, 2)} of the samples clipped"
        for muscle, rest, mains, clip in zip(trials.muscles, *(each.tolist() for each in measured), strict=True)
    ]
    said.append(f"Force: {number(trials.rest_force_n)} N at rest, subtracted")
    if np.isfinite(trials.lag_s) and trials.repetition.size:
        known = np.isfinite(trials.lag_se_s)
        shared_s = muscle_error_s(trials.lag_s)
        error = f"standard error between presses {1e3 * trials.lag_se_s:.0f} ms" if known else "from one press"
        if shared_s:
            error += f"; {1e3 * shared_s:.0f} ms in all presses alike where the muscle itself makes the lag"
        said.append(f"Force follows EMG by {1e3 * trials.lag_s:.0f} ms ({error})")
    return said
