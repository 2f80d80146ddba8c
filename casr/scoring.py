"""From the frames of a press to its contact area spread rate: frames -> initial area -> flow -> area -> rate."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from casr.contact_area import FirstContact
from casr.doubts import doubts_on_motion, doubts_on_score, note_on_repeats
from casr.errors import CasrError, NoContactError, PinsError, said_of
from casr.frames import CameraLag, FrameSequence, LoadingPhase, loading_phase
from casr.pins import PinTracker
from casr.press_forces import PressForces, lag_of, note_on_shift, notes_on_lag, pins_before, press_forces, shifted
from casr.press_scorer import PinsAtRest, PressScorer, pins_at_rest
from casr.scored import Score, ScoreSettings, SkinScore
from casr.skin_motion import SeenLoading

__all__ = ["Score", "ScoreSettings", "SkinScore", "score", "score_skin"]


class Begun:
    """Pins at rest and first contacts of one press by the numbers of their frames, found once for all that score it by
    the same settings of pins."""

    def __init__(self) -> None:
        self._at_rest: dict[int, PinsAtRest] = {}
        self._contacts: dict[tuple[int, int], FirstContact] = {}

    def rest(self, scorer: PressScorer, index: int, image: NDArray[np.generic]) -> PinTracker:
        """``PressScorer.rest``."""
        if index not in self._at_rest:
            self._at_rest[index] = pins_at_rest(image, scorer.settings.flow.pins)
        return scorer.rest(image, self._at_rest[index])

    def touch(self, scorer: PressScorer, rest: int, index: int, image: NDArray[np.generic]) -> bool:
        """``PressScorer.touch``."""
        begun = scorer.touch(image, self._contacts.get((rest, index)))
        if begun and scorer.first_contact is not None:
            self._contacts[rest, index] = scorer.first_contact
        return begun


NO_TRAVEL = "travel_mm is not used: too few rows have it in the loading phase, or it does not grow with the force"


def score(sequence: FrameSequence, settings: ScoreSettings | None = None) -> Score:
    """Score one press; every frame is decoded once at most, and once more where a lag is taken off unasked.

    With a force log the loading phase is that of ``loading_phase``, and only its frames, the rest frame and, where the
    log has times, those between are decoded. Without one there is no spread rate, and loading is what the pins show
    (``SeenLoading``), from frame 0 when the region is given.

    Bad frames are skipped as ``PressScorer`` says, with a note.

    NoContactError : nothing touches. FramesError : no loading phase, too few frames, forces that are not newtons or do
        not rise, or a lag that cannot be corrected.
    PinsError : too few pins to start from, or in three frames in a row. SettingError : the region lies outside the
        image or holds fewer than three pins.
    """
    return score_press(sequence, settings or ScoreSettings(), Begun())


def score_press(sequence: FrameSequence, settings: ScoreSettings, known: Begun) -> Score:
    """``score`` of a press that is scored in other ways, too."""
    scored = _by_pins(sequence, settings) if sequence.force_n is None else _by_force(sequence, settings, known)
    notes, mm_per_n = dict.fromkeys((*sequence.notes, *scored.notes)), None
    if sequence.travel is not None:
        zero_n = scored.force_zero.level_n if scored.force_zero and scored.force_zero.taken_off else 0.0
        stop_n = np.inf if settings.force_stop_n is None else settings.force_stop_n
        mm_per_n = sequence.travel.per_newton(scored.rest_frame, settings.force_start_n, stop_n, zero_n)
        if np.isnan(mm_per_n):
            mm_per_n, notes = None, notes | {NO_TRAVEL: None}
    doubts = (*scored.doubts, *doubts_on_score(scored))
    return replace(scored, notes=tuple(notes), doubts=doubts, travel_mm_per_n=mm_per_n)


def score_skin(
    sequence: FrameSequence, settings: ScoreSettings, bad: Collection[int] = (), *, doubt_pins: bool = True,
    known: Begun | None = None,
) -> SkinScore:  # fmt: skip
    """Score the skin of the first contact of a press with a force log, and nothing else.

    It is what ``score`` says of the skin, for another engine, law or force of the same press, and takes less than half
    of the time: dense flow needs the pins of two frames only. bad : frames that ``score`` skipped.
    doubt_pins : say what is odd about the pins at rest, too. known : of this press.

    As ``score``, but areas above that of the pin array are not looked for.
    """
    with said_of(sequence.name):
        forces = press_forces(sequence, settings)
        phase = loading_phase(forces.force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
        phase = replace(phase, frames=np.setdiff1d(phase.frames, list(bad)))
        follow_pins = settings.flow.engine == "pin-affine"
        scorer = PressScorer(sequence.camera, settings, follow_pins=follow_pins, doubt_pins=doubt_pins)
        begun = False
        known = known or Begun()
        known.rest(scorer, phase.rest, sequence[phase.rest])
        for index in phase.frames.tolist():
            if begun:
                scorer.load(sequence[index])
            else:
                begun = known.touch(scorer, phase.rest, index, sequence[index])
        scored = scorer.skin(phase, forces.force_n[phase.frames])
    return replace(scored, notes=(*forces.notes, *scored.notes), force_zero=forces.zero)


def _by_force(sequence: FrameSequence, settings: ScoreSettings, known: Begun) -> Score:
    with said_of(sequence.name):
        forces = press_forces(sequence, settings)
    phase, scorer, lag = _followed(sequence, forces, settings, known)
    told: tuple[str, ...] = ()
    unasked = settings.camera_lag_s is None and not settings.correct_lag
    if lag is not None and lag.lag_s is not None and lag.sure and unasked:
        with said_of(sequence.name):
            forces, told = shifted(sequence, settings, lag.lag_s), (note_on_shift(lag),)
        phase, scorer, lag = _followed(sequence, forces, settings, known)
    with said_of(sequence.name):
        force_n = forces.force_n[phase.frames]
        zero_sd_n = forces.zero.sd_n if forces.zero and forces.zero.taken_off else None
        scored = scorer.result(sequence.name, phase, force_n, zero_sd_n)
    repeats = note_on_repeats(phase.frames[1:], np.array(scorer.same[1:]))
    notes = (*told, *forces.notes, *notes_on_lag(lag), *scored.notes, *repeats)
    doubts = doubts_on_motion(phase.frames, force_n, scorer.moved_px)
    return replace(scored, notes=notes, force_zero=forces.zero, camera_lag=lag, doubts=doubts)


def _followed(
    sequence: FrameSequence, forces: PressForces, settings: ScoreSettings, known: Begun
) -> tuple[LoadingPhase, PressScorer, CameraLag | None]:
    """The loading by these forces, what has seen its frames, and the lag that they show."""
    scorer, begun = PressScorer(sequence.camera, settings), False
    with said_of(sequence.name):
        phase = loading_phase(forces.force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
        before, pins_px = pins_before(sequence, phase, partial(known.rest, scorer, phase.rest))
    for index in phase.frames.tolist():
        image = sequence[index]
        with said_of(f"{sequence.name}, frame {index}" if begun else sequence.name):
            if begun:
                scorer.load(image)
            else:
                begun = known.touch(scorer, phase.rest, index, image)
    frames = [*before, *phase.frames[scorer.good].tolist()]
    return phase, scorer, lag_of(sequence, forces, frames, [*pins_px, *scorer.pins_px], settings.force_start_n)


def _by_pins(sequence: FrameSequence, settings: ScoreSettings) -> Score:
    """Loading and its score in one pass, which ends with the press."""
    given = settings.region is not None
    loading = SeenLoading(settings.threshold_px, from_start=given)
    tracker = PinTracker(settings.flow.pins)
    rest = sequence[0]
    with said_of(sequence.name):
        tracker.start(rest)
    scoring = _Scoring(sequence, settings, rest)
    if given:
        scoring.touch(0, rest)
    for index in range(1, len(sequence)):
        image = sequence[index]
        before = loading.first
        loading.take(index, tracker.away_px(tracker.step(image)))
        if loading.over:
            break
        if loading.first is None:
            continue
        if loading.first != before:
            scoring.touch(index, image)
        else:
            scoring.load(index, image)
    with said_of(sequence.name):
        phase = loading.phase(len(sequence), tracker.first_px)
    return scoring.result(phase)


class _Scoring:
    """A scorer whose trouble counts only if the frame that makes it turns out to be of the press."""

    def __init__(self, sequence: FrameSequence, settings: ScoreSettings, rest: NDArray[np.generic]) -> None:
        self._sequence, self._settings, self._rest = sequence, settings, rest

    def touch(self, index: int, image: NDArray[np.generic]) -> None:
        self._scorer = PressScorer(self._sequence.camera, self._settings)
        self._scorer.rest(self._rest)
        self._trouble: tuple[int, CasrError] | None = None
        self._begun = False
        self.load(index, image)

    def load(self, index: int, image: NDArray[np.generic]) -> None:
        if self._trouble is None:
            try:
                if self._begun:
                    self._scorer.load(image)
                else:
                    self._begun = self._scorer.touch(image)
            except (NoContactError, PinsError) as error:
                self._trouble = index, error

    def result(self, phase: LoadingPhase) -> Score:
        name = self._sequence.name
        if self._trouble is not None and self._trouble[0] <= phase.frames[-1]:
            index, error = self._trouble
            with said_of(f"{name}, frame {index}" if index > phase.frames[0] else name):
                raise error
        with said_of(name):
            return self._scorer.result(name, phase, None)
