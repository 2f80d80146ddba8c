"""The rig of a world: a table of scores, and the stiffness by each algorithm and condition, without frames."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from benchmarks.claims.people import drawn, serially
from benchmarks.claims.worlds import ALGORITHMS, DESIGNS, KAPPA, PRESSED, Law, Rig
from emg2vsa.arrays import Floats
from emg2vsa.discrimination.run_table import RunTable

CASR_MM2_PER_N, AREA_MM2 = 64.0, 90.0
"Of S1 at 0 degrees, as in the demo."
AREA_PRESS, AREA_MOUNTING = 0.048, 0.03
OTHERS = {"circle": (0.045, 0.097, 0.29), "paper": (0.23, 0.42, 0.43)}
"SD of ln CASR from press to press at 0, 30 and 45 degrees."
Draw = Callable[[np.random.Generator, Law, tuple[int, ...]], Floats]
_ANGLES = (0.0, 30.0, 45.0)
NEW = PRESSED.index("S_new")


def true_casr(world: Rig, algorithm: str) -> Floats:
    """ln CASR (D, S) over that of the stiffest at 0 degrees."""
    found = np.empty((len(DESIGNS), len(PRESSED)))
    for d, (condition, angle) in enumerate(DESIGNS):
        at = _ANGLES.index(angle)
        human = condition == "modular"
        softness = np.array(world.casr)
        stretch = np.log(world.contrast) if human else 0.0
        found[d] = softness * (1 + stretch / softness[-1] if softness[-1] else 1.0) + world.casr_of_angle[at]
        off = world.new_off.get(algorithm, (0.0,) * 3)[at]
        if human and algorithm != "circle" and world.human_like_off is not None:
            off = world.human_like_off[at]
        found[d, NEW] += _shift(found[d], off)
        if condition == "constant-min":
            found[d, NEW] += (world.at_minimum - 1) * (found[d, NEW] - found[d, 0])
    return found


def _shift(logs: Floats, off: float) -> float:
    """Of ln CASR of the new specimen, so that the curve through all four gives its kappa (1 + ``off``).

    The curve is straight in 1 / kappa over CASR^1.5 between the neighbours of the new specimen.
    """
    if off == 0 or logs[0] == logs[2]:
        return 0.0
    x, y = np.exp(1.5 * logs), 1 / KAPPA
    side = slice(0, 2) if off > 0 else slice(1, 3)
    slope = (y[side][1] - y[side][0]) / (x[side][1] - x[side][0])
    wanted = x[NEW] + (y[NEW] / (1 + off) - y[NEW]) / slope
    return float(np.log(max(wanted, 0.1 * x[NEW])) / 1.5 - logs[NEW])


def even(_: np.random.Generator, law: Law, shape: tuple[int, ...]) -> Floats:
    """In place of draws, their expected ranks on the last axis, of mean 0 and SD 1: what is true needs no chance."""
    n = shape[-1]
    many = np.sort(drawn(np.random.default_rng(0), law, (4000 * n,))).reshape(n, -1).mean(axis=1)
    spread = (many - many.mean()) / (many.std(ddof=1) if n > 1 else 1.0)
    return np.broadcast_to(spread, shape)


def table_of(world: Rig, rng: np.random.Generator, draw: Draw = drawn) -> RunTable:
    """Scores of all cells, mounting by mounting."""
    d, s, m, r = len(DESIGNS), len(PRESSED), world.mountings, world.presses
    of_press, of_mounting = world.scatter()
    position = _positions(world, rng)
    drift = world.drift * of_mounting.mean() * (position / position.max() - 0.5)
    mounting = of_mounting[..., None] * draw(rng, world.law, (d, s, m)) + drift
    size = _over_cells(of_mounting, rng, world)[..., None] * draw(rng, world.law, (d, s, m)) + drift
    angle = np.array([_ANGLES.index(each) for _, each in DESIGNS])
    area = np.array(world.area)[None] + np.array(world.area_of_angle)[angle][:, None]
    casr, start = {}, {}
    for name in ALGORITHMS:
        own = of_press
        if name in OTHERS and world.own_scatter:
            own = np.broadcast_to(np.array(OTHERS[name])[angle][:, None], of_press.shape)
        press = own[..., None, None] * serially(draw(rng, world.law, (d, s, m, r)), world.serial)
        press[rng.random(press.shape) < world.lost] = np.nan
        logs = true_casr(world, name)[..., None, None] + mounting[..., None] + press
        casr[name] = CASR_MM2_PER_N * np.exp(logs).reshape(d, s, m * r)
        press = AREA_PRESS * serially(draw(rng, world.law, (d, s, m, r)), world.serial)
        start[name] = AREA_MM2 * np.exp(area[..., None, None] + size[..., None] + press).reshape(d, s, m * r)
    return RunTable(
        conditions=tuple(condition for condition, _ in DESIGNS),
        angles_deg=np.array([each for _, each in DESIGNS]),
        specimens=PRESSED, stiffness_n_per_mm=KAPPA, new=NEW, algorithm="front", area_unit="mm2", a_c0=start,
        start_area=start, casr=casr, true_a_c0=np.full((d, s, m * r), np.nan),
        mounting=np.broadcast_to(np.repeat(np.arange(1, m + 1), r), (d, s, m * r)).copy(),
        position=None if world.order == "unknown" else np.repeat(position, r, axis=-1),
    )  # fmt: skip


def _over_cells(of_mounting: Floats, rng: np.random.Generator, world: Rig) -> Floats:
    """SD of areas from mounting to mounting (D, S): where CASR of a cell scatters more, areas do."""
    return np.asarray(AREA_MOUNTING * of_mounting / np.median(of_mounting))


def _positions(world: Rig, rng: np.random.Generator) -> Floats:
    """(D, S, M) place of each mounting in the order of pressing, from 1."""
    shape = (len(DESIGNS), len(PRESSED), world.mountings)
    places = np.arange(1.0, np.prod(shape) + 1)
    if world.order != "constant":
        return rng.permutation(places).reshape(shape)
    # specimen by specimen, as to change it takes longest
    return np.swapaxes(places.reshape(shape[1], shape[0], shape[2]), 0, 1)
