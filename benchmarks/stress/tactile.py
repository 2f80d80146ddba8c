"""The tactile side: areas, their growth, the rate over force, the camera, pins between pixels."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from mpmath import mp, mpf

from benchmarks.stress.case import ROUNDED, Case, Found
from benchmarks.stress.exact_curves import mpfs
from casr.camera import Camera
from casr.contact_area import initial_area
from casr.flow.dense_engine import mean_divergence
from casr.flow.pin_engine import fit_affine
from casr.flow.region import Region
from casr.pins.detect import Pins
from casr.pins.spots import measure_spots
from casr.spread import contact_areas, spread_rate
from casr.spread.curves import CURVATURE, CURVATURE_SD


def cases() -> Iterator[Case]:
    for offset, scale, bound, smoke in (
        (0.0, 1.0, 12.0, True),
        (1e6, 1.0, 12.0, True),
        (1e9, 1.0, 12.0, True),
        (0.0, 1e-200, 12.0, False),
    ):
        yield slope_case(offset, scale, bound, smoke)
    for scale, bound in ((1.0, 12.0), (1e-200, 11.0), (1e200, 11.0)):
        yield power_case(scale, bound)
    for growth, frames, bound in ((0.02, 300, 12.0), (1e-12, 300, 13.0), (1.0, 600, 11.0)):
        yield growth_case(growth, frames, bound)
    for offset, bound, smoke in ((150.0, 13.0, True), (1e6, 13.0, False), (1e9, 13.0, True)):
        yield region_case(offset, bound, smoke)
    for offset, motion, bound, smoke in ((150.0, 1.0, 12.0, True), (150.0, 1e-6, 7.0, True), (1e6, 1.0, 9.0, False)):
        yield affine_case(offset, motion, bound, smoke)
    yield line_case()
    for offset, bound in ((0.0, 12.0), (1024.0, 12.0)):
        yield divergence_case(offset, bound)
    for coefficients, bound, smoke in (
        ((-0.3, 0.1, 1e-3, -1e-3, 0.0), 10.0, True),
        ((0.2, 0.0, 0.0, 0.0), 10.0, False),
        ((-0.3, 0.1, 1e-3, -1e-3, 0.0, 0.01, -0.02, 0.01), 10.0, False),
    ):
        yield camera_case(coefficients, bound, smoke)
    for offset, bound in ((150.0, 12.0), (2000.0, 10.0)):
        yield hexagon_case(offset, bound)
    for grey, contrast, bound, smoke in ((40.0, 160.0, 2.5, True), (90.0, 160.0, 2.5, False), (40.0, 20.0, 1.5, False)):
        yield spot_case(grey, contrast, bound, smoke)


def slope_case(offset: float, scale: float, bound: float, smoke: bool) -> Case:
    """dA/dF by the line through the piecewise linear curve; no area far enough off to be drawn in."""
    force = np.linspace(0.5, 7.0, 60) + 0.01 * np.sin(np.arange(60.0))
    area = scale * (30 * force ** (2 / 3) + offset)

    def exact(a: np.ndarray, f: np.ndarray) -> dict[str, Any]:
        areas, forces = mpfs(a), mpfs(f)
        middle, total = (forces[0] + forces[-1]) / 2, mpf(0)
        for i in range(59):
            # integral of A (F - middle) over a piece, A linear on it
            h, x0, x1 = forces[i + 1] - forces[i], forces[i] - middle, forces[i + 1] - middle
            total += h * (areas[i] * (2 * x0 + x1) + areas[i + 1] * (x0 + 2 * x1)) / 6
        return {"slope": total * 12 / (forces[-1] - forces[0]) ** 3}

    return Case(
        "casr.spread_rate, slope",
        f"area offset {offset:g}, scale {scale:g}",
        (area, force),
        lambda a, f: Found({"slope": spread_rate(a, f, rule="slope").value}),
        exact,
        bound,
        smoke=smoke,
    )


def power_case(scale: float, bound: float) -> Case:
    """Mean rate by the power law, weighted by force, no outliers."""
    force = np.linspace(0.5, 7.0, 60)
    area = scale * 30 * force ** (2 / 3) * (1 + 0.01 * np.sin(3 * np.arange(60.0)))

    def exact(a: np.ndarray, f: np.ndarray) -> dict[str, Any]:
        forces, n = mpfs(f), len(f)
        weights = [v / mp.fsum(forces) for v in forces]
        x, y = [mp.log(v) for v in forces], [mp.log(v) for v in mpfs(a)]

        def mean(values: Any) -> Any:
            return mp.fsum(w * v for w, v in zip(weights, values, strict=True))

        middle = mean(x)
        square, cube = (mean([(v - middle) ** power for v in x]) for power in (2, 3))

        def columns(at: Any) -> tuple[Any, ...]:
            x = at - middle
            return mpf(1), x, x * (x - cube / square) - square

        rows = [columns(v) for v in x]
        told = [mean([row[k] * v for row, v in zip(rows, y, strict=True)]) for k in range(3)]
        power = [mean([row[k] ** 2 for row in rows]) for k in range(3)]
        power[2] += mpf("1e-12") * square**2
        found = [t / p for t, p in zip(told, power, strict=True)]
        left = mean([(v - mp.fdot(row, found)) ** 2 for row, v in zip(rows, y, strict=True)])
        pull = n * left / (mpf(n - 3) * n * mpf(CURVATURE_SD) ** 2)
        found[2] = (told[2] + pull * mpf(CURVATURE)) / (power[2] + pull)
        low, high = (mp.exp(mp.fdot(columns(mp.log(v)), found)) for v in (mpf("0.5"), mpf(7)))
        return {"rate": (high - low) / mpf("6.5")}

    return Case(
        "casr.spread_rate, power",
        f"areas x {scale:g}",
        (area, force),
        lambda a, f: Found({"rate": spread_rate(a, f).value}),
        exact,
        bound,
        smoke=scale == 1,
    )


def growth_case(growth: float, frames: int, bound: float) -> Case:
    """Area after many steps of growth, equation (1)."""
    steps = growth * (1 + 0.1 * np.sin(np.arange(float(frames))))
    return Case(
        "casr.contact_areas",
        f"{frames} steps of {growth:g}",
        (steps,),
        lambda x: Found({"area": contact_areas(3.0, x)[-1]}),
        lambda x: {"area": 3 * mp.exp(mp.fsum(mpfs(x)))},
        bound,
        smoke=growth == 0.02,
    )


def region_case(offset: float, bound: float, smoke: bool) -> Case:
    """Area and centre of a polygon far from the origin."""
    angle = np.arange(12) * 2 * np.pi / 12
    corners = offset + 60 * np.column_stack([np.cos(angle), 1.2 * np.sin(angle)])

    def exact(p: np.ndarray) -> dict[str, Any]:
        points = list(zip(mpfs(p[:, 0]), mpfs(p[:, 1]), strict=True))
        turns = [(a, b, a[0] * b[1] - b[0] * a[1]) for a, b in zip(points, points[1:] + points[:1], strict=True)]
        area = mp.fsum(turn for *_, turn in turns) / 2
        return {
            "area": area,
            "centre": [mp.fsum((a[i] + b[i]) * turn for a, b, turn in turns) / (6 * area) for i in (0, 1)],
        }

    def ours(p: np.ndarray) -> Found:
        region = Region(p)
        return Found({"area": region.area_px2, "centre": region.centre_px})

    return Case("casr.flow.Region", f"polygon at {offset:g} px", (corners,), ours, exact, bound, smoke=smoke)


def _lattice(offset: float) -> np.ndarray:
    rows, columns = np.mgrid[0:9, 0:9]
    return offset + 20.25 * np.column_stack([(columns + rows % 2 / 2).ravel(), (rows * np.sqrt(0.75)).ravel()])


def affine_case(offset: float, motion: float, bound: float, smoke: bool) -> Case:
    """Displacement gradient of pins, a regression of each coordinate of the motion on the place."""
    before = _lattice(offset)
    wobble = np.random.default_rng(12).standard_normal(before.shape) / 20
    move = (before - before.mean(axis=0)) @ np.array([[0.012, 0.002], [-0.003, 0.011]]) + wobble
    after = before + motion * move

    def exact(b: np.ndarray, a: np.ndarray) -> dict[str, Any]:
        n = len(b)
        centred = [[value - mp.fsum(column) / n for value in column] for column in (mpfs(b[:, 0]), mpfs(b[:, 1]))]
        xx, xy, yy = (mp.fdot(centred[i], centred[j]) for i, j in ((0, 0), (0, 1), (1, 1)))
        matrix = []
        for i in (0, 1):
            moved = [p - q for p, q in zip(mpfs(a[:, i]), mpfs(b[:, i]), strict=True)]
            sx, sy = mp.fdot(centred[0], moved), mp.fdot(centred[1], moved)
            matrix += [(yy * sx - xy * sy) / (xx * yy - xy * xy), (xx * sy - xy * sx) / (xx * yy - xy * xy)]
        return {"matrix": matrix}

    return Case(
        "casr.flow.fit_affine",
        f"pins at {offset:g} px, motion x {motion:g}",
        (before, after),
        lambda b, a: Found({"matrix": fit_affine(b, a).matrix}),
        exact,
        bound,
        size="largest",
        smoke=smoke,
    )


def line_case() -> Case:
    """Pins on a line have no gradient across it: refused."""
    before = np.column_stack([np.arange(9.0) * 20, 1e-9 * np.arange(9.0) ** 2])
    return Case(
        "casr.flow.fit_affine",
        "pins on one line within 1e-9 of its length",
        (before, before * 1.01),
        lambda b, a: Found({"matrix": fit_affine(b, a).matrix}),
        lambda b, a: {"matrix": [0.01, 0, 0, 0.01]},
        9.0,
        condition=9.0,
    )


def divergence_case(offset: float, bound: float) -> Case:
    """Mean divergence of a linear field, whose values are exact in single precision."""
    rows, columns = np.mgrid[:200, :200].astype(np.float64)
    flow = np.stack([columns / 64 + offset, rows / 128 - offset], axis=2).astype(np.float32)
    square = np.array([[50.3, 50.1], [150.7, 50.2], [149.9, 149.5], [50.0, 150.4]])
    return Case(
        "casr.flow.mean_divergence",
        f"motion of {offset:g} px beside it",
        (),
        lambda: Found({"divergence": mean_divergence(flow, square)}),
        lambda: {"divergence": mpf(1) / 64 + mpf(1) / 128},
        bound,
        condition=0.0,
    )


def camera_case(coefficients: tuple[float, ...], bound: float, smoke: bool) -> Case:
    """Pixels to where a camera without distortion sees them: Brown's polynomial inverted; error in px."""
    camera = Camera(distortion=coefficients)
    points = np.array([[149.5, 149.5], [20.0, 30.0], [290.0, 150.0], [280.0, 285.0]])
    seen = camera.distorted_px(points)
    k1, k2, p1, p2, k3, k4, k5, k6 = (mpf(c) for c in (*coefficients, *([0.0] * (8 - len(coefficients)))))

    def forward(x: Any, y: Any) -> tuple[Any, Any]:
        r2 = x * x + y * y
        radial = (1 + k1 * r2 + k2 * r2**2 + k3 * r2**3) / (1 + k4 * r2 + k5 * r2**2 + k6 * r2**3)
        return (
            x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y,
        )

    def exact(p: np.ndarray) -> dict[str, Any]:
        found = []
        for u, v in p:
            x0, y0 = (mpfs(np.array([u]))[0] - mpf("149.5")) / 300, (mpfs(np.array([v]))[0] - mpf("149.5")) / 300
            x, y = x0, y0
            for _ in range(2000):
                seen_x, seen_y = forward(x, y)
                x, y = x + (x0 - seen_x), y + (y0 - seen_y)
                if abs(x0 - seen_x) + abs(y0 - seen_y) < mpf("1e-40"):
                    break
            found += [300 * x + mpf("149.5"), 300 * y + mpf("149.5")]
        return {"px": found}

    return Case(
        "casr.camera.undistorted_px",
        f"{len(coefficients)} coefficients, k1 = {coefficients[0]:g}",
        (seen,),
        lambda p: Found({"px": camera.undistorted_px(p)}),
        exact,
        bound,
        size=1.0,
        smoke=smoke,
    )


