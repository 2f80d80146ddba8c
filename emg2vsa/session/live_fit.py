"""After a specimen: the slope of its presses so far, its interval, and whether further presses would narrow it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import special

from emg2vsa.session.views import SpecimenFit
from emg2vsa.session_settings import SessionSettings


def specimen_fit(
    specimen: str, slopes: Sequence[tuple[float, float]], confidence: float, settings: SessionSettings, planned: int
) -> SpecimenFit | None:
    """Mean slope of the presses that count, with the Student interval over presses; None with fewer than two.

    slopes : a and b of their fits, V and V per ln N. planned : presses of the specimen that count or are still to be
    done. A suggestion is made only where the study set stop = "width" before the session, and depends on the interval's
    width beside the activity at 1 N, never on b.
    """
    if (n := len(slopes)) < 2:
        return None
    a_v, b_v = np.array(slopes).T.copy()
    half_v = float(special.stdtrit(n - 1, (1 + confidence) / 2) * b_v.std(ddof=1) / np.sqrt(n))
    mean_v = float(b_v.mean())
    said = _suggestion(half_v, float(a_v.mean()), planned, settings)
    return SpecimenFit(specimen, n, mean_v, mean_v - half_v, mean_v + half_v, said)


def _suggestion(half_v: float, level_v: float, planned: int, settings: SessionSettings) -> str:
    if settings.stop != "width" or planned >= settings.most_presses or level_v <= 0:
        return ""
    width = half_v / level_v
    if width <= settings.width:
        return ""
    wide, wanted = f"{100 * width:.0f} %", f"{100 * settings.width:.3g} %"
    return f"The interval of b is {wide} of the activity at 1 N; {wanted} is wanted. One more press is suggested."
