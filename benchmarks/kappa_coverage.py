"""How often does the interval of kappa hold the truth, of all estimates and of those that are called determined?

Run with ``python -m benchmarks.kappa_coverage [--write FILE]``, about one minute. Scores of three known specimens and
of a new one are drawn as presses and mountings scatter, without frames, and calibrated as a study is. In most worlds
the compliance law is true, with a sensor of which 1 % of CASR is 9 % of kappa at 5.32 N/mm.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

import numpy as np

from benchmarks.bench.record import print_page
from emg2vsa.arrays import Floats
from emg2vsa.calibration.calibrate import calibrate
from emg2vsa.calibration.mountings import MountingScatter, mounting_scatter, pooled
from emg2vsa.calibration.unknown import Estimate, estimate
from emg2vsa.settings import CalibrationSettings

KNOWN = np.array([7.63, 3.35, 1.11])
NEW = (5.32, 2.0)
PRESS, MOUNTING = 0.021, 0.043
"SD of CASR, as shares of it: benchmarks/results/emulated_scatter."
EXPERIMENTS = 4000
_UNEQUAL = np.array([1.6, 1.2, 0.5, 1.0])
"Times the scatter of a press, of the known specimens and the new one."
_FEW = 100


def front(kappa: Floats) -> Floats:
    """The demo's front: a sensor that is stiff beside the specimens."""
    return np.asarray(((1 / kappa + 0.917) / 0.002112) ** (2 / 3))


def spread_more(kappa: Floats) -> Floats:
    """A sensor whose contact spreads more."""
    return np.asarray(((1 / kappa + 0.05) / 0.35) ** (2 / 3))


def logarithm(kappa: Floats) -> Floats:
    """A line of CASR over ln kappa through the same ends as ``front``: not the law that is fitted."""
    ends = front(KNOWN[[0, -1]])
    return np.asarray(np.interp(-np.log(kappa), -np.log(KNOWN[[0, -1]]), ends))


@dataclass(frozen=True)
class Layout:
    """Mountings of each specimen, presses of each mounting, conditions and angles that tell how mountings differ."""

    mountings: int
    presses: int
    designs: int = 1


@dataclass(frozen=True)
class Drawn:
    """A world. mounting : SD between mountings. assumed : by the study. noise : unit scatter of presses. fitted : the
    law, and how."""

    says: str
    mounting: float = MOUNTING
    assumed: float = MOUNTING
    curve: Callable[[Floats], Floats] = front
    noise: Callable[[np.random.Generator, tuple[int, ...]], Floats] = np.random.Generator.standard_normal
    fitted: CalibrationSettings = field(default_factory=CalibrationSettings)


