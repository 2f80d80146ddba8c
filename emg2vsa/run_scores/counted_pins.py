"""The pins that Algorithm 1 of the paper counts in a press: the same whatever scores it, none where none moved."""

from __future__ import annotations

import numpy as np

from casr.contact_area import initial_area
from casr.errors import CasrError, NoContactError, PinsError
from casr.frames import FrameSequence, LoadingPhase, loading_phase
from casr.pins import Pins, PinSettings, PinTracker
from casr.press_forces import press_forces
from casr.scored import SkinScore
from emg2vsa.arrays import Floats
from emg2vsa.run_scores.measured import asked_of
from emg2vsa.run_scores.product import FirstContact
from emg2vsa.settings import RunSettings


def counted_pins(
    frames: FrameSequence, settings: RunSettings, repetition: int, seen: SkinScore | None = None
) -> FirstContact | None:
    """What Algorithm 1 sees at first contact, by the force of the recipe "paper"; None where that is not determined.

    A press can be counted that is not scored: no pin moved beyond the threshold is an answer, n = 0. seen : by that
    recipe, where it was scored; its pins are taken.
    """
    try:
        return _counted(frames, settings, repetition, seen)
    except CasrError:
        return None


def _counted(frames: FrameSequence, settings: RunSettings, repetition: int, seen: SkinScore | None) -> FirstContact:
    frames, asked = asked_of(frames, settings, settings.recipe_of("paper"), "skin")
    force_n = press_forces(frames, asked).force_n
    phase = loading_phase(force_n, start_n=asked.force_start_n, stop_n=asked.force_stop_n)
    if seen is not None and (seen.rest_frame, seen.frames[0]) == (phase.rest, phase.frames[0]):
        rest, index, contact_px = seen.rest, int(phase.frames[0]), seen.contact_px
    else:
        rest, index, contact_px = _followed(frames, phase, asked.flow.pins)
    try:
        found = initial_area(rest, contact_px, camera=frames.camera, rule="paper", threshold_px=settings.threshold_px)
        selected = found.selected.astype(np.int64)
    except NoContactError:
        selected = np.empty(0, dtype=np.int64)
    shown = phase.frames[phase.frames >= index][:2]
    return FirstContact(
        repetition=repetition,
        frames=np.stack([np.asarray(frames[int(i)]).astype(np.uint8) for i in (phase.rest, *shown)]),
        force_n=force_n[shown].copy(),
        rest_px=rest.centroids_px,
        contact_px=contact_px.copy(),
        selected=selected,
    )


def _followed(frames: FrameSequence, phase: LoadingPhase, settings: PinSettings) -> tuple[Pins, int, Floats]:
    """Pins at rest, the first frame of the loading in which they are seen, and where they are in it."""
    tracker = PinTracker(settings)
    rest = tracker.start(frames[phase.rest])
    for index in phase.frames[:-1].tolist():
        contact_px = tracker.step(frames[index])
        if np.isfinite(contact_px).any():
            return rest, index, contact_px
    raise PinsError(frames.name, wanted="pins in contact", found="none in any frame", do="Look at the frames.")
