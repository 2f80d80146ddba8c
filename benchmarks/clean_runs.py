"""Runs without a fault: does a guard speak, and how near does the largest force come to the one to expect?

Run with ``python -m benchmarks.clean_runs [--write FILE]``: every specimen, condition and angle with a fine force
sensor and with one whose readings come in steps of 1/16 N and never dither.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

from benchmarks.bench.record import keep
from benchmarks.rig.clean_run import Clean, clean_run
from casr.specimens import SPECIMENS
from emg2vsa.rig.plan import RIGID, Condition

CONDITIONS: tuple[Condition, ...] = (RIGID, "modular", "constant-min", "constant-max")
ANGLES_DEG = (0.0, 30.0, 45.0)
STEPS_N = (0.0, 0.0625)


def main() -> None:
    """Print a table, and the sums."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path, metavar="FILE", help="the same as Markdown there")
    path = parser.parse_args().write
    text = "\n".join(_page([(case, _carried_out(seed, *case)) for seed, case in enumerate(_cases())]))
    print(text)
    if path:
        keep(path, text)


def _cases() -> Iterator[tuple[str, Condition, float, float]]:
    return product(SPECIMENS, CONDITIONS, ANGLES_DEG, STEPS_N)


def _carried_out(seed: int, specimen: str, condition: Condition, angle_deg: float, step_n: float) -> Clean:
    with TemporaryDirectory() as folder:
        return clean_run(specimen, condition, angle_deg, step_n, seed, Path(folder) / "run")


def _page(found: list[tuple[tuple[str, Condition, float, float], Clean]]) -> Iterator[str]:
    shares = [clean.largest_n / clean.expected_n for _, clean in found]
    whole = sum(clean.ended.how == "completed" for _, clean in found)
    yield "# Runs without a fault on the emulated rig"
    yield ""
    yield f"`python -m benchmarks.clean_runs`: {whole} of {len(found)} completed, two presses each, all default guards."
    yield f"The largest force is {min(shares):.3f} to {max(shares):.3f} of the one that `rig dry-run` lets expect."
    yield ""
    yield "| specimen | condition | angle, degrees | steps of the force, N | ended | largest force, N | to expect, N |"
    yield "|---|---|---|---|---|---|---|"
    for (specimen, condition, angle_deg, step_n), clean in found:
        ended = " ".join((clean.ended.how, clean.ended.cause)).strip()
        yield (
            f"| {specimen} | {condition} | {angle_deg:g} | {step_n or 'none'} | {ended} | {clean.largest_n:.2f} "
            f"| {clean.expected_n:.2f} |"
        )


if __name__ == "__main__":
    main()
