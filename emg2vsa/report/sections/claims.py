"""The summary: the question, five sentences, a picture of all verdicts, and every claim beside the paper's own test."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from emg2vsa.claims import arithmetic, calibrated, paper
from emg2vsa.claims.arithmetic import Counted, arithmetic_claims
from emg2vsa.claims.claim import OF_A_STUDY, Claim, Judged, judge
from emg2vsa.claims.on_rig import claims_on_rig
from emg2vsa.claims.people import claims_of_study
from emg2vsa.figures.verdicts import draw_verdicts
from emg2vsa.hypotheses import Hypotheses
from emg2vsa.registration import Registered
from emg2vsa.report.drawing import Drawing
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.people_tests import people_tests
from emg2vsa.report.rig_tests import rig_tests
from emg2vsa.report.section import PaperTest, Quantities, Section
from emg2vsa.report.sections.robustness import paths_share, told_of_paths
from emg2vsa.report.table import Cell, Column, Table
from emg2vsa.report.wording import UNDEFINED, bounded, count, ends, number, percent

_KINDS = {"holds": "holds", "refuted": "fails", "not determined": "untested"}
_UNITS = {"none": "exact", "mounting": "mountings", "person": "people"}
_SUMMARY = ("specimens_differ", "interpolation_rmse", "fig12_order", "human_like_contrast", "kappa_error_human_like")
"""The claims that the five sentences are on."""


def judged_claims(results: StudyResults) -> tuple[Judged, ...]:
    """Every claim that this study has something on, with the interval that all of them together allow."""
    return judge(_claims(results), results.study.claims.false_verdict_percent / 100, OF_A_STUDY)


def _claims(results: StudyResults) -> Iterator[Claim]:
    study, people, runs = results.study, results.people, results.runs
    weight = np.nan
    if people is not None:
        tested = people.hypotheses
        if tested or any(failure.stage == "hypotheses" for failure in results.failures):  # no report of the rig alone
            places, laws = (tested.places(), tested.laws) if tested else ({}, None)
            yield from map(partial(_with_misfit, tested), claims_of_study(study, people.fits, places, laws))
        weight = people.profiles.weight_alpha if people.profiles and people.profiles.new else np.nan
    if runs is not None:
        yield from claims_on_rig(study, runs.discrimination.table if runs.discrimination else None, runs.calibration)
    yield from arithmetic_claims(
        study, weight_alpha=weight, counted=_counted(results), runs=runs is not None, plates=results.plates
    )


def _with_misfit(tested: Hypotheses | None, claim: Claim) -> Claim:
    """No other law may predict better than a logarithm that does not fit either."""
    if tested is None or claim.key != "log_fit_r2" or not tested.misfits.together[0].told:
        return claim
    return replace(claim, why=f"{claim.why} The logarithm itself does not fit.".lstrip())


def _counted(results: StudyResults) -> Counted | None:
    if results.people is None:
        return None
    fits, expected = results.people.fits, results.study.window.expected_trials
    cells = [(who, specimen) for who in results.study.participants for specimen in results.study.palpated]
    presses = Counter(zip(fits.participant.tolist(), fits.specimen.tolist(), strict=True))
    there = [presses[cell] for cell in cells]
    recorded = int(fits.verdict.size)
    visits = max(len(results.study.visits), 1)
    asked = max(expected * len(cells) * visits, recorded) if expected else sum(there) if all(there) else 0
    return Counted(int(np.count_nonzero(np.isfinite(fits.b_v))), recorded, asked)


def claim_quantities(judged: Sequence[Judged], registered: Registered | None = None) -> Items:
    """``claims.<key>.ours``, its interval, its margin and its verdict, and how it was registered; in the unit that the
    table shows."""
    for each in judged:
        claim, name = each.claim, f"claims.{each.claim.key}"
        yield f"{name}.ours", claim.found.estimate * claim.factor
        yield f"{name}.low", each.low * claim.factor
        yield f"{name}.high", each.high * claim.factor
        yield f"{name}.margin", claim.margin * claim.factor
        yield f"{name}.unit_of_error", claim.unit
        yield f"{name}.verdict", each.verdict
        if registered is not None:
            yield f"{name}.registered", registered.state(each)


COLUMNS = (
    Column("says", "Claim"), Column("verdict", "Verdict"), Column("here", "Estimate and interval"),
    Column("margin", "What matters"), Column("unit", "Error over"), Column("algorithm", "Algorithm"),
    Column("paper", "Paper"), Column("own_test", "The paper's own test here"), Column("why", "Remark"),
)  # fmt: skip


def claims_tables(results: StudyResults, judged: Sequence[Judged], q: Quantities) -> Iterator[Table]:
    """All claims, those on data by their questions, each with a link to its section; then those on settings."""
    tests = people_tests(results, q) | rig_tests(results, q) | _setting_tests(results, q)
    of_data = [each for each in judged if each.claim.question != arithmetic.QUESTION]
    level = _level(of_data)
    caption = (
        f"What the paper claims, beside this study. Intervals of {level} each, as for {OF_A_STUDY} claims, so that any "
        f"verdict is false with a chance of {results.study.claims.false_verdict_percent:g} % at most, as far as the "
        "intervals hold what they say. A difference is refuted where its interval lies below what matters, a size "
        "where it lies above. Error over: what was drawn at random and counts once. The paper's own test decides "
        "nothing here"
    )
    yield _table("claims", caption, of_data, tests, _more(results, of_data))
    others = [each for each in judged if each.claim.question == arithmetic.QUESTION]
    yield _table("claims_on_settings", "Claims on settings, arithmetic and plates", others, tests, {})
    yield _how_often_right(of_data)


def _level(judged: Sequence[Judged]) -> str:
    return f"{100 * max((each.confidence for each in judged), default=np.nan):.4g} %"


def _more(results: StudyResults, judged: Sequence[Judged]) -> dict[Column, list[str]]:
    """Columns of a study whose verdicts were judged along other paths, or were registered."""
    found: dict[Column, list[str]] = {}
    if shares := paths_share(results):
        each = (shares.get(one.claim.key, (0, 0)) for one in judged)
        found[Column("paths", "Paths that keep it")] = [f"{percent(k / of, 2)} of {of}" if of else "" for k, of in each]
    if results.registered is not None:
        found[Column("registered", "Registered")] = [results.registered.state(one) for one in judged]
    return found


def _table(
    name: str, caption: str, judged: Sequence[Judged], tests: dict[str, PaperTest], more: dict[Column, list[str]]
) -> Table:
    rows = [_row(each, tests.get(each.claim.key, PaperTest(""))) for each in judged]
    for place, row in enumerate(rows):
        row |= {column.key: values[place] for column, values in more.items()}
    return Table(
        name, caption, (*COLUMNS[:2], *more, *COLUMNS[2:]), rows,
        kinds=tuple(_KINDS[each.verdict] for each in judged),
        links=tuple(f"#{each.claim.section}" for each in judged),
        groups=tuple(_capital(each.claim.question) for each in judged),
    )  # fmt: skip


def _capital(text: str) -> str:
    return text[0].upper() + text[1:]


_RIGHT = (
    Column("says", "Claim"), Column("false", "False, worst world, %", 100, 2),
    Column("false_at_most", "At most, %", 100, 2), Column("world", "World"),
    Column("power", "Found at the paper's effects, %", 100), Column("right", "As"),
)  # fmt: skip


def _how_often_right(judged: Sequence[Judged]) -> Table:
    """What the benchmark says of each of the study's claims."""
    rows = [
        {
            "says": each.claim.says, "false": right.false, "false_at_most": right.bound,
            "world": right.world if right.false else None, "power": right.power, "right": right.right,
        }
        for each in judged
        if (right := calibrated.CLAIMS.get(each.claim.key))
    ]  # fmt: skip
    caption = (
        f"How often each claim is right in {calibrated.STUDIES} studies of each of {calibrated.WORLDS} made worlds, "
        "with 14 people and three mountings of three presses. Any false verdict in a report: "
        f"{number(100 * calibrated.ANY.false, 2)} % at worst, at most {number(100 * calibrated.ANY.bound, 2)} %. These "
        "studies have scores and no pins: κ is by CASR there"
    )
    return Table("claims_calibrated", caption, _RIGHT, rows)