def hexagon_case(offset: float, bound: float) -> Case:
    """Algorithm 1: one hexagon of the lattice's pitch for each of seven pins that moved."""
    rest = _lattice(offset)
    middle = rest[np.argmin(((rest - rest.mean(axis=0)) ** 2).sum(axis=1))]
    near = np.hypot(*(rest - middle).T) < 21
    contact = rest + np.where(near[:, None], [3.0, 1.0], 0.0)
    pins = Pins(rest, np.full(len(rest), 30.0), ())

    def ours(r: np.ndarray, c: np.ndarray) -> Found:
        return Found({"area": initial_area(Pins(r, pins.area_px, ()), c, rule="paper").area_px2})

    def exact(r: np.ndarray, c: np.ndarray) -> dict[str, Any]:
        points = [mpfs(row) for row in r]
        nearest = sorted(
            min((p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2 for j, q in enumerate(points) if i != j)
            for i, p in enumerate(points)
        )
        pitch2 = nearest[len(nearest) // 2]
        return {"area": int(near.sum()) * mp.sqrt(3) / 2 * pitch2}

    return Case(
        "casr.contact_area.rules, hexagons",
        f"array at {offset:g} px",
        (rest, contact),
        ours,
        exact,
        bound,
        condition=0.0,
        smoke=offset == 150,
    )


def spot_case(grey: float, contrast: float, bound: float, smoke: bool) -> Case:
    """Pins between pixels of a frame without noise: distance from where they were drawn, px.

    What is allowed is what whole grey levels leave: about 0.02 px over the contrast in grey levels.
    """
    rng = np.random.default_rng(13)
    centres = np.array([[x, y] for x in range(30, 280, 25) for y in range(30, 280, 25)]) + rng.uniform(
        -0.5, 0.5, (100, 2)
    )
    rows, columns = np.mgrid[:300, :300]
    image = np.full((300, 300), grey)
    for x, y in centres:
        image += contrast / (1 + np.exp(np.minimum(2 * (np.hypot(columns - x, rows - y) - 5.0), 700)))
    frame = np.clip(np.rint(image), 0, 255).astype(np.uint8)

    def ours(p: np.ndarray) -> Found:
        spots = measure_spots(frame, np.rint(p), np.full(len(p), 11.0))
        off = np.hypot(*(spots.centroids_px - p).T)
        return Found({"rms": 1.0 + float(np.sqrt(np.mean(off**2)))}, f"rms error {np.sqrt(np.mean(off**2)):.2g} px")

    return Case(
        "casr.pins.measure_spots",
        f"background {grey:g}, contrast {contrast:g} grey levels",
        (centres,),
        ours,
        lambda p: {"rms": 1},
        bound,
        condition=ROUNDED - float(np.log10(50 * contrast)),
        smoke=smoke,
    )
