"""The page in the browser that follows a run, with its stop button: one process serves it to any number of viewers."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator, Callable
from contextlib import suppress
from dataclasses import asdict, replace
from functools import lru_cache
from pathlib import Path

import cv2
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response, StreamingResponse
from starlette.routing import BaseRoute, Route

from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.live.follow import Curves, Follower, Snapshot, joined, newest_run
from emg2vsa.live.run_facts import read_ending
from emg2vsa.live.server import file_routes, listening, serve
from emg2vsa.rig.executor.stop_requests import request_stop
from emg2vsa.rig.record.press_recorder import newest_page

STOP_REASON = "STOP on the live page"
_PERIOD_S = 0.05
_QUALITY = 90
"""Quality of the JPEG; to be looked at, not measured."""
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


def watch(folder: Path, port: int, ready: Callable[[str], None]) -> None:
    """Serve the page of a run, or of the newest of a folder of runs, until Ctrl-C, which ends the page alone.

    port : 0 takes any free one. ready : told the whole address, which opens the page on this computer only.
    SettingError : ``folder`` is a file, or the port is taken.
    """
    if folder.exists() and not folder.is_dir():
        do = "Choose the folder of a run, or of runs."
        raise SettingError(folder, wanted="a folder", found="a file", do=do)
    try:
        with listening(port) as at:
            serve({"watch": watch_routes(folder)}, at, ready)
    except KeyboardInterrupt:
        pass


MOST_AT_ONCE = 5
"""Newcomers of one moment, each with all curves, some 300 kB; the others come in with the next, and STOP between."""


class Audience:
    """Server-sent events for any number of viewers; the follower looks only while there is one.

    Every viewer begins with the curves there are, which are written out once for all who come in the same moment.
    """

    def __init__(self, follower: Follower, period_s: float) -> None:
        self._follower, self._period_s = follower, period_s
        self._viewers = self._newcomers = self._moment = self._places = 0
        self._curves, self._folder = Curves(), ""
        self._new = self._whole = ""
        self._came = asyncio.Condition()
        self._looking: asyncio.Task[None] | None = None

    async def events(self) -> AsyncIterator[str]:
        """Events without end, each the `Snapshot` of a moment as JSON. What ends the looking ends them all."""
        yield "retry: 500\n\n"
        self._viewers += 1
        try:
            seen = 0
            while True:
                self._newcomers += seen == 0
                if self._looking is None or self._looking.done():
                    self._looking = asyncio.create_task(self._look_on())
                moment, text, whole = await self._next()
                # a viewer that is slow has missed moments, and begins anew
                missed = moment != seen + 1
                if missed and (not whole or not self._places):
                    seen = 0
                    continue
                self._places -= missed
                seen = moment
                yield whole if missed else text
        finally:
            self._viewers -= 1

    async def _next(self) -> tuple[int, str, str]:
        assert self._looking is not None
        async with self._came:
            await self._came.wait()
        if self._looking.done():
            await self._looking  # raises what ended it
        return self._moment, self._new, self._whole

    async def _look_on(self) -> None:
        try:
            while self._viewers:
                newcomers, self._newcomers = self._newcomers, 0
                self._new, self._whole = await asyncio.to_thread(self._look, newcomers > 0)
                self._moment, self._places = self._moment + 1, MOST_AT_ONCE
                await self._tell()
                await asyncio.sleep(self._period_s)
        finally:
            await self._tell()

    async def _tell(self) -> None:
        async with self._came:
            self._came.notify_all()

    def _look(self, whole: bool) -> tuple[str, str]:
        """The events for those who have seen the moment before, and for those who come."""
        now = self._follower.look()
        before = self._curves if now.folder == self._folder else Curves()
        self._curves, self._folder = joined(before, now.curves), now.folder
        return _event(now), _event(replace(now, curves=self._curves, anew=True)) if whole else ""


def _event(moment: Snapshot) -> str:
    return f"data: {json.dumps(asdict(moment), separators=(',', ':'))}\n\n"


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
    """JPEG of the newest page, made once for all who look while the file has this size."""
    image = newest_page(frames)
    if image is None:
        return None
    _, jpeg = cv2.imencode(".jpg", image, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return jpeg.tobytes()
