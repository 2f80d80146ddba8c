"""Logarithmic, exponential, robust and general fits where forces are alike, offset, or of extreme scale."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.stress.case import Case, Found
from benchmarks.stress.exact_curves import exact_exponential, exact_huber, exact_line, mpfs
from emg2vsa.curves.exponential import fit_exponential, fit_exponential_log
from emg2vsa.curves.line import TUNING, fit_line_huber
from emg2vsa.curves.logarithmic import fit_log, said_of_forces
from emg2vsa.curves.plate import fit_hooke


def cases() -> Iterator[Case]:
    yield from _logarithmic()
    yield from _robust()
    yield from _exponential()
    yield from _hooke()


def _forces(n: int = 40) -> np.ndarray:
    return np.geomspace(0.5, 7.0, n)


def _activity(force_n: np.ndarray, noise: float = 0.1) -> np.ndarray:
    relative = np.log(force_n) / np.ptp(np.log(force_n))
    return 2e-5 * (1 + relative + noise * np.random.default_rng(3).standard_normal(force_n.size))


def _logarithmic() -> Iterator[Case]:
    force = _forces()
    v = _activity(force)
    alike = {share: 3.0 * (1 + share * np.linspace(0, 1, 40)) for share in (1e-3, 1e-6, 1e-9, 1e-12)}
    yield log_case("as measured", force, v, 14.0, smoke=True)
    yield log_case("v x 1e-200", force, v * 1e-200, 14.0, smoke=True)
    yield log_case("v x 1e300", force, v * 1e300, 14.0)
    yield log_case("v and F single precision", force.astype(np.float32), v.astype(np.float32), 14.0)
    yield log_case("v + 1e6 x slope", force, v + 20.0, 9.0, smoke=True)
    yield log_case("v + 1e9 x slope", force, v + 2e4, 6.0)
    yield log_case("forces x 1e-300", force * 1e-300, v, 11.0)
    yield log_case("perfect fit, noise 1e-12", force, _activity(force, 1e-12), 12.0, names=("a", "b", "R2"))
    yield log_case("perfect fit, noise 1e-6: errors", force, _activity(force, 1e-6), 8.0)
    yield log_case("two points", force[[0, -1]], v[[0, -1]], 14.0, names=("a", "b"))
    for share, bound in ((1e-3, 11.0), (1e-6, 8.0), (1e-9, 5.0), (1e-12, 2.0)):
        yield log_case(
            f"forces within {share:g} of each other",
            alike[share],
            _activity(alike[share]),
            bound,
            names=("b", "SE(b)"),
            must_say=share < 1e-3,
            smoke=share in (1e-6, 1e-12),
        )


def log_case(
    world: str,
    force: np.ndarray,
    v: np.ndarray,
    bound: float,
    *,
    names: tuple[str, ...] = ("a", "b", "SE(b)", "R2"),
    must_say: bool = False,
    smoke: bool = False,
) -> Case:
    """v = a + b ln F by least squares."""

    def ours(f: np.ndarray, y: np.ndarray) -> Found:
        fit = fit_log(f, y)
        values = {"a": fit.a, "b": fit.b, "SE(a)": fit.a_se, "SE(b)": fit.b_se, "R2": fit.r2}
        return Found({name: values[name] for name in names}, said_of_forces(np.atleast_2d(f))[0])

    def exact(f: np.ndarray, y: np.ndarray) -> dict[str, Any]:
        if len(f) == 2:
            slope = (mpfs(y)[1] - mpfs(y)[0]) / mp.log(mpfs(f)[1] / mpfs(f)[0])
            return {"a": mpfs(y)[0] - slope * mp.log(mpfs(f)[0]), "b": slope}
        line = exact_line([mp.log(value) for value in mpfs(f)], mpfs(y))
        return {name: line[name] for name in names}

    return Case("curves.logarithmic.fit_log", world, (force, v), ours, exact, bound, must_say=must_say, smoke=smoke)


def _robust() -> Iterator[Case]:
    x = np.log(_forces())
    y = _activity(_forces())
    spiked = y.copy()
    spiked[[7, 20]] *= 40
    for world, values, bound, smoke in (
        ("two bursts of 40 x", spiked, 9.0, True),
        ("two bursts, y + 1e6 x slope", spiked + 20.0, 6.0, False),
        ("two bursts, y x 1e-200", spiked * 1e-200, 9.0, False),
        ("two bursts, y x 1e200", spiked * 1e200, 9.0, False),
    ):
        yield huber_case(world, x, values, bound, smoke)


def huber_case(world: str, x: np.ndarray, y: np.ndarray, bound: float, smoke: bool) -> Case:
    """Huber's line."""

    def ours(x: np.ndarray, y: np.ndarray) -> Found:
        fit = fit_line_huber(x[None], y[None], np.ones((1, x.size)))
        return Found({"a": fit.intercept, "b": fit.slope})

    def exact(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
        return exact_huber(mpfs(x), mpfs(y), mpf(TUNING))

    return Case("curves.line.fit_line_huber", world, (x, y), ours, exact, bound, smoke=smoke)


def _exponential() -> Iterator[Case]:
    x = np.linspace(1, 4, 12)
    y = 5 * np.exp(-0.7 * x) * (1 + 0.05 * np.random.default_rng(4).standard_normal(12))
    near = 2.0 + 1e-8 * np.linspace(0, 1, 12)
    for world, at, values, bound, smoke in (
        ("as measured", x, y, 13.0, True),
        ("x x 1e-6", x * 1e-6, y, 13.0, False),
        ("x x 1e6", x * 1e6, y, 13.0, False),
        ("y x 1e-300", x, y * 1e-300, 13.0, True),
        ("y x 1e300", x, y * 1e300, 13.0, False),
        ("x + 1e4", x + 1e4, y, 9.0, True),
        ("x + 1e9", x + 1e9, y, 5.0, False),
        ("x within 1e-8", near, y, 6.0, False),
        ("y negative", x, -y, 13.0, False),
        ("noise 1e-12", x, 5 * np.exp(-0.7 * x), 13.0, False),
        (
            "a spike: exp(-40 x) + 1e-3",
            np.linspace(0, 3, 12),
            np.exp(-40 * np.linspace(0, 3, 12)) + 1e-3 * (1 + np.arange(12) % 3),
            6.0,
            False,
        ),
    ):
        yield exponential_case(world, at, values, bound, smoke)
    yield exponential_case("ln y, y x 1e-300", x, y * 1e-300, 13.0, False, logarithms=True)
    yield exponential_case("ln y, x + 1e4", x + 1e4, y, 9.0, False, logarithms=True)


def exponential_case(
    world: str, x: np.ndarray, y: np.ndarray, bound: float, smoke: bool, logarithms: bool = False
) -> Case:
    """y = y0 exp(q (x - x0)): q, and the curve at the mean of x."""

    def ours(x: np.ndarray, y: np.ndarray) -> Found:
        fit = fit_exponential_log(x, y) if logarithms else fit_exponential(x, y)
        return Found(
            {"q": fit.q, "curve": fit.y0 * np.exp(fit.q * (x[5] - fit.x0))},
            "undefined (NaN)" * bool(np.isnan(fit.q[0])),
        )

    def exact(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
        at, values = mpfs(x), mpfs(y)
        if logarithms:
            line = exact_line(at, [mp.log(value) for value in values])
            return {"q": line["b"], "curve": mp.exp(line["a"] + line["b"] * at[5])}
        sign = 1 if sum(values) > 0 else -1
        found = exact_exponential(at, [sign * value for value in values])
        return {"q": found["q"], "curve": sign * found["level"] * mp.exp(found["q"] * (at[5] - found["centre"]))}

    return Case("curves.exponential", world, (x, y), ours, exact, bound, smoke=smoke)


def _hooke() -> Iterator[Case]:
    x = np.linspace(0, 4, 60)
    force = 1.5 * np.maximum(x - 1, 0) + 0.01 * np.random.default_rng(5).standard_normal(60)
    for world, at, values, bound, smoke in (
        ("as measured", x, force, 13.0, True),
        ("force + 1e6 N", x, force + 1e6, 8.0, False),
        ("force x 1e-200", x, force * 1e-200, 13.0, False),
        ("x + 1e6 mm", x + 1e6, force, 8.0, False),
        ("x x 1e-200", x * 1e-200, force, 13.0, False),
    ):
        yield hooke_case(world, at, values, bound, smoke)


def hooke_case(world: str, x: np.ndarray, force: np.ndarray, bound: float, smoke: bool) -> Case:
    """kappa behind the contact that was found; the truth takes the same points."""
    points = int(fit_hooke(x, force).n[0])

    def ours(x: np.ndarray, y: np.ndarray) -> Found:
        fit = fit_hooke(x, y)
        return Found({"kappa": fit.kappa, "SE": fit.kappa_se})

    def exact(x: np.ndarray, y: np.ndarray) -> dict[str, Any]:
        line = exact_line(mpfs(x)[-points:], mpfs(y)[-points:])
        return {"kappa": line["b"], "SE": line["SE(b)"]}

    return Case("curves.plate.fit_hooke", world, (x, force), ours, exact, bound, smoke=smoke)
