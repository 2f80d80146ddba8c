"""What the runs show, in sentences that are computed from the tests and not taken from the paper."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from emg2vsa.discrimination import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.report.runs_tables import design_name, gap_of, level_change
from emg2vsa.report.wording import bounded, count, interval, listed, number, p_text, percent
from emg2vsa.runs import RunScores
from emg2vsa.stats.kruskal import smallest_worst_p


def first_frames(runs: Sequence[RunScores], found: Discrimination) -> str:
    """Which areas are compared, and why not A_c0 as it is."""
    first_n = [curve.first_n for run in runs for curve in run.curves if curve.force_n.size]
    if found.table.algorithm == "paper" or not first_n:
        return "Compared is A_c0, the area of the first frame in contact, at whatever force that frame came."
    return (
        f"A_c0 is the area of the first frame in contact, and that frame came at {min(first_n):.2f} to "
        f"{max(first_n):.2f} N. Areas grow with force: compared are the areas at the force where loading begins, on "
        "the power law of each press."
    )


_ONE_PRESS = "a gap takes two scored presses or more of each specimen"
_ONE_MOUNTING = (
    "These intervals come from repeated presses within one mounting for each run: how far mounting again moves CASR is "
    "not in them."
)


def area_and_specimens(found: Discrimination) -> str:
    """Is the initial area independent of the specimen? No word of the paper's claim is taken from a p above alpha."""
    p, area, alpha = found.area.groups.kruskal.p, found.area, found.settings.alpha
    tested, differ = int(np.isfinite(p).sum()), int((p < alpha).sum())
    tost = area.equality.tost
    equal = int(np.sum(np.all(tost.p < alpha, axis=1))) if tost is not None else 0
    margin = percent(found.settings.equivalence_margin)
    ratio = _range(area.softest_over_stiffest)
    stiffest, softest = found.spread.specimens[0], found.spread.specimens[-1]
    size = f"The area on {softest}, the softest, is {ratio} times that on {stiffest}, the stiffest."
    if not tested:
        return "Initial areas could not be compared between specimens."
    if differ == 0 and equal == tested:
        return f"The initial area is the same on all specimens within ± {margin} in all of {tested} designs. {size}"
    if differ == 0:
        return (
            f"No difference of the initial area between specimens was found in {count(tested, 'design')}, but equality "
            f"within ± {margin} is shown in {equal} only. {size}"
        )
    return (
        f"The initial area differs between specimens in {differ} of {count(tested, 'design')}: the paper's claim that "
        f"it does not depend on the specimen does not hold here. {size} Contact mechanics expects this: at the same "
        "force a softer specimen is touched over a larger area."
    )


def area_and_angle(found: Discrimination) -> str:
    """Does the initial area change, and fall, with the angle?"""
    of, alpha = found.area_by_angle, found.settings.alpha
    if of is None:
        return "No condition was pressed at two angles."
    told = []
    for i, (condition, specimen) in enumerate(zip(of.conditions, of.specimens, strict=True)):
        if specimen:
            continue
        own = [j for j, name in enumerate(of.conditions) if name == condition and of.specimens[j]]
        pooled = "all pairs of angles differ" if of.worst_p(i) < alpha else "not all pairs of angles differ"
        each = sum(of.worst_p(j) < alpha for j in own)
        falls = "falls" if all(of.falls(j) for j in (i, *own)) else "does not always fall"
        mixed = "; pooling mixes specimens whose areas differ" if of.worst_p(i) >= alpha and each == len(own) else ""
        told.append(
            f"{condition.capitalize()}: with the specimens pooled {pooled} (worst pair {p_text(of.worst_p(i))}), for "
            f"{each} of {len(own)} specimens alone all do, and the mean area {falls} with every larger angle{mixed}."
        )
    return " ".join(told)


def specimens(found: Discrimination) -> str:
    """Does CASR tell the known specimens apart, softer ones larger?"""
    spread, table, alpha = found.spread, found.table, found.settings.alpha
    untested = {i: who for i in range(len(table.conditions)) if (who := table.unscored(i, spread.specimens))}
    tested = [i for i in range(len(table.conditions)) if i not in untested]
    failed = [design_name(table, i) for i in tested if not (spread.worst_p_holm[i] < alpha and spread.rises[i])]
    n, names = count(len(tested), "design"), listed(spread.specimens)
    told = (
        f"CASR tells {names} apart pair by pair, softer ones larger, in {len(tested) - len(failed)} of {n}; it does "
        f"not in {listed(failed)}."
        if failed
        else f"CASR tells {names} apart pair by pair in all of {n}, and every softer one has the larger."
    )
    lacking = listed([f"{design_name(table, i)} (no scored press of {listed(which)})" for i, which in untested.items()])
    return (told if tested else "") + (f" Not tested: {lacking}." if untested else "")


