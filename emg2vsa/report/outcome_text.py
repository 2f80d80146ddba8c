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
from emg2vsa.report.wording import NO_BREAK, UNDEFINED, aligned, number, p_parts, p_text
from emg2vsa.statistics.outcome import Outcome
from emg2vsa.statistics.power import MEANING, PairPower, PowerTable

Style = Literal["apa", "ieee", "latex", "plain"]
STYLES: tuple[Style, ...] = ("apa", "ieee", "latex", "plain")

_SYMBOLS = {
    "chi2": ("χ²", r"\chi^2"), "BF01": ("BF₀₁", r"\mathrm{BF}_{01}"), "eta2": ("η²", r"\eta^2"),
    "omega2": ("ω²", r"\omega^2"), "partial eta2": ("η²_p", r"\eta^2_p"), "partial omega2": ("ω²_p", r"\omega^2_p"),
    "generalised eta2": ("η²_G", r"\eta^2_G"), "rank epsilon2": ("ε²_R", r"\varepsilon^2_R"),
    "rank-biserial": ("r_rb", r"r_\mathrm{rb}"), "Kendall's W": ("Kendall's W", r"W_\mathrm{Kendall}"),
    "Hedges g": ("g", "g"), **{letter: (letter, letter) for letter in "pFHDUtqWz"},
}  # fmt: skip
"""Statistics and effects as Unicode and as mathematics; a name that is not here is text, and stays as it is."""
_AT_MOST_ONE = frozenset(_SYMBOLS) - {"chi2", "BF01", "Hedges g", *"pFHDUtqWz"} | {"rank correlation"}
_COUNTS = frozenset({"D", "W"})
"""Statistics without degrees of freedom whose n stands in their place."""


def said(outcome: Outcome, style: Style = "apa") -> str:
    """``F(4, 45) = 5.23, p = .002, ω² = .25, 95% CI [.08, .46], η² = .32``; what it does not have is left out."""
    effect = "" if _undefined(outcome) else effect_said(outcome, style)
    return ", ".join(filter(None, (statistic_said(outcome, style), effect)))


def statistic_said(outcome: Outcome, style: Style = "apa") -> str:
    """The statistic and p alone."""
    if _undefined(outcome):
        return "not defined"
    parts = [] if outcome.statistic_name is None or outcome.statistic is None else [_statistic(outcome, style)]
    return ", ".join(parts if outcome.p is None else [*parts, p_said(outcome.p, style)])


def effect_said(outcome: Outcome, style: Style = "apa") -> str:
    """The estimate with its interval, and the effect."""
    parts = []
    if outcome.estimate_name is not None and outcome.estimate is not None:
        parts.append(_named(outcome.estimate_name, outcome.estimate, style))
        if outcome.interval and outcome.confidence and not math.isnan(outcome.estimate):
            share = _is_share(outcome.estimate_name)
            parts.append(_interval(*outcome.interval, outcome.confidence, style, share=share))
    if outcome.effect_name is not None and outcome.effect_size is not None:
        parts.append(_named(outcome.effect_name, outcome.effect_size, style))
    return ", ".join(parts)


def p_said(p: float, style: Style = "apa") -> str:
    """``p = .039``, ``p < .001``; plain: four digits, however small."""
    if style == "apa" or math.isnan(p):
        return p_text(p) if style == "apa" else "p not defined"
    relation, value = ("=", f"{p:.4g}") if style == "plain" else p_parts(p)
    return _equation("p", re.sub(r"^\.", "0.", value) if style == "ieee" else value, style, relation)


def range_said(name: str, values: Floats, style: Style = "apa") -> str:
    """One value of (n,) in full (``η² = .32``), the range of many (``η² from .12 to .61``)."""
    known = values[~np.isnan(values)]
    shown = span_said(known, style, share=_is_share(name))
    if known.size and " to " not in shown:
        return _named(name, float(known[0]), style)
    return f"{_symbol(name, style)} {'from ' if known.size else ''}{shown}"


def span_said(values: Floats, style: Style = "apa", *, share: bool = False) -> str:
    """``.32``, or ``.12 to .61``, of (n,) without NaN."""
    known = values[~np.isnan(values)]
    if not known.size:
        return "not defined"
    ends = dict.fromkeys(_value(float(end), style, share=share) for end in (known.min(), known.max()))
    return " to ".join(f"${end}$" if style == "latex" else end for end in ends)


def _interval(low: float, high: float, confidence: float, style: Style, *, share: bool) -> str:
    """``95% CI [.08, .46]``."""
    ends = ", ".join(_value(end, style, share=share) for end in (low, high))
    limits = f"$[{ends}]$" if style == "latex" else f"[{ends}]"
    if math.isnan(high - low) or (math.isinf(low) and math.isinf(high)):
        # NaN too where both ends are infinite on one side
        limits = f"not defined{'' if math.isnan(high - low) else ' at this n'}"
    percent = {"latex": r"\,\%", "apa": "%"}.get(style, " %")
    said = f"{100 * confidence:g}{percent} CI {limits}"
    return said if style in ("latex", "plain") else said.replace(" ", NO_BREAK)


