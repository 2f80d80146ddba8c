"""The pins that Algorithm 1 of the paper counts in a press: the same whatever scores it, none where none moved."""

from __future__ import annotations

import numpy as np

from casr.contact_area import initial_area
from casr.errors import CasrError, NoContactError, PinsError
from casr.frames import FrameSequence, loading_phase
from casr.pins import PinTracker
from casr.press_forces import press_forces
from emg2vsa.runs.measured import asked_of
from emg2vsa.runs.product import FirstContact
from emg2vsa.settings import RunSettings


def counted_pins(frames: FrameSequence, settings: RunSettings, repetition: int) -> FirstContact | None:
    """What Algorithm 1 sees at first contact, by the force of the recipe "paper"; None where that is not determined.

    A press can be counted that is not scored: no pin moved beyond the threshold is an answer, n = 0.
    """
    try:
        return _counted(frames, settings, repetition)
    except CasrError:
        return None


def _counted(frames: FrameSequence, settings: RunSettings, repetition: int) -> FirstContact:
    frames, asked = asked_of(frames, settings, settings.recipe_of("paper"), "skin")
    force_n = press_forces(frames, asked).force_n
    phase = loading_phase(force_n, start_n=asked.force_start_n, stop_n=asked.force_stop_n)
    tracker = PinTracker(asked.flow.pins)
    rest = tracker.start(frames[phase.rest])
    for index in phase.frames[:-1].tolist():
        contact_px = tracker.step(frames[index])
        if np.isfinite(contact_px).any():
            break
    else:
        raise PinsError(frames.name, wanted="pins in contact", found="none in any frame", do="Look at the frames.")
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