def new_specimen(found: Discrimination) -> str:
    """Is the new specimen told from its neighbours, and what could the paper's own test have said?"""
    new, table = found.new, found.table
    if new is None:
        return "No new specimen was pressed."
    if not all(new.neighbours):
        return _at_the_end(found)
    n = new.discriminated.size
    failed = [f"{design_name(table, i)} ({_why_not(found, i)})" for i in np.flatnonzero(~new.discriminated).tolist()]
    between = f"between {listed(new.neighbours)}"
    told = f"CASR of {new.name} lies {between} and is told from its neighbours in {n - len(failed)} of {n} designs"
    return f"{told}; not in {listed(failed)}." if failed else f"{told}."


def _why_not(found: Discrimination, design: int) -> str:
    new, table = found.new, found.table
    assert new is not None
    lacking = table.unscored(design, (new.name, *new.neighbours))
    if lacking:
        return f"no scored press of {listed(lacking)}"
    if not new.between[design]:
        return "it does not lie between"
    same = [new.neighbours[side] for side in (0, 1) if not new.p[design, side] < found.settings.alpha]
    side = new.neighbours.index(same[0])
    return f"not told from {listed(same)}, {p_text(float(new.p[design, side]))}"


def _at_the_end(found: Discrimination) -> str:
    """A new specimen that is the stiffest or the softest of all has one neighbour, or none."""
    new = found.new
    assert new is not None
    if not any(new.neighbours):
        return f"No other specimen was pressed beside {new.name}."
    side = 0 if new.neighbours[0] else 1
    end, size = (("softest", "larger"), ("stiffest", "smaller"))[side]
    shift = new.shift[:, side] * (1, -1)[side]
    told = np.count_nonzero((shift > 0) & (new.p[:, side] < found.settings.alpha))
    scored = int(np.count_nonzero(np.isfinite(shift)))
    return (
        f"{new.name} is the {end} of all and lies between no two. Its CASR is {size} than that of "
        f"{new.neighbours[side]}, and told from it, in {told} of {count(scored, 'design')} where both have scores."
    )


def mean_rank_bound(found: Discrimination) -> str:
    """What the paper's pairwise test can say of a specimen among all at the very best."""
    counts = np.isfinite(found.table.casr[found.table.algorithm]).sum(axis=2)
    k, n = counts.shape[1], int(counts.max(initial=0))
    bound = smallest_worst_p(k, n)
    if not bound >= found.settings.alpha:
        return ""
    return (
        f"The paper's pairwise test, Dunn's on the ranks of all specimens with Bonferroni's correction, cannot tell "
        f"neighbours apart here: even if {k} groups of {n} do not overlap, the worst pair of neighbours has "
        f"p = {bounded(bound)} or more. The .3799 that the paper prints for the lowest constant stiffness lies next to "
        "the bound for four groups of ten, .335, and says little against a difference. The verdicts above rest on "
        "exact Mann-Whitney tests."
    )


def vision(found: Discrimination) -> str:
    """Old against new algorithm on the presses of the rigid condition, the most tilted last."""
    compared, table, old = found.algorithms, found.table, found.settings.old_algorithm
    designs = table.of_condition(RIGID) or table.of_condition(table.conditions[0])
    if old not in compared.names[1:]:
        return f"The runs have no scores by {old}, the old algorithm."
    at = compared.names.index(old)
    told = [
        f"{table.angles_deg[i]:g}°: its area is {number(float(compared.area_ratio[at, i]))} times that of "
        f"{compared.names[0]}{_errors(found, at, i)}, CASR of repeated presses varies by "
        f"{percent(float(compared.casr_cv[at, i]))} against {percent(float(compared.casr_cv[0, i]))}, and the "
        f"gap between {listed(compared.pair)} is {number(compared.gap(at, i)[0])} against "
        f"{number(compared.gap(0, i)[0])} SD"
        for i in designs
    ]
    both = [i for i in designs if np.isfinite([compared.gap(0, i)[0], compared.gap(at, i)[0]]).all()]
    wins = sum(compared.gap(0, i)[0] > compared.gap(at, i)[0] for i in both)
    head = (
        f"{compared.names[0].capitalize()} (new) sets the specimens further apart than {old} (old) at {wins} of "
        f"{count(len(both), 'angle')}, {table.conditions[designs[0]]}"
        if both
        else f"{compared.names[0].capitalize()} (new) and {old} (old) cannot be compared by their gaps: {_ONE_PRESS}"
    )
    return f"{head}. {old.capitalize()} at {'; '.join(told)}."


def _errors(found: Discrimination, algorithm: int, design: int) -> str:
    error = found.algorithms.area_error[:, design]
    if np.isnan(error[algorithm]):
        return ""
    return f" (error {percent(float(error[algorithm]))} against {percent(float(error[0]))} of the true area)"


