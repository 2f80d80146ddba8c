"""Processes beside the loop: the emulated rig, a loop with nothing to do, and programs that only take processors."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from typing import IO

from emg2vsa.devices.clock import LEAST_PRIORITY, LoopTiming
from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.qbmove import QbmoveSettings
from emg2vsa.rig.rig_settings import DeviceSettings

HOG = "while True: pass"


@dataclass
class Served:
    """The emulated rig in another process: how to reach it, and, once it has ended, its share of a processor."""

    settings: DeviceSettings
    cpu_share: float = 0.0


@dataclass
class BareLoop:
    """How well a loop with nothing to do has kept its beat; known once it has ended."""

    timing: LoopTiming | None = None


@contextmanager
def served_rig(real_time: bool) -> Iterator[Served]:
    """Start it and end it. ``real_time``: no program keeps it waiting, as none does a real device."""
    with _module("benchmarks.rig.plans") as process:
        at = json.loads(_lines(process).readline())
        if real_time:
            _make_real_time(process.pid)
        served = Served(
            DeviceSettings(
                actuator=QbmoveSettings(port=at["port"]),
                force=NetFtSettings(host=at["host"], rdt_port=at["rdt_port"], http_port=at["http_port"]),
                camera=OpenCvSettings(source=at["camera"]),
            )
        )
        yield served
        served.cpu_share = json.loads(process.communicate()[0])["cpu_share"]


@contextmanager
def bare_loop(rate_hz: float) -> Iterator[BareLoop]:
    """Start and end it; scheduled as the program that starts it."""
    with _module("benchmarks.rig.loop_run", str(rate_hz)) as process:
        bare = BareLoop()
        yield bare
        bare.timing = LoopTiming(**json.loads(process.communicate()[0]))


@contextmanager
def hogs(count: int) -> Iterator[None]:
    """So many programs that take all the time they get, at ordinary priority."""
    running = [subprocess.Popen([sys.executable, "-c", HOG]) for _ in range(count)]
    try:
        yield
    finally:
        for process in running:
            process.kill()
            process.wait()


@contextmanager
def _module(name: str, *arguments: str) -> Iterator[subprocess.Popen[str]]:
    """A module run as a program until its input ends."""
    command = [sys.executable, "-m", name, *arguments]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _lines(process: subprocess.Popen[str]) -> IO[str]:
    assert process.stdout is not None
    return process.stdout


def _make_real_time(process_id: int) -> None:
    for thread in os.listdir(f"/proc/{process_id}/task"):
        with suppress(OSError):
            os.sched_setscheduler(int(thread), os.SCHED_FIFO, os.sched_param(LEAST_PRIORITY))
