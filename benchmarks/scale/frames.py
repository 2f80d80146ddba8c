"""Any number of frames through the streaming scorer: CPU seconds and memory as they go by.

Frames of one simulated press, 300 x 300 px, stand in memory. A press comes every ``EVERY`` frames; between presses the
sensor rests, with noise on its force.
"""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from typing import Any

import numpy as np

from casr.frames import force_per_frame
from casr.scored import ScoreSettings
from casr.specimens import SPECIMENS
from casr.stream import StreamScorer
from emg2vsa.worlds.tactile import PressSettings, TabulatedWorld, simulate_press

EVERY = 50_000
FORCE_NOISE_N = 0.01


def measure(counts: list[int]) -> Iterator[dict[str, Any]]:
    """What was taken after each of ``counts`` frames, rising; the score at the end is that of a whole press."""
    press = simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS["S3"], world=TabulatedWorld()))
    images = [press.frames.read(index) for index in range(len(press.frames))]
    line = press.timeline
    force_n = force_per_frame(line.log_force_n, line.log_frame_index, len(images))
    rng = np.random.default_rng(1)
    stream, started, contact = StreamScorer(None, ScoreSettings()), time.process_time(), 0
    for taken in range(1, counts[-1] + 1):
        at = taken % EVERY
        if at < len(images):
            state = stream.push(images[at], float(force_n[at]))
        else:
            state = stream.push(images[0], FORCE_NOISE_N * float(rng.standard_normal()))
        contact += state.phase != "rest"
        if taken in counts:
            yield {
                "frames": taken,
                "in_contact": contact,
                "cpu_s": time.process_time() - started,
                "memory_mb": _resident_mb(),
            }
    scored = stream.finish()
    assert scored.rate is not None
    assert len(scored.frames) > 10


def _resident_mb() -> float:
    with open("/proc/self/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6
