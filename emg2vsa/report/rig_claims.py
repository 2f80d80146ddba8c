"""What the paper claims in numbers of the rig's runs (section VI and Discussion), beside what this study finds.

Every claim is judged by the quantities alone. "Here" is the paper's own test, and for κ its algorithms (circle: old;
paper: its hexagons and equations) with its exponential law; the companion is the study's own choice.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np

from emg2vsa.report import paper
from emg2vsa.report.companion_rows import dunn_bounds
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import Claim, Quantities, judged, not_tested
from emg2vsa.report.wording import NO_BREAK, bounded, exact_p, number, p_text, signed
from emg2vsa.rig.executor.motion import MovingAverage
from emg2vsa.statistics.kruskal import kruskal

_RIGID, _HUMAN_LIKE = "high-stiffness", "modular"
_OLD, _NEW = "circle", "paper"
_CONSTANT = ("constant-min", "constant-mean", "constant-max")
_POWERLESS = "Neighbours cannot reach significance."
_PARTLY = "Not every angle was tested."
_TOO_FEW = "So few presses cannot reach significance."
_NOT_EQUAL = "Not rejected is not equal."
_NOT_HEXAGON = "The area rule of this study is not of hexagons."


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
    known, alike = bool(np.isfinite(p).all()), bool((p >= alpha).all())
    missing = _missing(results, [(_RIGID, angle) for angle in angles])
    yield judged(
        "area_same_on_specimens", "initial area is the same on all specimens (Kruskal-Wallis)",
        f"p = {', '.join(bounded(each, 2) for each in paper.AREA_SPECIMENS_P.values())}", p_text(float(p.min())),
        float(p.min()), alike, known=known, missing=missing,
        untested=_TOO_FEW if known and alike and not _can_reject(results, alpha) else "",
        why=_said(not_tested(missing), _NOT_EQUAL if alike else ""),
        companion=f"softest : stiffest up to {ratio.max():.2f}" if known else "",
    )  # fmt: skip
    begin, end = f"runs.{_RIGID}.area.angles", ".worst_p"
    worst = float(q.get(begin + end, np.nan))
    alone = [key for key in q if key.startswith(f"{begin}.") and key.endswith(end) and key != begin + end]
    yield judged(
        "area_changes_with_angle", "initial area differs between all angles (Dunn)",
        f"worst p = {_power(paper.AREA_ANGLES_WORST_P)}", p_text(worst), worst, worst < alpha, known=worst == worst,
        missing=missing, why=not_tested(missing) or "Pooling mixes specimens.",
        companion=f"specimens alone: {p_text(_largest(_of(q, alone)))}" if alone else "",
    )  # fmt: skip


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
        printed = dict.fromkeys(exact_p(paper.CASR_WORST_P[design]) for design in designs)
        powerless = known and _largest(p) >= alpha and _bound(results, neighbours=False) >= alpha
        yield judged(
            key, f"CASR tells specimens apart, {says} (Dunn)", f"worst p = {', '.join(printed)}", p_text(_largest(p)),
            _largest(p), bool((p < alpha).all()), known=known, missing=missing,
            untested=_POWERLESS if powerless else "", why=not_tested(missing),
            companion=f"Mann-Whitney: {p_text(_largest(holm))}" if known else "",
        )  # fmt: skip
    yield _order(results, q, 10, _RIGID, "rigid motor")
    yield _order(results, q, 12, _HUMAN_LIKE, "human-like stiffness")
    yield _at_minimum(results, q, alpha)
    yield _discriminated(results, q, alpha)


def _order(results: StudyResults, q: Quantities, figure: int, condition: str, says: str) -> Claim:
    """Figs 10 and 12: the softer the larger, the new specimen in its place."""
    designs = [design for design in paper.CASR_WORST_P if design[0] == condition]
    names = [f"runs.{condition}.{angle:g}" for _, angle in designs]
    found = [(q.get(f"{name}.casr.rises"), q.get(f"{name}.new.between")) for name in names]
    known = [each for each in found if None not in each]
    right, partly = sum(all(each) for each in known), [_PARTLY] * (len(known) < len(designs))
    missing = _missing(results, designs)
    return judged(
        f"fig{figure}_order", f"CASR rises with softness, {_new(results)} in its place, {says}",
        f"{len(designs)} of {len(designs)} angles", f"{right} of {len(known)} angles", right if known else np.nan,
        right == len(known), known=bool(known), missing=missing or partly, why=not_tested(missing) or "".join(partly),
    )  # fmt: skip


def _new(results: StudyResults) -> str:
    return results.study.profile.new_specimen or "the new specimen"


def _discriminated(results: StudyResults, q: Quantities, alpha: float) -> Claim:
    """Fig. 13: at the mean and the highest level the new specimen is told from both neighbours."""
    sides = [f"runs.{condition}.0.new.{side}" for condition in paper.ERROR_CONSTANT for side in ("stiffer", "softer")]
    p, exact = (_of(q, [f"{side}_{test}" for side in sides]) for test in ("mean_rank_p", "p"))
    worst, known = _largest(p), bool(np.isfinite(p).all())
    return judged(
        "fig13_new_specimen", f"mean and highest stiffness tell {_new(results)} from its neighbours (Dunn)",
        "told apart", p_text(worst), worst, worst < alpha, known=known,
        untested=_POWERLESS if known and worst >= alpha and _bound(results) >= alpha else "",
        companion=f"Mann-Whitney: {p_text(_largest(exact))}" if np.isfinite(exact).all() else "",
    )  # fmt: skip


def _counts(results: StudyResults, *, neighbours: bool) -> np.ndarray:
    """Presses with a CASR of each specimen; without ``neighbours`` of those of known stiffness alone."""
    assert results.pressed.discrimination is not None
    table = results.pressed.discrimination.table
    count = np.isfinite(table.casr[table.algorithm]).sum(axis=2)[0]
    return np.asarray(count if neighbours else count[table.known])


def _bound(results: StudyResults, *, neighbours: bool = True) -> float:
    """The least p that the paper's test can give the worst pair; NaN where the specimens' presses differ in number.

    neighbours : among all specimens, as of the new one; else among those of known stiffness.
    """
    tested = results.pressed.discrimination is not None
    bounds = dunn_bounds(_counts(results, neighbours=neighbours)) if tested else None
    return bounds[1] if bounds else np.nan


def _can_reject(results: StudyResults, alpha: float) -> bool:
    """Whether Kruskal and Wallis' test of the specimens can reject with so few presses: as if none overlapped."""
    if results.pressed.discrimination is None:
        return True
    count = _counts(results, neighbours=False)
    apart = np.full((count.size, max(int(count.max(initial=0)), 1)), np.nan)
    for i, n in enumerate(count.tolist()):
        apart[i, :n] = np.arange(n) + 1e3 * i
    return bool(kruskal(apart).p < alpha)


