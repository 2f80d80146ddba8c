"""Numbers as sentences and tables show them (APA style); NaN is shown as not defined, never as a number."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from emg2vsa.figures.activity_scale import ActivityScale

UNDEFINED = "–"
NO_BREAK = "\N{NO-BREAK SPACE}"


def number(value: float | None, digits: int = 3) -> str:
    """``digits`` significant digits, zeros at the end kept; integers, and whole parts up to a million, in full."""
    if value is None or math.isnan(value):
        return UNDEFINED
    if isinstance(value, int) or value == 0 or 10**digits <= abs(value) < 1e6:
        return f"{value:.0f}"
    return f"{value:#.{digits}g}".removesuffix(".").replace(".e", "e")


def bounded(value: float, decimals: int = 3) -> str:
    """A number that cannot exceed 1 in size (p, R², η²): fixed decimals and no leading zero."""
    return UNDEFINED if math.isnan(value) else re.sub(r"^(-?)0\.", r"\1.", f"{value:.{decimals}f}")


def p_text(p: float) -> str:
    """``p = .039``, ``p < .001``."""
    if math.isnan(p):
        return f"p{NO_BREAK}not defined"
    return f"p{NO_BREAK}<{NO_BREAK}.001" if p < 0.001 else f"p{NO_BREAK}={NO_BREAK}{bounded(p)}"


def f_text(f: float, df1: float, df2: float, p: float, eta2: float) -> str:
    """``F(4, 45) = 5.23, p = .002, η² = .32``."""
    shown = f"F({df1:.0f}, {df2:.0f}) = {f:.2f}, {p_text(p)}, η² = {bounded(eta2, 2)}"
    return shown.replace(" = ", f"{NO_BREAK}={NO_BREAK}")


def t_text(t: float, df: float, p: float) -> str:
    """``t(45) = 2.12, p = .039``."""
    return f"t({df:.0f}) = {t:.2f}, {p_text(p)}"


def percent(share: float, digits: int = 3) -> str:
    """A share as percent."""
    return UNDEFINED if math.isnan(share) else f"{number(100 * share, digits)}{NO_BREAK}%"


def count(n: int, noun: str) -> str:
    """``1 trial``, ``2 trials``."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def activity(value: float, scale: ActivityScale) -> str:
    """A stored activity in the unit of ``scale``."""
    return f"{number(value * scale.factor)} {scale.unit}".rstrip()


def listed(names: Sequence[str]) -> str:
    """``S1, S3 and S5``."""
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1] if names else ""]))
