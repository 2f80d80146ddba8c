"""The page of one participant: is the session good, and what every press looked like."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from html import escape
from pathlib import Path

import numpy as np

from casr import html
from casr.atomic import write_text_atomic
from emg2vsa.figures.activity_scale import ActivityScale, activity_scale
from emg2vsa.figures.palette import INK, looks
from emg2vsa.fits import Fits
from emg2vsa.report.failures import Failure, ShortPaths
from emg2vsa.report.session_plots import LEGEND, PATTERNS, activity_plot, force_trace
from emg2vsa.report.table import Column, Table, activity_column
from emg2vsa.report.wording import NO_BREAK, number, percent
from emg2vsa.session_verdict import SessionVerdict, SpecimenVerdict, judge_session
from emg2vsa.study import RecordingEntry, Study
from emg2vsa.trials import Trials

VERDICT_TEXT = {
    "good": "Every press is as wanted.",
    "usable": "The session can be used; read the remarks.",
    "repeat": "Record again what is listed, while the participant is there.",
    "unreadable": "A recording cannot be used as it is: read why, and mend the file or the study file.",
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
    path = folder / "participants" / f"{participant}.html"
    write_text_atomic(path, _page(study, participant, trials, fits, failures))
    return [path]


def session_verdict(
    participant: str, entries: Sequence[RecordingEntry], trials: Sequence[Trials], failures: Sequence[Failure]
) -> SessionVerdict:
    """The verdict on one participant's recordings; all arguments are this participant's."""
    missed = {failure.key.partition("/")[2]: failure.message for failure in failures}
    return judge_session(participant, trials, {}, {e.specimen: e.window.expected_trials for e in entries}, missed)


def _page(
    study: Study, participant: str, trials: Sequence[Trials], fits: Fits | None, failures: Sequence[Failure]
) -> str:
    entries = {entry.specimen: entry for entry in study.recordings if entry.participant == participant}
    short = ShortPaths(replace(study, recordings=tuple(entries.values())))
    failures = short.failures(failure for failure in failures if failure.participant == participant)
    by_specimen = {t.specimen: t for t in trials}
    verdict = session_verdict(participant, list(entries.values()), trials, failures)
    look = looks([specimen.name for specimen in study.specimens])
    scale = activity_scale(fits.activity_unit, fits.v_max_v) if fits else activity_scale("V", [])
    sections = []
    for place, judged in enumerate(verdict.specimens):
        body = ""
        if recording := by_specimen.get(judged.specimen):
            own = _rows(fits, fits.specimen == judged.specimen) if fits else None
            colour = look[judged.specimen].colour if judged.specimen in look else INK
            body = _recording(recording, own, entries[judged.specimen].window.force_n, colour, scale, f"r{place}")
            body += html.details("Signal quality and processing", _quality(recording, short))
        faults = html.bullets(filter(None, (judged.fault, *judged.problems)))
        sections.append(html.section(f"r{place}", _heading(judged), faults, body))
    top = html.statement(verdict.verdict, verdict.verdict.capitalize() + ".", VERDICT_TEXT[verdict.verdict])
    steps = "".join(
        html.paragraph(f"{f.stage} failed for {f.key}: {f.message}") for f in failures if f.stage != "trials"
    )
    header = f'<h1>{escape(participant)}</h1><p class="sub">{escape(study.title)}</p>'
    nav = [("../index.html", "Study report"), *((f"#r{i}", s.specimen) for i, s in enumerate(verdict.specimens))]
    body = top + html.bullets(verdict.advice) + steps + PATTERNS + LEGEND + "".join(sections)
    return html.page(f"{participant}: {study.title}", header, nav, body, "<p></p>")


def _heading(judged: SpecimenVerdict) -> str:
    wanted = f" of {judged.wanted}" if judged.wanted is not None else ""
    return f"{judged.specimen}: usable presses {judged.usable}{wanted}"


def _recording(
    trials: Trials, own: Fits | None, window_n: tuple[float, float], colour: str, scale: ActivityScale, name: str
) -> str:
    body = html.figure(
        force_trace(trials, window_n, f"{name}f"), "Force over time. Loading phases are shaded and numbered."
    )
    if own is None or not np.isfinite(own.bin_v).any():
        body += html.paragraph("No press has co-contraction within the force window, so there is no curve to show.")
    else:
        dashed = "solid: ok; dashed: warned; dotted: rejected"
        body += html.figure(
            activity_plot(own, colour, scale, f"{name}v"), f"Force bins and fits v = a + b ln F. Curves: {dashed}."
        )
    if own is not None and own.b_v.size:
        body += _table(trials, own, scale).html()
    return body


def _rows(fits: Fits, of: np.ndarray) -> Fits:
    per_trial = {f.name: getattr(fits, f.name) for f in fields(fits)}
    return replace(fits, **{k: v[of] for k, v in per_trial.items() if isinstance(v, np.ndarray) and k != "bin_edges_n"})


def _table(trials: Trials, fits: Fits, scale: ActivityScale) -> Table:
    columns = (
        Column("repetition", "Press"), Column("start_s", "Start (s)", digits=4), Column("duration_s", "Lasts (s)"),
        Column("peak_force_n", "Peak (N)"), Column("falling_share", "Falling (%)", 100.0, 2),
        Column("snr_db", "SNR (dB)"), activity_column("a_v", "a", scale), activity_column("b_v", "b", scale),
        activity_column("b_lo_v", "b low", scale), activity_column("b_hi_v", "b high", scale),
        Column("adj_r2_bins", "adj. R², bins"),
        Column("adj_r2_samples", "adj. R², samples"), Column("verdict", "Verdict"), Column("reason", "Reason"),
    )  # fmt: skip
    rows = []
    for i in range(fits.b_v.size):
        rows.append(tuple(getattr(fits if hasattr(fits, c.key) else trials, c.key)[i].item() for c in columns))
    interval = f"{100 * fits.confidence:g}{NO_BREAK}%"
    caption = f"Presses on {trials.specimen}; b low and b high are the ends of its {interval} interval"
    return Table("presses", caption, columns, tuple(rows))


def _quality(trials: Trials, short: ShortPaths) -> str:
    muscles = [
        f"{muscle}: rest {number(rest * 1e6)} µV, mains {percent(mains, 2)} of power, clipped {percent(clip, 2)}"
        for muscle, rest, mains, clip in zip(
            trials.muscles, trials.rest_envelope_v.tolist(), trials.mains_ratio.tolist(), trials.clip_share.tolist(),
            strict=True,
        )
    ]  # fmt: skip
    notes = map(short.text, trials.notes)
    return html.bullets([*muscles, f"force at rest: {number(trials.rest_force_n)} N, subtracted", *notes])
