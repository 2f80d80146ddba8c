"""The first page: five sentences, and every quantitative claim of the paper with a verdict."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items, Quantity
from emg2vsa.report.section import Claim, Quantities, Section
from emg2vsa.report.table import Column, Row, Table
from emg2vsa.report.wording import count, p_text, percent

NOT_RESULTS = frozenset({"power", "interpolation_weight", "schedule_range", "force_filter", "kappa_curves"})
"""Claims on settings and arithmetic: no data can change their verdicts, so they are not counted as results."""
_KINDS = {"holds": "holds", "does not hold": "fails", "cannot be tested here": "untested"}


def claim_quantities(claims: Mapping[str, Sequence[Claim]]) -> Items:
    """``claims.<key>.ours`` and ``.verdict`` of every claim."""
    for of_section in claims.values():
        for claim in of_section:
            yield f"claims.{claim.key}.ours", claim.ours
            yield f"claims.{claim.key}.verdict", claim.verdict


COLUMNS = (
    Column("says", "Claim of the paper"), Column("verdict", "Verdict"), Column("paper", "Paper"),
    Column("here", "Here, same test"), Column("companion", "Companion test"), Column("why", "Why"),
)  # fmt: skip


def claims_tables(claims: Mapping[str, Sequence[Claim]]) -> Iterator[Table]:
    """All claims in the order of their sections, each with a link to its own; people see those with a result first."""
    every = [(name, claim) for name, of_section in claims.items() for claim in of_section]
    results = [each for each in every if each[1].key not in NOT_RESULTS]
    caption = "Quantitative claims of the paper beside this study"
    untested = [each for each in results if each[1].verdict == "cannot be tested here"]
    yield _table("claims", caption, every, shown=[each for each in results if each not in untested])
    yield _table("claims_untested", "Claims that cannot be tested here, and why", untested, untested)
    others = [each for each in every if each[1].key in NOT_RESULTS]
    yield _table("claims_on_settings", "Claims on settings and arithmetic, which no data can change", others, others)


_Claims = Sequence[tuple[str, Claim]]
"""Name of the section, and its claim."""


def _table(name: str, caption: str, every: _Claims, shown: _Claims) -> Table:
    return Table(
        name, caption, COLUMNS, tuple(_row(claim) for _, claim in every), tuple(_row(claim) for _, claim in shown),
        kinds=tuple(_KINDS[claim.verdict] for _, claim in shown), links=tuple(f"#{section}" for section, _ in shown),
    )  # fmt: skip


def _row(claim: Claim) -> Row:
    return {column.key: getattr(claim, column.key) for column in COLUMNS} | {
        "says": claim.says[0].upper() + claim.says[1:]
    }


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    return {"summary": list(_summary(results, q))}


def _summary(results: StudyResults, q: Quantities) -> Iterator[str]:
    """Five sentences, fewer where a part is missing; on each subject what was found, whatever it is."""
    if results.people is None:
        yield (
            "No recording of people could be used."
            if results.study.recordings
            else "The study has no recordings of people."
        )
    if results.runs is None:
        yield "The study has no scored runs of the rig, so claims on the rig are left out."
    verdicts = {
        key.removeprefix("claims.").removesuffix(".verdict"): value
        for key, value in q.items()
        if key.startswith("claims.") and key.endswith(".verdict")
    }
    if results_only := Counter(value for key, value in verdicts.items() if key not in NOT_RESULTS):
        yield _counted(results_only, len(verdicts) - results_only.total())
    if "hypotheses.worst_p" in q:
        yield _people(q)
        yield from _order(results, q)
    yield from _interpolation(results, q)
    if "runs.new.designs" in q:
        yield _rates(results, q)
    if "runs.kappa.new_specimen" in q:
        yield _stiffness(results, q)


def _counted(verdicts: Counter[Quantity], others: int) -> str:
    holds, fails, untested = (verdicts[kind] for kind in _KINDS)
    uncounted = f"; {others} on settings and arithmetic are not counted" if others else ""
    return (
        f"Of {count(verdicts.total(), 'quantitative claim')} of the paper, {holds} hold in this study, {fails} do not, "
        f"and {untested} cannot be tested here{uncounted}."
    )


def _people(q: Quantities) -> str:
    """Of pairs and of people, each as its claim has it; nothing tested, nothing found."""
    worst, verdict = float(q["hypotheses.worst_p"]), q["claims.specimens_differ.verdict"]
    kept, name = str(q["hypotheses.kept"]), "hypotheses.between_participants"
    if verdict == "cannot be tested here":
        pairs = f"Whether the slopes of co-contraction on {kept} differ pairwise for every participant was not tested"
        pairs += f" for all of them (worst {p_text(worst)} of those tested)" if worst == worst else ""
    else:
        differ = "differ" if verdict == "holds" else "do not all differ"
        pairs = (
            f"The slopes of co-contraction on {kept} {differ} pairwise for every participant (worst {p_text(worst)})"
        )
    tested = int(q[f"{name}.tested"])
    people = (
        f"participants differ on {q[f'{name}.significant']} of {count(tested, 'specimen')}"
        if tested
        else "participants were not compared"
    )
    return f"{pairs}; {people}."


def _order(results: StudyResults, q: Quantities) -> Iterator[str]:
    """Whether b rises with stiffness as in the paper, and in which order the specimens come."""
    name = "hypotheses.b_over_log_stiffness"
    p, t = float(q[f"{name}.p"]), float(q[f"{name}.t"])
    if p == p:
        way = "does not change significantly" if p >= float(q["hypotheses.alpha"]) else "rises" if t > 0 else "falls"
        stiffness = results.study.stiffness_n_per_mm
        stiffest_first = ", ".join(sorted(stiffness, key=stiffness.__getitem__, reverse=True))
        yield (
            f"The slope b {way} with stiffness ({p_text(p)}). Steepest first, the specimens are "
            f"{q['hypotheses.b_order']}; stiffest first, {stiffest_first}."
        )


def _interpolation(results: StudyResults, q: Quantities) -> Iterator[str]:
    new = results.study.profile.new_specimen
    share = float(q.get(f"profiles.{new}.rmse_relative", np.nan))
    if share == share:
        yield f"The interpolated profile of {new} is {percent(share, 2)} (RMSE) from the measured one."


def _rates(results: StudyResults, q: Quantities) -> str:
    rises = [bool(value) for key, value in q.items() if key.endswith(".casr.rises")]
    told = f"{q['runs.new.discriminated']} of {q['runs.new.designs']}"
    return (
        f"The contact area spread rate rises with softness in {sum(rises)} of {count(len(rises), 'design')}, and tells "
        f"{q['runs.new.specimen']} from its neighbours in {told}."
    )


def _stiffness(results: StudyResults, q: Quantities) -> str:
    own, new = results.study.scoring.algorithm, q["runs.kappa.new_specimen"]
    found = {
        law: [abs(float(value)) for key, value in q.items() if key.endswith(f".{own}.kappa.{law}") and value == value]
        for law in ("error", "paper_law.error")
    }
    if not found["error"]:
        return f"The stiffness of {new} is not known, so its estimates cannot be judged."
    median, by_paper = (percent(float(np.median(errors)), 2) for errors in found.values())
    papers = "" if results.study.calibration.law == "exponential" else f", {by_paper} by the paper's law"
    shared = (
        f"; estimator and simulated world share a finite-element program (one press in the advancing-front world, "
        f"which shares the law alone: {percent(float(q['runs.kappa.advancing_front_error']), 2)})"
        if q["runs.simulated"] and own == "front"
        else ""
    )
    determined = [bool(value) for key, value in q.items() if key.endswith(f".{own}.kappa.determined")]
    known = f"; its interval determines it in {sum(determined)} of {len(determined)}" if determined else ""
    return (
        f"The stiffness of {new} is {median} off in the median of {count(len(found['error']), 'design')}"
        f"{papers}{known}{shared}."
    )


_TEXT = """
{% for sentence in summary %}
<p>{{ sentence }}</p>
{% endfor %}
{% if table("claims") %}
{{ table("claims") }}
<p class="small">“Here” is the paper's own test or definition; a companion fits the question better.</p>
{{ folded("claims_untested", "Claims that cannot be tested here") }}
{{ folded("claims_on_settings", "Claims on settings and arithmetic") }}
{% endif %}
"""

CLAIMS = Section("claims", "Summary", _TEXT, words=_words)
