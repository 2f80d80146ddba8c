"""What the study claims of people: b by specimen, people, clusters, the law, the interpolated profile.

People are the unit: of every person's presses on a specimen the mean counts once. A comparison of specimens is free of
drift where the order of acquisition tells it, and else as uncertain as drift allows (``emg2vsa.statistics.drift``).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise, product

import numpy as np

from emg2vsa.arrays import Floats, Ints, mean_of
from emg2vsa.claims.claim import UNKNOWN, Asserts, Claim, Found, largest, moved, size, smallest
from emg2vsa.claims.drifting import Difference, contrast
from emg2vsa.claims.spread import ROUNDING, by_recordings, mean_of_people, people_f, shape_of
from emg2vsa.companions.force_laws import LAWS, ForceLaws, log_ratios
from emg2vsa.companions.visits import unequal_people, within_visits
from emg2vsa.fits import Fits, usable
from emg2vsa.profiles import ByPerson, by_person
from emg2vsa.settings import ClaimSettings
from emg2vsa.statistics.clusters import Clusters, Names, clusters_of
from emg2vsa.statistics.drift import Drift, drift
from emg2vsa.study import Study

QUESTION = "co-contraction of people"
ALONE = "Presses of one person say nothing on people."
ORDERS = {
    "differs": "",
    "same": "All people pressed in one order or in few; drift is taken to be no faster between recordings than within.",
    "unknown": "The order of specimens is not known; drift is taken to be no faster between recordings than within.",
}
"""Why a comparison of specimens is uncertain."""
_BY_BIN, _NAMED, _LARGEST_LOG = 1, 4, 700.0
_PERCENT = 100.0


@dataclass(frozen=True, eq=False)
class PressTable:
    """n presses that count; all arrays (n,). v = a + b ln(F / N), in one unit of activity.

    place : of the press's recording in the session of the person, NaN where nobody knows.
    """

    participant: Names
    specimen: Names
    repetition: Ints
    a_v: Floats
    b_v: Floats
    place: Floats

    @classmethod
    def of(cls, fits: Fits, use: str, place: Mapping[tuple[str, str], float]) -> PressTable:
        """The presses of ``fits`` that ``use`` admits, within visits; place : of recordings, by cell."""
        at = usable(fits, use)
        fits = within_visits(fits, at)
        cells = zip(fits.participant[at].tolist(), fits.specimen[at].tolist(), strict=True)
        known = np.array([place.get(cell, np.nan) for cell in cells], dtype=np.float64)
        return cls(fits.participant[at], fits.specimen[at], fits.repetition[at], fits.a_v[at], fits.b_v[at], known)


def claims_of_study(
    study: Study, fits: Fits, place: Mapping[tuple[str, str], float], laws: ForceLaws | None
) -> Iterator[Claim]:
    """Claims on the people of ``study``. place : of recordings, as for ``PressTable.of``. laws : of these fits."""
    use, stiffness = study.hypotheses.use, study.stiffness_n_per_mm
    table = PressTable.of(fits, use, place)
    there = set(zip(table.participant.tolist(), table.specimen.tolist(), strict=True))
    lost = [" ".join(cell) for cell in product(study.participants, study.palpated) if cell not in there]
    more = f" and {len(lost) - _NAMED} more" if len(lost) > _NAMED else ""
    lacks = f"Without a usable press: {', '.join(lost[:_NAMED])}{more}." if lost else ""
    unequal = unequal_people(fits) if study.visits else []
    if unequal:
        lacks += f" At the visits of {', '.join(unequal)} specimens miss; presses of such visits are doubtful."
    found = people_claims(
        table, stiffness, study.hypotheses.kept_specimens or study.palpated, study.claims,
        laws=laws, new=study.profile.new_specimen or "", interpolated=by_person(fits, stiffness, study.profile, use),
        force_n=study.window.force_n,
    )  # fmt: skip
    return (replace(claim, why=" ".join(filter(None, (claim.why, lacks.strip())))) for claim in found)


def people_claims(
    table: PressTable,
    stiffness_n_per_mm: Mapping[str, float],
    kept: Sequence[str],
    margins: ClaimSettings,
    *,
    laws: ForceLaws | None = None,
    new: str = "",
    interpolated: ByPerson | None = None,
    force_n: tuple[float, float] = (0.5, 7.0),
) -> Iterator[Claim]:
    """Claims on ``table``. kept : specimens that are said to differ, all where it is empty. laws : the logarithm and
    its rivals. new : specimen whose profile was interpolated, "" for none; interpolated : that profile beside a
    measured one, None where nobody pressed such a specimen. force_n : ends of the force range, newtons.
    """
    cells = _Cells(table)
    kept = kept or cells.names
    yield from _steps(cells, stiffness_n_per_mm, kept, margins.slope_percent / _PERCENT)
    yield _claim(
        "equal_participants", "people do not differ",
        "SD of b between people on the mean of the specimens, SDs of presses", "within", cells.of_people(),
        margins.people_f, why=cells.alone,
    )  # fmt: skip
    yield _claim(
        "gaussian_clusters", "clusters of b are shaped like Gaussian ones, on the mean",
        "mean skewness of clusters as small as these or half their mean excess kurtosis",
        "within", cells.shape(), margins.cluster_shape, why=cells.alone,
    )  # fmt: skip
    yield _claim(
        "log_fit_r2", "no other law predicts v better than a + b ln F",
        "gain by the best other law, % of the error of prediction", "within",
        UNKNOWN if laws is None else _of_laws(laws), margins.law_percent / _PERCENT, "fits", _PERCENT, cells.alone,
    )  # fmt: skip
    if new:
        yield _interpolated(cells, new, interpolated, stiffness_n_per_mm, margins, force_n)


def _claim(
    key: str, says: str, estimand: str, asserts: Asserts, found: Found, margin: float, section: str = "hypotheses",
    factor: float = 1.0, why: str = "",
) -> Claim:  # fmt: skip
    return Claim(key, QUESTION, says, estimand, asserts, found, margin, "person", section, factor=factor, why=why)


@dataclass(frozen=True, eq=False)
class _Cells:
    """The presses by person and specimen."""

    table: PressTable

    @cached_property
    def clusters(self) -> Clusters:
        table = self.table
        return clusters_of(table.participant, table.specimen, table.b_v, np.isfinite(table.b_v))

    @property
    def names(self) -> list[str]:
        return [str(name) for name in self.clusters.specimens]

    @property
    def alone(self) -> str:
        return ALONE if self.clusters.participants.size == 1 else ""

    @cached_property
    def mean(self) -> Floats:
        """(P, S) of b, NaN without a press."""
        return mean_of(self.clusters.values)

    @cached_property
    def place(self) -> Floats:
        """(P, S) of the recordings; of several recordings of a cell the mean."""
        table = self.table
        return mean_of(clusters_of(table.participant, table.specimen, table.place, np.isfinite(table.b_v)).values)

    def drift(self, values: Floats) -> Drift:
        """Drift of one value a press."""
        table = self.table
        return drift(table.participant, table.specimen, table.place, table.repetition.astype(np.float64), values)

    @cached_property
    def drift_of_b(self) -> Drift:
        return self.drift(self.table.b_v)

    def at(self, name: str) -> int:
        return self.names.index(name) if name in self.names else -1

    def step(self, stiffer: str, softer: str, kept: Sequence[int]) -> Found:
        """b of ``stiffer`` less that of ``softer``, over the mean b of a person on the kept specimens."""
        i, j = self.at(stiffer), self.at(softer)
        if min(i, j) < 0:
            return UNKNOWN
        difference, level = self.mean[:, i] - self.mean[:, j], mean_of(self.mean[:, kept])
        who = np.isfinite(difference + level)
        apart, by = (self.place[:, i] - self.place[:, j])[who], self.drift_of_b
        return contrast(Difference(difference[who], apart, by), Difference(level[who], np.empty(0), by))

    def of_people(self) -> Found:
        """Cohen's f between people, of their means over the specimens.

        A straight drift leaves these means as they are in the middle of the session, whatever its rate and the order.
        One specimen alone has too few presses to tell f = 0 from f = 0.25.
        """
        values = self.clusters.values
        if not values.size:
            return UNKNOWN
        rest = np.where(np.isfinite(values), values - self.mean[..., None], 0.0)
        if np.abs(rest).max() < ROUNDING * np.nanmax(np.abs(values)):
            return UNKNOWN
        steps = self.mean - mean_of(self.mean.T)
        level, squares = mean_of(steps), float(np.sum(rest**2))
        count, cells = self.clusters.count.sum(axis=1), int(np.count_nonzero(self.clusters.count))
        found, free = people_f(level, count, squares, cells), int(count.sum()) - cells
        return by_recordings(found, level, steps, squares / free) if squares > 0 else found

    def shape(self) -> Found:
        values = self.clusters.values
        by_person = (mean_of(each) for each in shape_of(values))
        skewness, kurtosis = (mean_of_people(each) for each in by_person)
        return largest((size(skewness), size(moved(kurtosis, lambda excess: excess / 2))))


def _steps(cells: _Cells, stiffness: Mapping[str, float], kept: Sequence[str], margin: float) -> Iterator[Claim]:
    others = [name for name in cells.names if name not in kept]
    at = [cells.at(name) for name in kept if name in cells.names]

    def why(names: Sequence[str]) -> str:
        unknown = [name for name in names if name not in stiffness]
        missing = [name for name in names if name not in cells.names]
        if unknown or missing:
            said = f"The stiffness of {', '.join(unknown)} is not known." if unknown else ""
            return said or f"Nobody pressed {', '.join(missing)}."
        few = "This takes two specimens or more." if len(names) < 2 else ""
        return few or cells.alone or ORDERS[cells.drift_of_b.order]

    def neighbours(names: Sequence[str], touching: Sequence[str]) -> Iterator[Found]:
        """Steps from each to the next stiffer; of unknown stiffness there is no next."""
        if all(name in stiffness for name in names):
            for softer, stiffer in pairwise(sorted(names, key=stiffness.__getitem__)):
                if softer in touching or stiffer in touching:
                    yield cells.step(stiffer, softer, at)

    yield _claim(
        "specimens_differ", f"the slope b rises with stiffness from each to the next of {', '.join(kept)}",
        "smallest step of b to the next stiffer specimen, % of the mean", "more", smallest(neighbours(kept, kept)),
        margin, factor=_PERCENT, why=why(kept),
    )  # fmt: skip
    if others:
        yield _claim(
            "others_not_distinct", f"{', '.join(others)} {'is' if len(others) == 1 else 'are'} not distinct",
            "largest distance of their b from the nearer neighbour in stiffness, % of the mean", "within",
            largest(smallest(map(size, neighbours((*kept, *others), [other]))) for other in others), margin,
            factor=_PERCENT, why=why((*kept, *others)),
        )  # fmt: skip


def _of_laws(laws: ForceLaws) -> Found:
    """1 less the error of the best other law over that of the logarithm, of force bins that were left out."""
    by_law = log_ratios(laws.participant, laws.error)[_BY_BIN]
    rivals = [mean_of_people(-by_law[place]) for place in range(1, len(LAWS))]
    return largest(moved(rival, lambda log: float(-np.expm1(min(-log, _LARGEST_LOG)))) for rival in rivals)


def _interpolated(
    cells: _Cells, new: str, of: ByPerson | None, stiffness: Mapping[str, float], margins: ClaimSettings,
    force_n: tuple[float, float],
) -> Claim:  # fmt: skip
    level, difference = margins.profile_percent, margins.neighbour_percent
    matters = f"{level:g} % of the level or {difference:g} % of the difference of its neighbours, at {force_n[1]:g} N"
    why = "Nobody pressed a specimen of this stiffness besides those that the interpolation takes."
    return _claim(
        "interpolation_rmse", f"the profile interpolated for {new} agrees with a measured one",
        f"largest error of the interpolated profile, of what matters ({matters})", "within",
        UNKNOWN if of is None else _error(cells, of, stiffness, margins, np.array(force_n)), 1.0, "profiles",
        why=why if of is None else cells.alone or ORDERS[cells.drift_of_b.order],
    )  # fmt: skip


def _error(
    cells: _Cells, of: ByPerson, stiffness: Mapping[str, float], margins: ClaimSettings, ends_n: Floats
) -> Found:
    """At both ends of the force range: a straight line in ln F is largest there."""
    people = cells.clusters.participants.tolist()
    who = [people.index(name) for name in of.participants]
    stiffer, softer, measured = (cells.place[who, cells.at(name)] for name in (*of.bracket, of.measured_as))
    weight = _softer_weight(*(stiffness.get(name, np.nan) for name in (*of.bracket, of.measured_as)))
    drifts = [cells.drift(cells.table.a_v + cells.table.b_v * log_force) for log_force in np.log(ends_n)]
    level, share = margins.profile_percent / _PERCENT, margins.neighbour_percent / _PERCENT
    scales = (
        Difference(of.level_v(ends_n)[:, -1] * level, np.empty(0), drifts[-1]),
        Difference(of.neighbours_v(ends_n)[:, -1] * share, (stiffer - softer) * share, drifts[-1]),
    )
    errors = [
        Difference(error, (1 - weight) * stiffer + weight * softer - measured, by)
        for error, by in zip(of.error_v(ends_n).T, drifts, strict=True)
    ]
    return largest(size(contrast(error, scale)) for error in errors for scale in scales)


def _softer_weight(stiffer: float, softer: float, new: float) -> float:
    """Weight of the softer neighbour by place, whatever rule weighted the profiles; half where a stiffness is not
    known.
    """
    weight = (stiffer - new) / (stiffer - softer) if stiffer != softer else 0.5
    return weight if weight == weight else 0.5
