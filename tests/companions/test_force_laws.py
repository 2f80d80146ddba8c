"""Logarithm, power and straight line by prediction: each is found where it is true, and the errors are plain ones."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from scipy import optimize, stats

from emg2vsa.companions.force_laws import LAWS, LEFT_OUT, cell_errors, compare_laws, force_laws
from emg2vsa.fits import Fits

FORCE_N = np.geomspace(0.6, 6.8, 12)
TRUE = {
    "logarithm": 4 + 1.5 * np.log(FORCE_N),
    "power": 3 * FORCE_N**0.45,
    "linear": 2 + 0.6 * FORCE_N,
}


def fits_of(v: np.ndarray, verdict: str = "ok") -> Fits:
    """Of presses (P, S, R, B)."""
    p, s, r, b = v.shape
    i, j, k = (index.ravel() for index in np.indices((p, s, r)))
    n = i.size
    columns = {f.name: np.ones(n) for f in dataclasses.fields(Fits)}
    own = {
        "participant": np.char.add("P", i.astype(str)), "specimen": np.char.add("S", j.astype(str)),
        "repetition": k + 1, "verdict": np.full(n, verdict), "bin_v": v.reshape(n, b),
        "bin_force_n": np.broadcast_to(FORCE_N[:b], (n, b)), "activity_unit": "V", "points": "bins", "weights": "none",
        "confidence": 0.95,
    }  # fmt: skip
    return Fits(**columns | own)  # type: ignore[arg-type]


def presses(law: str, seed: int = 0, shape: tuple[int, int, int] = (6, 2, 5), noise: float = 0.05) -> np.ndarray:
    """Each press with an amplitude of its own."""
    rng = np.random.default_rng(seed)
    return TRUE[law] * (1 + 0.1 * rng.standard_normal((*shape, 1))) * (1 + noise * rng.standard_normal((*shape, 12)))


@pytest.mark.parametrize("law", LAWS)
def test_the_true_law_predicts_best(law: str) -> None:
    found = force_laws(fits_of(presses(law)), "ok")
    kind = LEFT_OUT.index("bin")
    assert LAWS[int(np.argmin(found.ratio[kind]))] == law
    for other in set(LAWS) - {law}:
        a, b = LAWS.index(law), LAWS.index(other)
        assert found.ratio[kind, a] < found.ratio[kind, b]
    if law != "logarithm":
        assert found.p[kind, LAWS.index(law)] < 0.01
        assert found.ratio_high[kind, LAWS.index(law)] < 1


def test_errors_are_those_of_a_plain_loop() -> None:
    v = presses("power", 3, (2, 1, 4))
    v[0, 0, 1, 5] = np.nan
    found = force_laws(fits_of(v), "ok")
    for cell in range(2):
        own = v[cell, 0]
        there = np.isfinite(own)
        squares: dict[str, dict[str, list[float]]] = {kind: {law: [] for law in LAWS} for kind in LEFT_OUT}
        for r, b in np.argwhere(there):
            others = np.delete(np.arange(4), r)
            seen = {
                "press": (np.tile(FORCE_N, 3)[there[others].ravel()], own[others].ravel()[there[others].ravel()]),
                "bin": tuple(values[there[r] & (np.arange(12) != b)] for values in (FORCE_N, own[r])),
            }
            for kind, (f, y) in seen.items():
                log, line = np.polyfit(np.log(f), y, 1), np.polyfit(f, y, 1)
                power, _ = optimize.curve_fit(lambda f, a, c: a * f**c, f, y, [3, 0.4], ftol=1e-14, xtol=1e-14)
                at = FORCE_N[b]
                for law, value in zip(
                    LAWS, (np.polyval(log, np.log(at)), power[0] * at ** power[1], np.polyval(line, at)), strict=True
                ):
                    squares[kind][law].append((value - own[r, b]) ** 2)
        for k, kind in enumerate(LEFT_OUT):
            for i, law in enumerate(LAWS):
                plain = np.sqrt(np.mean(squares[kind][law])) / np.nanmean(own)
                assert found.error[k, i, cell] == pytest.approx(plain, rel=1e-6)


def test_the_comparison_is_a_t_test_over_participants() -> None:
    found = force_laws(fits_of(presses("logarithm", 5)), "ok")
    of_person = np.log(found.error[0, 2] / found.error[0, 0]).reshape(6, 2).mean(axis=1)
    peer = stats.ttest_1samp(of_person, 0)
    assert found.p[0, 2] == pytest.approx(peer.pvalue, rel=1e-10)
    assert found.ratio[0, 2] == pytest.approx(np.exp(of_person.mean()), rel=1e-12)
    assert found.compared.tolist() == [12, 12]


def test_one_recording_at_a_time_gives_the_same() -> None:
    v = presses("power", 7, (12, 2, 3))  # P10 stands behind P9
    fits = fits_of(v)
    columns = {
        name: values for name, values in vars(fits).items() if isinstance(values, np.ndarray) and name != "bin_edges_n"
    }
    parts = [
        dataclasses.replace(fits, **{name: values[own] for name, values in columns.items()})
        for own in np.random.default_rng(0).permutation(np.arange(v[..., 0].size).reshape(-1, 3))
    ]
    found = compare_laws(error for part in parts for error in cell_errors(part, "ok"))
    whole = force_laws(fits, "ok")
    for field in dataclasses.fields(whole):
        np.testing.assert_array_equal(getattr(found, field.name), getattr(whole, field.name))
    assert whole.participant.tolist()[-2:] == ["P11", "P11"]


@pytest.mark.parametrize("change", ["rejected", "one press", "no bins", "one participant", "constant"])
def test_what_cannot_be_compared_is_not(change: str) -> None:
    v = presses("logarithm", 1, (1 if change == "one participant" else 3, 1, 1 if change == "one press" else 3))
    v = np.full_like(v, np.nan) if change == "no bins" else np.ones_like(v) if change == "constant" else v
    found = force_laws(fits_of(v, "rejected" if change == "rejected" else "ok"), "ok")
    assert np.isnan(found.p[0]).all()
    if change == "one participant":
        assert np.isfinite(found.error).all()
    if change == "one press":
        assert np.isfinite(found.p[1, 2])
