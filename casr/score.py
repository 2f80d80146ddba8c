"""From the frames of a press to its contact area spread rate: frames -> initial area -> flow -> area -> rate."""

from __future__ import annotations

from casr.errors import said_of
from casr.frames import FrameSequence, LoadingPhase, loading_phase
from casr.press_scorer import PressScorer
from casr.scored import Score, ScoreSettings
from casr.seen_loading import first_touch, seen_loading

__all__ = ["Score", "ScoreSettings", "score"]


def score(sequence: FrameSequence, settings: ScoreSettings | None = None) -> Score:
    """Score one press. With a force log only its rest frame and the frames of the loading phase are decoded.

    The loading phase is that of ``loading_phase``. Without a force log there is no spread rate, and loading is what the
    pins show: from ``first_touch``, or from frame 0 when the region is given, to the end of ``seen_loading``.

    Bad frames are skipped as ``PressScorer`` says, with a note.

    Raises
    ------
    NoContactError : nothing touches. FramesError : no loading phase, too few frames or a force that does not rise.
    PinsError : too few pins to start from, or in three frames in a row. SettingError : the region lies outside the
        image or holds fewer than three pins.
    """
    settings = settings or ScoreSettings()
    phase = _loading(sequence, settings)
    scorer = PressScorer(sequence.camera, settings)
    rest, frames = sequence[phase.rest], phase.frames.tolist()
    n_tried = 1
    with said_of(sequence.name):
        while not scorer.touch(rest, sequence[frames[n_tried - 1]]) and n_tried < len(frames):
            n_tried += 1
    for index in frames[n_tried:]:
        image = sequence[index]
        with said_of(f"{sequence.name}, frame {index}"):
            scorer.load(image)
    force_n = None if sequence.force_n is None else sequence.force_n[phase.frames]
    with said_of(sequence.name):
        return scorer.result(sequence.name, phase, force_n)


def _loading(sequence: FrameSequence, settings: ScoreSettings) -> LoadingPhase:
    with said_of(sequence.name):
        if sequence.force_n is not None:
            return loading_phase(sequence.force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
        pins = settings.flow.pins
        first = 0 if settings.region is not None else first_touch(sequence, settings.threshold_px, pins)
        return seen_loading(sequence, first, pins)
