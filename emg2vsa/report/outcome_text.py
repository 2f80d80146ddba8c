"""One result as a journal prints it: APA, IEEE, LaTeX (APA's numbers in mathematics) or plain text in full digits.

And the power of a design: for programs, and in lines for people.
"""

from __future__ import annotations

import math
import re
from typing import Any, Literal

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.report.latex import latex_number, latex_text
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, number, p_text
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.power import MEANING, PairPower, PowerTable

Style = Literal["apa", "ieee", "latex", "plain"]
STYLES: tuple[Style, ...] = ("apa", "ieee", "latex", "plain")

_SYMBOLS = {
    "chi2": ("χ²", r"\chi^2"),
    "BF01": ("BF₀₁", r"\mathrm{BF}_{01}"),
    "eta2": ("η²", r"\eta^2"),
    "omega2": ("ω²", r"\omega^2"),
    "partial eta2": ("η²_p", r"\eta^2_p"),
    "partial omega2": ("ω²_p", r"\omega^2_p"),
    "generalised eta2": ("η²_G", r"\eta^2_G"),
    "rank epsilon2": ("ε²_R", r"\varepsilon^2_R"),
    "rank-biserial": ("r_rb", r"r_\mathrm{rb}"),
    "Kendall's W": ("Kendall's W", r"W_\mathrm{Kendall}"),
    "Hedges g": ("g", "g"),
}
"""Names of statistics and effects as Unicode and as mathematics; a name that is not here stays as it is."""
_AT_MOST_ONE = frozenset(
    {
        "eta2", "omega2", "partial eta2", "partial omega2", "generalised eta2", "rank epsilon2", "rank-biserial",
        "Kendall's W", "rank correlation",
    }
)  # fmt: skip
_COUNTS = frozenset({"D", "W"})
"""Statistics without degrees of freedom whose n stands in their place."""


def said(outcome: Outcome, style: Style = "apa") -> str:
    """``F(4, 45) = 5.23, p = .002, ω² = .25, 95% CI [.08, .46], η² = .32``; what the outcome does not have is left
    out."""
    if _undefined(outcome):
        return "not defined"
    parts = (_statistic(outcome, style), _p(outcome, style), effect_said(outcome, style))
    return ", ".join(filter(None, parts))


def statistic_said(outcome: Outcome, style: Style = "apa") -> str:
    """The statistic and p alone."""
    if _undefined(outcome):
        return "not defined"
    return ", ".join(filter(None, (_statistic(outcome, style), _p(outcome, style))))


def effect_said(outcome: Outcome, style: Style = "apa") -> str:
    """The estimate with its interval, and the effect."""
    return ", ".join(filter(None, (_estimate(outcome, style), _effect(outcome, style))))


def p_said(p: float, style: Style = "apa") -> str:
    """``p = .039``, ``p < .001``; plain: four digits, however small."""
    if style == "apa":
        return p_text(p)
    if math.isnan(p):
        return "p not defined"
    if style == "plain":
        return f"p = {p:.4g}"
    relation, value = ("<", 0.001) if p < 0.001 else (">", 0.999) if p > 0.9995 else ("=", p)
    return _equation("p", "p", _decimals(value, 3, style, at_most_one=True), style, relation)


def range_said(name: str, values: Floats, style: Style = "apa") -> str:
    """One value in full (``η² = .32``), the range of many (``η² from .12 to .61``)."""
    known = values[~np.isnan(values)]
    shown = span_said(known, style, at_most_one=_is_share(name))
    if known.size and " to " not in shown:
        return _named(name, float(known[0]), style)
    return f"{_symbol(name, style)} {'from ' if known.size else ''}{shown}"


def span_said(values: Floats, style: Style = "apa", *, at_most_one: bool = False) -> str:
    """``.32``, or ``.12 to .61``."""
    known = values[~np.isnan(values)]
    if not known.size:
        return "not defined"
    ends = dict.fromkeys(_value(float(end), style, at_most_one=at_most_one) for end in (known.min(), known.max()))
    return " to ".join(f"${end}$" for end in ends) if style == "latex" else " to ".join(ends)


def _interval_said(
    low: float, high: float, confidence: float, style: Style = "apa", *, at_most_one: bool = False
) -> str:
    """``95% CI [.08, .46]``."""
    ends = ", ".join(_value(end, style, at_most_one=at_most_one) for end in (low, high))
    limits = f"$[{ends}]$" if style == "latex" else f"[{ends}]"
    if math.isnan(high - low):  # NaN, or both ends infinite on one side
        limits = "not defined"
    elif math.isinf(low) and math.isinf(high):
        limits = "not defined at this n"
    level = f"{100 * confidence:g}"
    if style == "latex":
        return rf"{level}\,\% CI {limits}"
    sign = "%" if style == "apa" else " %"
    return f"{level}{sign} CI {limits}".replace(" ", " " if style == "plain" else NO_BREAK)


def _undefined(outcome: Outcome) -> bool:
    numbers = (*outcome.df, *([] if outcome.statistic is None else [outcome.statistic]))
    return any(map(math.isnan, numbers))


def _statistic(outcome: Outcome, style: Style) -> str:
    name, value = outcome.statistic_name, outcome.statistic
    if name is None or value is None:
        return ""
    df = outcome.df or ((float(outcome.n),) if name in _COUNTS else ())
    shown = ", ".join([*(_df(each, style) for each in df), *([f"N = {outcome.n}"] if name == "chi2" else [])])
    if style in ("apa", "ieee"):
        shown = shown.replace(" ", NO_BREAK)
    of = f"({shown})" if shown else ""
    plain, mathematics = _SYMBOLS.get(name, (name, name))
    if style == "plain":
        plain = name
    return _equation(f"{plain}{of}", f"{mathematics}{of}", _of_statistic(value, style), style)


