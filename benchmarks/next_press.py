"""Presses needed for a width of kappa: the next best press against fixed plans, and the belief against the interval.

Three conditions that differ in how long a press takes (presets of 20, 50 and 80 %), so in what a camera that is late
costs; every condition and every new mounting draws its own error. A fixed plan presses one condition in one mounting,
or mounts anew before every press.

    python -m benchmarks.next_press     # writes benchmarks/results/next_press.json
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from benchmarks.bench.record import keep
from benchmarks.press_curves import DEFAULT, Bench, Mounting, World, power_law, relaxing
from emg2vsa.arrays import Floats
from emg2vsa.calibration.cut_presses import cut_rates
from emg2vsa.calibration.next_press import Belief, Done, belief, next_press
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.settings import CalibrationSettings

RESULTS = Path(__file__).parent / "results" / "next_press.json"
KAPPA, CONFIDENCE = 5.32, 0.95
MOST = 24
"Presses after which an experiment gives up."
EXPERIMENTS = 40
WIDTHS = (0.5, 0.35, 0.25)
CONDITIONS = ("20 %", "50 %", "80 %")
Decide = Callable[["Session"], "tuple[int, bool] | None"]


@dataclass
class Session:
    """Presses of one unknown specimen, condition by condition."""

    benches: list[Bench]
    calibrations: list[OnlineCalibration]
    rates: list[list[Floats]] = field(default_factory=list)
    labels: list[list[int]] = field(default_factory=list)
    mounted: list[Mounting | None] = field(default_factory=list)
    done: dict[int, Done] = field(default_factory=dict)

    def __post_init__(self) -> None:
        count = len(self.benches)
        self.rates, self.labels = [[] for _ in range(count)], [[] for _ in range(count)]
        self.mounted = [None] * count

    @property
    def presses(self) -> int:
        return sum(map(len, self.rates))

    @property
    def mountings(self) -> int:
        return sum(len(set(labels)) for labels in self.labels)

    def press(self, index: int, remount: bool) -> None:
        bench, own = self.benches[index], self.calibrations[index]
        if remount or self.mounted[index] is None:
            self.mounted = [None] * len(self.benches)  # another condition takes the specimen off
            self.mounted[index] = bench.mounting()
        mounting = self.mounted[index]
        assert mounting is not None
        press = bench.press(KAPPA, mounting)
        self.rates[index].append(cut_rates(press.force_n, press.area_mm2, own.start_n, own.forces_n[-1:]))
        self.labels[index].append(max(self.labels[index], default=0) + remount)
        rates, labels = np.stack(self.rates[index]), np.array(self.labels[index])
        found = own.judged(rates, np.full_like(rates, np.nan), np.array([own.forces_n.size - 1]), labels)
        kappa, low = float(found.kappa[0]), float(found.low[0])
        self.done[index] = Done(len(rates), len(set(self.labels[index])), kappa, low, found.cues)
        self.high = float(found.high[0])

    def belief(self) -> Belief:
        return belief(self.calibrations, self.done)

    def half_width(self) -> float:
        low, high = self.belief().interval(CONFIDENCE)
        return (high - low) / (2 * self.belief().middle)


def adaptive(session: Session) -> tuple[int, bool] | None:
    choice = next_press(session.calibrations, session.done)
    return None if choice is None else (choice.calibration, choice.remount)


def fixed(index: int, *, anew: bool) -> Decide:
    return lambda session: (index, anew or not session.rates[index])


PLANS: dict[str, Decide] = {
    "adaptive": adaptive,
    "20 %, one mounting": fixed(0, anew=False),
    "50 %, one mounting": fixed(1, anew=False),
    "80 %, one mounting": fixed(2, anew=False),
    "20 %, mounted anew for each press": fixed(0, anew=True),
    "80 %, mounted anew for each press": fixed(2, anew=True),
}


def session(worlds: list[World], rng: np.random.Generator) -> Session:
    benches = [Bench(world, DEFAULT, rng) for world in worlds]
    return Session(benches, [bench.calibration(3, 4, CalibrationSettings()) for bench in benches])


def carried_out(worlds: list[World], decide: Decide, rng: np.random.Generator) -> tuple[Floats, Floats, bool, bool]:
    """Presses and mountings (W,) until each of ``WIDTHS``, NaN where it is not reached, and at the end whether the
    belief, and the interval of the condition pressed last, hold kappa."""
    own, needed, mountings = session(worlds, rng), np.full(len(WIDTHS), np.nan), np.full(len(WIDTHS), np.nan)
    last = 0
    while own.presses < MOST and np.isnan(needed).any():
        decided = decide(own)
        if decided is None:
            break
        last = decided[0]
        own.press(*decided)
        reached = np.isnan(needed) & (own.half_width() <= np.array(WIDTHS))
        needed[reached], mountings[reached] = own.presses, own.mountings
    low, high = own.belief().interval(CONFIDENCE)
    return needed, mountings, low <= KAPPA <= high, own.done[last].low <= KAPPA <= own.high


def rows(count: int) -> Iterator[str]:
    for name, make in (
        ("power law, exponent 0.333", lambda preset: power_law(1 / 3, preset)),
        ("relaxing bodies", relaxing),
    ):
        worlds = [make(preset) for preset in (600.0, 1500.0, 2400.0)]
        for plan, decide in PLANS.items():
            rng = np.random.default_rng(3)
            found = [carried_out(worlds, decide, rng) for _ in range(count)]
            needed, mountings = (np.stack([each[i] for each in found]) for i in (0, 1))
            cells = [
                f"{np.median(np.nan_to_num(needed[:, w], nan=np.inf)):.0f}, "
                f"{np.median(np.nan_to_num(mountings[:, w], nan=np.inf)):.0f} "
                f"({np.mean(np.isfinite(needed[:, w])):.0%})"
                for w in range(len(WIDTHS))
            ]
            held = [np.mean([each[i] for each in found]) for i in (2, 3)]
            yield f"| {name} | {plan} | " + " | ".join(cells) + f" | {held[0]:.0%} | {held[1]:.0%} |"


def main(count: int = EXPERIMENTS) -> None:
    start = time.perf_counter()
    lines = [
        "# Presses needed for a width of κ",
        "",
        f"`python -m benchmarks.next_press`: {count} experiments a row. S2 (5.32 N/mm) is unknown, S1, S3 and S5 were",
        "mounted three times and pressed four times each. A cell is: presses, mountings (medians; an experiment gives",
        f"up after {MOST} presses) and the share of experiments that reach the half width. Coverage is at the end of",
        "each experiment, of the belief over all conditions and of the interval of the condition pressed last.",
        "",
        "| world | plan | "
        + " | ".join(f"±{width:.0%}" for width in WIDTHS)
        + " | belief holds κ | interval holds κ |",
        "|---|---|" + "---|" * (len(WIDTHS) + 2),
    ]
    for line in rows(count):
        print(line, flush=True)
        lines.append(line)
    lines += ["", f"Made in {time.perf_counter() - start:.0f} s."]
    keep(RESULTS, "\n".join(lines))


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