def actuators(found: Discrimination) -> str:
    """Does the human-like condition set specimens further apart than the rigid one?"""
    compared, table = found.conditions, found.table
    against = [i for i, other in enumerate(compared.other.tolist()) if table.conditions[other] == RIGID]
    if not against:
        return f"The conditions {HUMAN_LIKE} and {RIGID} were not both pressed at the same angle."
    against = [i for i in against if np.isfinite(compared.gap_differences.gap[i])]
    if not against:
        return f"Human-like stiffness and the rigid motor cannot be compared: {_ONE_PRESS}."
    better, worse = ([i for i in against if compared.wins(i) is verdict] for verdict in (True, False))
    n = count(len(against), "angle")
    if better or worse:
        less = f" and less far at {len(worse)}" if worse else ""
        head = (
            f"Human-like stiffness sets the specimens further apart than the rigid motor at {len(better)} of {n}{less}"
        )
    else:
        head = (
            f"Human-like stiffness does not win here: at none of {n} can its separation of the specimens be told from "
            "that of the rigid motor"
        )
    told = "; ".join(_difference(found, i) for i in against)
    return f"{head}. Gap between {listed(compared.pair)}, the closest neighbours, in SDs of their presses: {told}."


def constants(found: Discrimination) -> str:
    """The same against the constant levels of the profile; "" where none was pressed."""
    compared, table = found.conditions, found.table
    verdicts: dict[bool | None, list[str]] = {True: [], False: [], None: []}
    for i, other in enumerate(compared.other.tolist()):
        if table.conditions[other] != RIGID and np.isfinite(compared.gap_differences.gap[i]):
            verdicts[compared.wins(i)].append(design_name(table, other))
    said = ((True, "better than"), (False, "worse than"), (None, "not to be told from"))
    told = [f"{words} {listed(verdicts[which])}" for which, words in said if verdicts[which]]
    return f"Beside the constant levels of the profile, human-like stiffness is {', '.join(told)}." if told else ""


def constant_levels(found: Discrimination) -> str:
    """How far mean CASR lies from that at the constant levels; "" where none was pressed."""
    other = found.conditions.other.tolist()
    levels = [
        i for i, design in enumerate(other)
        if found.table.conditions[design] != RIGID and np.isfinite(found.conditions.level_ratio.low[i])
    ]  # fmt: skip
    return f"{_levels(found, levels, 'a constant level')} {_ONE_MOUNTING}" if levels else ""


def why(found: Discrimination, simulated: bool) -> str:
    """What stands behind the comparison with the rigid motor: the level of CASR, and the noise of repetitions."""
    compared, margin = found.conditions, found.settings.equivalence_margin
    against = [i for i, other in enumerate(compared.other.tolist()) if found.table.conditions[other] == RIGID]
    low, high = compared.level_ratio.low[against], compared.level_ratio.high[against]
    if not against or not np.isfinite([low, high]).all():
        return ""
    level, within = _levels(found, against, "the rigid motor"), percent(margin)
    alike, beyond = (low > 1 - margin) & (high < 1 + margin), (low > 1 + margin) | (high < 1 - margin)
    if not np.all(alike):
        return (
            f"{level} Equality within ± {within} is shown at {np.count_nonzero(alike)} of "
            f"{count(alike.size, 'angle')}, a larger difference at {np.count_nonzero(beyond)}. {_ONE_MOUNTING}"
        )
    noise = compared.cv_ratio
    quiet = bool(np.all((noise.low[against] < 1) & (noise.high[against] > 1)))
    scatter = (
        "Their presses scatter alike, as far as can be told"
        if quiet
        else f"What differs is the scatter of presses (CV, human-like over rigid: {_range(noise.estimate[against])})"
    )
    built = (
        " In the simulated world the contact area follows from force alone, so that the actuator's stiffness only "
        "changes how far the force steps from frame to frame."
        if simulated
        else ""
    )
    return f"{level} At every angle it is within ± {within} of the rigid motor's. {_ONE_MOUNTING} {scatter}.{built}"


def _levels(found: Discrimination, which: Sequence[int], other: str) -> str:
    """Mean CASR less that of the other conditions, in percent of it, and how many intervals leave 0 out."""
    compared = found.conditions
    each = [f"{level_change(compared, i)} ({design_name(found.table, int(compared.other[i]))})" for i in which]
    apart = sum(bool(compared.level_ratio.low[i] > 1 or compared.level_ratio.high[i] < 1) for i in which)
    return (
        f"Mean CASR of the same specimens with human-like stiffness, less that with {other}, is {listed(each)} in "
        f"percent; {apart} of {count(len(which), 'interval')} leave 0 out."
    )


def _difference(found: Discrimination, i: int) -> str:
    """Gaps of both, and their difference."""
    compared, gaps = found.conditions, found.conditions.gaps.gap
    human, other = int(compared.human[i]), int(compared.other[i])
    said = interval(*gap_of(compared.gap_differences, i))
    return (
        f"{found.table.angles_deg[human]:g}°: {number(float(gaps[human]))} against {number(float(gaps[other]))}, "
        f"difference {said}"
    )


def _range(values: np.ndarray) -> str:
    known = values[np.isfinite(values)]
    if not known.size:
        return "not defined"
    return " to ".join(dict.fromkeys(number(float(end)) for end in (known.min(), known.max())))
