"""A muscle seen through the electrode of another, by the share that somebody measured, taken out in power.

Farina et al. and Lowery et al. 2003: correlation and filters do not tell crosstalk from co-contraction, so the share
is the operator's, from a contraction of one muscle alone. Signals of two muscles are independent and add in power.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.errors import SettingError

LEAST_LEFT = 0.25
"Share of the power of a level that stays at least."
KNOWN_TO = 0.2
"A measured share is right within this share of itself, which an interval holds."


def without_crosstalk(
    envelopes_v: Floats, levels_v: Floats, muscles: tuple[str, ...], shares: Mapping[str, Mapping[str, float]]
) -> tuple[Floats, Floats]:
    """Envelopes and their smooth levels (m, N) without what other muscles add; along the tangent at the level.

    shares : muscle to the others that its electrode sees, each with its share of its own amplitude. SettingError for a
    muscle that is not recorded, and for shares by which muscles cannot be told apart.
    That the share must be stated: Farina et al. and Lowery et al. (2003).
    """
    unknown = [name for into, of in shares.items() for name in (into, *of) if name not in muscles or into in of]
    if unknown:
        raise SettingError(
            "cocontraction.crosstalk", wanted=f"another muscle of {', '.join(muscles)} in each", found=unknown[0],
            do="Write crosstalk = { EDC = { FDS = 0.2 } }, where EDC sees a fifth of the amplitude of FDS.",
        )  # fmt: skip
    mixing = np.eye(len(muscles))
    for into, of in shares.items():
        for other, share in of.items():
            mixing[muscles.index(into), muscles.index(other)] = share**2
    if np.linalg.cond(mixing) > 1e3:
        raise SettingError(
            "cocontraction.crosstalk", wanted="muscles that can be told apart", found="channels that hold the same",
            do="Measure the shares again, each with one muscle tensed alone.",
        )  # fmt: skip
    power = levels_v**2
    share = np.divide(np.linalg.solve(mixing, power), power, out=np.ones_like(power), where=power > 0)
    left = np.sqrt(np.clip(share, LEAST_LEFT, 1.0))
    return np.maximum(levels_v * left + (envelopes_v - levels_v) / left, 0.0), levels_v * left
