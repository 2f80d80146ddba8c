"""People of a world: the fits of their presses, as the stage of fits would hand them on, without recordings."""

from __future__ import annotations

import numpy as np

from benchmarks.claims.worlds import SPECIMENS, Law, People
from emg2vsa.arrays import Floats
from emg2vsa.curves.force_bins import fit_edges
from emg2vsa.curves.logarithmic import fit_log
from emg2vsa.fits import Fits

MICROVOLT = 1e-6
WINDOW_N, BIN_N = (0.5, 7.0), 0.3
_SKEW = 0.6
"SD of the logarithm of the lognormal law."


def drawn(rng: np.random.Generator, law: Law, shape: tuple[int, ...]) -> Floats:
    """Values of mean 0 and SD 1."""
    if law == "t3":
        return np.asarray(rng.standard_t(3, shape) / np.sqrt(3))
    if law == "lognormal":
        variance = np.exp(_SKEW**2)
        return np.asarray((rng.lognormal(0, _SKEW, shape) - np.sqrt(variance)) / np.sqrt((variance - 1) * variance))
    return rng.standard_normal(shape)


def serially(values: Floats, rho: float) -> Floats:
    """The same SD, each value correlated by ``rho`` with the one before on the last axis."""
    out = values.copy()
    for i in range(1, values.shape[-1]):
        out[..., i] = rho * out[..., i - 1] + np.sqrt(1 - rho**2) * values[..., i]
    return out


def places(rng: np.random.Generator, world: People) -> Floats:
    """(P, S) place of a specimen in the session of each person, from 0."""
    if world.order == "constant":
        return np.tile(np.arange(len(SPECIMENS), dtype=np.float64), (world.people, 1))
    return np.array([rng.permutation(len(SPECIMENS)) for _ in range(world.people)], dtype=np.float64)


def fits_of(world: People, rng: np.random.Generator) -> tuple[Fits, Floats]:
    """Fits of all presses, person by person and specimen by specimen; and the ``places`` of specimens."""
    p, s, r = world.people, len(SPECIMENS), world.presses
    place = places(rng, world)
    person = world.person * rng.standard_normal((p, 1, 1))
    crossed = world.person_by_specimen * drawn(rng, world.law, (p, s, 1))
    sd = world.press * np.exp(np.log(world.unequal) * rng.uniform(-1, 1, (p, 1, 1)))
    press = sd * serially(drawn(rng, world.law, (p, s, r)), world.serial)
    session = (place[..., None] + (0.5 if world.steps else np.arange(r) / r)) / s
    of_press = float(np.hypot(world.press, 0.07))
    drift = world.drift * of_press * (1 + 0.3 * rng.standard_normal((p, 1, 1))) * (session - 0.5)
    factor = np.maximum(1 + person + crossed + press + drift, 0.1).reshape(-1)
    a, b = (factor * np.tile(np.repeat(np.array(values), r), p) for values in (world.a, world.b))
    edges = fit_edges(*WINDOW_N, BIN_N)
    force = np.broadcast_to(np.sqrt(edges[1:] * edges[:-1]), (a.size, edges.size - 1))
    level = a[:, None] + b[:, None] * np.log(force)
    if world.power_law:  # the same level and slope in the middle of the window, 1.9 N
        middle = np.log(np.sqrt(WINDOW_N[0] * WINDOW_N[1]))
        there = a + b * middle
        level = there[:, None] * np.exp((b / there)[:, None] * (np.log(force) - middle))
    v = level * (1 + world.bin * rng.standard_normal(level.shape))
    fits = _fits(force, v * MICROVOLT, edges, p, r)
    fits.verdict[rng.random(fits.verdict.size) < world.lost] = "rejected"
    return fits, np.full(place.shape, np.nan) if world.order == "unknown" else place


def _fits(force: Floats, v: Floats, edges: Floats, people: int, presses: int) -> Fits:
    fit, n, s = fit_log(force, v), len(v), len(SPECIMENS)
    ends = fit.at(np.broadcast_to(np.array(WINDOW_N), (n, 2)))
    names = np.array([f"P{i + 1:02d}" for i in range(people)])
    one, nothing = np.ones(n), np.full(n, np.nan)
    return Fits(
        participant=np.repeat(names, s * presses), specimen=np.tile(np.repeat(np.array(SPECIMENS), presses), people),
        repetition=np.tile(np.arange(1, presses + 1), people * s), verdict=np.full(n, "ok", dtype="<U8"),
        reason=np.full(n, ""), visit=np.full(n, ""),
        start_s=nothing, a_v=fit.a, b_v=fit.b, a_se_v=fit.a_se, b_se_v=fit.b_se, b_lo_v=fit.b_lo, b_hi_v=fit.b_hi,
        n_points=np.full(n, force.shape[1]), adj_r2=fit.adj_r2, r2_bins=fit.r2, adj_r2_bins=fit.adj_r2,
        r2_samples=nothing, adj_r2_samples=nothing, n_effective=one, lag1=one, b_bias=nothing,
        b_bias_se=nothing, b_corrected=nothing, cause=np.full(nothing.shape, ""), v_min_v=ends[:, 0],
        v_max_v=ends[:, 1],
        bin_edges_n=edges, bin_force_n=force, bin_v=v, activity_unit="V", points="bins", weights="none",
        confidence=0.95,
    )  # fmt: skip
