"""The quantities: a number, or a word, under a flat name that tells its unit and whether it is a p; and their files."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.report.latex import latex_number, latex_text
from emg2vsa.report.table import Table
from emg2vsa.report.wording import p_parts

Quantity = str | int | float | bool
Items = Iterator[tuple[str, Quantity]]


def fields_of(name: str, found: object, *keys: str, at: Any = None) -> Items:
    """``name.key`` of attributes of ``found`` of these names. at : place in those that are arrays."""
    for key in keys:
        value = getattr(found, key)
        value = value if at is None else value[at]
        yield f"{name}.{key}", value.item() if isinstance(value, np.generic) else value


def named(name: str, **found: Quantity | None) -> Items:
    """``name.key`` of each; NaN where there is none."""
    yield from ((f"{name}.{key}", np.nan if value is None else value) for key, value in found.items())


def with_interval(name: str, estimate: float, low: float, high: float) -> Items:
    """An estimate and its ends."""
    yield from zip((name, f"{name}.low", f"{name}.high"), map(float, (estimate, low, high)), strict=True)


def moments(name: str, values: Floats) -> Items:
    """Mean and SD of the finite ``values`` (n,); NaN where there are too few."""
    known = values[np.isfinite(values)]
    yield f"{name}.mean", float(np.mean(known)) if known.size else np.nan
    yield f"{name}.sd", float(np.std(known, ddof=1)) if known.size > 1 else np.nan


def least(values: Floats) -> float:
    """Smallest finite value of (n,), or NaN."""
    return float(np.min(values, initial=np.inf, where=np.isfinite(values))) if np.isfinite(values).any() else np.nan


def most(values: Floats) -> float:
    """Largest finite value of (n,), or NaN."""
    return -least(-values)


def median(values: Floats) -> float:
    """Median of the finite values of (n,); NaN where none is finite."""
    return float(np.nanmedian(values)) if np.isfinite(values).any() else np.nan


_UNITS = {
    "nm_per_rad": "N·m/rad", "n_per_mm": "N/mm", "mm2_per_n": "mm²/N", "px2_per_n": "px²/N", "deg_per_s": "°/s",
    "mm_per_s": "mm/s", "mm2": "mm²", "px2": "px²", "mm": "mm", "deg": "°", "percent": "%", "hz": "Hz", "ms": "ms",
    "s": "s", "n": "N", "v": "V",
}  # fmt: skip
_STATISTICS = frozenset({"mean", "sd", "median", "min", "max", "low", "high"})
_P = re.compile(r"(?:.*_)?p(?:_gg|_hf)?")


def unit_of(key: str) -> str:
    """Unit of the quantity ``key``, "" where it has none: ``fit.S1.b_v.mean`` is in V, ``fit.S1.n`` is a count."""
    words = key.split(".")
    name = words[-2] if words[-1] in _STATISTICS and len(words) > 1 else words[-1]
    if name in _STATISTICS:
        return ""
    for ending, unit in _UNITS.items():
        if name.endswith(f"_per_{ending}"):
            return ""
        # a letter alone is a name: n is a count, f a statistic
        if name.endswith(f"_{ending}") or (name == ending and len(ending) > 1):
            return unit
    return ""


def is_p(key: str) -> bool:
    """Whether the quantity is a p: its name ends so, or is the test that corrected a ``worst_p``."""
    words = key.split(".")
    return bool(_P.fullmatch(words[-1])) or words[-2:-1] == ["worst_p"]


_DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")


def results_json(found: Mapping[str, Quantity]) -> str:
    """Flat JSON object, keys sorted, one a line; every digit; null where a number is not defined.

    An interval without an upper end has "inf" there, as text: JSON knows no infinity.
    """
    known = {key: None if value != value else value for key, value in found.items()}
    plain = {key: str(value) if value in (math.inf, -math.inf) else value for key, value in known.items()}
    return json.dumps(plain, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def numbers_tex(found: Mapping[str, Quantity]) -> str:
    r"""One macro a quantity: ``fit.adj_r2.min`` is ``\emgFitAdjRTwoMin``.

    Numbers have four significant digits and their unit; a p says its relation, as ``p < .001``.
    """
    names = macro_names(list(found))
    lines = [rf"\newcommand{{\{names[key]}}}{{{_latex(key, value)}}} % {key}" for key, value in found.items()]
    return "\n".join([_HEAD, *lines, ""])


_HEAD = r"""% Written by emg2vsa; include with \input. After each macro: the key of its number in results.json.
% Redefine the next two before this file to set units and p your way, e.g. \newcommand{\emgquantity}[2]{\SI{#1}{#2}}.
\providecommand{\emgquantity}[2]{\mbox{#1\,#2}}
\providecommand{\emgp}[2]{\ensuremath{p #1 #2}}"""


def macro_names(keys: list[str], prefix: str = "emg") -> dict[str, str]:
    """Key to macro name: letters only, unique (keys that spell the same get X, XX, ...)."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for key in keys:
        words = re.findall(r"[A-Za-z]+|[0-9]", key)
        name = prefix + "".join(_DIGITS[int(w)] if w.isdigit() else w[0].upper() + w[1:] for w in words)
        while name in taken:
            name += "X"
        taken.add(name)
        names[key] = name
    return names


def statements_tex(table: Table) -> str:
    r"""One ``\newcommand`` a statement, e.g. ``\emgTestOverPeopleFriedman``."""
    names = macro_names([f"{row['key']}.{row['method']}" for row in table.rows], "emgTest")
    lines = [
        rf"\newcommand{{\{name}}}{{{row['latex']}}} % {row['key']}, {row['method']}"
        for name, row in zip(names.values(), table.rows, strict=True)
    ]
    return "\n".join(["% Written by emg2vsa; include with \\input. Needs amsmath.", *lines, ""])


def _latex(key: str, value: Quantity) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return latex_text(value)
    if math.isnan(value):
        return "--"
    if math.isinf(value):
        return r"\ensuremath{\infty}" if value > 0 else r"\ensuremath{-\infty}"
    if is_p(key):
        relation, shown = p_parts(value)
        return rf"\emgp{{{relation}}}{{{shown}}}"
    unit = unit_of(key)
    if unit == "V" and value:  # few volts are said in mV or µV
        factor, unit = next((f, u) for f, u, least in _VOLTS if abs(value) >= least)
        value *= factor
    shown = str(value) if isinstance(value, int) else latex_number(f"{value:.4g}")
    return rf"\emgquantity{{{shown}}}{{{latex_text(unit)}}}" if unit else shown


_VOLTS = ((1.0, "V", 1.0), (1e3, "mV", 1e-3), (1e6, "µV", 0.0))
