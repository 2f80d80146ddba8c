"""What the paper claims in numbers of the rig's runs (section VI and Discussion), beside what this study finds.

Every claim is judged by the quantities alone. "Here" is the paper's own test, and for κ its algorithms (circle: old;
paper: its hexagons and equations) with its exponential law; the companion is the study's own choice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from emg2vsa.report import paper
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import Claim, Quantities, Verdict, not_tested, verdict_of_all
from emg2vsa.report.verdicts import dunn_bounds
from emg2vsa.report.wording import NO_BREAK, bounded, exact_p, number, p_text, signed
from emg2vsa.rig.executor.motion import MovingAverage
from emg2vsa.statistics.kruskal import kruskal

_RIGID, _HUMAN_LIKE = "high-stiffness", "modular"
_OLD, _NEW = "circle", "paper"
_CONSTANT = ("constant-min", "constant-mean", "constant-max")
_NOT_PRESSED = "Accepted presses are missing."
_POWERLESS = "Neighbours cannot reach significance."
_PARTLY = "Not every angle was tested."
_TOO_FEW = "So few presses cannot reach significance."
_NOT_EQUAL = "Not rejected is not equal."
_NOT_HEXAGON = "The area rule of this study is not of hexagons."
_UNTESTED: Verdict = "cannot be tested here"


def _verdict(known: bool, holds: bool) -> Verdict:
    return _UNTESTED if not known else "holds" if holds else "does not hold"


def _missing(results: StudyResults, designs: Iterable[tuple[str, float]]) -> list[str]:
    """Specimens of the rig, of known stiffness, of which a design has no press that was accepted, with that design."""
    accepted = {
        (run.specimen, run.condition, run.angle_deg)
        for run in results.pressed.scores
        if set(run.verdicts) - {"rejected"}
    }
    pressed = {run.specimen for run in results.pressed.scores} | {run.specimen for run in results.study.runs}
    known = sorted(pressed & results.study.stiffness_n_per_mm.keys() - {results.study.profile.new_specimen})
    return [f"{name} {c} {angle:g}°" for c, angle in designs for name in known if (name, c, angle) not in accepted]


def _on_all(known: bool, holds: bool, missing: Sequence[str]) -> Verdict:
    """A claim on all specimens can be refuted by some of them, and is confirmed by all of them only."""
    return _verdict(known and not (holds and missing), holds)


def _of(q: Quantities, keys: Sequence[str]) -> np.ndarray:
    """The numbers under ``keys``, NaN for those that are absent."""
    return np.array([float(q.get(key, np.nan)) for key in keys])


def _largest(values: np.ndarray) -> float:
    """NaN as soon as one is."""
    return float(np.max(values))


def area_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """Does the initial area depend on the specimen and on the angle?"""
    alpha = results.study.discrimination.alpha
    angles = list(paper.AREA_SPECIMENS_P)
    p = _of(q, [f"runs.{_RIGID}.{angle:g}.area.specimens_p" for angle in angles])
    ratio = _of(q, [f"runs.{_RIGID}.{angle:g}.area.softest_over_stiffest" for angle in angles])
    known = bool(np.isfinite(p).all())
    missing = _missing(results, [(_RIGID, angle) for angle in angles])
    alike = bool((p >= alpha).all())
    powerless = known and alike and not _can_reject(results, alpha)
    said = _said(not_tested(missing), _NOT_EQUAL if alike else "")
    yield Claim(
        "area_same_on_specimens",
        "initial area is the same on all specimens (Kruskal-Wallis)",
        f"p = {', '.join(bounded(each, 2) for each in paper.AREA_SPECIMENS_P.values())}",
        p_text(float(p.min())) if known else "not tested",
        float(p.min()),
        _on_all(known and not powerless, alike, missing),
        companion=f"softest : stiffest up to {ratio.max():.2f}" if known else "",
        why=_TOO_FEW if powerless else said if known else _NOT_PRESSED,
    )
    worst = float(q.get(f"runs.{_RIGID}.area.angles.worst_p", np.nan))
    alone = [key for key in q if key.startswith(f"runs.{_RIGID}.area.angles.") and key.endswith(".worst_p")]
    alone = [key for key in alone if key != f"runs.{_RIGID}.area.angles.worst_p"]
    yield Claim(
        "area_changes_with_angle",
        "initial area differs between all angles (Dunn)",
        f"worst p = {_power(paper.AREA_ANGLES_WORST_P)}",
        p_text(worst) if worst == worst else "not tested",
        worst,
        _on_all(worst == worst, worst < alpha, missing),
        companion=f"specimens alone: {p_text(_largest(_of(q, alone)))}" if alone else "",
        why=(not_tested(missing) or "Pooling mixes specimens.") if worst == worst else _NOT_PRESSED,
    )


def _power(value: float) -> str:
    """``3.1 × 10⁻⁵``, as the paper prints it."""
    exponent = int(np.floor(np.log10(value)))
    superscript = str(exponent).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
    return f"{value / 10.0**exponent:.1f}{NO_BREAK}×{NO_BREAK}10{superscript}"


def rate_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """Does CASR tell the specimens apart?"""
    alpha = results.study.discrimination.alpha
    for key, says, conditions in (
        ("casr_rigid", "rigid motor", (_RIGID,)),
        ("casr_human_like", "human-like stiffness", (_HUMAN_LIKE,)),
        ("casr_constant", "constant stiffness", _CONSTANT),
    ):
        designs = [design for design in paper.CASR_WORST_P if design[0] in conditions]
        names = [f"runs.{condition}.{angle:g}.casr.worst_p" for condition, angle in designs]
        p, holm = _of(q, names), _of(q, [f"{name}.holm" for name in names])
        known, missing = bool(np.isfinite(p).all()), _missing(results, designs)
        powerless = known and _largest(p) >= alpha and _bound(results, neighbours=False) >= alpha
        printed = dict.fromkeys(exact_p(paper.CASR_WORST_P[design]) for design in designs)
        yield Claim(
            key,
            f"CASR tells specimens apart, {says} (Dunn)",
            f"worst p = {', '.join(printed)}",
            p_text(_largest(p)) if known else "not tested",
            _largest(p),
            _on_all(known and not powerless, bool((p < alpha).all()), missing),
            companion=f"Mann-Whitney: {p_text(_largest(holm))}" if known else "",
            why=_POWERLESS if powerless else not_tested(missing) if known else _NOT_PRESSED,
        )
    yield _order(results, q, 10, _RIGID, "rigid motor")
    yield _order(results, q, 12, _HUMAN_LIKE, "human-like stiffness")
    yield from _new_specimen(results, q, alpha)
    yield _discriminated(results, q)


def _order(results: StudyResults, q: Quantities, figure: int, condition: str, says: str) -> Claim:
    """Figs 10 and 12: the softer the larger, the new specimen in its place."""
    designs = [design for design in paper.CASR_WORST_P if design[0] == condition]
    names = [f"runs.{condition}.{angle:g}" for _, angle in designs]
    found = [(q.get(f"{name}.casr.rises"), q.get(f"{name}.new.between")) for name in names]
    known = [each for each in found if None not in each]
    right, missing = sum(all(each) for each in known), _missing(results, designs)
    new = results.study.profile.new_specimen or "the new specimen"
    return Claim(
        f"fig{figure}_order",
        f"CASR rises with softness, {new} in its place, {says}",
        f"{len(designs)} of {len(designs)} angles",
        f"{right} of {len(known)} angles" if known else "not tested",
        right if known else np.nan,
        verdict_of_all(refuted=right < len(known), complete=len(known) == len(designs) and not missing),
        why=(not_tested(missing) or _PARTLY * (len(known) < len(designs))) if known else _NOT_PRESSED,
    )


def _discriminated(results: StudyResults, q: Quantities) -> Claim:
    """Fig. 13: at the mean and the highest level the new specimen is told from both neighbours."""
    designs = [(condition, 0.0) for condition in paper.ERROR_CONSTANT]
    alpha = results.study.discrimination.alpha
    p = {
        test: _of(q, [f"runs.{c}.0.new.{side}_{test}" for c, _ in designs for side in ("stiffer", "softer")])
        for test in ("mean_rank_p", "p")
    }
    worst, known = _largest(p["mean_rank_p"]), bool(np.isfinite(p["mean_rank_p"]).all())
    powerless = known and worst >= alpha and _bound(results) >= alpha
    new = results.study.profile.new_specimen or "the new specimen"
    return Claim(
        "fig13_new_specimen",
        f"mean and highest stiffness tell {new} from its neighbours (Dunn)",
        "told apart",
        p_text(worst) if known else "not tested",
        worst,
        _verdict(known and not powerless, worst < alpha),
        companion=f"Mann-Whitney: {p_text(_largest(p['p']))}" if np.isfinite(p["p"]).all() else "",
        why=_POWERLESS if powerless else "" if known else _NOT_PRESSED,
    )


def _bound(results: StudyResults, *, neighbours: bool = True) -> float:
    """The least p that the paper's test can give the worst pair; NaN where the specimens' presses differ in number.

    neighbours : among all specimens, as of the new one; else among those of known stiffness.
    """
    if results.pressed.discrimination is None:
        return np.nan
    table = results.pressed.discrimination.table
    count = np.isfinite(table.casr[table.algorithm]).sum(axis=2)[0]
    bounds = dunn_bounds(count if neighbours else count[table.known])
    return bounds[1] if bounds else np.nan


def _can_reject(results: StudyResults, alpha: float) -> bool:
    """Whether Kruskal and Wallis' test of the specimens can reject with so few presses: as if none overlapped."""
    if results.pressed.discrimination is None:
        return True
    table = results.pressed.discrimination.table
    count = np.isfinite(table.casr[table.algorithm]).sum(axis=2)[0][table.known]
    apart = np.full((count.size, max(int(count.max(initial=0)), 1)), np.nan)
    for i, n in enumerate(count.tolist()):
        apart[i, :n] = np.arange(n) + 1e3 * i
    return bool(kruskal(apart).p < alpha)


