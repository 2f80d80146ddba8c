"""Optical flow on the field's sequences with known flow, beside published numbers and peers.

    python -m benchmarks.optical_flow_references

Yosemite and Translating Tree with the outputs of Barron's own program, two Middlebury sequences; data as in
``EMG2VSA_TEST_DATA``. The reproduction runs the modified Horn and Schunck of Barron, Fleet and Beauchemin (IJCV 12,
1994, section 2.1) in this package's plain NumPy: Gaussian of 1.5 px and frames over eleven frames, four-point central
differences, alpha 0.5, 100 iterations. Times are processor time on one thread, best of repeats.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from collections.abc import Iterable
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.optical_flow_data import Flow, Frames, barron_output, middlebury, translating_tree, yosemite
from benchmarks.tactile.flow_scores import angular_error_deg, endpoint_error_px, percent_error
from benchmarks.tactile.jacobi import relaxed
from benchmarks.tactile.method import Method
from benchmarks.tactile.ours import NATURAL_IMAGES, horn_schunck_method
from benchmarks.tactile.peers import dense_peers, pin_peers
from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.timing import Run, best_times, one_thread
from casr.flow.dense_engine import fit_field
from casr.flow.horn_schunck import HornSchunckSettings
from casr.flow.region import Region

FOUR_POINTS = np.array([1, -8, 0, 8, -1], dtype=np.float32) / 12
BORDER_PX = 14
EDGES = f"{BORDER_PX} px left out at the edges (original: 4 px)"
TREE_DIVERGENCE = 0.57 / 149
Motions = list[tuple[str, float | None, Flow]]
PUBLISHED = "Barron, Fleet and Beauchemin print 9.78 ± 16.19 (modified) and 31.69 ± 31.18 (original), all pixels."


def main() -> None:
    """Print the three tables."""
    with one_thread():
        for table in (
            yosemite_table(),
            tree_table(),
            *(middlebury_table(name) for name in ("RubberWhale", "Dimetrodon")),
        ):
            print(table.text(), end="\n\n")


def yosemite_table() -> Table:
    """Average angular error with and without the sky, as the literature reports it."""
    frames, truth, sky = yosemite()
    motions = references("yosemite", "", frames, truth) + cropped(motions_of(methods(), *frames[7:9]))
    columns = (("method", ""), ("ms", ".1f"), ("AAE °", ".2f"), ("sd", ".2f"), ("no sky °", ".2f"), ("EPE px", ".3f"))
    rows = []
    for name, time_ms, flow in motions:
        whole = angular_error_deg(flow, truth)
        epe = float(np.nanmean(endpoint_error_px(flow, truth)))
        rows.append([name, time_ms, *mean_sd(whole), float(np.nanmean(whole[~sky])), epe])
    return Table("yosemite", f"Yosemite, frame 9 to 10, {EDGES}", columns, rows, (PUBLISHED,))


def tree_table() -> Table:
    """Average angular error and the divergence, which is known everywhere."""
    frames, truth = translating_tree()
    motions = references("translating_tree", "_frame20", frames, truth)
    motions += cropped(motions_of(methods(), *frames[7:9]))
    columns = (
        ("method", ""),
        ("ms", ".1f"),
        ("AAE °", ".2f"),
        ("sd", ".2f"),
        ("EPE px", ".3f"),
        ("divergence %", "+.1f"),
    )
    rows = []
    for name, time_ms, flow in motions:
        epe = float(np.nanmean(endpoint_error_px(flow, truth)))
        error = float(percent_error(fitted_divergence(flow), TREE_DIVERGENCE))
        rows.append([name, time_ms, *mean_sd(angular_error_deg(flow, truth)), epe, error])
    notes = (
        "divergence: of the affine motion fitted to the flow, against the true 0.003826 per frame.",
        "Barron, Fleet and Beauchemin print 2.02 ± 2.27 (modified) and 38.72 ± 27.67 (original).",
    )
    return Table("tree", f"Translating Tree, frame 20 to 21, {EDGES}", columns, rows, notes)


def fitted_divergence(flow: Flow) -> float:
    """Divergence per frame of the affine motion of the part that is known, as the engines for pins measure it."""
    known = flow[np.ix_(*(np.isfinite(flow[..., 0]).any(axis=axis) for axis in (1, 0)))]
    height, width = known.shape[:2]
    edge = np.array([[0, 0], [width - 1, 0], [width - 1, height - 1], [0, height - 1]], dtype=np.float64)
    return float(np.trace(fit_field(known, Region(edge)).matrix))


def middlebury_table(name: str) -> Table:
    """Endpoint and angular error over the pixels whose flow is known."""
    frames, truth = middlebury(name)
    known = np.isfinite(truth).all(axis=-1)
    columns = (("method", ""), ("ms", ".1f"), ("EPE px", ".3f"), ("AAE °", ".2f"), ("sd", ".2f"))
    rows: list[list[Cell]] = []
    for method, time_ms, flow in motions_of(methods(), *frames):
        epe = float(endpoint_error_px(flow, truth)[known].mean())
        rows.append([method, time_ms, epe, *mean_sd(angular_error_deg(flow, truth)[known])])
    return Table(
        name.lower(), f"Middlebury {name}, frame 10 to 11, {truth.shape[1]} x {truth.shape[0]} px", columns, rows
    )


def methods() -> list[Method]:
    """The dense solver with both sets of defaults, and every peer that is installed."""
    ours = [
        horn_schunck_method("Horn-Schunck, defaults for pins", HornSchunckSettings()),
        horn_schunck_method("Horn-Schunck, for natural images", NATURAL_IMAGES),
    ]
    return [method for method in (*ours, *dense_peers(), *pin_peers()) if method.installed]


def motions_of(compared: Iterable[Method], first: Frames, second: Frames) -> Motions:
    """Name, time in ms and flow of each method from one frame to the next."""
    whole = Region.circle(first.shape[1] / 2, first.shape[0] / 2, min(first.shape) / 3)
    runs: dict[str, Run] = {
        f"{method.library} {method.name}": method.prepare(first, second, whole) for method in compared
    }
    flows = {name: run() for name, run in runs.items()}
    times = best_times(runs, n_repeats=5, budget_s=1.0)
    return [(name, 1e3 * times[name], flow) for name, flow in flows.items()]


def references(folder: str, suffix: str, frames: Frames, truth: Flow) -> Motions:
    """The flows Barron's own program gave, NaN at the edges it leaves out, and its modified method done again here."""
    found: Motions = []
    for kind in ("modified", "original"):
        flow, edge = barron_output(f"{folder}/barron_horn_{kind}_output{suffix}.npz")
        whole = np.full(truth.shape, np.nan, dtype=np.float32)
        whole[edge : edge + flow.shape[0], edge : edge + flow.shape[1]] = flow
        found.append((f"Barron's program, {kind}", None, whole))
    return [*found, *cropped([("modified, done again here", None, barron_modified(frames))])]


