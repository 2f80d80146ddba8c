"""From the frames of a press to its contact area spread rate: frames -> initial area -> flow -> area -> rate."""

from __future__ import annotations

import numpy as np

from casr.errors import FramesError, NoContactError, PinsError
from casr.frames import FrameSequence, LoadingPhase, loading_phase
from casr.pins import PinTracker
from casr.press_scorer import PressScorer
from casr.scored import Score, ScoreSettings

__all__ = ["Score", "ScoreSettings", "score"]

TOUCHED_PINS = 3  # one pin may be a reflection, two on a line span no contact


def score(sequence: FrameSequence, settings: ScoreSettings | None = None) -> Score:
    """Score one press. Only its rest frame and the frames of the loading phase are decoded.

    With a force log the loading phase is that of ``loading_phase``. Without one there is no spread rate, the rest frame
    is the first, and loading runs to the last frame: from the first in which three pins have moved more than
    ``threshold_px`` from rest, or from frame 0 when the region is given.

    Raises
    ------
    NoContactError : nothing touches. FramesError : no loading phase, too few frames or a force that does not rise.
    PinsError : too few pins to start from or to go on with. SettingError : the region lies outside the image.
    """
    settings = settings or ScoreSettings()
    phase = _loading(sequence, settings)
    scorer = PressScorer(sequence.camera, settings)
    scorer.touch(sequence[phase.rest], sequence[int(phase.frames[0])])
    for index in phase.frames[1:].tolist():
        try:
            scorer.load(sequence[index])
        except PinsError as lost:
            where = f"{sequence.name}, frame {index}, {lost.where}"
            raise PinsError(where, wanted=lost.wanted, found=lost.found, do=lost.do) from lost
    force_n = None if sequence.force_n is None else sequence.force_n[phase.frames]
    return scorer.result(sequence.name, phase, force_n)


def _loading(sequence: FrameSequence, settings: ScoreSettings) -> LoadingPhase:
    if sequence.force_n is not None:
        return loading_phase(sequence.force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
    first = 0 if settings.region is not None else _first_touched(sequence, settings)
    frames = np.arange(first, len(sequence))
    if frames.size < 2:
        raise FramesError(
            sequence.name,
            wanted="at least two frames in contact",
            found=f"{frames.size}, from frame {first} to the end",
            do="Record on into the press.",
        )
    how = "the region is given for it" if settings.region is not None else f"{TOUCHED_PINS} pins have moved by then"
    note = f"no force log: loading is taken to run from frame {first} ({how}) to the last; there is no spread rate"
    return LoadingPhase(0, frames, (note,))


def _first_touched(sequence: FrameSequence, settings: ScoreSettings) -> int:
    """First frame in which some pins have moved more than the threshold from where they are in frame 0."""
    tracker = PinTracker(settings.flow.pins)
    rest_px = tracker.start(sequence[0]).centroids_px
    farthest_px = 0.0
    for index in range(1, len(sequence)):
        moved_px = np.hypot(*(tracker.step(sequence[index]) - rest_px).T)
        if np.sum(moved_px > settings.threshold_px) >= TOUCHED_PINS:
            return index
        farthest_px = max(farthest_px, float(np.nanmax(moved_px, initial=0.0)))
    raise NoContactError(
        sequence.name,
        wanted=f"{TOUCHED_PINS} pins that move more than {settings.threshold_px:g} px from frame 0",
        found=f"at most {farthest_px:.2f} px",
        do="Begin with a frame at rest, lower threshold_px, or give the region.",
    )
