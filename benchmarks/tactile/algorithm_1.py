"""Algorithm 1 of the paper once more, from its text alone, beside casr's: pins selected in the first frame in contact.

Run with ``python -m benchmarks.tactile.algorithm_1 RUNS [--write FILE]`` on the emulated runs of the demo (studies/
palpation/runs-virtual after ``emg2vsa run``).
"""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.bench.record import keep
from casr.frames import FrameSequence, loading_phase
from casr.pins import PinTracker
from casr.press_forces import press_forces
from casr.scored import ScoreSettings
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.run_scores.score_run import score_run
from emg2vsa.settings import RunSettings

THRESHOLD_PX = 2.0
BINS_N = (0.5, 0.6, 0.7, 0.8, 0.9, 1.5)


def mask_centroids(image: NDArray[np.uint8]) -> NDArray[np.float64]:
    """(N, 2) px: centroids of the contours in a mask of what is brighter than its surroundings (Fig. 2b to 2d)."""
    grey = image.astype(np.float32)
    mask = (cv2.GaussianBlur(grey, (0, 0), 1.0) > cv2.blur(grey, (31, 31)) + 10).astype(np.uint8)
    contours, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    moments = [cv2.moments(contour) for contour in contours]
    least = 0.4 * np.median([each["m00"] for each in moments])
    return np.array(
        [(each["m10"] / each["m00"], each["m01"] / each["m00"]) for each in moments if each["m00"] >= least]
    )


def selected_pins(
    rest_px: NDArray[np.float64], contact_px: NDArray[np.float64], threshold_px: float = THRESHOLD_PX
) -> int:
    """n of Algorithm 1 from centroids (N, 2) and (M, 2), in any order.

    Two are a pair where each is the nearest to the other; a pair counts where its whole-pixel centroids, the paper's
    ``int(cX), int(cY)``, lie more than the threshold apart.
    """
    apart = np.hypot(*(rest_px[:, None] - contact_px[None]).transpose(2, 0, 1))
    nearest = apart.argmin(axis=1)
    mutual = apart.argmin(axis=0)[nearest] == np.arange(len(rest_px))
    first, second = rest_px[mutual].astype(np.int64), contact_px[nearest[mutual]].astype(np.int64)
    return int(np.count_nonzero(np.hypot(*(first - second).T) > threshold_px))


@dataclass(frozen=True)
class Counted:
    """One press. n : by emg2vsa. of_pins, of_masks : by ``selected_pins``, of casr's centroids and of its own."""

    angle_deg: float
    first_n: float
    n: int
    of_pins: int
    of_masks: int


def counted(folder: Path) -> Iterator[Counted]:
    """The presses of a run's folder, S1_0_modular or S1_0_modular_mounting-2."""
    presses, (run, _, _) = list(read_presses([folder])), folder.name.partition("_mounting-")
    angle_deg = float(run.rsplit("_", 2)[1])
    settings = RunSettings(algorithm="paper", threshold_px=THRESHOLD_PX)
    scores = score_run(presses, settings, specimen="", angle_deg=angle_deg, condition="", simulated=True)
    for press, first_n, n in zip(presses, scores.first_n.tolist(), scores.pins_selected.tolist(), strict=True):
        assert press.frames is not None
        rest, contact = first_contact(press.frames)
        tracker = PinTracker()
        pins, moved = tracker.start(rest).centroids_px, tracker.step(contact)
        moved = np.random.default_rng(0).permutation(moved[np.isfinite(moved).all(axis=1)])
        of_masks = selected_pins(mask_centroids(rest), mask_centroids(contact))
        yield Counted(angle_deg, first_n, n, selected_pins(pins, moved), of_masks)


def first_contact(frames: FrameSequence) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The static frame and the first whose mean force is 0.5 N."""
    sequence = frames.by_mean()
    phase = loading_phase(press_forces(sequence, ScoreSettings()).force_n)
    rest, contact = (np.asarray(sequence[int(i)]).astype(np.uint8) for i in (phase.rest, phase.frames[0]))
    return rest, contact


def main() -> None:
    """Print the counts by the force of the first frame."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path, metavar="RUNS", help="folder of the runs")
    parser.add_argument("--write", type=Path, metavar="FILE", help="a record of it there")
    arguments = parser.parse_args()
    found = [each for folder in sorted(arguments.runs.glob("*_*_*")) for each in counted(folder)]
    text = "\n".join(_page(found))
    print(text)
    if arguments.write:
        keep(arguments.write, text)


def _page(found: list[Counted]) -> Iterator[str]:
    same = sum(each.n == each.of_pins for each in found)
    apart = Counter(each.of_masks - each.n for each in found)
    yield "# Pins that Algorithm 1 selects"
    yield ""
    yield (
        f"`python -m benchmarks.tactile.algorithm_1 studies/palpation/runs-virtual`: {len(found)} presses of the demo, "
        "mean force per frame, 2 px."
    )
    yield ""
    yield (
        f"emg2vsa's n equals that of a second implementation, written from the paper's text, in {same} of "
        f"{len(found)} presses, from the same centroids in any order."
    )
    yield (
        "With a mask and contours of its own in place of casr's grey-level centroids, the second implementation's n "
        "differs as follows. The paper cuts centroids to whole pixels, so that a difference of 0.1 px can decide on a "
        "pin."
    )
    yield ""
    yield "| difference of n | presses |"
    yield "|---|---|"
    yield from (f"| {difference:+d} | {apart[difference]} |" for difference in sorted(apart))
    yield ""
    yield "n by the mean force of the first frame in contact:"
    yield ""
    yield "| angle, degrees | force, N | presses | least n | median | largest |"
    yield "|---|---|---|---|---|---|"
    for angle in sorted({each.angle_deg for each in found}):
        for low, high in pairwise(BINS_N):
            n = [each.n for each in found if each.angle_deg == angle and low <= each.first_n < high]
            if n:
                yield f"| {angle:g} | {low:g} to {high:g} | {len(n)} | {min(n)} | {np.median(n):g} | {max(n)} |"


if __name__ == "__main__":
    main()
