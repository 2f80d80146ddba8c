"""Optical-flow sequences with known flow, read from a folder of downloaded data.

Flows are (H, W, 2) px per frame, u to the right and v down; unknown flow is NaN.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

Flow = NDArray[np.float32]
Frames = NDArray[np.uint8]

DATA = Path(os.environ.get("EMG2VSA_TEST_DATA", Path(__file__).resolve().parents[2] / "shared" / "data"))
FLO_MAGIC = 202021.25
UNKNOWN_FLOW = 1e9


def read_flo(path: Path) -> Flow:
    """A Middlebury .flo file (Baker et al., IJCV 2011): magic number, width, height, then u, v of every pixel."""
    data = path.read_bytes()
    magic = np.frombuffer(data, "<f4", 1)[0]
    if magic != FLO_MAGIC:
        raise SystemExit(f"{path}: expected a .flo file, but found the magic number {magic:g}.")
    width, height = np.frombuffer(data, "<i4", 2, offset=4)
    flow = np.frombuffer(data, "<f4", 2 * width * height, offset=12).reshape(height, width, 2).copy()
    flow[(np.abs(flow) > UNKNOWN_FLOW).any(axis=-1)] = np.nan
    return flow


def read_grey(path: Path) -> Frames:
    """One image, grey."""
    image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
    if image is None:
        raise SystemExit(f"{path}: expected an image, but found none that can be read.")
    return np.asarray(image, dtype=np.uint8)


def middlebury(name: str) -> tuple[Frames, Flow]:
    """Frames 10 and 11 (2, H, W) and the flow between them."""
    folder = DATA / "flow" / "middlebury" / name
    frames = np.stack([read_grey(folder / f"frame{i}.png") for i in (10, 11)])
    return frames, read_flo(folder / "flow10.flo")


def yosemite() -> tuple[Frames, Flow, NDArray[np.bool_]]:
    """Fifteen frames 2 ... 16 (15, 252, 316), the flow at frame 9, and where the sky is."""
    folder = DATA / "flow" / "yosemite"
    frames = np.stack([read_grey(folder / f"yos{i}.tif") for i in range(2, 17)])
    known = np.load(folder / "correct_flow_yos9_to_yos10.npz")
    return frames, _flow(known), known["sky"]


def translating_tree() -> tuple[Frames, Flow]:
    """Fifteen frames 13 ... 27 (15, 150, 150) and the flow at frame 20: u = 1.73 + 0.57 x / 149 px, v = 0."""
    folder = DATA / "flow" / "translating_tree"
    frames = np.stack([np.fromfile(folder / f"new2binarytreet.{i}", np.uint8).reshape(150, 150) for i in range(13, 28)])
    u = np.broadcast_to(1.73 + 0.57 * np.arange(150) / 149, (150, 150))
    return frames, np.stack([u, np.zeros((150, 150))], axis=-1).astype(np.float32)


def barron_output(relative: str) -> tuple[Flow, int]:
    """What Barron's own program gave, and how many pixels it leaves out at every edge."""
    output = np.load(DATA / "flow" / relative)
    return _flow(output), int(output["x0"])


def _flow(fields: Any) -> Flow:
    return np.stack([fields["u"], fields["v_down"]], axis=-1).astype(np.float32)
