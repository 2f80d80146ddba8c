"""From one turn of the loop to the next: phase, depth and force step, decided by the filtered force."""

from __future__ import annotations

from typing import Literal, NamedTuple

from emg2vsa.rig.plan import RunPlan

REST_S = 0.7
"""At the retracted position before the first press, with the stiffest springs: there their zero shows best."""
Phase = Literal["home", "approach", "contact", "load", "retract", "pause", "done", "escape"]


class Motion(NamedTuple):
    """Where a run is."""

    phase: Phase
    since_s: float
    "When the phase began; when the rest of it did, of the way home."
    depth_mm: float
    repetition: int = 0
    "From 1; 0 on the way home before the first."
    step: int = 0
    "Force step whose stiffness is commanded."

    @property
    def stiff(self) -> bool:
        """Whether the stiffest springs are commanded instead."""
        return self.phase == "home" and self.depth_mm == 0


def advance(
    motion: Motion, plan: RunPlan, force_n: float, now_s: float, elapsed_s: float, growth_n_per_s: float = 0.0
) -> Motion:
    """The motion ``elapsed_s`` later, at ``now_s``. ``growth_n_per_s`` : of the force.

    Loading never goes back to an earlier force step: a softer spring lowers the force, and a step that followed it
    down would come and go at every edge. Retraction keeps the step that loading has reached.
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
            return motion._replace(depth_mm=motion.depth_mm + moved_mm)
        case "contact":
            return _in_contact(motion, plan, force_n, now_s)
        case "load":
            step = max(motion.step, plan.step_at(force_n))
            if force_n + plan.lead_s * max(0.0, growth_n_per_s) >= plan.f_max_n:
                return motion._replace(phase="retract", since_s=now_s, step=step)
            return motion._replace(depth_mm=motion.depth_mm + moved_mm, step=step)
        case "pause":
            return _after_pause(motion, plan, now_s)
    return motion


def towards_home(depth_mm: float, moved_mm: float) -> float:
    """Depth after moving by ``moved_mm`` towards 0, from either side, and not beyond."""
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
        return motion._replace(depth_mm=depth_mm)
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