def _undefined(outcome: Outcome) -> bool:
    return any(map(math.isnan, (*outcome.df, *([] if outcome.statistic is None else [outcome.statistic]))))


def _statistic(outcome: Outcome, style: Style) -> str:
    name, value = outcome.statistic_name or "", float(outcome.statistic or 0)
    df = outcome.df or ((float(outcome.n),) if name in _COUNTS else ())
    of = [f"{each:.6g}" if style == "plain" else f"{each:.{0 if each == round(each) else 1}f}" for each in df]
    shown = ", ".join([*of, *([f"N = {outcome.n}"] if name == "chi2" else [])])
    fixed = 0.005 <= abs(value) < 1e6 or value == 0
    shown = shown.replace(" ", NO_BREAK) if style in ("apa", "ieee") else shown
    return _equation(name, _value(value, style, 2 if fixed else None), style, of=f"({shown})" if shown else "")


def _named(name: str, value: float, style: Style) -> str:
    if math.isnan(value):
        return f"{_symbol(name, style)} not defined"
    return _equation(name, _value(value, style, share=_is_share(name)), style)


def _symbol(name: str, style: Style) -> str:
    if style == "latex":
        return f"${_SYMBOLS[name][1]}$" if name in _SYMBOLS else latex_text(name)
    return name if style == "plain" else _SYMBOLS.get(name, (name,))[0]


def _is_share(name: str) -> bool:
    return name in _AT_MOST_ONE or name.startswith("ICC")


def _value(value: float, style: Style, decimals: int | None = None, *, share: bool = False) -> str:
    """``decimals``, else three digits; of a share two decimals and, but for IEEE, no zero before the point."""
    if style == "plain":
        return f"{value:.6g}"
    if not math.isfinite(value):
        nan, infinity = ("--", r"\infty") if style == "latex" else (UNDEFINED, "∞")
        return nan if math.isnan(value) else f"{'-' if value < 0 else ''}{infinity}"
    decimals = 2 if share else decimals
    shown = number(value) if decimals is None else f"{value:.{decimals}f}"
    shown = re.sub(r"^(-?)0\.", r"\1.", shown) if share and style != "ieee" else shown
    return latex_number(shown).removeprefix(r"\ensuremath{").removesuffix("}") if style == "latex" else shown


def _equation(name: str, value: str, style: Style, relation: str = "=", of: str = "") -> str:
    """``F(4, 45) = 5.23``."""
    if style == "latex":
        symbol = _SYMBOLS.get(name)
        return f"${symbol[1]}{of} {relation} {value}$" if symbol else f"{latex_text(name)}{of} ${relation} {value}$"
    space = " " if style == "plain" else NO_BREAK
    return f"{_symbol(name, style)}{of}{space}{relation}{space}{value}"


def pair_words(found: PairPower, design: str, n: int, target: float) -> tuple[dict[str, Any], list[str]]:
    """Words on the power of two treatments; n : people, of each group for "equal-groups". target : the wanted power."""
    groups, paired = design == "equal-groups", design == "paired"
    of = f"to find equality within {found.margin:g} SD where the true difference is {found.effect:g} SD"
    name, least = "smallest_margin", "margin shown"
    if paired:
        name, least = "smallest_effect", "difference found"
        of = f"to find a mean difference of {found.effect:g} SD of the differences"
    lines = [
        f"power {found.power:.4f} with {'two groups of ' * groups}{n} participants {of}",
        f"participants needed{' in each group' * groups} for power {target:g}: {found.needed or 'more than a million'}",
        f"smallest {least} with power {target:g}: {found.least:.3f} SD{' of the differences' * paired}",
    ]
    told = {"design": design, "power": found.power, "participants_needed": found.needed or None, name: found.least}
    return told, lines


def repeated_words(
    power: float, needed: int, table: PowerTable, n: int, m: int, target: float, *, sensitivity: bool
) -> tuple[dict[str, Any], list[str]]:
    """Words on the power of n people measured m times each. needed : 0 where more than a million. sensitivity :
    lines of the table too.
    """
    lines = [
        f"power {power:.4f} with {n} participants measured {m} times each",
        f"participants needed for power {target:g}: {needed or 'more than a million'}",
    ]
    if sensitivity:
        rows = [["rho", *(f"{epsilon:.2f}" for epsilon in table.epsilon)]]
        for rho, powers, people in zip(table.rho, table.power, table.people, strict=True):
            cells = (f"{p:.4f} ({k or '>1e6'})" for p, k in zip(powers, people, strict=True))
            rows.append([f"{rho:.2f}", *cells])
        lines += ["power (participants needed) over rho (down) and epsilon (across)", *aligned(rows)]
    over = {key: getattr(table, key).tolist() for key in ("rho", "epsilon", "power")}
    over["participants_needed"] = table.people.tolist()
    told = {"power": power, "participants_needed": needed or None, "sensitivity": over}
    return told, [*lines, f"The paper's design: {MEANING}"]