def _said(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


def _at_minimum(results: StudyResults, q: Quantities, alpha: float) -> Claim:
    name = "runs.constant-min.0.new"
    dunn, exact = (float(q.get(f"{name}.{key}", np.nan)) for key in ("stiffer_mean_rank_p", "stiffer_p"))
    alike = dunn >= alpha
    return judged(
        "new_specimen_at_minimum", f"lowest stiffness does not tell {_new(results)} from its stiffer neighbour (Dunn)",
        f"p = {exact_p(paper.NEW_MIN_STIFFNESS_P)}", p_text(dunn), dunn, alike, known=dunn == dunn,
        untested=_POWERLESS if alike and _bound(results) >= alpha else "", why=_NOT_EQUAL if alike else "",
        companion=f"Mann-Whitney: {p_text(exact)}" if dunn == dunn else "",
    )  # fmt: skip


def kappa_claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    """How well is the stiffness of the new specimen found?"""
    constant = {(condition, 0.0): error for condition, error in paper.ERROR_CONSTANT.items()}
    for key, what, printed in (
        ("rigid", "rigid motor", {(_RIGID, angle): error for angle, error in paper.ERROR_NEW_VISION.items()}),
        (
            "human_like",
            "human-like stiffness",
            {(_HUMAN_LIKE, angle): error for angle, error in paper.ERROR_HUMAN_LIKE.items()},
        ),
        ("constant", "constant stiffness", constant),
    ):
        yield _fit(results, q, key, what, list(printed))
        yield _error(results, q, key, what, printed)
    yield _curves()


def _curves() -> Claim:
    """The unit of CASR cancels in the ratio of two specimens, which contact mechanics bounds."""
    implied, bound = [paper.implied_ratio(angle) for angle in paper.CURVES], paper.largest_ratio()
    return judged(
        "kappa_curves", "one exponential curve for each angle gives κ of CASR",
        "; ".join(f"{level:g} exp({rate:g} x)" for level, rate in paper.CURVES.values()),
        f"S5 : S1 of {', '.join(number(ratio, 2) for ratio in implied)} implied", max(implied), max(implied) <= bound,
        why=f"Contact mechanics allows a ratio of {number(bound, 2)} at most.",
    )  # fmt: skip


_Design = tuple[str, float]
"""Condition and angle."""


def _fit(results: StudyResults, q: Quantities, key: str, what: str, designs: Sequence[_Design]) -> Claim:
    own, missing = results.study.scoring.algorithm, _missing(results, designs)
    r2, companion = (_laws(q, designs, algorithm, "adj_r2") for algorithm in (_NEW, own))
    printed = min(paper.WORST_ADJ_R2[condition] for condition, _ in designs)
    slope = _laws(q, designs, _NEW, "parameter.second")
    rising = int(np.count_nonzero(slope > 0))
    holds = bool((slope < 0).all()) and float(r2.min()) >= printed
    undetermined = _undetermined(q, [(*design, _NEW) for design in designs]) if holds else ""
    rises = f"κ rises with CASR in {rising} of {slope.size} designs, against the paper's." if rising else ""
    said = _said(not_tested(missing), rises, undetermined)
    known = bool(np.isfinite(r2).all())
    claim = judged(
        f"kappa_fit_{key}", f"an exponential law gives κ, {what}", f"adj. R² ≥ {bounded(printed, 4)}",
        bounded(float(r2.min())), float(r2.min()), holds, known=known, missing=missing,
        untested=said if undetermined else "", why=said, companion=f"by {own}: {bounded(float(companion.min()))}"
        if own != _NEW and np.isfinite(companion).all() else "",
        absent=("not defined", "Not every design gives a law."),
    )  # fmt: skip
    return _of_hexagons(results, claim)


def _laws(q: Quantities, designs: Sequence[_Design], algorithm: str, key: str) -> np.ndarray:
    """A number of the paper's law in each design."""
    return _of(q, [f"runs.{c}.{angle:g}.{algorithm}.kappa.paper_law.{key}" for c, angle in designs])


def _error(results: StudyResults, q: Quantities, key: str, what: str, printed: Mapping[_Design, float]) -> Claim:
    own = results.study.scoring.algorithm
    here = _laws(q, list(printed), _NEW, "error")
    mine = _of(q, [f"runs.{c}.{angle:g}.{own}.kappa.error" for c, angle in printed])
    small = bool((np.abs(here) < np.array([*printed.values()]) + _ROUNDED).all())
    claim = judged(
        f"kappa_error_{key}", f"the error of κ is small, {what}",
        f"{', '.join(number(100 * error, 2) for error in printed.values())}{NO_BREAK}%", _percents(here),
        float(np.abs(here).max()), small, known=bool(np.isfinite(here).all()),
        untested=_undetermined(q, [(*design, _NEW) for design in printed]) if small else "",
        companion=_by(own, mine, _percents(mine)), absent=("not defined", _no_kappa(q)),
    )  # fmt: skip
    return _of_hexagons(results, claim)


def _by(own: str, values: np.ndarray, said: str) -> str:
    """What the algorithm of the study says, where that is another one."""
    return f"by {own}: {said}" if own != _NEW and np.isfinite(values).all() else ""


def _percents(errors: np.ndarray) -> str:
    return f"{', '.join(signed(100 * error) for error in errors.tolist())}{NO_BREAK}%"


def _of_hexagons(results: StudyResults, claim: Claim) -> Claim:
    """Not to be tested where the algorithm "paper" of this study has no hexagons: keys can set another area rule."""
    if results.study.scoring.recipe_of(_NEW).area_rule in ("paper", "hexagon"):
        return claim
    return replace(claim, verdict="cannot be tested here", why=_NOT_HEXAGON)


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
        ours = [(condition, own if name == _NEW else name) for condition, name in (before, after)]
        mine = _reduction(q, ours[0], ours[1], angles, "error")
        claim = judged(
            f"reduction_{key}", f"{says}, {'/'.join(f'{angle:g}' for angle in angles)}°", printed, _points(here),
            float(here.min()), bool((here > 0).all()), known=bool(np.isfinite(here).all()),
            untested=_undetermined(q, [(c, angle, name) for c, name in (before, after) for angle in angles]),
            companion=_by(own, mine, _points(mine)), absent=("not defined", _no_kappa(q)),
        )  # fmt: skip
        yield _of_hexagons(results, claim)
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
    better, undecided = (verdicts.count(verdict) for verdict in ("better", "undecided"))
    zero = "The intervals include zero."
    return judged(
        "constant_levels", "the profile tells specimens apart better than one stiffness", "3 of 3 levels",
        f"{better} of 3 better, {undecided} undecided", better if all(verdicts) else np.nan, better == len(_CONSTANT),
        known=all(verdicts), untested=zero if undecided == len(_CONSTANT) else "", why=zero if undecided else "",
    )  # fmt: skip


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
