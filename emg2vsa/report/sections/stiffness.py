"""Can stiffness help? What that of the actuator can do to CASR by contact mechanics, by frames and by timing."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from emg2vsa.contact_mechanics.stiffness_effect import PRESS_CV, StiffnessEffect, replicates_needed
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.numbers import Items
from emg2vsa.report.section import Claim, Quantities, Section
from emg2vsa.report.table import Cell, Column, Row, Table, rows_of
from emg2vsa.report.wording import number, signed

_HUMAN_LIKE = "modular"
_ASSUMED, _LOSSY = 1, 2
"Materials other than the elastic ones, in their order."
_WANTED = 0.2
"A gain of contrast that would be plain to see, as a share."
_SUM = "paper"
"The algorithm whose spread rate is equation (2) as printed."


def _applies(results: StudyResults) -> bool:
    return results.stiffness is not None


def _effect(results: StudyResults) -> StiffnessEffect:
    assert results.stiffness is not None
    return results.stiffness


def _gains(effect: StiffnessEffect) -> np.ndarray:
    """(M, C) contrast of the softest specimen against that under the rigid motor, difference of logarithms."""
    contrast = effect.contrast(effect.slope)
    return np.asarray(contrast - contrast[:, :1])


def _neighbours(effect: StiffnessEffect, sums: np.ndarray) -> np.ndarray:
    """(C,) ratio of the second stiffest specimen to the stiffest."""
    return np.asarray(np.exp(effect.contrast(sums, 1)))


def _quantities(results: StudyResults) -> Items:
    effect = _effect(results)
    gains, sums = _gains(effect), np.exp(effect.contrast(effect.frame_sum))
    yield "stiffness.pair", " ".join(effect.pair)
    for c, condition in enumerate(effect.conditions):
        name = f"stiffness.{condition}"
        for k, specimen in enumerate(effect.specimens):
            yield f"{name}.{specimen}.duration_s", float(effect.duration_s[k, c])
            yield f"{name}.{specimen}.frame_sum", float(effect.frame_sum[k, c])
            yield f"{name}.{specimen}.frame_sum_swapped", float(effect.frame_sum_swapped[k, c])
        for m, material in enumerate(("elastic", "assumed", "lossy_sensor")):
            yield f"{name}.contrast.{material}", float(np.exp(effect.contrast(effect.slope)[m, c]))
            yield f"{name}.contrast_gain.{material}_percent", float(100 * np.expm1(gains[m, c]))
        yield f"{name}.frame_sum.contrast", float(sums[c])
        yield f"{name}.frame_sum.neighbour", float(_neighbours(effect, effect.frame_sum)[c])
        yield f"{name}.frame_sum.neighbour_swapped", float(_neighbours(effect, effect.frame_sum_swapped)[c])
        yield f"{name}.slope.neighbour_swapped", float(_neighbours(effect, effect.slope_swapped)[c])
        yield f"{name}.timing.d", float(effect.timing_d[c])
        for k, specimen in enumerate(effect.pair):
            yield f"{name}.timing.{specimen}.cv", float(effect.timing_cv[k, c])
        if c:
            yield f"{name}.presses_needed", float(replicates_needed(gains[_ASSUMED], PRESS_CV)[c])
            yield f"{name}.mountings_needed", float(replicates_needed(gains[_ASSUMED], _mounting_sd(results))[c])
    yield "stiffness.timing.best", effect.conditions[int(effect.timing_d.argmax())]
    yield "stiffness.frame_sum.swaps_order", _swaps(effect)
    if _HUMAN_LIKE in effect.conditions:
        yield "stiffness.modular.creep_exponent_needed", _exponent(effect)


def _mounting_sd(results: StudyResults) -> float:
    return results.study.calibration.mounting_sd_percent / 100


def _exponent(effect: StiffnessEffect) -> float:
    return effect.creep_exponent(_WANTED, effect.conditions.index(_HUMAN_LIKE))


def _swaps(effect: StiffnessEffect) -> bool:
    """Whether the two stiffest specimens change places by equation (2) when human-like schedules are swapped."""
    if _HUMAN_LIKE not in effect.conditions:
        return False
    c = effect.conditions.index(_HUMAN_LIKE)
    return bool(_neighbours(effect, effect.frame_sum)[c] > 1 > _neighbours(effect, effect.frame_sum_swapped)[c])


def _named(condition: str) -> str:
    return f"constant, {condition.removeprefix('all-')} % for all" if condition.startswith("all-") else condition


def _tables(results: StudyResults, q: Quantities) -> Iterator[Table]:
    effect = _effect(results)
    stiff, soft, second = effect.specimens[0], effect.specimens[-1], effect.specimens[1]
    gains, names = _gains(effect), [_named(condition) for condition in effect.conditions]
    columns = (
        Column("condition", "Condition"),
        Column("duration_stiff_s", f"{stiff} lasts (s)"), Column("duration_soft_s", f"{soft} lasts (s)"),
        Column("gain_percent", "Contrast, assumed creep (%)", digits=2),
        Column("gain_lossy_percent", "Contrast, lossy sensor (%)", digits=2),
        Column("frame_sum", f"Eq. (2), {soft} : {stiff}"), Column("neighbour", f"Eq. (2), {second} : {stiff}"),
        Column("neighbour_swapped", f"{second} : {stiff}, swapped"),
        Column("timing_d", f"d′ of {stiff} and {second}", digits=2),
    )  # fmt: skip
    rows = rows_of(
        {
            "condition": names,
            "duration_stiff_s": effect.duration_s[0],
            "duration_soft_s": effect.duration_s[-1],
            "gain_percent": 100 * np.expm1(gains[_ASSUMED]),
            "gain_lossy_percent": 100 * np.expm1(gains[_LOSSY]),
            "frame_sum": np.exp(effect.contrast(effect.frame_sum)),
            "neighbour": _neighbours(effect, effect.frame_sum),
            "neighbour_swapped": _neighbours(effect, effect.frame_sum_swapped),
            "timing_d": effect.timing_d,
        }
    )
    caption = (
        f"What stiffness can do at 0°: duration of a press; change of the contrast {soft} : {stiff} of CASR against "
        "the rigid motor; ratios by equation (2), elastic bodies, with own and with swapped schedules; d′ with errors "
        "of timing"
    )
    yield Table("stiffness_effect", caption, columns, rows)
    yield _needed(results, effect, names)
    yield _by_specimen(effect, names)
    yield _measured(results, effect)
    yield _would_be(results, effect)


def _needed(results: StudyResults, effect: StiffnessEffect, names: list[str]) -> Table:
    gains = _gains(effect)[_ASSUMED]
    columns = (
        Column("condition", "Condition"), Column("gain_percent", "Change of the contrast (%)", digits=2),
        Column("presses", "Presses per cell, without mountings", digits=2),
        Column("mountings", "Mountings per cell", digits=2),
    )  # fmt: skip
    rows = rows_of(
        {
            "condition": names[1:],
            "gain_percent": 100 * np.expm1(gains[1:]),
            "presses": replicates_needed(gains, PRESS_CV)[1:],
            "mountings": replicates_needed(gains, _mounting_sd(results))[1:],
        }
    )
    caption = (
        f"What it takes to see the change by assumed creep (5 % level, 80 % power): presses with a CV of "
        f"{100 * PRESS_CV:g} %, or mountings with an SD of {100 * _mounting_sd(results):g} %"
    )
    return Table("stiffness_needed", caption, columns, rows)


def _by_specimen(effect: StiffnessEffect, names: list[str]) -> Table:
    columns = (
        Column("condition", "Condition"), Column("specimen", "Specimen"), Column("duration_s", "Duration (s)"),
        Column("slope_mm2_per_n", "Slope (mm²/N)"), Column("frame_sum", "Eq. (2) (mm²/N)"),
        Column("frame_sum_swapped", "Eq. (2), schedules swapped"),
    )  # fmt: skip
    count = len(effect.specimens)
    rows = rows_of(
        {
            "condition": [name for name in names for _ in range(count)],
            "specimen": list(effect.specimens) * len(names),
            "duration_s": effect.duration_s.T.ravel(),
            "slope_mm2_per_n": effect.slope[0].T.ravel(),
            "frame_sum": effect.frame_sum.T.ravel(),
            "frame_sum_swapped": effect.frame_sum_swapped.T.ravel(),
        }
    )
    return Table(
        "stiffness_specimens", "Elastic bodies: duration, slope of area on force, and equation (2)", columns, rows
    )


def _measured(results: StudyResults, effect: StiffnessEffect) -> Table:
    """Contrasts of the scored runs at the smallest angle; no rows without them."""
    columns = (
        Column("condition", "Condition"), Column("slope", "CASR"), Column("frame_sum", "Eq. (2) as printed"),
    )  # fmt: skip
    soft, stiff = effect.specimens[-1], effect.specimens[0]
    own: list[Row] = []
    for condition in effect.conditions:
        ratios = [_ratio(results, condition, soft, stiff, rule) for rule in (results.study.scoring.algorithm, _SUM)]
        if not np.isnan(ratios).all():
            cells: dict[str, Cell] = {"condition": condition, "slope": ratios[0], "frame_sum": ratios[1]}
            own.append(cells)
    caption = f"The runs of this study at 0°: ratio {soft} : {stiff} of median CASR, and of equation (2) as printed"
    return Table("stiffness_measured", caption, columns, tuple(own))


def _ratio(results: StudyResults, condition: str, soft: str, stiff: str, algorithm: str) -> float:
    medians = []
    for specimen in (soft, stiff):
        scores = [
            run.casr[algorithm]
            for run in (results.runs.scores if results.runs else ())
            if (run.specimen, run.condition, run.angle_deg) == (specimen, condition, 0.0) and algorithm in run.casr
        ]
        known = np.concatenate(scores) if scores else np.array([])
        known = known[np.isfinite(known)]
        medians.append(float(np.median(known)) if known.size else np.nan)
    return medians[0] / medians[1]


def _would_be(results: StudyResults, effect: StiffnessEffect) -> Table:
    columns = (Column("need", "For the paper's claim this would have to be true"), Column("here", "Here"))
    rows: list[Row] = []
    if _HUMAN_LIKE in effect.conditions:
        c = effect.conditions.index(_HUMAN_LIKE)
        sums = np.exp(effect.contrast(effect.frame_sum))
        best = int(effect.timing_d.argmax())
        exponent = _exponent(effect)
        rows = [
            {
                "need": "CASR counts frames or duration",
                "here": f"Equation (2) as printed does: {number(sums[0])} (rigid), {number(sums[c])} (human-like). "
                "Presses of equal duration, or a CASR free of the number of frames, would show it.",
            },
            {
                "need": "Errors of timing dominate",
                "here": f"Then {_named(effect.conditions[best])} is best (d′ {number(effect.timing_d[best])}; "
                f"human-like {number(effect.timing_d[c])}).",
            },
            {
                "need": "Specimens creep far more than solids do",
                "here": f"{100 * _WANTED:g} % more contrast needs creep like t to the power {number(exponent)}"
                + (" or more; a liquid has 1." if np.isfinite(exponent) else "."),
            },
            {
                "need": "The skin's contact area depends on stiffness directly",
                "here": "No such mechanism is known. Control world P1 has one made up.",
            },
            {
                "need": "Rigid motor and variable stiffness actuator guide the probe differently",
                "here": "They are different mechanics, never exchanged. Several mountings of both would show it.",
            },
        ]
    return Table("stiffness_would_be", "What would have to be true for the paper's claim", columns, tuple(rows))


def _claims(results: StudyResults, q: Quantities) -> Iterator[Claim]:
    effect = _effect(results)
    if _HUMAN_LIKE not in effect.conditions:
        return
    c, d, gains = effect.conditions.index(_HUMAN_LIKE), effect.timing_d, 100 * np.expm1(_gains(effect)[_ASSUMED])
    best = int(d.argmax())
    others = f"d′ {number(d[c])}, {_named(effect.conditions[best])} {number(d[best])}"
    yield Claim(
        "human_like_contrast",
        "human-like stiffness tells specimens apart better, by contact mechanics",
        "better than rigid and constant",
        f"contrast {signed(float(gains[c]), '%')}; {others}",
        float(gains[c]),
        "holds" if best == c and gains[c] >= gains.max() else "does not hold",
        why="" if best == c else "Against errors of timing another stiffness is best.",
    )


_TEXT = """
<p>In contact mechanics the actuator acts through the duration of a press alone. Duration may change CASR by creep of
sensor and specimen, by the number of frames that equation (2) as printed sums over, and by errors of the camera's
timing. The table keeps these three ways apart.</p>
{{ table("stiffness_effect") }}
<p>{% if small %}Creep changes the contrast by less than mountings scatter. {% endif %}
{% if swaps %}Equation (2) follows the schedule: {{ pair[0] }} and {{ pair[1] }} change places when schedules are
swapped. {% endif %}
{% if softest %}Against errors of timing the softest constant stiffness is best.{% endif %}</p>
{{ folded("stiffness_would_be", "What would have to be true for the paper's claim") }}
{{ folded("stiffness_needed", "Presses and mountings needed to see the change by creep") }}
{{ folded("stiffness_measured", "The same in the runs of this study") }}
{{ folded("stiffness_specimens", "Every specimen alone") }}
"""


def _words(results: StudyResults, q: Quantities) -> dict[str, object]:
    effect = _effect(results)
    softest = int(effect.duration_s.sum(axis=0).argmax())
    return {
        "small": bool(np.abs(_gains(effect)[_ASSUMED]).max() < _mounting_sd(results)),
        "swaps": _swaps(effect),
        "softest": int(effect.timing_d.argmax()) == softest,
        "pair": effect.pair,
    }


STIFFNESS = Section(
    "stiffness", "Can stiffness help?", _TEXT, _applies, _quantities, _tables, claims=_claims, words=_words
)
