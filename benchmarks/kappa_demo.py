"""Kappa of the demo's unknown specimen by the pins (``casr kappa``), in each of its nine designs.

``scripts/demo``, then ``python -m benchmarks.kappa_demo | python -m benchmarks.bench.record kappa_demo``: two minutes.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from casr.frame_files import open_frames
from casr.kappa.estimate import SensorKappa, estimate_kappa
from casr.kappa.presses import KappaPress
from casr.scoring import score

BY_PLATE = {"S1": 7.78, "S3": 3.43, "S5": 1.11}
"Of the known specimens, N/mm, as the demo's report tells them by its plates, each to 2.5 %."
PLATE_SD = 0.025
UNKNOWN, TRUE = "S_new", 5.32
DESIGNS = [
    *((0, each) for each in ("modular", "high-stiffness", "constant-min", "constant-mean", "constant-max")),
    *((angle, each) for angle in (30, 45) for each in ("modular", "high-stiffness")),
]


def presses(folder: Path) -> Iterator[KappaPress]:
    """Of a design, whose runs' folders start alike; (mountings are folders)."""
    for run in sorted(folder.parent.glob(f"*_{folder.name}*")):
        specimen = run.name.removesuffix(f"_{folder.name}").split(f"_{folder.name}_mounting")[0]
        if specimen not in (*BY_PLATE, UNKNOWN):
            continue
        for press in sorted(run.glob("press-*")):
            known = BY_PLATE.get(specimen)
            yield KappaPress.of_score(
                score(open_frames(press)), name=f"{run.name}/{press.name}", specimen=specimen, mounting=run.name,
                stiffness_n_per_mm=known, stiffness_sd=PLATE_SD if known else 0.0,
            )  # fmt: skip


def row(name: str, found: SensorKappa, count: int) -> tuple[str, float, bool]:
    kappa = found.kappas[UNKNOWN]
    error = kappa.value / TRUE - 1
    cells = [
        f"{count}", f"{kappa.value:.2f}", f"{kappa.low:.2f} to {kappa.high:.2f}", f"{100 * error:+.1f}",
        f"{50 * (kappa.high - kappa.low) / kappa.value:.0f}", "yes" if kappa.determined else "no",
        f"{found.misfit:.3f}", *(f"{found.kappas[each].value:.2f}" for each in BY_PLATE),
    ]  # fmt: skip
    return f"| {name} | {' | '.join(cells)} |", error, kappa.low <= TRUE <= kappa.high


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path, nargs="?", default=Path("studies/palpation/runs-virtual"))
    given = parser.parse_args()
    print("# Kappa of the demo's unknown specimen by the pins\n")
    print(f"{UNKNOWN} has {TRUE} N/mm. Known: {', '.join(f'{each} {value}' for each, value in BY_PLATE.items())} N/mm;")
    print("their own columns are what the others say of them. Three mountings of three presses each.\n")
    print(
        "| design | presses | kappa (N/mm) | 95 % interval | error (%) | half width (%) | determined | misfit |", end=""
    )
    print(" S1 | S3 | S5 |\n|---|" + "---:|" * 10)
    rows = []
    for angle, condition in DESIGNS:
        used = list(presses(given.runs / f"{angle}_{condition}"))
        first = next(given.runs.glob(f"*_{angle}_{condition}"))
        camera = open_frames(next(first.glob("press-*"))).camera
        assert camera is not None
        rows.append(row(f"{condition}, {angle}°", estimate_kappa(used, camera), len(used)))
        print(rows[-1][0], flush=True)
    errors = np.abs([error for _, error, _ in rows])
    print(
        f"\nMedian of the error without its sign: {100 * np.median(errors):.1f} %, largest {100 * errors.max():.1f} %;",
        end="",
    )
    print(f" {sum(held for *_, held in rows)} of {len(rows)} intervals hold {TRUE}.")


if __name__ == "__main__":
    main()
