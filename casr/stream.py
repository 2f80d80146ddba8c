"""Scoring while the press goes on: one frame at a time, few images kept, the same numbers as from a recording."""

from __future__ import annotations

from array import array
from collections import deque
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from casr.doubts import doubts_on_motion, doubts_on_score, note_on_repeats
from casr.errors import FramesError, NoContactError, PinsError
from casr.frames import LoadingPhase, RestingForce, check_newtons, loading_phase, notes_on_zero, spikes
from casr.frames.loading import NEARLY
from casr.images import Grey, as_grey
from casr.press_scorer import PressScorer
from casr.scored import Score, ScoreSettings, Spread

RECENT_FRAMES = 64
LOOKS = 64
"""A long rest is looked at anew each time it has grown by this part: of a million frames, some hundred times."""
Kept = tuple[int, Grey]


class RestFrame:
    """Knows the frame that ``loading_phase`` would take for the static one if contact came next.

    That choice looks at the forces of all frames at rest, so it may fall back on an earlier frame. Kept are the images
    of the last 64 frames at rest, and the one that was the choice up to 32 frames ago, or in a long rest up to a 64th
    of its frames ago.

    start_n : force of first contact, N.
    """

    def __init__(self, start_n: float) -> None:
        self._start_n = start_n
        self._force_n = array("d")
        self._recent: deque[Kept] = deque(maxlen=RECENT_FRAMES)
        self._earlier: Kept | None = None
        self._look_at = RECENT_FRAMES // 2

    def take(self, image: NDArray[Any], force_n: float, zero_n: float = 0.0) -> None:
        """Take a frame (H, W) or (H, W, 3) out of contact and its force, N. zero_n : what counts as 0 N, by the forces
        so far."""
        # a camera may write its next frame into the same memory
        self._recent.append((len(self._force_n), as_grey(image).copy()))
        self._force_n.append(force_n)
        if (n := len(self._force_n)) == self._look_at:
            self._earlier = self._choice(zero_n)
            self._look_at = n + max(RECENT_FRAMES // 2, n // LOOKS)

    def image(self, zero_n: float = 0.0) -> Grey:
        """The static frame if contact comes now. Raises FramesError when no frame came before contact.

        zero_n : what the sensor reads at rest, N.
        """
        if not self._recent:
            raise FramesError(
                "stream", wanted="a static frame before contact", found="a first frame in contact",
                do="Start before the touch, or raise force_start_n.",
            )  # fmt: skip
        return self._choice(zero_n)[1]

    def _choice(self, zero_n: float) -> Kept:
        contact_n = (self._start_n, 2 * self._start_n)
        chosen = loading_phase(np.append(np.array(self._force_n) - zero_n, contact_n), start_n=self._start_n).rest
        kept = [self._earlier] if self._earlier else []
        # the frame itself, or the last one kept from before it
        return max(
            (each for each in (*kept, *self._recent) if each[0] <= chosen), default=self._recent[0], key=itemgetter(0)
        )


PHASES = ("rest", "loading", "done")
AFTER_FRAMES = 20
"""So many frames out of contact after a contact, and the press is over."""
SKIPPED = "the pins cannot be told: this frame is skipped"


@dataclass(frozen=True)
class StreamState:
    """Where the press stands after a frame.

    frame : index of the frame, from 0. phase : one of ``PHASES``.
    force_n : of the frame, N, above the level at rest; NaN where none is known.
    area : contact area in ``area_unit`` (``mm2`` or ``px2``), by the quantity of the settings; None out of contact,
        where a front is not determined, and in a frame that is skipped because its pins cannot be told.
    log_growth : of the skin of the first contact since then; None out of contact and in a frame that is skipped.
    notes : of this frame; also why the contact can no longer be followed, if so.
    """

    frame: int
    phase: str
    force_n: float
    area: float | None = None
    area_unit: str = ""
    log_growth: float | None = None
    notes: tuple[str, ...] = ()


class StreamScorer:
    """Scores a press while it happens.

    Contact starts when the force reaches ``force_start_n`` and ends when it falls below it again, which happens in the
    chatter of a touch too: scoring then starts anew with the next contact. Forces count from the level at rest before
    the first contact (``RestingForce``), unless the settings say otherwise. Which contact was the press is known only
    at the end (``loading_phase``); until then those that can still be it keep their numbers. With ``force_stop_n`` the
    first contact that reaches it is the press, and frames after that are ignored; where none does, the first that
    nearly does.

    Parameters
    ----------
    camera : None leaves areas in px^2.
    settings : as for ``score``.
    """

    def __init__(self, camera: Camera | None = None, settings: ScoreSettings | None = None) -> None:
        self._camera, self._settings = camera, settings or ScoreSettings()
        self._rest = RestFrame(self._settings.force_start_n)
        self._resting = RestingForce(self._settings.force_start_n)
        self._force_n = array("d")
        self._contacts: list[_Contact] = []
        self._phase, self._rested = "rest", 0

    def push(self, image: NDArray[Any], force_n: float) -> StreamState:
        """Take the next frame (H, W) or (H, W, 3) and its force, N; NaN where there is none: such a frame is skipped.

        A bad frame is skipped as ``PressScorer`` says. Pins that do not move, or bad frames in a row, are no error
        here: the note says so, and ``finish`` raises it if it matters.
        FramesError : the first frame with a force is in contact already. ImageError : not an image.
        """
        self._force_n.append(force_n)
        if self._phase == "done" or np.isnan(force_n):
            return self._state(force_n, ())
        touches = self._resting.touches(force_n)
        if not (touches if self._settings.tare else force_n >= self._settings.force_start_n):
            self._part()
            self._rested += bool(self._contacts)
            self._rest.take(image, force_n, self._zero_n)
            return self._state(force_n - self._zero_n, ())
        force_n -= self._zero_n
        self._rested = 0
        if self._phase == "rest":
            self._contacts.append(_Contact(self._camera, self._settings, len(self._force_n) - 1))
            self._phase = "loading"
        notes = self._contacts[-1].take(self._rest, image, force_n, self._zero_n)
        stop_n = self._settings.force_stop_n
        if stop_n is not None and force_n >= stop_n:
            self._phase = "done"
        return self._state(force_n, notes)

    def curve(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Force (T,), N, and area (T,) of the present contact so far, in the frames whose area is known. The areas of
        earlier frames change a little with every frame, for a front is fitted to all of them."""
        return self._contacts[-1].curve() if self._phase != "rest" else (np.empty(0), np.empty(0))

    def pins(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Pins at rest (N, 2), pins (T, N, 2) and force (T,), N, of the good frames of the present contact so far."""
        return self._contacts[-1].pins()

    def spread(self) -> Spread | None:
        """Spread rate and total interval of the present contact so far; None while they are not known."""
        return self._contacts[-1].spread() if self._phase != "rest" else None

    def settle(self) -> None:
        """Work that ``push`` leaves for the time in which no frame waits: what ``push`` answers next is surer then."""
        if self._phase != "rest":
            self._contacts[-1].settle()

    def finish(self) -> Score:
        """Score of the press among the frames so far; more may be pushed after. Raises what ``score`` would, and
        FramesError where the first contact was none by the later rest."""
        settings, zero = self._settings, self._resting.zero
        force_n = np.array(self._force_n) - self._zero_n
        check_newtons(force_n, "force")
        phase = loading_phase(force_n, start_n=settings.force_start_n, stop_n=settings.force_stop_n)
        press = next((contact for contact in self._contacts if contact.first == phase.frames[0]), None)
        if press is None:
            raise FramesError(
                "stream",
                wanted=f"a first contact that is at {settings.force_start_n:g} N by the force at rest then and later",
                found=f"contact from frame {phase.frames[0]}, by the rest after it",
                do="Let the sensor rest longer before the touch.",
            )
        zero_sd_n = zero.sd_n if zero is not None and settings.tare else None
        scored = press.result(phase, force_n[phase.frames], zero_sd_n)
        notes = notes_on_zero(zero, settings.force_start_n) if settings.tare else ()
        zero = None if zero is None else replace(zero, taken_off=settings.tare)
        doubts = (*scored.doubts, *_spikes_scored(phase, force_n), *doubts_on_score(scored))
        return replace(scored, notes=(*notes, *scored.notes), force_zero=zero, doubts=doubts)

    @property
    def _zero_n(self) -> float:
        """What counts as 0 N: of the rest so far, from first contact on for good."""
        return self._resting.level_n if self._settings.tare else 0.0

    def _part(self) -> None:
        """Contact is over: of the contacts so far keep those that ``loading_phase`` may still choose."""
        if self._phase == "rest":
            return
        self._phase = "rest"
        if (stop_n := self._settings.force_stop_n) is not None:
            self._contacts = [contact for contact in self._contacts if contact.peak_n >= NEARLY * stop_n][:1]
            return
        largest_n = max(contact.peak_n for contact in self._contacts)
        kept: list[_Contact] = []
        for contact in self._contacts:
            # it takes the first contact of at least half of the largest force, whatever that will be
            if contact.peak_n >= largest_n / 2 and all(contact.peak_n > earlier.peak_n for earlier in kept):
                kept.append(contact)
        self._contacts = kept

    @property
    def over(self) -> bool:
        """Whether the press is: as the settings say, or after ``AFTER_FRAMES`` out of contact."""
        return self._phase == "done" or self._rested >= AFTER_FRAMES

    def _state(self, force_n: float, notes: tuple[str, ...]) -> StreamState:
        frame = len(self._force_n) - 1
        if self._phase == "rest":
            return StreamState(frame, "rest", force_n, notes=notes)
        return self._contacts[-1].state(frame, self._phase, force_n, notes)


def _spikes_scored(phase: LoadingPhase, force_n: NDArray[np.float64]) -> tuple[str, ...]:
    """A force that goes up for one frame cannot be told from a press while it goes on, only later."""
    wild = phase.frames[spikes(force_n)[phase.frames]]
    return tuple(
        f"the force of frame {k} is a spike, {force_n[k]:.3g} N: score the recording" for k in wild[:1].tolist()
    )


class _Contact:
    """One stretch of frames in contact: what may turn out to be the press."""

    def __init__(self, camera: Camera | None, settings: ScoreSettings, first: int) -> None:
        self._scorer = PressScorer(camera, settings)
        self._force_n = array("d")
        self._trouble: NoContactError | PinsError | None = None
        self._n_taken = 0
        self._bad = False
        self._area = np.empty(0)
        self.first, self.peak_n = first, 0.0

    def take(self, rest: RestFrame, image: NDArray[Any], force_n: float, zero_n: float) -> tuple[str, ...]:
        """The next frame in contact and its force above ``zero_n``, N; notes on it."""
        self._force_n.append(force_n)
        self.peak_n = max(self.peak_n, force_n)
        if self._trouble is None:
            try:
                return self._scored(rest, image, zero_n)
            except (NoContactError, PinsError) as trouble:
                self._trouble = trouble
        return (str(self._trouble),)

    def _scored(self, rest: RestFrame, image: NDArray[Any], zero_n: float) -> tuple[str, ...]:
        notes: tuple[str, ...] = ()
        if not self._scorer.good:
            if self._n_taken == 0:
                self._scorer.rest(rest.image(zero_n))
            self._bad = not self._scorer.touch(image)
        else:
            step = self._scorer.load(image)
            self._bad = step is None
            notes = () if step is None else step.notes
        self._n_taken += 1
        if self._bad:
            return (SKIPPED,)
        try:
            self._area = self._scorer.follow(np.array(self._force_n))
        except PinsError as trouble:  # as the front has it; the press is still followed
            self._area = np.empty(0)
            return (*notes, str(trouble))
        return notes

    def state(self, frame: int, phase: str, force_n: float, notes: tuple[str, ...]) -> StreamState:
        if self._trouble is not None or self._bad:
            return StreamState(frame, phase, force_n, notes=notes)
        area = self._area[-1] if self._area.size else np.nan
        return StreamState(
            frame, phase, force_n, area=float(area) if np.isfinite(area) else None, area_unit=self._scorer.area_unit,
            log_growth=self._scorer.log_growth, notes=notes,
        )  # fmt: skip

    def curve(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        known = np.isfinite(self._area)
        return np.array(self._force_n)[self._scorer.good[: known.size]][known], self._area[known]

    def pins(self) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        scorer = self._scorer
        return scorer.rest_px, np.array(scorer.pins_px), np.array(self._force_n)[scorer.good]

    def spread(self) -> Spread | None:
        return None if self._trouble or not self._area.size else self._scorer.so_far(np.array(self._force_n))

    def settle(self) -> None:
        if self._trouble is None:
            self._scorer.settle()

    def result(self, phase: LoadingPhase, force_n: NDArray[np.float64], zero_sd_n: float | None) -> Score:
        if self._trouble is not None and self._n_taken < len(phase.frames):
            raise self._trouble
        scored, n = self._scorer.result("stream", phase, force_n, zero_sd_n), len(phase.frames)
        notes = (*scored.notes, *note_on_repeats(phase.frames[1:], np.array(self._scorer.same[1:n])))
        doubts = doubts_on_motion(phase.frames, force_n, self._scorer.moved_px[:n])
        return replace(scored, notes=notes, doubts=doubts)
