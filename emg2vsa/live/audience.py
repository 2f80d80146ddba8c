"""All who watch a run see what one pair of eyes has seen: the folder is read once, however many they are."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from dataclasses import asdict, replace

from emg2vsa.live.follow import Follower
from emg2vsa.live.snapshot import Curves, Snapshot, joined

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
