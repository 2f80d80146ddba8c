"""What the contrasts say, in words: for `emg2vsa run` and the report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from emg2vsa.discrimination.contrast import Contrast, Estimates
from emg2vsa.discrimination.discriminate import Discrimination
from emg2vsa.discrimination.run_table import HUMAN_LIKE, RIGID
from emg2vsa.statistics.drift import Order

_MEASURES = {"slope": "CASR by slope", "frame_sum": "CASR by equation (2), a sum over frames,"}
_ORDERS: dict[Order, str] = {
    "same": "their order does not tell what drift does",
    "unknown": "nobody knows the order of mountings",
}
_NAMES = {HUMAN_LIKE: "human-like stiffness", RIGID: "the rigid motor"}


def contrast_words(found: Discrimination) -> list[str]:
    """Sentences that are true of the runs; none where nothing was compared."""
    said = [line for contrast in found.contrasts for line in _of_measure(found, contrast)]
    return [*said, *schedule_words(found), *_gaps(found)] if said else []


def change_percent(of: Estimates, i: int) -> str:
    """A difference of logarithms as a change of the ratio, ``+0.4 % [-4.1, +5.2]``."""
    ends = [100 * np.expm1(end) for end in of.at(i)]
    estimate, low, high = (f"{end:+.1f}" for end in ends)
    if np.isfinite(ends).all():
        return f"{estimate} % [{low}, {high}]"
    return f"{estimate} %, interval not determined" if np.isfinite(ends[0]) else "not determined"


def headline(contrast: Contrast, conditions: Sequence[str]) -> int | None:
    """Number of the comparison that is tested first; None where the human-like condition met no rigid motor."""
    rows = zip(contrast.one.tolist(), contrast.other.tolist(), contrast.pair.tolist(), strict=True)
    for i, (one, other, pair) in enumerate(rows):  # by rising angle
        if (conditions[one], conditions[other], pair) == (HUMAN_LIKE, RIGID, 0):
            return i
    return None


def _of_measure(found: Discrimination, contrast: Contrast) -> Iterator[str]:
    table = found.table
    i = headline(contrast, table.conditions)
    if i is None:
        return
    measure, pair = _MEASURES[contrast.measure], _pair(contrast, 0)
    change, against = change_percent(contrast.changes, i), "against the rigid motor"
    counts = contrast.mountings[[contrast.one[i], contrast.other[i]]]
    mounted = f"p = {contrast.p_adjusted[i]:.2g}, {_mountings(int(counts.min()))}"
    match contrast.verdicts[i]:
        case "raises" | "lowers" as verdict:
            yield f"Human-like stiffness {verdict} the contrast {pair} of {measure} {against}: {change} ({mounted})."
        case "not shown":
            yield (
                f"No change of the contrast {pair} of {measure} by human-like stiffness {against} is shown: {change} "
                f"({mounted})."
            )
        case _:
            yield (
                f"Whether human-like stiffness raises the contrast {pair} of {measure} {against} cannot be told"
                f"{_why(found, contrast, i, once=bool(counts.min() < 2))}."
            )
    others = [
        f"{_NAMES.get(table.conditions[one], table.conditions[one])} at {table.angles_deg[one]:g}° {verdict} "
        f"{_pair(contrast, int(k))} against {_NAMES.get(table.conditions[other], table.conditions[other])} "
        f"({change_percent(contrast.changes, j)})"
        for j, (one, other, k, verdict) in enumerate(
            zip(contrast.one, contrast.other, contrast.pair, contrast.verdicts, strict=True)
        )
        if j != i and verdict in ("raises", "lowers")
    ]
    if others:
        yield f"Also by this measure: {'; '.join(others)}."


def _why(found: Discrimination, contrast: Contrast, i: int, *, once: bool) -> str:
    """Reason why comparison ``i`` is weak, and what it says all the same."""
    if not np.isfinite(contrast.changes.at(i)).all():
        return ", as presses with a score are missing"
    order = found.drift.order
    why = ["specimens were mounted once"] * once + [_ORDERS[order]] * (order != "differs")
    assumed = f" if mountings differ by {100 * contrast.assumed_sd:g} % (SD, assumed)" if once else ""
    return (
        f"{', as ' if why else ''}{' and '.join(why)}. It is {change_percent(contrast.changes, i)}{assumed}. Three "
        "mountings of each specimen or more, in random order, would tell ([experiment] mountings)"
    )


def schedule_words(found: Discrimination) -> Iterator[str]:
    """Whether an effect follows the specimen or its schedule."""
    pressed_with = {name: found.schedule_of.get(name, name) for name in found.table.specimens}
    if len(set(pressed_with.values())) == 1:
        yield "All specimens were pressed with the same schedules, so that no schedule tells the specimens apart."
        return
    others = {one: other for one, other in pressed_with.items() if one != other}
    if others:
        told = ", ".join(f"{one} with those of {other}" for one, other in others.items())
        yield f"Specimens were pressed with the schedules of others: {told}."
        if found.table.of_condition(HUMAN_LIKE):
            yield from (line for contrast in found.contrasts for line in _order(found, contrast, pressed_with))
    claimed = {
        contrast.pairs[int(k)]
        for contrast in found.contrasts
        for k, verdict in zip(contrast.pair, contrast.verdicts, strict=True)
        if verdict in ("raises", "lowers")
    }
    labelled = [
        f"{softer} and {stiffer}"
        for softer, stiffer in sorted(claimed)
        if pressed_with[softer] != pressed_with[stiffer] and not _swapped(found, pressed_with, softer, stiffer)
    ]
    if labelled:
        yield (
            f"The schedules of {', and of '.join(labelled)} differ and are not swapped, so that a schedule carries the "
            "label of its specimen, and the effect may be that of the label. Swapped schedules decide: press again "
            "with [experiment] schedule_of (docs/how-to/controls.md)."
        )


def _swapped(found: Discrimination, pressed_with: Mapping[str, str], softer: str, stiffer: str) -> bool:
    """Whether the softer specimen was pressed with the schedules of a stiffer one than the stiffer specimen was."""
    places = {name: place for place, name in enumerate(found.table.specimens)}  # the stiffest first
    owners = pressed_with[softer], pressed_with[stiffer]
    return all(owner in places for owner in owners) and places[owners[0]] < places[owners[1]]


def _order(found: Discrimination, contrast: Contrast, pressed_with: Mapping[str, str]) -> Iterator[str]:
    """Whether a measure ranks specimens by their stiffness although their schedules are swapped."""
    said: list[str] = []
    rigid = found.table.of_condition(RIGID)
    for k, (softer, stiffer) in enumerate(contrast.pairs):
        if not _swapped(found, pressed_with, softer, stiffer):
            continue
        level = found.table.of_condition(HUMAN_LIKE)[0] * len(contrast.pairs) + k
        _, low, high = contrast.levels.at(level)
        ratio = f"{softer} : {stiffer} {change_percent(contrast.levels, level)}"
        if low > 0:
            said.append(f"keeps the order of {stiffer} and {softer} ({ratio}), as the specimens have it")
        elif high < 0:
            ends = contrast.levels.at(rigid[0] * len(contrast.pairs) + k)[1:] if rigid else (np.nan, np.nan)
            why = ": it follows the schedule, not the specimen" if ends[0] > 0 else ""
            why = ", and so does the rigid motor, which follows no schedule" if ends[1] < 0 else why
            said.append(f"reverses {stiffer} and {softer} ({ratio}){why}")
        else:
            said.append(f"does not tell {stiffer} and {softer} apart ({ratio})")
    if said:
        yield f"Under human-like stiffness {_MEASURES[contrast.measure]} {'; it '.join(said)}."


def _gaps(found: Discrimination) -> Iterator[str]:
    """How far conditions set the closest specimens apart, at the smallest angle."""
    table, gaps = found.table, found.conditions.gaps
    known = [i for i in np.flatnonzero(table.angles_deg == table.angles_deg.min()).tolist() if np.isfinite(gaps.gap[i])]
    if len(known) > 1:
        told = ", ".join(
            f"{table.conditions[i]} {gaps.gap[i]:.1f} [{gaps.low[i]:.1f}, {gaps.high[i]:.1f}]" for i in known
        )
        stiffer, softer = found.conditions.pair
        yield f"Distance of CASR of {stiffer} and {softer}, in SDs of a press, by condition: {told}."


def _pair(contrast: Contrast, place: int) -> str:
    return " : ".join(contrast.pairs[place])


def _mountings(count: int) -> str:
    return f"{count} mountings of each specimen" if count > 1 else "one mounting, which is assumed to be like any other"