def autoregression(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Successive presses are correlated by .7."""
    noise = rng.standard_normal(shape)
    for i in range(1, shape[-1]):
        noise[..., i] = 0.7 * noise[..., i - 1] + np.sqrt(1 - 0.7**2) * noise[..., i]
    return noise


def heavy_tails(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Student's t of three degrees of freedom."""
    return np.asarray(rng.standard_t(3, shape) / np.sqrt(3))


def unequal(rng: np.random.Generator, shape: tuple[int, ...]) -> Floats:
    """Specimens scatter unequally."""
    return np.asarray(_UNEQUAL[:, None, None] * rng.standard_normal(shape))


PAPERS_LAW = CalibrationSettings(law="exponential", minimise="kappa")
ONE, THREE, NINE = LAYOUTS = (Layout(1, 10), Layout(3, 3), Layout(3, 3, 9))
WORLDS: tuple[tuple[Layout, Drawn], ...] = (
    (ONE, Drawn("no scatter of mountings, none assumed", 0.0, 0.0)),
    (ONE, Drawn("the same, presses correlated by .7", 0.0, 0.0, noise=autoregression)),
    (ONE, Drawn("the same, specimens scatter unequally", 0.0, 0.0, noise=unequal)),
    (ONE, Drawn("the same, heavy tails", 0.0, 0.0, noise=heavy_tails)),
    (ONE, Drawn("mountings 2.5 %, assumed 2.5 %", 0.025, 0.025)),
    *((layout, Drawn("mountings 4.3 %")) for layout in LAYOUTS),
    *((layout, Drawn("the same, presses correlated by .7", noise=autoregression)) for layout in LAYOUTS),
    *((layout, Drawn("the same, specimens scatter unequally", noise=unequal)) for layout in LAYOUTS),
    *((layout, Drawn("the same, heavy tails", noise=heavy_tails)) for layout in LAYOUTS),
    (NINE, Drawn("mountings 2.7 %", 0.027)),
    (ONE, Drawn("mountings 4.3 %, assumed 2.5 %", assumed=0.025)),
    (THREE, Drawn("mountings 4.3 %, none assumed", assumed=0.0)),
    *((layout, Drawn("a sensor that spreads more, mountings 4.3 %", curve=spread_more)) for layout in LAYOUTS),
    *((layout, Drawn("another law, mountings 4.3 %", curve=logarithm)) for layout in LAYOUTS),
    *((layout, Drawn("mountings 4.3 %, the paper's law is fitted", fitted=PAPERS_LAW)) for layout in LAYOUTS),
    (ONE, Drawn("another law, mountings 2.5 %, assumed 2.5 %", 0.025, 0.025, logarithm)),
    (ONE, Drawn("another law, no scatter of mountings, none assumed", 0.0, 0.0, logarithm)),
)  # fmt: skip


def experiments(layout: Layout, world: Drawn, new: float, count: int, seed: int = 1) -> Estimate:
    """So many studies, each with a calibration of its own."""
    rng = np.random.default_rng(seed)
    m, r = layout.mountings, layout.presses
    logs = PRESS * world.noise(rng, (count, 4, m, r)) + world.mounting * rng.standard_normal((count, 4, m, 1))
    scores = (world.curve(np.append(KNOWN, new))[:, None, None] * np.exp(logs)).reshape(count, 4, m * r)
    labels = np.repeat(np.arange(1, m + 1), r)
    scatter = None
    if layout.designs > 1:
        each = mounting_scatter(scores, np.tile(labels, (4, 1)), world.assumed)
        scatter = in_studies(each, layout.designs)
    calibration = calibrate(
        KNOWN, scores[:, :3], world.fitted, casr_unit="mm2/N", mounting_sd=world.assumed,
        mountings=np.tile(labels, (3, 1)), scatter=scatter,
    )  # fmt: skip
    return estimate(calibration, scores[:, 3], labels, known=new, bootstrap=False)


def in_studies(each: MountingScatter, designs: int) -> MountingScatter:
    """Of experiments that are so many designs of one study each, one after the other."""
    fields = [field.name for field in dataclasses.fields(MountingScatter)]
    studies = [
        pooled(MountingScatter(**{name: getattr(each, name)[i : i + designs] for name in fields}))
        for i in range(0, each.sd.size, designs)
    ]
    return MountingScatter(**{name: np.concatenate([getattr(one, name) for one in studies]) for name in fields})


def row(layout: Layout, world: Drawn, new: float, count: int) -> str:
    found = experiments(layout, world, new, count)
    there, determined = np.isfinite(found.low), found.determined
    held = (found.low <= new) & (new <= found.high)
    width = np.median((found.high - found.low)[there]) / (2 * new)
    few = np.count_nonzero(determined) < _FEW
    return (
        f"| {layout.mountings} x {layout.presses}{f', {layout.designs} designs' if layout.designs > 1 else ''} "
        f"| {world.says} | {new:g} | {np.mean(~there):.1%} | "
        f"{np.mean(held[there]):.1%} | {np.mean(determined):.1%} | "
        f"{'–' if few else f'{np.mean(held[determined]):.1%}'} | {'∞' if np.isinf(width) else f'{width:.0%}'} |"
    )


def _page(count: int = EXPERIMENTS) -> Iterator[str]:
    yield "# Coverage of the interval of kappa"
    yield ""
    yield f"`python -m benchmarks.kappa_coverage`: {count} studies a row, each calibrated on three known specimens."
    yield f"Presses scatter by {PRESS:.1%}; intervals are of 95 %. Whether κ is determined follows from the design, not"
    yield f"from the interval (decision 25). A standard error of a coverage is 0.3 points in {count} studies and 2 in"
    yield f"{_FEW}; where fewer are determined, none is given."
    yield ""
    yield (
        "| mountings x presses | world | κ, N/mm | no interval | held, of all | determined | held, of those | "
        "half width (median) |"
    )
    yield "|---|---|---:|---:|---:|---:|---:|---:|"
    for layout, world in WORLDS:
        for new in NEW:
            yield row(layout, world, new, count)
    yield ""
    yield "With another law the interval is wide on purpose: it holds what every law says that the known specimens"
    yield "do not reject, and is widened where they reject that of the study. An assumed SD that is too small cannot be"
    yield "made good. Where none is assumed, repeated mountings judge the design as well, and choose a little."


if __name__ == "__main__":
    print_page(__doc__, _page)
