"""Real frames of TacTip sensors: pins found per frame, and growth of a real press by every engine.

    python -m benchmarks.tactile_real_frames

Data as in ``EMG2VSA_TEST_DATA``. In the flat press the area inside a circle of skin must grow by the same factor
whether pins are counted at its ends or divergence is summed over its ninety steps.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import time
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from benchmarks.optical_flow_data import DATA
from benchmarks.tactile.table import Cell, Table
from benchmarks.tactile.timing import best_times, one_thread
from casr.errors import CasrError
from casr.flow.estimate import ENGINES, FlowSettings, FlowTracker
from casr.flow.region import Region
from casr.frame_files import open_frames
from casr.images import as_grey
from casr.pins import PinTracker, detect_pins

FLAT_PRESS = "tactip127_flat_press_640x480"
CENTRE_PX, RADII_PX = (324.0, 240.0), (48.0, 60.0)
SETS = {
    FLAT_PRESS: 127,
    "tactip127_shapes_300x300": 127,
    "tactip127_surface2d_bw_256x256": 127,
    "tactip331_raw_640x480": 331,
}
TIMED_FRAMES = 10


def main() -> None:
    """Print the two tables."""
    with one_thread():
        for table in (pins_table(), growth_table()):
            print(table.text(), end="\n\n")


def pins_table() -> Table:
    """Pins found in every frame of every set."""
    rows: list[list[Cell]] = []
    for name, n_pins in SETS.items():
        images = [as_grey(cv2.imread(str(path), cv2.IMREAD_UNCHANGED)) for path in image_paths(DATA / "tactile" / name)]
        counts = np.array([count_pins(image) for image in images])
        sample = images[:: max(1, len(images) // TIMED_FRAMES)]
        time_s = best_times({name: lambda sample=sample: [count_pins(image) for image in sample]}, n_repeats=5)[name]  # type: ignore[misc]
        exact = 100 * float(np.mean(counts == n_pins))
        rows.append(
            [
                name,
                len(images),
                n_pins,
                *map(int, np.percentile(counts, [0, 50, 100])),
                exact,
                1e3 * time_s / len(sample),
            ]
        )
    columns = (("set", ""), ("frames", "d"), ("pins", "d"), ("fewest", "d"), ("median", "d"), ("most", "d"))
    return Table("pins", "Pins found with default settings", (*columns, ("exact %", ".0f"), ("ms", ".2f")), rows)


def count_pins(image: NDArray[np.uint8]) -> int:
    """Pins of one frame, 0 where it is refused."""
    try:
        return len(detect_pins(image))
    except CasrError:
        return 0


def image_paths(folder: Path) -> list[Path]:
    """All images below a folder."""
    return sorted(folder.rglob("*.png"))


def growth_table() -> Table:
    """Logarithm of the factor by which circles of skin grow over the flat press."""
    frames = list(open_frames(DATA / "tactile" / FLAT_PRESS))
    hulls = hull_growths(frames)
    rows: list[list[Cell]] = [
        ["hull of the pins, first to last", None, *[cell for hull in hulls for cell in (hull, 0.0)]]
    ]
    for engine in ENGINES:
        start_s = time.process_time()
        growths = [summed_growth(frames, engine, radius_px) for radius_px in RADII_PX]
        step_ms = 1e3 * (time.process_time() - start_s) / (len(RADII_PX) * (len(frames) - 1))
        cells = [
            cell for growth, hull in zip(growths, hulls, strict=True) for cell in (growth, 100 * (growth / hull - 1))
        ]
        rows.append([f"{engine}, summed over the steps", step_ms, *cells])
    columns = [column for radius in RADII_PX for column in ((f"r < {radius:g} px", ".3f"), ("% of hull", "+.1f"))]
    note = f"Circles around ({CENTRE_PX[0]:g}, {CENTRE_PX[1]:g}); two of the steps move 4 to 5 px."
    title = f"Growth of a real flat press, {len(frames)} frames: ln of the area ratio"
    return Table("flat_press", title, (("", ""), ("ms per step", ".2f"), *columns), rows, (note,))


def summed_growth(frames: list[NDArray[np.uint8]], engine: str, radius_px: float) -> float:
    """Sum over all steps of the logarithmic growth of a circle, measured on all of it."""
    tracker = FlowTracker(FlowSettings(engine=engine, core_fraction=1.0))
    tracker.start(frames[0], Region.circle(*CENTRE_PX, radius_px))
    return sum(tracker.step(frame).log_growth for frame in frames[1:])


def hull_growths(frames: list[NDArray[np.uint8]]) -> list[float]:
    """The same from the ends alone: the convex hull of the pins that start inside each circle."""
    tracker = PinTracker()
    first = tracker.start(frames[0]).centroids_px
    for frame in frames[1:]:
        last = tracker.step(frame)
    distance_px = np.hypot(*(first - CENTRE_PX).T)
    growths = []
    for radius_px in RADII_PX:
        before, after = (Region.from_points(pins_px[distance_px < radius_px]).area_px2 for pins_px in (first, last))
        growths.append(float(np.log(after / before)))
    return growths


if __name__ == "__main__":
    main()
