"""Indices of co-contraction: the envelopes of antagonists as one activity."""

from __future__ import annotations

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.settings import CocontractionSettings


def cocontraction_index(
    envelopes_v: Floats, muscles: tuple[str, ...], settings: CocontractionSettings
) -> tuple[Floats, str, tuple[str, ...]]:
    """Activity (n,), its unit ("V" or "1") and what must be said of it, from envelopes (m, n) in volts.

    With L and H the lower and the higher envelope at each instant: sum (paper IV.B); minimum, L; rudolph,
    (L / H)(L + H) (Rudolph et al. 2000); falconer-winter, 2 L / (L + H) (Falconer and Winter 1985, instant by instant;
    0 to 1). Where a denominator is zero the index is zero.
    """
    levels, notes = _normalised(envelopes_v, muscles, settings)
    pairwise = settings.index in ("rudolph", "falconer-winter")
    if (pairwise and len(muscles) != 2) or (settings.index == "minimum" and len(muscles) < 2):
        wanted = "exactly two muscles" if pairwise else "two muscles or more"
        found = ", ".join(muscles)
        raise SettingError(f"cocontraction.index = {settings.index!r}", wanted=wanted, found=found, do="Use 'sum'.")
    if settings.index in ("rudolph", "minimum") and settings.normalise == "none":
        notes = (
            *notes,
            f"co-contraction: the {settings.index} index is meant for normalised envelopes; these are volts",
        )
    unit = "V" if settings.normalise == "none" and settings.index != "falconer-winter" else "1"
    return _index(levels, settings.index), unit, notes


def _index(levels: Floats, index: str) -> Floats:
    if index == "sum":
        return np.asarray(levels.sum(axis=0))
    lower, higher = levels.min(axis=0), levels.max(axis=0)
    if index == "minimum":
        return np.asarray(lower)
    total = lower + higher
    numerator, denominator = (lower * total, higher) if index == "rudolph" else (2 * lower, total)
    return np.asarray(np.divide(numerator, denominator, out=np.zeros_like(lower), where=denominator > 0))


def _normalised(
    envelopes_v: Floats, muscles: tuple[str, ...], settings: CocontractionSettings
) -> tuple[Floats, tuple[str, ...]]:
    if settings.normalise == "none":
        return envelopes_v, ()
    if settings.normalise == "mvc":
        missing = [muscle for muscle in muscles if muscle not in settings.mvc_v]
        if missing:
            do = "State the envelope level of the maximum voluntary contraction, in volts."
            raise SettingError(
                "cocontraction.mvc_v", wanted="a level for every muscle", found="none for " + ", ".join(missing), do=do
            )
        level = np.array([settings.mvc_v[muscle] for muscle in muscles])
    else:
        level = envelopes_v.max(axis=1, initial=0.0)
    shown = ", ".join(f"{muscle} {1e6 * v:.4g} uV" for muscle, v in zip(muscles, level, strict=True))
    source = "MVC" if settings.normalise == "mvc" else "the largest envelope of this recording's trials"
    scale = np.divide(1.0, level, out=np.zeros_like(level), where=level > 0)
    return envelopes_v * scale[:, None], (f"co-contraction: envelopes divided by {source}: {shown}",)
