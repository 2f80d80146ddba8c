"""The stage from scored runs to what section VI of the paper says of areas, rates, algorithms and actuators.

It answers four questions:

- Does CASR tell the known specimens apart, and is it larger for softer ones?
- Does the CASR of the new specimen lie between those of its neighbours in stiffness, and apart from both?
- What do the old and the new vision algorithm give for the same presses (VI.A)?
- How do condition, angle and specimen change area and CASR, and do they act together?

The last is a model of logarithms: an angle or a condition multiplies the scores, and their scatter grows with their
level. It holds the known specimens. Conditions that were pressed at some angles only leave cells empty
(`stats.factorial`).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.discrimination.area import AreaByAngle, AreaBySpecimen, area_by_angle, area_by_specimen
from emg2vsa.discrimination.conditions import ConditionComparison, compare_conditions
from emg2vsa.discrimination.contrast import Contrast, contrasts
from emg2vsa.discrimination.mountings import Mountings
from emg2vsa.discrimination.rates import NewSpecimen, SpreadBySpecimen, beside_neighbours, spread_by_specimen
from emg2vsa.discrimination.run_table import RunTable, run_table
from emg2vsa.discrimination.separation import Gaps, closest_pair, gaps_of, press_sds, pressed_everywhere
from emg2vsa.errors import DataError
from emg2vsa.run_scores import RunScores
from emg2vsa.settings import DiscriminationSettings
from emg2vsa.shown import shown
from emg2vsa.statistics.drift import Drift
from emg2vsa.statistics.factorial import Factorial, factorial


@dataclass(frozen=True)
class AlgorithmComparison:
    """A algorithms compared in D designs; (A, D) unless said, over the ``specimens`` pressed in every design.

    names : (A,), the one that is tested first, then the old one. area : (A, D, S) mean A_c0. area_ratio : to that of
    the first, mean of presses. area_error, area_error_sd : A_c0 over its truth less 1, mean and SD of presses; NaN
    where nobody knows the truth. area_cv, casr_cv : SD of ln score of a press within its mounting. gaps : of the
    ``pair`` of specimens that lies closest, for each algorithm.
    """

    names: tuple[str, ...]
    specimens: tuple[str, ...]
    area: Floats
    area_ratio: Floats = field(metadata=shown("A_c0 / that of the first"))
    area_error: Floats = field(metadata=shown("Error of A_c0 (%)", 100))
    area_error_sd: Floats = field(metadata=shown("SD of that error (%)", 100))
    area_cv: Floats = field(metadata=shown("SD of A_c0 (%)", 100))
    casr_cv: Floats = field(metadata=shown("SD of CASR (%)", 100))
    pair: tuple[str, str]
    gaps: tuple[Gaps, ...]


def compare_algorithms(
    table: RunTable, settings: DiscriminationSettings, mounting_sd: float = 0.0
) -> AlgorithmComparison:
    """All algorithms that the runs were scored with; mounting_sd : as in ``compare_conditions``."""
    names = tuple(dict.fromkeys((table.algorithm, settings.old_algorithm, *table.casr)))
    names = tuple(name for name in names if name in table.casr)
    used = pressed_everywhere(table.casr[names[0]])
    area = np.stack([table.a_c0[name][:, used] for name in names])
    a, d, s, r = area.shape
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = (area / area[0]).reshape(a, d, s * r)
        error = (area / table.true_a_c0[:, used] - 1).reshape(a, d, s * r)
    mean_error = mean_of(error)
    pair = closest_pair(table.stiffness_n_per_mm, used.tolist())
    areas, rates = (
        [Mountings.of_table(table, scores[name], mounting_sd) for name in names] for scores in (table.a_c0, table.casr)
    )
    return AlgorithmComparison(
        names=names,
        specimens=tuple(table.specimens[i] for i in used),
        area=mean_of(area),
        area_ratio=mean_of(ratio),
        area_error=mean_error,
        area_error_sd=np.sqrt(mean_of((error - mean_error[..., None]) ** 2)),
        area_cv=np.stack([press_sds(each) for each in areas]),
        casr_cv=np.stack([press_sds(each) for each in rates]),
        pair=(table.specimens[pair[0]], table.specimens[pair[1]]),
        gaps=tuple(gaps_of(each, pair, 1 - settings.alpha) for each in rates),
    )


@dataclass(frozen=True)
class Factors:
    """area, casr : the models of ln(score), None where they cannot be fitted. not_positive : presses left out of each,
    whose score has no logarithm. constant : factors with one level only.
    """

    area: Factorial | None
    casr: Factorial | None
    not_positive: tuple[int, int]
    constant: tuple[str, ...]


def factors_of(table: RunTable, areas: Mountings, rates: Mountings, alpha: float) -> Factors:
    """Means of mountings by the algorithm of ``table``; the area is that at the force where loading begins."""
    d, _, m = areas.own.shape
    specimens = [table.specimens[i] for i in table.known]
    levels = {
        "condition": np.repeat(table.conditions, len(specimens) * m),
        "angle": np.repeat([f"{angle:g}" for angle in table.angles_deg.tolist()], len(specimens) * m),
        "specimen": np.tile(np.repeat(specimens, m), d),
    }
    varied = {name: names for name, names in levels.items() if np.unique(names).size > 1}
    lost = [
        int(np.count_nonzero(scores[table.algorithm][:, table.known] <= 0)) for scores in (table.start_area, table.casr)
    ]
    return Factors(
        area=_model(areas.own[:, table.known].ravel(), varied, 1 - alpha),
        casr=_model(rates.own[:, table.known].ravel(), varied, 1 - alpha),
        not_positive=(lost[0], lost[1]),
        constant=tuple(name for name in levels if name not in varied),
    )


def _model(logs: Floats, levels: dict[str, np.ndarray], confidence: float) -> Factorial | None:
    """None where the means that are left cover no two levels of every factor, or leave no scatter within cells."""
    there = np.isfinite(logs)
    if any(np.unique(names[there]).size < 2 for names in levels.values()):
        return None
    found = factorial(logs[there], {name: names[there].tolist() for name, names in levels.items()}, confidence)
    return found if found.error_df > 0 else None


@dataclass(frozen=True)
class Discrimination:
    """Everything that is tested of the runs; ``notes`` say what could not be.

    drift : of ln CASR from mounting to mounting. schedule_of : specimen to the one whose schedule pressed it, where
    that is another.
    """

    settings: DiscriminationSettings
    table: RunTable
    area: AreaBySpecimen
    area_by_angle: AreaByAngle | None
    spread: SpreadBySpecimen
    new: NewSpecimen | None
    algorithms: AlgorithmComparison
    conditions: ConditionComparison
    contrasts: tuple[Contrast, ...]
    schedule_of: dict[str, str]
    factors: Factors
    drift: Drift
    notes: tuple[str, ...]


def discriminate(
    runs: Sequence[RunScores],
    stiffness_n_per_mm: Mapping[str, float],
    new_specimen: str,
    settings: DiscriminationSettings | None = None,
    *,
    mounting_sd: float = 0.0,
    schedule_of: Mapping[str, str] | None = None,
) -> Discrimination:
    """Test ``runs``, one a specimen, angle and condition.

    stiffness_n_per_mm : of every specimen, the new one included, N/mm; only its order is used.
    new_specimen : the one whose stiffness is to be estimated, which enters no test of the known ones; it need not have
        been pressed.
    mounting_sd : standard deviation of a score from one mounting to the next, as a share of it, see
        ``compare_conditions`` and ``contrasts``.
    schedule_of : as in ``Discrimination``.
    DataError as ``run_table``, and where fewer than two known specimens were pressed.
    """
    settings = settings or DiscriminationSettings()
    table = run_table(runs, stiffness_n_per_mm, new_specimen)
    _check(table)
    areas, rates = (
        Mountings.of_table(table, scores[table.algorithm], mounting_sd) for scores in (table.start_area, table.casr)
    )
    spread = spread_by_specimen(table, rates, settings.alpha)
    return Discrimination(
        settings=settings,
        table=table,
        area=area_by_specimen(table, areas, settings.alpha),
        area_by_angle=area_by_angle(table, areas, settings.alpha),
        spread=spread,
        new=beside_neighbours(table, spread.steps),
        algorithms=compare_algorithms(table, settings, mounting_sd),
        conditions=compare_conditions(table, settings.alpha, mounting_sd),
        contrasts=contrasts(table, settings.alpha, mounting_sd),
        schedule_of=dict(schedule_of or {}),
        factors=factors_of(table, areas, rates, settings.alpha),
        drift=rates.drift,
        notes=_notes(table, rates.count, new_specimen, settings),
    )


def _check(table: RunTable) -> None:
    if len(table.known) < 2:
        found = ", ".join(table.specimens[i] for i in table.known) or "none"
        raise DataError(
            "runs, specimens", wanted="two specimens or more besides the new one", found=found,
            do="Press more specimens; nothing can be told apart.",
        )  # fmt: skip
    if not np.isfinite(table.casr[table.algorithm]).any():
        raise DataError(
            "runs, presses", wanted="a press that counts and has a score", found="none",
            do="See in presses.csv of the runs why they were rejected.",
        )  # fmt: skip


def _notes(table: RunTable, mountings: Ints, new_specimen: str, settings: DiscriminationSettings) -> tuple[str, ...]:
    """mountings : (D, S) with a score."""
    designs = [f"{c} at {a:g}°" for c, a in zip(table.conditions, table.angles_deg.tolist(), strict=True)]
    missing = [
        f"{table.specimens[specimen]} ({designs[design]})" for design, specimen in np.argwhere(mountings == 0).tolist()
    ]
    notes = [f"no scored press: {', '.join(missing)}"] if missing else []
    if not np.any(mountings > 1):
        notes.append("every specimen was mounted once: nothing tells the scatter that a model of factors needs")
    if new_specimen and table.new < 0:
        notes.append(f"no run of the new specimen {new_specimen}: it is not discriminated from its neighbours")
    if settings.old_algorithm not in table.casr:
        notes.append(f"no scores by the old algorithm {settings.old_algorithm}: nothing to compare it with")
    return tuple(notes)
