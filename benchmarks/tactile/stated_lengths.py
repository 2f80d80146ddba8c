"""Intervals of CASR and of areas where camera.toml states depth and pin length with errors, and is wrong by so much.

Run with ``python -m benchmarks.tactile.stated_lengths [--write FILE]``, twelve minutes. Frames are rendered
and scored as ``casr score`` does; domes of the library are left out of it while they are pressed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

from benchmarks.bench.record import print_page
from benchmarks.tactile.world_scores import GROUPS, WorldScore, named, world_named, world_scored
from casr.camera import Camera
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile import PressSettings

SHARE_SD = 0.01
"Of depth and of pin length, as stated."
ANGLES_DEG = (0.0, 30.0)
STOPS_N = (5.0, 7.0)
"Largest force: tables were computed up to 5 N, and the emulated press continues them up to 7."
KINDS = {"dome A, between those of the library": GROUPS["full"], "domes left out of the library": GROUPS["domes"]}


def main() -> None:
    """Print the table."""
    print_page(__doc__, _page)


def stated(camera: Camera, rng: np.random.Generator) -> Camera:
    """The camera file of someone who measured both lengths with a relative standard error of ``SHARE_SD``."""
    length_mm = camera.sensor.pin_length_mm
    assert length_mm is not None
    depth, length = 1 + SHARE_SD * rng.standard_normal(2)
    sensor = replace(camera.sensor, pin_length_mm=length_mm * length, pin_length_sd_mm=SHARE_SD * length_mm)
    return replace(camera, depth_mm=camera.depth_mm * depth, depth_sd_mm=SHARE_SD * camera.depth_mm, sensor=sensor)


def _page() -> Iterator[str]:
    yield "# Intervals where lengths are stated with errors"
    yield ""
    yield f"`python -m benchmarks.tactile.stated_lengths`: {', '.join(SPECIMENS)} at 0 and 30°. camera.toml is wrong"
    yield f"by {SHARE_SD:.0%} (SD) in depth and in pin length, and says so. Errors are roots of mean squares."
    yield ""
    head = ["dome", "up to N", "presses", "CASR, error %", "half width %", "held %", "areas, error %", "half width %"]
    head += ["held %", "misfit"]
    yield f"| {' | '.join(head)} |"
    yield "|---|" + "---:|" * (len(head) - 1)
    for (kind, group), stop_n in product(KINDS.items(), STOPS_N):
        scored = [_scored(name, specimen, angle, stop_n) for name in named(group) if world_named(name).world
                  for specimen, angle in product(SPECIMENS.values(), ANGLES_DEG)]  # fmt: skip
        yield f"| {kind} | {stop_n:g} | {' | '.join(_cells([one for one in scored if not one.refused]))} |"


def _scored(name: str, stiffness_n_per_mm: float, angle_deg: float, stop_n: float) -> WorldScore:
    settings = PressSettings(stiffness_n_per_mm=stiffness_n_per_mm, angle_deg=angle_deg)
    seed = [*name.encode(), round(1000 * stiffness_n_per_mm), round(angle_deg)]
    return world_scored(name, settings, stated(settings.camera, np.random.default_rng(seed)), stop_n=stop_n)


def _cells(scored: list[WorldScore]) -> list[str]:
    casr = np.array(
        [[np.log(one.front.value / one.true_casr), np.log(one.front.high / one.front.low) / 2] for one in scored]
    )
    areas = np.concatenate([np.c_[one.log_area_error, 1.96 * one.area_sd] for one in scored])
    told = [str(len(scored))]
    for error, half in (casr.T, areas.T):
        told += [f"{100 * np.sqrt(np.mean(error**2)):.1f}", f"{100 * np.median(half):.1f}"]
        told.append(f"{100 * np.mean(np.abs(error) <= half):.0f}")
    return [*told, f"{np.median([one.misfit for one in scored]):.3f}"]


if __name__ == "__main__":
    main()
