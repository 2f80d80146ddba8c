"""From CASR to stiffness where specimens are alike, scores of extreme scale, and mountings next to equal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.stress.case import Case, Found
from benchmarks.stress.exact_curves import exact_line, mpfs
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.laws import WAYS
from emg2vsa.calibration.mountings import mounting_scatter
from emg2vsa.calibration.repeats import by_kappa, by_mean_score
from emg2vsa.settings import CalibrationSettings

Law = tuple[str, str]
LAWS: tuple[Law, ...] = (
    ("compliance", "casr"),
    ("exponential", "ln kappa"),
    ("power", "ln kappa"),
    ("linear-log", "kappa"),
)


def cases() -> Iterator[Case]:
    assert all(way in WAYS[law] for law, way in LAWS)  # type: ignore[index]
    kappa = np.array([0.2, 0.45, 0.9, 2.1])
    wobble = 1 + 0.02 * np.array([1.0, -1.0, 0.5, -0.7])
    casr = (1 / kappa + 0.3) ** (2 / 3) * wobble
    for law in LAWS:
        yield law_case(law, "as measured", kappa, casr, 12.0, smoke=True)
        if law[0] != "exponential":
            yield law_case(law, "scores x 1e-6", kappa, casr * 1e-6, 12.0)
            yield law_case(law, "scores x 1e6", kappa, casr * 1e6, 12.0)
        for share, bound in ((1e-3, 9.0), (1e-6, 6.0), (1e-9, 3.0)):
            near = 0.5 * (1 + share * np.array([0.0, 0.3, 0.6, 1.0]))
            scores = 2.0 * (1 - share * np.array([0.0, 0.25, 0.7, 1.0]))
            yield law_case(
                law,
                f"specimens within {share:g} of each other: slope",
                near,
                scores,
                bound,
                of_slope=True,
                must_say=share < 1e-3,
                smoke=share == 1e-9,
            )
    yield gradient_case("as measured", kappa, casr, 9.0, smoke=True)
    yield gradient_case("scores x 1e-6", kappa, casr * 1e-6, 9.0)
    yield gradient_case("scores x 1e6", kappa, casr * 1e6, 9.0)
    for share, bound in ((0.05, 12.0), (1e-6, 8.0), (1e-9, 5.0)):
        yield mounting_case(share, bound)


def law_case(
    law: Law,
    world: str,
    kappa: np.ndarray,
    casr: np.ndarray,
    bound: float,
    *,
    of_slope: bool = False,
    must_say: bool = False,
    smoke: bool = False,
) -> Case:
    """kappa at a new score between the others, or the slope of the law."""
    settings = CalibrationSettings(law=law[0], minimise=law[1])  # type: ignore[arg-type]
    new = float(np.mean(casr[1:3]))

    def ours(k: np.ndarray, c: np.ndarray) -> Found:
        found = calibrate(k, c[:, None], settings, casr_unit="mm2/N")
        said = "; ".join(note for note in found.notes() if "ill-conditioned" in note or "undefined" in note)
        return Found({"slope": found.fit.slope} if of_slope else {"kappa": found.fit.at(np.array([[new]]))}, said)

    def exact(k: np.ndarray, c: np.ndarray) -> dict[str, Any]:
        slope, at_new = exact_law(law, mpfs(k), mpfs(c), mpf(new))
        return {"slope": slope} if of_slope else {"kappa": _kappa(law, at_new)}

    return Case(
        f"calibration.calibrate, {law[0]}", world, (kappa, casr), ours, exact, bound, must_say=must_say, smoke=smoke
    )


def exact_law(law: Law, kappa: list[Any], casr: list[Any], new: Any) -> tuple[Any, Any]:
    """Slope of the law on its own axes, and its eta at a new score."""
    if law[0] == "compliance":
        weights = [1 / score for score in casr]  # the slope of CASR^1.5 goes as its root; squared and inverted
        turned = exact_line([1 / k for k in kappa], [score ** mpf("1.5") for score in casr], weights)
        return 1 / turned["b"], (new ** mpf("1.5") - turned["a"]) / turned["b"]
    x = (lambda score: score) if law[0] == "exponential" else mp.log
    eta = (lambda k: k) if law[0] == "linear-log" else mp.log
    line = exact_line([x(score) for score in casr], [eta(k) for k in kappa])
    return line["b"], line["a"] + line["b"] * x(new)


def _kappa(law: Law, eta: Any) -> Any:
    return {"compliance": lambda: 1 / eta, "linear-log": lambda: eta}.get(law[0], lambda: mp.exp(eta))()


def gradient_case(world: str, kappa: np.ndarray, casr: np.ndarray, bound: float, smoke: bool = False) -> Case:
    """How the estimate moves with each known score and stiffness: what the interval from repeats is made of."""
    settings, law = CalibrationSettings(), LAWS[0]
    new = float(np.mean(casr[1:3]))

    def ours(k: np.ndarray, c: np.ndarray) -> Found:
        found = calibrate(k, c[:, None], settings, casr_unit="mm2/N")
        return Found({"by score": by_mean_score(found, np.array([new])), "by kappa": by_kappa(found, np.array([new]))})

    def exact(k: np.ndarray, c: np.ndarray) -> dict[str, Any]:
        known, scores = mpfs(k), mpfs(c)

        def slope(of_kappa: bool, i: int) -> Any:
            def moved(value: Any) -> Any:
                parts = [list(known), list(scores)]
                parts[not of_kappa][i] = value
                return exact_law(law, parts[0], parts[1], mpf(new))[1]

            at = (known if of_kappa else scores)[i]
            step = at * mpf("1e-15")
            return (moved(at + step) - moved(at - step)) / (2 * step)

        n = range(len(known))
        return {"by score": [slope(False, i) for i in n], "by kappa": [slope(True, i) for i in n]}

    return Case("calibration.repeats, gradients", world, (kappa, casr), ours, exact, bound, smoke=smoke)


def mounting_case(share: float, bound: float) -> Case:
    """SD from one mounting to the next: 3 specimens, 3 mountings, 4 presses each."""
    rng = np.random.default_rng(11)
    level = np.array([1.0, 2.5, 4.0])[:, None, None]
    presses = level * (1 + share * rng.standard_normal((3, 3, 1)) + 0.2 * share * rng.standard_normal((3, 3, 4)))
    labels = np.repeat(np.arange(3), 4) * np.ones((3, 1), dtype=np.int64)

    def ours(x: np.ndarray) -> Found:
        return Found({"SD": mounting_scatter(x.reshape(1, 3, 12), labels, 0.0).sd})

    def exact(x: np.ndarray) -> dict[str, Any]:
        between, within = mpf(0), mpf(0)
        for specimen in x:
            values = [mpfs(mounting) for mounting in specimen]
            whole = mp.fsum(value for mounting in values for value in mounting) / 12
            means = [mp.fsum(mounting) / 4 / whole for mounting in values]
            between += mp.fsum((m - mp.fsum(means) / 3) ** 2 for m in means)
            within += mp.fsum((v / whole - m) ** 2 for mounting, m in zip(values, means, strict=True) for v in mounting)
        return {"SD": mp.sqrt(between / 6 - within / 27 / 4)}

    return Case("calibration.mountings", f"mountings differ by {share:g} of the score", (presses,), ours, exact, bound)
