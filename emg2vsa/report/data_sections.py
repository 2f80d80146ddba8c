"""Sections of the study report on what was recorded: at a glance, participants, trials, fits, recovery."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy as np

from casr import html
from emg2vsa.fits import by_recording
from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import StudyResults, origin
from emg2vsa.report.quantity import Quantity
from emg2vsa.report.session_page import session_verdict
from emg2vsa.report.table import Column, Table
from emg2vsa.report.wording import bounded, count, listed, number, p_text, percent
from emg2vsa.session_verdict import doubts_between
from emg2vsa.study import RecordingEntry
from emg2vsa.trials.reasons import most_frequent


def glance(results: StudyResults, found: Mapping[str, Quantity]) -> str:
    """What a reader in a hurry must know."""
    tiles = [
        (f"{len(results.trials)} of {found['study.recordings']}", "recordings read"),
        (f"{found['trials.total']}", "trials found"),
        (f"{found['trials.rejected']}", "trials rejected"),
        (f"{found['fit.used']}", "trials in the tests"),
    ]
    tested = results.hypotheses
    if tested is not None and tested.worst_pair:
        tiles.append((p_text(tested.worst_p), f"worst pair among {listed(tested.kept)}"))
    if "recovery.mean_b_error" in found:
        error, mcse = (100 * float(found[f"recovery.mean_b_error{suffix}"]) for suffix in ("", "_mcse"))
        tiles.append((f"{error:.2f} ± {mcse:.2f} %", "mean error of b against the truth"))
    tiles += _rig_tiles(results)
    shown = "".join(f"<li><b>{escape(value)}</b>{escape(name)}</li>" for value, name in tiles)
    said = origin(results)
    opening = html.statement(said.kind, said.strong, said.text)
    return opening + f'<ul class="tiles">{shown}</ul>\n' + html.paragraph(_TERMS)


def _rig_tiles(results: StudyResults) -> list[tuple[str, str]]:
    """Presses of the rig, and how well they tell the stiffness of the new specimen."""
    tiles = [(f"{sum(len(run.verdicts) for run in results.runs)}", "presses of the rig")] if results.runs else []
    found = results.calibration
    if found is not None and np.isfinite(found.known_kappa_new):
        errors = [abs(r.algorithms[results.study.scoring.algorithm].chosen.error) for r in found.conditions]
        known = [error for error in errors if np.isfinite(error)]
        if known:
            what = f"median error of κ of {found.new_specimen}, {len(known)} conditions and angles"
            tiles.append((f"{100 * float(np.median(known)):.1f} %", what))
    return tiles


_TERMS = (
    "A trial is the loading phase of one press. Its co-contraction v, what the muscles do together, is fitted against "
    "the force F as v = a + b ln F: a is v at 1 N, the slope b says how fast v grows. The tests compare b. A cluster "
    "is the trials of one participant on one specimen; κ is a specimen's stiffness. “The paper” is the published study "
    "whose analysis is repeated here."
)


def participants(results: StudyResults) -> str:
    """One row a participant, with a link to the page; then everything that failed."""
    rows, without_page = [], {failure.key for failure in results.failures if failure.stage == "pages"}
    entries: dict[str, list[RecordingEntry]] = {}
    for entry in results.study.recordings:
        entries.setdefault(entry.participant, []).append(entry)
    fits = by_recording(results.fits) if results.fits else {}
    doubts = doubts_between(results.trials, fits, results.study.judgements)
    for name, (trials, failures) in results.by_participant().items():
        verdict = session_verdict(name, entries[name], trials, fits, failures, doubts)
        of = verdict.specimens
        cells = (
            len(of),
            sum(s.found for s in of),
            *(sum(getattr(s, v) for s in of) for v in ("ok", "warned", "rejected")),
        )
        numbers = "".join(f'<td class="n">{n}</td>' for n in cells)
        link = escape(name)
        if name not in without_page:
            link = f'<a href="participants/{link}.html">{link}</a>'
        rows.append(f'<tr><th scope="row">{link}</th><td>{verdict.verdict}</td>{numbers}</tr>')
    heads = "".join(
        f'<th scope="col">{head}</th>'
        for head in ("Participant", "Session", "Recordings", "Trials", "Ok", "Warned", "Rejected")
    )
    table = (
        '<div class="wide" role="region" tabindex="0" aria-label="Sessions"><table>'
        f"<caption>Sessions: good, usable, to repeat, or unreadable</caption><thead><tr>{heads}</tr></thead>"
        f"<tbody>{''.join(rows)}</tbody></table></div>\n"
    )
    return html.section("participants", "Participants", table, _failures(results), _rejected(results))


def _failures(results: StudyResults) -> str:
    if not results.failures:
        return html.paragraph("Every step of every recording was done.")
    return html.heading("What failed") + failed_steps(results.failures).html()


def failed_steps(failures: Sequence[Failure]) -> Table:
    """Every failure with its reason."""
    columns = (Column("key", "For"), Column("stage", "Step"), Column("message", "Why"))
    rows = tuple((f.key, f.stage, f.message) for f in failures)
    return Table("failures", "Steps that could not be done", columns, rows)


def _rejected(results: StudyResults) -> str:
    fits = results.fitted
    blocks = html.heading("Rejected and warned trials")
    accepted = (fits.verdict == "ok") & (fits.reason != "")
    for verdict, chosen, kept in (
        ("rejected", fits.verdict == "rejected", "Rejected trials stay in fits.csv; no test uses them."),
        ("warned", fits.verdict == "warned", _use_of_warned(results)),
        ("accepted by hand", accepted, "The study file accepts them, and they enter the tests."),
    ):
        these = np.flatnonzero(chosen)
        if not these.size:
            blocks += html.paragraph(f"No trial was {verdict}.")
            continue
        reasons = [reason for i in these for reason in str(fits.reason[i]).split("; ")]
        blocks += html.paragraph(f"{count(these.size, 'trial')} {verdict}. {kept}")
        columns = (
            Column("participant", "Participant"),
            Column("specimen", "Specimen"),
            Column("press", "Press"),
            Column("reason", "Reason"),
        )
        rows = tuple(
            (str(fits.participant[i]), str(fits.specimen[i]), str(fits.repetition[i]), str(fits.reason[i]))
            for i in these
        )
        listing = Table(verdict.split()[0], f"Trials {verdict}, with reasons", columns, rows).html()
        frequent = "; ".join(most_frequent(reasons, 5))
        blocks += html.paragraph(f"Most frequent reasons: {frequent}.", "small") + html.details("All of them", listing)
    return blocks


def _use_of_warned(results: StudyResults) -> str:
    enter = "enter" if "warned" in results.study.hypotheses.use else "do not enter"
    return f"Warned trials {enter} the tests."


def fits(results: StudyResults, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    """What equation (6) gives, at each stage of smoothing."""

    def worst(stage: str) -> str:
        least, middle = (float(found[f"fit.adj_r2_{stage}.{which}"]) for which in ("min", "median"))
        return f"worst {bounded(least)}, median {bounded(middle)}"

    text = (
        f"Each trial is fitted as v = a + b ln F. Adjusted R² on force bins: {worst('bins')}; on the samples of the "
        f"same trials: {worst('samples')}. Smoother data give a larger R² from the same trial, so the two are never "
        f"mixed. Neighbouring samples are alike (lag-1 correlation {number(float(found['fit.lag1.median']))}): the "
        f"samples of a trial are worth about {number(float(found['fit.n_effective.median']), 2)} independent ones. "
        f"Slopes that are not positive: {found['fit.b_not_positive']}."
    )
    where = '<p class="small">All trials, rejected ones included: <a href="tables/fits.csv">tables/fits.csv</a>.</p>\n'
    return html.section(
        "fits",
        "Fits",
        html.paragraph(text),
        tables["fits_by_specimen"].html(),
        where,
        _recovery(results, found, tables),
    )


def _recovery(results: StudyResults, found: Mapping[str, Quantity], tables: Mapping[str, Table]) -> str:
    if "recovery" not in tables:
        return ""
    if "recovery.n" not in found:
        return html.heading("Against the truth") + html.paragraph(
            "The activity is not in volts, the truth is: they cannot be compared."
        )
    value = {
        key: float(found[f"recovery.{key}"])
        for key in ("mean_b_error", "mean_b_error_mcse", "coverage", "coverage_mcse", "sd_b_error", "confidence")
    }
    text = (
        f"Over {found['recovery.n']} trials whose truth is known, fitted b is off by "
        f"{percent(value['mean_b_error'], 2)} on average (Monte-Carlo standard error "
        f"{percent(value['mean_b_error_mcse'], 2)}), with a standard deviation of {percent(value['sd_b_error'], 2)}. "
        f"{percent(value['coverage'])} of the {100 * value['confidence']:g} % intervals hold the true b (Monte-Carlo "
        f"standard error {percent(value['coverage_mcse'], 2)})."
    )
    return html.heading("Against the truth of the simulation") + html.paragraph(text) + tables["recovery"].html()
