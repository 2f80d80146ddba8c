"""The addresses of the page that watches a run."""

from __future__ import annotations

from contextlib import suppress
from functools import lru_cache
from pathlib import Path

import cv2
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from emg2vsa.errors import Emg2vsaError
from emg2vsa.live.audience import Audience
from emg2vsa.live.follow import Follower, newest_run
from emg2vsa.live.run_facts import read_ending
from emg2vsa.live.server import file_routes
from emg2vsa.rig.executor.stop_requests import request_stop
from emg2vsa.rig.record.tiff_pages import newest_page

STOP_REASON = "STOP on the live page"
_PERIOD_S = 0.05
_QUALITY = 90
"""Of the JPEG; to be looked at, not measured."""
_PAGES = Path(__file__).parent / "page"


def watch_routes(folder: Path) -> list[BaseRoute]:
    """Page, stream of moments, newest frame and stop button for the run, or the newest of the runs, in ``folder``."""

    audience = Audience(Follower(folder), _PERIOD_S)

    async def stream(request: Request) -> Response:
        return StreamingResponse(audience.events(), media_type="text/event-stream")

    def frame(request: Request) -> Response:
        run = newest_run(folder)
        try:
            jpeg = newest_frame(run) if run else None
        except Emg2vsaError as error:
            return Response(str(error), status_code=500)
        return Response(jpeg, media_type="image/jpeg") if jpeg else Response(status_code=204)

    # not in the pool of threads, which those who come and their frames may have taken whole
    async def stop(request: Request) -> Response:
        run = newest_run(folder)
        if run is None or read_ending(run, 0):
            return PlainTextResponse("nothing is running", status_code=409)
        try:
            request_stop(run, STOP_REASON)
        except OSError as error:
            return PlainTextResponse(error.strerror or str(error), status_code=500)
        return PlainTextResponse(run.name)

    return [
        Route("/stream", stream),
        Route("/frame", frame),
        Route("/stop", stop, methods=["POST"]),
        *file_routes(_PAGES / "watch", _PAGES / "shared"),
    ]


def newest_frame(run: Path) -> bytes | None:
    """JPEG of the newest frame saved of the run in folder ``run``; None while there is none.

    DeviceError when the file is not the rig's.
    """
    for frames in sorted(run.glob("press-*/frames.tif"), key=lambda path: (len(path.parent.name), path), reverse=True):
        with suppress(FileNotFoundError):
            if jpeg := _jpeg(frames, frames.stat().st_size):
                return jpeg
    return None


@lru_cache(maxsize=4)
def _jpeg(frames: Path, size_bytes: int) -> bytes | None:
    """Of the newest page; made once for all who look while the file has this size."""
    image = newest_page(frames)
    if image is None:
        return None
    _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return jpeg.tobytes()
