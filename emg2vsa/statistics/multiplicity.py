"""Several tests at once: p corrected for a family of pairs, and which of a paper's claims survive together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError

Adjustment = Literal["bonferroni", "holm", "fdr_bh"]


@dataclass(frozen=True)
class ClaimFamily:
    """One family of c claims, each resting on one p; p, p_holm : (c,), NaN where a claim could not be tested.

    survives : whether p_holm is below ``alpha``; None where the claim was not tested.
    """

    names: tuple[str, ...]
    p: Floats
    p_holm: Floats
    survives: tuple[bool | None, ...]
    alpha: float


def claim_family(claims: Mapping[str, float], alpha: float = 0.05) -> ClaimFamily:
    """Holm's (1979) correction over all ``claims``, name to p; NaN: not tested, and no member of the family.

    A claim that needs several tests to succeed at once (in every participant, for every pair) has the largest of their
    p: it is wrong as soon as one of them is. SettingError for a p outside 0 to 1, or an alpha outside 0 to 1.
    """
    if not 0 < alpha < 1:
        raise SettingError("claims, alpha", wanted="a level between 0 and 1", found=str(alpha), do="Give such a level.")
    p = np.array(list(claims.values()), dtype=np.float64)
    wrong = [name for name, value in claims.items() if not (np.isnan(value) or 0 <= value <= 1)]
    if wrong:
        raise SettingError(
            f"claims, {wrong[0]}", wanted="p from 0 to 1", found=str(claims[wrong[0]]), do="Give the p of its test."
        )
    corrected = adjust(p, "holm") if p.size else p
    survives = tuple(None if np.isnan(value) else bool(value < alpha) for value in corrected)
    return ClaimFamily(tuple(claims), p, corrected, survives, alpha)


def adjust(p: ArrayLike, method: Adjustment) -> Floats:
    """Adjusted p (f, m) of f families of m tests, or (m,) of one; NaN is no test: it stays NaN and does not count.

    bonferroni, holm (1979): family-wise error under any dependence. fdr_bh (1995): false discovery rate, independent or
    positively dependent tests.
    """
    values = np.asarray(p, dtype=np.float64)
    m = np.count_nonzero(~np.isnan(values), axis=-1, keepdims=True)
    if method == "bonferroni":
        return np.minimum(values * m, 1.0)
    order = np.argsort(values, axis=-1)  # NaN last
    ordered, rank = np.take_along_axis(values, order, axis=-1), np.arange(1, values.shape[-1] + 1)
    if method == "holm":
        stepped = np.fmax.accumulate(ordered * (m - rank + 1), axis=-1)
    else:
        stepped = np.fmin.accumulate((ordered * (m / rank))[..., ::-1], axis=-1)[..., ::-1]
    adjusted = np.empty_like(values)
    np.put_along_axis(adjusted, order, np.where(np.isnan(ordered), np.nan, np.minimum(stepped, 1.0)), axis=-1)
    return adjusted
