"""The newest picture of a run's tactile camera, as a browser shows it."""

from __future__ import annotations

from pathlib import Path

import cv2

from emg2vsa.rig.tiff_pages import newest_page

_QUALITY = 90
"""Of the JPEG; to be looked at, not measured."""


def newest_frame(run: Path) -> bytes | None:
    """JPEG of the newest frame saved of the run in folder ``run``; None while there is none.

    DeviceError when the file is not the rig's.
    """
    for frames in sorted(run.glob("press-*/frames.tif"), key=lambda path: (len(path.parent.name), path), reverse=True):
        image = newest_page(frames)
        if image is not None:
            _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
            return jpeg.tobytes()
    return None