def _row(each: Judged, test: PaperTest) -> dict[str, Cell]:
    claim = each.claim
    return {
        "says": _capital(claim.says),
        "verdict": each.verdict,
        "here": f"{claim.estimand}: {_said(each)}",
        "margin": f"{number(claim.margin * claim.factor, 2)} or {'more' if claim.asserts == 'more' else 'less'}",
        "unit": _UNITS[claim.unit],
        "algorithm": claim.algorithm,
        "paper": test.printed,
        "own_test": test.here,
        "why": claim.why,
    }


def _said(each: Judged, unit: str = "") -> str:
    estimate, low, high = (value * each.claim.factor for value in (each.claim.found.estimate, each.low, each.high))
    if not np.isfinite(estimate):
        return "not known"
    shown = f"{number(estimate)} {unit}".rstrip()
    if low == high:
        return shown
    return f"{shown} {ends(low, high)}" if low == low else f"{shown}, no interval"


def _setting_tests(results: StudyResults, q: Quantities) -> dict[str, PaperTest]:
    """Exact numbers as people know them."""
    schedule, filtered = results.study.schedule, arithmetic.FILTER
    worst = min((s.plate_adjusted_r2 for s in results.study.specimens if s.plate_adjusted_r2 is not None), default=None)
    low, high = schedule.stiffness_percent
    new, power = results.study.profile.new_specimen, q.get("power.study")
    alpha = float(q.get(f"profiles.{new}.alpha", np.nan))
    return {
        "plate_line": PaperTest("a line", f"adj. R² ≥ {bounded(worst, 4)}" if worst else ""),
        "plate_r2": PaperTest("adj. R² ≥ .882", UNDEFINED if worst is None else f"adj. R² ≥ {bounded(worst, 4)}"),
        "curves": PaperTest("700 curves", f"{q.get('fit.curves')} of {q.get('trials.total')} presses"),
        "power": PaperTest("power about .80", "" if power is None else f"{bounded(float(power))} between repetitions"),
        "interpolation_weight": PaperTest("α = .532", f"α = {number(alpha, 4)}"),
        "schedule_range": PaperTest("20 to 80 %, 0.3 N", f"{low:g} to {high:g} %, {schedule.step_n:g} N"),
        "force_filter": PaperTest(
            "5 Hz, 500 ms", f"{filtered.cutoff_hz:.0f} Hz, {1e3 * filtered.delay_s:.0f} ms"
        ),
        "kappa_curves": PaperTest(
            "; ".join(f"{level:g} exp({rate:g} x)" for level, rate in paper.CURVES.values()),
            f"S5 : S1 of {', '.join(number(paper.implied_ratio(angle), 2) for angle in paper.CURVES)} implied, "
            f"{number(paper.largest_ratio(), 2)} possible",
        ),
    }  # fmt: skip


