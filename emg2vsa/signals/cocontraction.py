"""Indices of co-contraction: the envelopes of antagonists as one activity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError
from emg2vsa.settings import CocontractionSettings


def cocontraction_index(
    envelopes_v: Floats,
    muscles: tuple[str, ...],
    settings: CocontractionSettings,
    session_v: Mapping[str, float] | None = None,
) -> tuple[Floats, str, tuple[str, ...]]:
    """Activity (n,), its unit ("V" or "1") and what must be said of it, from envelopes (m, n) in volts.

    With L and H the lower and the higher envelope at each instant: sum (paper IV.B); minimum, L; rudolph, (L / H)(L +
    H) (Rudolph et al. 2000); falconer-winter, 2 L / (L + H) (Falconer and Winter 1985, instant by instant; 0 to 1).
    Where a denominator is zero the index is zero.
    session_v : largest envelope of each muscle in the whole session, for normalise = "session-max"; while it is not
        known the envelopes stay in volts.
    SettingError : the index is not one of so many muscles.
    """
    pairwise = settings.index in ("rudolph", "falconer-winter")
    if (pairwise and len(muscles) != 2) or (settings.index == "minimum" and len(muscles) < 2):
        wanted = "exactly two muscles" if pairwise else "two muscles or more"
        found = ", ".join(muscles)
        raise SettingError(f"cocontraction.index = {settings.index!r}", wanted=wanted, found=found, do="Use 'sum'.")
    reference_v = _reference_v(muscles, settings, session_v)
    notes = () if reference_v is None else (_said(muscles, reference_v, settings),)
    if settings.index in ("rudolph", "minimum") and settings.normalise == "none":
        notes = (f"co-contraction: the {settings.index} index is meant for normalised envelopes; these are volts",)
    unit = "V" if reference_v is None and settings.index != "falconer-winter" else "1"
    return _index(_relative(envelopes_v, reference_v), settings.index), unit, notes


def _index(levels: Floats, index: str) -> Floats:
    if index == "sum":
        return np.asarray(levels.sum(axis=0))
    lower, higher = levels.min(axis=0), levels.max(axis=0)
    if index == "minimum":
        return np.asarray(lower)
    total = lower + higher
    numerator, denominator = (lower * total, higher) if index == "rudolph" else (2 * lower, total)
    nothing = np.where(np.isnan(denominator), np.nan, 0.0)  # samples that are left out stay so
    return np.asarray(np.divide(numerator, denominator, out=nothing, where=denominator > 0))


def _reference_v(
    muscles: tuple[str, ...], settings: CocontractionSettings, session_v: Mapping[str, float] | None
) -> Floats | None:
    """The level (m,) that counts as 1; None where the envelopes stay in volts."""
    known = {"none": None, "session-max": session_v, "mvc": settings.mvc_v}[settings.normalise]
    if known is None:
        return None
    missing = [muscle for muscle in muscles if muscle not in known]
    if missing:
        do = "State the envelope level of the maximum voluntary contraction, in volts."
        raise SettingError(
            "cocontraction.mvc_v", wanted="a level for every muscle", found="none for " + ", ".join(missing), do=do
        )
    return np.array([known[muscle] for muscle in muscles])


def _relative(envelopes_v: Floats, reference_v: Floats | None) -> Floats:
    if reference_v is None:
        return envelopes_v
    scale = np.divide(1.0, reference_v, out=np.zeros_like(reference_v), where=reference_v > 0)
    return np.asarray(envelopes_v * scale[:, None])


def _said(muscles: tuple[str, ...], reference_v: Floats, settings: CocontractionSettings) -> str:
    shown = ", ".join(f"{muscle} {1e6 * v:.4g} uV" for muscle, v in zip(muscles, reference_v, strict=True))
    source = "MVC" if settings.normalise == "mvc" else "the largest envelope of the session's trials"
    return f"co-contraction: envelopes divided by {source}: {shown}"
