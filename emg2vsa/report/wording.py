"""How numbers, intervals, runs and designs are said (APA style); NaN is shown as not defined."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence

from emg2vsa.figures.palette import ActivityScale
from emg2vsa.settings import RunSettings

UNDEFINED = "–"
NO_BREAK = "\N{NO-BREAK SPACE}"
MINUS = "\N{MINUS SIGN}"
_HYPHEN_MINUS = re.compile(r"(?<![\w.)-])-(?=\.?\d)")
_PERCENT = re.compile(r"(?<=\d) ?%")


def typeset(text: str) -> str:
    """A true minus before a number, and a space that does not break before a percent sign: one way on every page."""
    return _PERCENT.sub(f"{NO_BREAK}%", _HYPHEN_MINUS.sub(MINUS, text))


def number(value: float | None, digits: int = 3) -> str:
    """``digits`` significant digits, zeros at the end kept; integers, and whole parts up to a million, in full."""
    if value is None or math.isnan(value):
        return UNDEFINED
    if math.isinf(value):
        return "∞" if value > 0 else f"{MINUS}∞"
    if isinstance(value, int) or value == 0 or 10**digits <= abs(value) < 1e6:
        return typeset(f"{value:.0f}")
    return typeset(f"{value:#.{digits}g}".removesuffix(".").replace(".e", "e"))


def bounded(value: float, decimals: int = 3) -> str:
    """A number that cannot exceed 1 in size (p, R², η²): fixed decimals and no leading zero; 1 only where it is 1."""
    value = min(value, 1 - 10**-decimals) if value < 1 else value
    return UNDEFINED if math.isnan(value) else typeset(re.sub(r"^(-?)0\.", r"\1.", f"{value:.{decimals}f}"))


def p_text(p: float) -> str:
    """``p = .039``, ``p < .001``, ``p > .999``."""
    if math.isnan(p):
        return f"p{NO_BREAK}not defined"
    return f"p{NO_BREAK}{NO_BREAK.join(p_parts(p))}"


def p_parts(p: float) -> tuple[str, str]:
    """Relation and value: ``=`` ``.039``, ``<`` ``.001``, ``>`` ``.999``; NaN is ``=`` ``–``."""
    relation, value = ("<", 0.001) if p < 0.001 else (">", 0.999) if p > 0.9995 else ("=", p)
    return relation, bounded(value)


def percent(share: float, digits: int = 3) -> str:
    """A share as percent."""
    return UNDEFINED if math.isnan(share) else f"{number(100 * share, digits)}{NO_BREAK}%"


def signed(value: float, unit: str = "") -> str:
    """A difference with its sign and one decimal: ``+3.1 %``, ``−0.4``."""
    return UNDEFINED if math.isnan(value) else typeset(f"{round(value, 1) + 0.0:+.1f} {unit}".rstrip())


def count(n: int, noun: str) -> str:
    """``1 trial``, ``2 trials``."""
    return f"{n} {noun}" if n == 1 else f"{n} {noun}s"


def activity(value: float, scale: ActivityScale) -> str:
    """A stored activity in the unit of ``scale``."""
    return f"{number(value * scale.factor)} {scale.unit}".rstrip()


def unwrapped(text: str) -> list[str]:
    """Lines of a text; one that begins with two spaces goes on with the line above it."""
    return text.replace("\n  ", " ").strip().splitlines()


def listed(names: Sequence[str]) -> str:
    """``S1, S3 and S5``."""
    return " and ".join(filter(None, [", ".join(names[:-1]), names[-1] if names else ""]))


def aligned(rows: Sequence[Sequence[str]], left: Sequence[int] = (0,)) -> Iterator[str]:
    """Lines of text with columns as wide as their longest cell. left : columns that are no numbers."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        cut = (c.ljust(w) if i in left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True)))
        yield "  ".join(cut).rstrip()


SIMULATED = "Simulated rig."
"""Ends the caption of a figure, or of a table, of emulated runs."""


def area_unit(unit: str) -> str:
    """mm² or px²."""
    return unit.replace("2", "²")


def interval(estimate: float, low: float, high: float) -> str:
    """``3.01 [1.70, 4.23]``, ``3.01 [1.70, ∞)``."""
    return UNDEFINED if estimate != estimate else f"{number(estimate)} {ends(low, high)}"


def ends(low: float, high: float) -> str:
    """``[1.70, 4.23]``; an end that is infinite is open."""
    return f"{'(' if math.isinf(low) else '['}{number(low)}, {number(high)}{')' if math.isinf(high) else ']'}"


def p_value(p: float) -> str:
    """``.039``, ``< .001``: a p where the letter stands beside it."""
    return " ".join(p_parts(p)).removeprefix("= ")


def exact_p(p: float) -> str:
    """A p of the paper, as it prints them: four decimals, two digits below .0001."""
    return bounded(p, 4) if p >= 1e-4 or p != p else number(p, 2)


_FLOW = {"pin-affine": "flow of the pins", "horn-schunck": "dense Horn–Schunck flow", "dis": "dense DIS flow"}
_FORCE = {"exposure": "force at exposure", "mean": "mean force per frame"}
_LAW = {"ode": "area by the exponential of growth", "paper": "area by equation (1) as printed"}
_RATE = {"power": "CASR by a power law", "slope": "CASR by a slope", "paper": "CASR by equation (2) as printed"}


def scored_by(settings: RunSettings) -> str:
    """The algorithm that scored the presses and its steps, for captions."""
    recipe = settings.recipe
    measured = [_FORCE[recipe.force_rule], _RATE[recipe.rate]]
    if settings.algorithm != "front":
        over = "the contact" if recipe.region == "contact" else "the whole image"
        flow = f"{_FLOW[recipe.engine]} over {over}"
        measured = [f"initial area by rule {recipe.area_rule}", flow, measured[0], _LAW[recipe.law], measured[1]]
    return f"algorithm {settings.algorithm}: {', '.join(measured)}"