def verdict_drawings(judged: Sequence[Judged]) -> Iterator[Drawing]:
    """All verdicts on data; nothing where no claim has an estimate."""
    of_data = [each for each in judged if each.claim.question != arithmetic.QUESTION]
    if any(np.isfinite(each.claim.found.estimate) for each in of_data):
        caption = (
            f"Fig. V. Claims on data with {_level(of_data)} intervals in units of the smallest difference "
            "that matters. A claim holds where its line lies wholly in the green; no line: no estimate. "
            "Figures bear the numbers of the paper."
        )
        told = " ".join(map(sentence, of_data))
        yield Drawing("figverdicts", "Verdicts", caption, told, draw_verdicts(of_data))


_OF_PEOPLE = "Do people stiffen the finger as they press harder, and by another curve for each specimen?"
_OF_RUNS = "Does a rig that takes over people's stiffness tell specimens apart better than a rigid one?"


def summary(results: StudyResults, judged: Sequence[Judged]) -> Iterator[str]:
    """The question, how many claims hold, what lacks, and a sentence on the main claims that the study has data on."""
    yield " ".join([_OF_PEOPLE] * (results.people is not None) + [_OF_RUNS] * (results.runs is not None))
    if results.people is None:
        yield (
            "No recording of people could be used."
            if results.study.recordings
            else "The study has no recordings of people."
        )
    if results.runs is None:
        yield "The study has no scored runs of the rig, so claims on the rig are left out."
    judged = [each for each in judged if each.claim.question != arithmetic.QUESTION]
    if judged:
        found = Counter(each.verdict for each in judged)
        said = (f"{found[name]} {'is' if found[name] == 1 else 'are'} {name}" for name in ("refuted", "not determined"))
        holds = f"{found['holds']} {'holds' if found['holds'] == 1 else 'hold'}"
        yield f"Of {count(len(judged), 'claim')} on data, {', '.join((holds, *said))}."
    for each in judged:
        if each.claim.key in _SUMMARY:
            moved = results.registered is not None and "deviates" in results.registered.state(each)
            told = sentence(each), told_of_paths(results, each.claim.key)
            yield " ".join(filter(None, (*told, "This verdict deviates from the registered plan." * moved)))
    if results.people is not None and results.people.hypotheses is not None:
        misfits = results.people.hypotheses.misfits
        off = [misfits.of(0, person).told for person in range(misfits.participant.size)]
        beside = f" The presses of {off.count(True)} of {len(off)} people contradict it." if any(off) else ""
        yield misfits.said(results.people.fits.activity_unit) + beside


def sentence(each: Judged) -> str:
    """``Holds: specimens differ. The smallest difference of b is 31.2 % of the mean [18.0, 44.4].``"""
    claim = each.claim
    what, _, unit = claim.estimand.partition(", ")
    said = f"{_capital(each.verdict)}: {claim.says}. The {what} is {_said(each, unit)}."
    return f"{said} {claim.why}".rstrip()


_TEXT = """
{% for sentence in summary if sentence %}
<p{% if loop.first %} class="say"{% endif %}>{{ sentence }}</p>
{% endfor %}
{{ figure("figverdicts") }}
{% if has("claims") %}
{{ folded("claims", "Every claim: interval, algorithm, unit of error, and the paper's own test") }}
{{ folded("claims_on_settings", "Claims on settings and arithmetic") }}
{{ folded("claims_calibrated", "How often each claim is right") }}
{% endif %}
"""

CLAIMS = Section("claims", "Summary", _TEXT)
