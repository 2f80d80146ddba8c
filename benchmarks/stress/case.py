"""One row of the stress table: a function, a world that is hard for it, the truth, and the least digits it promises."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np
from mpmath import mp, mpf

from casr.errors import UserError

mp.dps = 50
MOST_DIGITS = 16.0
ROUNDED = -float(np.log10(np.finfo(np.float64).eps / 2))
"Digits of a double."
FEW_DIGITS = 6.0
"A number with fewer correct digits than this is no better than a guess to a reader: the function must say so."
_SHIFT = Fraction(1, 10**22)
_TRIES = 2

Inputs = tuple[Any, ...]
"Arrays of doubles; the truth gets the same arrays as exact fractions."
Numbers = Mapping[str, Any]


@dataclass(frozen=True)
class Found:
    """Numbers by name, and what a person reads beside them ("" for nothing)."""

    values: Numbers
    said: str = ""


@dataclass(frozen=True)
class Case:
    """
    inputs : doubles that both ways start from. ours : the function of the product. exact : the same formula in 50
    digits, of the inputs as exact fractions. size : what an error is a share of: each number itself, or the largest
    of its array ("largest", for signals), or a fixed number. bound : the least digits promised for this function in
    this world. condition : decimal digits that rounding the inputs takes, where it is not measured. must_say : the
    function has to warn here, whatever its digits. smoke : part of the short table.
    """

    function: str
    world: str
    inputs: Inputs
    ours: Callable[..., Found]
    exact: Callable[..., Numbers]
    bound: float
    size: str | float = "each"
    condition: float | None = None
    must_say: bool = False
    smoke: bool = False


@dataclass(frozen=True)
class Row:
    """digits : fewest of all numbers, by name the worst. allowed : what one rounding of every input leaves."""

    function: str
    world: str
    worst: str
    digits: float
    allowed: float
    bound: float
    verdict: str
    said: str
    seconds: float

    @property
    def kept(self) -> bool:
        return self.verdict != "broken"


def judged(case: Case) -> Row:
    """Run both ways and compare.

    The verdict: "kept" where the bound is reached and the function speaks where it must; "says so" where it falls
    short but refuses, or returns nothing but NaN and words; else "broken".
    """
    start = time.process_time()
    found, refused = _ours(case)
    if refused:
        return _row(case, "-", 0.0, case.condition or 0.0, "says so", found.said, start)
    exact = case.exact(*(_fractions(each) for each in case.inputs))
    condition = _condition(case, exact) if case.condition is None else case.condition
    digits = {name: fewest_digits(found.values.get(name), truth, case.size) for name, truth in exact.items()}
    worst = min(digits, key=digits.__getitem__)
    if all(_undefined(value) for value in found.values.values()):
        verdict = "says so" if found.said else "broken"
    else:
        silent = not found.said and (case.must_say or digits[worst] < FEW_DIGITS)
        verdict = "broken" if silent or digits[worst] < case.bound else "kept"
    return _row(case, worst, digits[worst], condition, verdict, found.said, start)


def _row(case: Case, worst: str, digits: float, condition: float, verdict: str, said: str, start: float) -> Row:
    allowed = min(max(ROUNDED - condition, 0.0), MOST_DIGITS)
    return Row(
        case.function, case.world, worst, digits, allowed, case.bound, verdict, said, time.process_time() - start
    )


def _ours(case: Case) -> tuple[Found, bool]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            found = case.ours(*case.inputs)
        except UserError as error:
            return Found({}, f"refused: {error}"), True
    said = [found.said, *(f"warning: {each.message}" for each in caught)]
    return Found(found.values, "; ".join(each for each in said if each)), False


def fewest_digits(found: Any, truth: Any, size: str | float = "each") -> float:
    """Correct digits of the worst of the numbers; 0 where one is missing or not a number."""
    if found is None:
        return 0.0
    values, exact = np.asarray(found, dtype=np.float64).ravel(), _flat(truth)
    if values.size != len(exact) or not np.all(np.isfinite(values)):
        return 0.0
    errors = [abs(mpf(value) - right) for value, right in zip(values.tolist(), exact, strict=True)]
    return min((_digits(e, s) for e, s in zip(errors, _sizes(exact, size), strict=True)), default=MOST_DIGITS)


def _sizes(exact: Sequence[Any], size: str | float) -> list[Any]:
    if size == "each":
        return [abs(right) or mpf(1) for right in exact]
    return [max(map(abs, exact)) if size == "largest" else mpf(size)] * len(exact)


def _digits(error: Any, size: Any) -> float:
    return MOST_DIGITS if error == 0 else float(min(mpf(MOST_DIGITS), max(mpf(0), -mp.log10(error / size))))


def _condition(case: Case, exact: Numbers) -> float:
    """log10 of how much larger than itself a relative error of the inputs is in the worst of the numbers."""
    rng = np.random.default_rng(0)
    worst = mpf(1)
    for _ in range(_TRIES):
        moved = case.exact(*(_moved(_fractions(each), rng) for each in case.inputs))
        for name, truth in exact.items():
            right, other = _flat(truth), _flat(moved[name])
            for a, b, size in zip(right, other, _sizes(right, case.size), strict=True):
                worst = max(worst, abs(a - b) / size / exactly(_SHIFT))
    return float(mp.log10(worst))


def _moved(values: Any, rng: np.random.Generator) -> Any:
    if not isinstance(values, np.ndarray):
        return values
    signs = rng.choice([-1, 1], values.size)
    flat = [value * (1 + int(sign) * _SHIFT) for value, sign in zip(values.ravel(), signs, strict=True)]
    return _objects(flat, values.shape)


def _fractions(values: Any) -> Any:
    if not isinstance(values, np.ndarray) or values.dtype.kind not in "f":
        return values
    return _objects([Fraction(value) for value in values.astype(np.float64).ravel().tolist()], values.shape)


def _objects(values: Iterable[Any], shape: tuple[int, ...]) -> np.ndarray:
    made = np.empty(int(np.prod(shape)), dtype=object)
    made[:] = list(values)
    return made.reshape(shape)


def exactly(value: Any) -> Any:
    """Fractions, one or an array of them, in 50 digits."""
    if isinstance(value, np.ndarray):
        return _objects([exactly(each) for each in value.ravel()], value.shape)
    return mpf(value.numerator) / value.denominator if isinstance(value, Fraction) else mpf(value)


def _flat(values: Any) -> list[Any]:
    return [exactly(value) for value in np.asarray(values, dtype=object).ravel()]


def _undefined(value: Any) -> bool:
    return bool(np.all(np.isnan(np.asarray(value, dtype=np.float64))))
