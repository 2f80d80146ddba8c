"""From one turn of the loop to the next: phase, depth and force step, decided by the filtered force; and its filter."""

from __future__ import annotations

import math
from collections import deque
from typing import Literal, NamedTuple

from emg2vsa.rig.plan import RunPlan

REST_S = 0.7
"""Rest at the retracted position before the first press, with the stiffest springs: there their zero shows best."""
Phase = Literal["home", "approach", "contact", "load", "retract", "pause", "done", "escape"]


class Motion(NamedTuple):
    """Where a run is."""

    phase: Phase
    since_s: float
    "When the phase began; when the rest of it did, of the way home."
    depth_mm: float
    repetition: int = 0
    "Number of the press, from 1; 0 on the way home before the first."
    step: int = 0
    "Force step whose stiffness is commanded."

    @property
    def stiff(self) -> bool:
        """Whether the stiffest springs are commanded instead."""
        return self.phase == "home" and self.depth_mm == 0


def advance(
    motion: Motion, plan: RunPlan, force_n: float, now_s: float, elapsed_s: float, growth_n_per_s: float = 0.0
) -> Motion:
    """The motion ``elapsed_s`` later, at ``now_s``, s, under the filtered force, N (paper, section V).
    ``growth_n_per_s`` : of the force.

    Loading never goes back to an earlier force step: a softer spring lowers the force, and a step that followed it down
    would come and go at every edge. Retraction keeps the step that loading has reached.
    """
    moved_mm = plan.ramp_mm_per_s * elapsed_s
    match motion.phase:
        case "home":
            return _home(motion, plan, moved_mm, now_s)
        case "retract":
            return _back(motion, moved_mm, now_s)
        case "approach":
            if force_n >= plan.f_contact_n:
                return motion._replace(phase="contact", since_s=now_s)
            return Motion("approach", motion.since_s, motion.depth_mm + moved_mm, motion.repetition, motion.step)
        case "contact":
            return _in_contact(motion, plan, force_n, now_s)
        case "load":
            step = max(motion.step, plan.step_at(force_n))
            if force_n + plan.lead_s * max(0.0, growth_n_per_s) >= plan.f_max_n:
                return motion._replace(phase="retract", since_s=now_s, step=step)
            return Motion("load", motion.since_s, motion.depth_mm + moved_mm, motion.repetition, step)
        case "pause":
            return _after_pause(motion, plan, now_s)
    return motion


def towards_home(depth_mm: float, moved_mm: float) -> float:
    """Depth, mm, after moving by ``moved_mm`` towards 0, from either side, and not beyond."""
    return max(0.0, depth_mm - moved_mm) if depth_mm > 0 else min(0.0, depth_mm + moved_mm)


def _home(motion: Motion, plan: RunPlan, moved_mm: float, now_s: float) -> Motion:
    depth_mm = towards_home(motion.depth_mm, moved_mm)
    rested = motion.depth_mm == 0 and now_s - motion.since_s >= REST_S
    if depth_mm == 0 and (rested or plan.schedule is None):
        return Motion("approach", now_s, 0.0, repetition=1)
    return motion._replace(depth_mm=depth_mm, since_s=motion.since_s if motion.depth_mm == 0 else now_s)


def _back(motion: Motion, moved_mm: float, now_s: float) -> Motion:
    depth_mm = towards_home(motion.depth_mm, moved_mm)
    if depth_mm != 0:
        return Motion("retract", motion.since_s, depth_mm, motion.repetition, motion.step)
    return Motion("pause", now_s, 0.0, motion.repetition)


def _in_contact(motion: Motion, plan: RunPlan, force_n: float, now_s: float) -> Motion:
    if force_n < plan.f_contact_n:
        return motion._replace(phase="approach", since_s=now_s)
    if now_s - motion.since_s < plan.contact_s:
        return motion
    return motion._replace(phase="load", since_s=now_s)


def _after_pause(motion: Motion, plan: RunPlan, now_s: float) -> Motion:
    if now_s - motion.since_s < plan.pause_s:
        return motion
    if motion.repetition == plan.repetitions:
        return motion._replace(phase="done", since_s=now_s)
    return Motion("approach", now_s, 0.0, motion.repetition + 1)


class MovingAverage:
    """Mean of the last ``n`` samples, one at a time; of those there are while there are fewer.

    Parameters
    ----------
    n : samples.
    rate_hz : samples a second.

    The paper (section V) says of five samples at 200 Hz "about 5 Hz, delay 0.5 s"; they are 18 Hz and 10 ms, and 5 Hz
    needs 18 samples. So the filter says itself what it is: `description`.
    """

    def __init__(self, n: int, rate_hz: float) -> None:
        self.n, self.rate_hz = n, rate_hz
        self._samples: deque[float] = deque(maxlen=n)
        self._means: deque[float] = deque(maxlen=n + 1)

    def update(self, value: float) -> float:
        """The mean with this sample."""
        self._samples.append(value)
        # summed anew every time: a running sum would keep every rounding error, and a NaN for ever
        self._means.append(math.fsum(self._samples) / len(self._samples))
        return self._means[-1]

    @property
    def growth_per_s(self) -> float:
        """Growth of the mean over the last ``n`` samples; 0 before there are two."""
        steps = len(self._means) - 1
        return (self._means[-1] - self._means[0]) * self.rate_hz / steps if steps > 0 else 0.0

    @property
    def delay_s(self) -> float:
        """Group delay, the same at all frequencies, s."""
        return (self.n - 1) / (2 * self.rate_hz)

    @property
    def cutoff_hz(self) -> float:
        """Frequency at which the amplitude has fallen by 3 dB, Hz; inf for a single sample.

        There |sin(pi n f / rate) / (n sin(pi f / rate))| = 1 / sqrt 2.
        """
        if self.n == 1:
            return math.inf
        low, high = 0.0, 1.0 / self.n  # the amplitude falls from 1 to its first zero, at rate / n
        while high - low > 1e-12:
            middle = (low + high) / 2
            amplitude = math.sin(math.pi * self.n * middle) / (self.n * math.sin(math.pi * middle))
            low, high = (middle, high) if amplitude > math.sqrt(0.5) else (low, middle)
        return low * self.rate_hz

    @property
    def description(self) -> str:
        """Length, cut-off and delay in words."""
        if self.n == 1:
            return "no filter: every sample by itself"
        return (
            f"mean of {self.n} samples at {self.rate_hz:g} Hz: -3 dB at {self.cutoff_hz:.3g} Hz, "
            f"delay {1e3 * self.delay_s:.3g} ms"
        )