def cropped(motions: Motions) -> Motions:
    """The motions with NaN where Barron's modified method gives none."""
    return [
        (name, time_ms, np.where(inner(flow.shape)[..., None], flow, np.float32("nan")))
        for name, time_ms, flow in motions
    ]


def barron_modified(frames: Frames, *, alpha: float = 0.5, n_iterations: int = 100, sigma: float = 1.5) -> Flow:
    """Flow (H, W, 2) at the middle frame; as in the original, edges without derivatives carry diffused flow only."""
    reach = int(6 * sigma + 1) // 2
    gauss = np.exp(-(np.arange(-reach, reach + 1) ** 2) / (2 * sigma**2)).astype(np.float32)
    gauss /= gauss.sum()
    middle = len(frames) // 2
    around = [frames[i - reach : i + reach + 1].astype(np.float32) for i in range(middle - 2, middle + 3)]
    smooth = [cv2.sepFilter2D(np.tensordot(gauss, stack, 1), -1, gauss, gauss) for stack in around]
    ix = cv2.filter2D(smooth[2], -1, FOUR_POINTS[None])
    iy = cv2.filter2D(smooth[2], -1, FOUR_POINTS[:, None])
    it = np.tensordot(FOUR_POINTS, np.stack(smooth), 1)
    inside = inner(smooth[2].shape, reach + 2)
    return relaxed(ix * inside, iy * inside, it * inside, alpha=alpha, n_iterations=n_iterations)


def inner(shape: tuple[int, ...], border_px: int = BORDER_PX) -> NDArray[np.bool_]:
    """(H, W) whether a pixel lies at least so far from the edges."""
    inside = np.zeros(shape[:2], dtype=bool)
    inside[border_px:-border_px, border_px:-border_px] = True
    return inside


def mean_sd(values: NDArray[Any]) -> tuple[float, float]:
    return float(np.nanmean(values)), float(np.nanstd(values, ddof=1))


if __name__ == "__main__":
    main()
