"""The quantities as files: results.json for programs, numbers.tex for papers."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Mapping

from emg2vsa.report.latex import latex_number, latex_text
from emg2vsa.report.quantity import Quantity

_DIGITS = ("Zero", "One", "Two", "Three", "Four", "Five", "Six", "Seven", "Eight", "Nine")


def results_json(found: Mapping[str, Quantity]) -> str:
    """Flat JSON object, keys sorted, one a line; every digit; null where a number is not defined."""
    plain = {key: None if isinstance(value, float) and math.isnan(value) else value for key, value in found.items()}
    return json.dumps(plain, indent=1, sort_keys=True, ensure_ascii=False, allow_nan=False) + "\n"


def numbers_tex(found: Mapping[str, Quantity]) -> str:
    r"""One ``\newcommand`` a quantity: ``fit.adj_r2.min`` is ``\FitAdjRTwoMin``; four significant digits."""
    names = macro_names(list(found))
    lines = [rf"\newcommand{{\{names[key]}}}{{{_latex(value)}}} % {key}" for key, value in found.items()]
    return "\n".join(["% Written by emg2vsa from results.json; include with \\input.", *lines, ""])


def macro_names(keys: list[str]) -> dict[str, str]:
    """Key to macro name: letters only, unique (keys that spell the same get X, XX, ...)."""
    names: dict[str, str] = {}
    taken: set[str] = set()
    for key in keys:
        name = _macro(key)
        while name in taken:
            name += "X"
        taken.add(name)
        names[key] = name
    return names


def _macro(key: str) -> str:
    words = re.findall(r"[A-Za-z]+|[0-9]", key)
    return "".join(_DIGITS[int(word)] if word.isdigit() else word[0].upper() + word[1:] for word in words)


def _latex(value: Quantity) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return latex_text(value)
    if isinstance(value, int):
        return str(value)
    if math.isnan(value):
        return "--"
    return latex_number(f"{value:.4g}")