def _said(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


def _new_specimen(results: StudyResults, q: Quantities, alpha: float) -> Iterator[Claim]:
    name = "runs.constant-min.0.new"
    dunn, exact = (float(q.get(f"{name}.{key}", np.nan)) for key in ("stiffer_mean_rank_p", "stiffer_p"))
    known, powerless = dunn == dunn, _bound(results) >= alpha
    new = results.study.profile.new_specimen or "the new specimen"
    yield Claim(
        "new_specimen_at_minimum",
        f"lowest stiffness does not tell {new} from its stiffer neighbour (Dunn)",
        f"p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}",
        p_text(dunn) if known else "not tested",
        dunn,
        _verdict(known and not (powerless and dunn >= alpha), dunn >= alpha),
        companion=f"Mann-Whitney: {p_text(exact)}" if known else "",
        why=(_POWERLESS if powerless else _NOT_EQUAL if dunn >= alpha else "") if known else _NOT_PRESSED,
    )


def kappa_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """How well is the stiffness of the new specimen found?"""
    for key, what, conditions, printed in (
        ("rigid", "rigid motor", (_RIGID,), paper.ERROR_NEW_VISION),
        ("human_like", "human-like stiffness", (_HUMAN_LIKE,), paper.ERROR_HUMAN_LIKE),
        ("constant", "constant stiffness", tuple(paper.ERROR_CONSTANT), None),
    ):
        designs = (
            [(conditions[0], angle) for angle in printed] if printed else [(condition, 0.0) for condition in conditions]
        )
        errors = list(printed.values()) if printed else list(paper.ERROR_CONSTANT.values())
        yield _fit(q, key, what, designs, conditions, results)
        yield _error(q, key, what, designs, errors, results)
    yield _curves()


def _curves() -> Claim:
    """The unit of CASR cancels in the ratio of two specimens, which contact mechanics bounds."""
    implied, bound = [paper.implied_ratio(angle) for angle in paper.CURVES], paper.largest_ratio()
    return Claim(
        "kappa_curves",
        "one exponential curve for each angle gives κ of CASR",
        "; ".join(f"{level:g} exp({rate:g} x)" for level, rate in paper.CURVES.values()),
        f"S5 : S1 of {', '.join(number(ratio, 2) for ratio in implied)} implied",
        max(implied),
        _verdict(True, max(implied) <= bound),
        why=f"Contact mechanics allows a ratio of {number(bound, 2)} at most.",
    )


def _fit(
    q: Quantities,
    key: str,
    what: str,
    designs: Sequence[tuple[str, float]],
    conditions: Sequence[str],
    results: StudyResults,
) -> Claim:
    own, missing = results.study.scoring.algorithm, _missing(results, designs)
    r2, companion = (
        _of(q, [f"runs.{c}.{angle:g}.{algorithm}.kappa.paper_law.adj_r2" for c, angle in designs])
        for algorithm in (_NEW, own)
    )
    printed = min(paper.WORST_ADJ_R2[condition] for condition in conditions)
    slope = _of(q, [f"runs.{c}.{angle:g}.{_NEW}.kappa.paper_law.parameter.second" for c, angle in designs])
    rising = int(np.count_nonzero(slope > 0))
    known, undetermined = bool(np.isfinite(r2).all()), _undetermined(q, [(c, angle, _NEW) for c, angle in designs])
    holds = bool((slope < 0).all()) and float(r2.min()) >= printed
    tested = _hexagons(results) and not (holds and undetermined)
    return Claim(
        f"kappa_fit_{key}",
        f"an exponential law gives κ, {what}",
        f"adj. R² ≥ {bounded(printed, 4)}",
        bounded(float(r2.min())) if known else "not defined",
        float(r2.min()),
        _on_all(known and tested, holds, missing),
        companion=f"by {own}: {bounded(float(companion.min()))}"
        if own != _NEW and np.isfinite(companion).all()
        else "",
        why=_NOT_HEXAGON
        if not _hexagons(results)
        else _said(
            not_tested(missing),
            f"κ rises with CASR in {rising} of {slope.size} designs, against the paper's." if rising else "",
            undetermined if holds else "",
        )
        if known
        else "Not every design gives a law.",
    )


def _error(
    q: Quantities,
    key: str,
    what: str,
    designs: Sequence[tuple[str, float]],
    printed: Sequence[float],
    results: StudyResults,
) -> Claim:
    own = results.study.scoring.algorithm
    here = _of(q, [f"runs.{c}.{angle:g}.{_NEW}.kappa.paper_law.error" for c, angle in designs])
    mine = _of(q, [f"runs.{c}.{angle:g}.{own}.kappa.error" for c, angle in designs])
    known, undetermined = bool(np.isfinite(here).all()), _undetermined(q, [(c, angle, _NEW) for c, angle in designs])
    small = bool((np.abs(here) < np.array(printed) + _ROUNDED).all())
    return Claim(
        f"kappa_error_{key}",
        f"the error of κ is small, {what}",
        f"{', '.join(number(100 * error, 2) for error in printed)}{NO_BREAK}%",
        _percents(here) if known else "not defined",
        float(np.abs(here).max()),
        _verdict(known and _hexagons(results) and not (small and undetermined), small),
        companion=f"by {own}: {_percents(mine)}" if own != _NEW and np.isfinite(mine).all() else "",
        why=(("" if not small else undetermined) if known else _no_kappa(q)) if _hexagons(results) else _NOT_HEXAGON,
    )


def _percents(errors: np.ndarray) -> str:
    return f"{', '.join(signed(100 * error) for error in errors.tolist())}{NO_BREAK}%"


def _hexagons(results: StudyResults) -> bool:
    """Whether the algorithm "paper" of this study has its hexagons: its keys can set another rule of the area."""
    return results.study.scoring.recipe_of(_NEW).area_rule in ("paper", "hexagon")


def _undetermined(q: Quantities, designs: Iterable[tuple[str, float, str]]) -> str:
    """Says so where the intervals of κ are wider than the range of the known stiffnesses: agreement may be chance.

    designs : condition, angle and vision algorithm.
    """
    found = [bool(q.get(f"runs.{c}.{angle:g}.{name}.kappa.paper_law.determined", True)) for c, angle, name in designs]
    if all(found):
        return ""
    return f"Determined in {found.count(True)} of {len(found)} designs."


def _no_kappa(q: Quantities) -> str:
    known = float(q.get("runs.kappa.known_n_per_mm", np.nan))
    return "The scores determine no κ." if known == known else "κ of the new specimen is not known."


_ROUNDED = 0.005
"""The paper prints errors in whole percents."""


def reduction_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """The Discussion: by how many percentage points each step makes the error of κ smaller."""
    own = results.study.scoring.algorithm
    steps = (
        ("vision", "hexagons, not the circle, cut the error of κ", (_RIGID, _OLD), (_RIGID, _NEW), (30.0, 45.0),
         "18, 15 points"),
        ("human_like", "human-like stiffness cuts it further", (_RIGID, _NEW), (_HUMAN_LIKE, _NEW), (30.0, 45.0),
         "4, 9 points"),
        ("both", "both together cut it", (_RIGID, _OLD), (_HUMAN_LIKE, _NEW), (0.0, 30.0, 45.0),
         f"3 (50{NO_BREAK}%), 22, 24 points"),
    )  # fmt: skip
    for key, says, before, after, angles, printed in steps:
        here = _reduction(q, before, after, angles, "paper_law.error")
        swap = {_NEW: own}
        mine = _reduction(
            q, (before[0], swap.get(before[1], before[1])), (after[0], swap.get(after[1], after[1])), angles, "error"
        )
        known, smaller = bool(np.isfinite(here).all()), bool((here > 0).all())
        undetermined = _undetermined(q, [(c, angle, name) for c, name in (before, after) for angle in angles])
        yield Claim(
            f"reduction_{key}",
            f"{says}, {'/'.join(f'{angle:g}' for angle in angles)}°",
            printed,
            _points(here) if known else "not defined",
            float(here.min()),
            _verdict(known and _hexagons(results) and not undetermined, smaller),
            companion=f"by {own}: {_points(mine)}" if own != _NEW and np.isfinite(mine).all() else "",
            why=(undetermined if known else _no_kappa(q)) if _hexagons(results) else _NOT_HEXAGON,
        )
    yield _levels(q)


def _reduction(
    q: Quantities, before: tuple[str, str], after: tuple[str, str], angles: Sequence[float], error: str
) -> np.ndarray:
    """Size of the error before less that after, in percentage points."""
    old, new = (
        np.abs(_of(q, [f"runs.{condition}.{angle:g}.{algorithm}.kappa.{error}" for angle in angles]))
        for condition, algorithm in (before, after)
    )
    return np.asarray(100 * (old - new))


def _points(values: np.ndarray) -> str:
    return f"{', '.join(signed(value) for value in values.tolist())} points"


def _levels(q: Quantities) -> Claim:
    verdicts = [str(q.get(f"runs.human_like_against.{level}.0.verdict", "")) for level in _CONSTANT]
    known = all(verdicts)
    better = verdicts.count("better")
    undecided = verdicts.count("undecided")
    return Claim(
        "constant_levels",
        "the profile tells specimens apart better than one stiffness",
        "3 of 3 levels",
        f"{better} of 3 better, {undecided} undecided" if known else "not tested",
        better if known else np.nan,
        _UNTESTED if not known or undecided == len(_CONSTANT) else _verdict(True, better == len(_CONSTANT)),
        why=_NOT_PRESSED if not known else "The intervals include zero." if undecided else "",
    )


def filter_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """The filter of the force, as the paper describes it."""
    average = MovingAverage(5, 200.0)
    yield Claim(
        "force_filter",
        "a mean of five samples at 200 Hz cuts off at 5 Hz and delays by 0.5 s",
        f"5{NO_BREAK}Hz, 500{NO_BREAK}ms",
        f"{average.cutoff_hz:.0f}{NO_BREAK}Hz, {1e3 * average.delay_s:.0f}{NO_BREAK}ms",
        average.cutoff_hz,
        "does not hold",
    )
