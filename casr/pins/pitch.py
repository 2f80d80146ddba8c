"""A first guess of the pin pitch of a frame in which no pin is known yet: how far it must be shifted to look alike."""

from __future__ import annotations

from typing import cast

import cv2
import numpy as np
from numpy.typing import NDArray

from casr.images import Grey

LEAST_SIDE = 32  # px
LARGEST_SIDE = 480  # px; larger frames are reduced for the guess
BROAD_LIGHT = 1 / 7  # of the longer side: light that changes over such lengths is taken off
CLIP_PERCENTILE = 97.0  # lamps and a bright rim count no more than a pin
LEAST_PITCH, LARGEST_SHIFT = 5.0, 1 / 3  # px of the reduced frame; share of its shorter side
LEAST_ALIKE = 0.12  # correlation of the shifted frame; pins of real sensors reach 0.3 and more
NEARLY_BEST = 0.65  # of the best shift: among those the shortest is one pitch, the others are several


def guess_pitch_px(grey: Grey) -> float | None:
    """Pin pitch, px, to about 5 %, by autocorrelation; None where nothing repeats."""
    if min(grey.shape) < LEAST_SIDE:
        return None
    reduction = max(1, -(-max(grey.shape) // LARGEST_SIDE))
    alike = _autocorrelation(reduced(grey, reduction))
    shift = _shortest_good_shift(alike)
    return None if shift is None else reduction * shift


def reduced(grey: Grey, reduction: int) -> Grey:
    """Means of squares of ``reduction`` x ``reduction`` px; rows and columns left over are cut off."""
    if reduction == 1:
        return grey
    height, width = (side // reduction for side in grey.shape)
    whole = grey[: height * reduction, : width * reduction]
    return cast(Grey, cv2.resize(whole, (width, height), interpolation=cv2.INTER_AREA))


def _autocorrelation(grey: Grey) -> NDArray[np.float32]:
    """(rows, columns) correlation of the frame with itself shifted down by the row and right by column - columns//2."""
    height, width = grey.shape
    light = grey.astype(np.float32)
    light -= cv2.GaussianBlur(light, (0, 0), BROAD_LIGHT * max(grey.shape))
    limit = float(np.percentile(np.abs(light[::2, ::2]), CLIP_PERCENTILE))
    light = np.clip(light, -limit, limit)
    light -= light.mean()
    reach = max(2, int(LARGEST_SHIFT * min(grey.shape)))
    size = [cv2.getOptimalDFTSize(side + reach) for side in (height, width)]
    padded = np.zeros(size, np.float32)
    padded[:height, :width] = light
    spectrum = cv2.dft(padded, flags=cv2.DFT_COMPLEX_OUTPUT)
    power = cv2.mulSpectrums(spectrum, spectrum, 0, conjB=True)
    alike = cv2.dft(power, flags=cv2.DFT_INVERSE | cv2.DFT_REAL_OUTPUT | cv2.DFT_SCALE)
    alike = np.roll(alike, reach, axis=1)[: reach + 1, : 2 * reach + 1]
    down, right = np.arange(reach + 1)[:, None], np.abs(np.arange(-reach, reach + 1))
    overlap = (height - down) * (width - right) / (height * width)
    return np.asarray(alike / (overlap * max(float(alike[0, reach]), 1e-6)), np.float32)


def _shortest_good_shift(alike: NDArray[np.float32]) -> float | None:
    reach = len(alike) - 1
    around = cv2.dilate(cv2.GaussianBlur(alike, (0, 0), 1.0), np.ones((5, 5)))
    smooth = cv2.GaussianBlur(alike, (0, 0), 1.0)
    down, right = np.nonzero((smooth >= around) & (smooth > LEAST_ALIKE))
    length = np.hypot(down, right - reach)
    inside = (length >= LEAST_PITCH) & (length < reach - 1)
    if not inside.any():
        return None
    value, length = smooth[down, right][inside], length[inside]
    return float(length[value >= NEARLY_BEST * value.max()].min())