def _p(outcome: Outcome, style: Style) -> str:
    return "" if outcome.p is None else p_said(outcome.p, style)


def _effect(outcome: Outcome, style: Style) -> str:
    if outcome.effect_name is None or outcome.effect_size is None:
        return ""
    return _named(outcome.effect_name, outcome.effect_size, style)


def _estimate(outcome: Outcome, style: Style) -> str:
    name = outcome.estimate_name
    if name is None or outcome.estimate is None:
        return ""
    text = _named(name, outcome.estimate, style)
    if outcome.interval is None or outcome.confidence is None or math.isnan(outcome.estimate):
        return text
    return f"{text}, {_interval_said(*outcome.interval, outcome.confidence, style, at_most_one=_is_share(name))}"


def _named(name: str, value: float, style: Style) -> str:
    if math.isnan(value):
        return f"{_symbol(name, style)} not defined"
    shown = _value(value, style, at_most_one=_is_share(name))
    if style == "latex":
        return f"{_symbol(name, style)} $= {shown}$" if name not in _SYMBOLS else f"${_SYMBOLS[name][1]} = {shown}$"
    return _equation(_symbol(name, style), "", shown, style)


def _symbol(name: str, style: Style) -> str:
    if style == "latex":
        return f"${_SYMBOLS[name][1]}$" if name in _SYMBOLS else latex_text(name)
    return name if style == "plain" else _SYMBOLS.get(name, (name,))[0]


def _is_share(name: str) -> bool:
    return name in _AT_MOST_ONE or name.startswith("ICC")


def _value(value: float, style: Style, *, at_most_one: bool) -> str:
    """An effect or the end of an interval: shares with two decimals, anything else with three digits."""
    if style == "plain":
        return f"{value:.6g}"
    if at_most_one:
        return _decimals(value, 2, style, at_most_one=True)
    return _finite(value, number(value) if math.isfinite(value) else "", style)


def _of_statistic(value: float, style: Style) -> str:
    if style == "plain":
        return f"{value:.6g}"
    fixed = 0.005 <= abs(value) < 1e6 or value == 0
    return _finite(value, f"{value:.2f}" if fixed else number(value), style)


def _decimals(value: float, decimals: int, style: Style, *, at_most_one: bool) -> str:
    shown = _finite(value, f"{value:.{decimals}f}", style)
    return re.sub(r"^(-?)0\.", r"\1.", shown) if at_most_one and style in ("apa", "latex") else shown


def _finite(value: float, shown: str, style: Style) -> str:
    if math.isnan(value):
        return UNDEFINED if style != "latex" else "--"
    if math.isinf(value):
        return ("-" if value < 0 else "") + (r"\infty" if style == "latex" else "∞")
    return latex_number(shown).removeprefix(r"\ensuremath{").removesuffix("}") if style == "latex" else shown


def _df(value: float, style: Style) -> str:
    if style == "plain":
        return f"{value:.6g}"
    return f"{value:.0f}" if value == round(value) else f"{value:.1f}"


def _equation(plain: str, mathematics: str, value: str, style: Style, relation: str = "=") -> str:
    if style == "latex":
        return f"${mathematics} {relation} {value}$"
    space = " " if style == "plain" else NO_BREAK
    return f"{plain}{space}{relation}{space}{value}"


def pair_words(found: PairPower, design: str, n: int, target: float) -> tuple[dict[str, Any], list[str]]:
    """Of two treatments; n : people, of each group for "equal-groups". target : the wanted power."""
    each = " in each group" if design == "equal-groups" else ""
    who = f"two groups of {n} participants" if each else f"{n} participants"
    if design == "paired":
        name, of = "smallest_effect", f"to find a mean difference of {found.effect:g} SD of the differences"
        least = f"smallest difference found with power {target:g}: {found.least:.3f} SD of the differences"
    else:
        name = "smallest_margin"
        of = f"to find equality within {found.margin:g} SD where the true difference is {found.effect:g} SD"
        least = f"smallest margin shown with power {target:g}: {found.least:.3f} SD"
    lines = [
        f"power {found.power:.4f} with {who} {of}",
        f"participants needed{each} for power {target:g}: {found.needed or 'more than a million'}",
        least,
    ]
    told = {"design": design, "power": found.power, "participants_needed": found.needed or None, name: found.least}
    return told, lines


def repeated_words(
    power: float, needed: int, table: PowerTable, n: int, m: int, target: float, *, sensitivity: bool
) -> tuple[dict[str, Any], list[str]]:
    """Of n people measured m times each. needed : people, 0 where more than a million. sensitivity : lines of the
    table too."""
    lines = [
        f"power {power:.4f} with {n} participants measured {m} times each",
        f"participants needed for power {target:g}: {needed or 'more than a million'}",
    ]
    if sensitivity:
        lines.append("power (participants needed) over rho (down) and epsilon (across)")
        lines.append("rho    " + "".join(f"{epsilon:>16.2f}" for epsilon in table.epsilon))
        for rho, powers, people in zip(table.rho, table.power, table.people, strict=True):
            cells = (f"{p:.4f} ({k or '>1e6'})" for p, k in zip(powers, people, strict=True))
            lines.append(f"{rho:<7.2f}" + "".join(f"{cell:>16}" for cell in cells))
    over = {
        "rho": table.rho.tolist(), "epsilon": table.epsilon.tolist(), "power": table.power.tolist(),
        "participants_needed": table.people.tolist(),
    }  # fmt: skip
    told = {"power": power, "participants_needed": needed or None, "sensitivity": over}
    return told, [*lines, f"The paper's design: {MEANING}"]
