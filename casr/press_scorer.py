"""The one way a press is scored, frame by frame; recordings and a running rig both feed it."""

from __future__ import annotations

from copy import copy
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area import FirstContact, InitialArea, area_of
from casr.contact_area.follow import FrontSoFar, contact_front
from casr.contact_area.front import ContactFront
from casr.contact_area.library_front import worlds_for
from casr.contact_area.motion import check_area
from casr.counts import count
from casr.dome.library import Library
from casr.errors import FramesError, NoContactError, PinsError
from casr.flow.estimate import FlowStep, FlowTracker
from casr.flow.pin_engine import need_pins_inside
from casr.flow.region import Region
from casr.flow.step import MOST_BAD_FRAMES, notes_by_frame
from casr.frames import LoadingPhase
from casr.front_spread import FEWEST_FRAMES, FrontSpread, front_doubt, front_spread
from casr.pins import Pins, PinSettings, PinTracker, pins_in_doubt
from casr.scored import NO_SCALE, WHOLE_IMAGE, Score, ScoreSettings, SkinScore, SkinSpread, Spread, skin_interval
from casr.spread import SpreadRate, contact_areas, spread_rate

Array = NDArray[np.float64]

LOST = "See why pins are lost: are the frames one press, in order?"
LEAST_MOVED_PX = 0.5
"Least motion of the pin that moved farthest at first contact: less is the camera's noise."


class PressScorer:
    """Scores one press from its rest frame, its first contact and the frames after; holds one image.

    A bad frame (black, torn, or one in which the pins cannot be told) is left out of the score, and growth is measured
    on from the last good one. Forces are given for all frames that were taken; those of bad frames are left out here.

    log_growth : of the region since first contact.
    pins_px : of every good frame since first contact, (N, 2): the place of each pin of the rest frame, NaN where it is
        lost.
    good : (T,) which of the frames since first contact these are, counted from 0.
    moved_px : of every frame since first contact the mean distance of the pins seen from rest, knocks of the camera
        taken off; NaN where none is seen. same : whether each is the image before it.

    camera : None leaves areas in px^2. settings : how.
    follow_pins : False: dense flow does without pins after first contact; there is ``skin`` then, and no ``result``.
    doubt_pins : False: no notes on the lattice of the pins at rest, for a press of which they are known.
    """

    def __init__(
        self, camera: Camera | None, settings: ScoreSettings, *, follow_pins: bool = True, doubt_pins: bool = True
    ) -> None:
        self._camera, self.settings = camera, settings
        self._follow_pins, self._doubt_pins = follow_pins, doubt_pins
        # a region that is given is meant whole; the core is for a contact edge, where the flow has a kink
        flow = replace(settings.flow, core_fraction=1.0) if isinstance(settings.region, Region) else settings.flow
        self._whole_image = settings.region == WHOLE_IMAGE
        self._flow = FlowTracker(flow, whole_image=self._whole_image)
        self._steps: list[FlowStep] = []
        self.log_growth = self._divergence = 0.0
        self.first_contact: FirstContact | None = None
        "What areas of the first contact follow from; None of a region that is given."
        self.pins_px: list[Array] = []
        self.good: list[int] = []
        self.moved_px: list[float] = []
        self.same: list[bool] = []
        self._n_taken = self._n_bad = 0

    def rest(self, image: NDArray[Any], pins: PinsAtRest | None = None) -> PinTracker:
        """Take the static frame (H, W) or (H, W, 3); what follows its pins to frames that are not scored. pins : in it,
        if they are known.

        PinsError : too few pins. ImageError : not an image.
        """
        self._last = image = np.array(image)
        self._at_rest, self._rest = pins or pins_at_rest(image, self.settings.flow.pins)
        return copy(self._at_rest)

    def touch(self, image: NDArray[Any], contact: FirstContact | None = None) -> bool:
        """Initial area and contact region from the static frame and the frame of first contact, (H, W) or (H, W, 3).
        contact : of these two frames, if it is known.

        Returns False if this frame is bad: touch again, with the next one.
        NoContactError : no pin moved, and no region is given.
        PinsError : too many bad frames in a row. ImageError : not an image.
        SettingError : a region is given that holds fewer than three pins.
        """
        self._tracker = copy(self._at_rest)
        rest_px = self._rest.centroids_px
        doubts = pins_in_doubt(rest_px, self.settings.flow.pins.expect_pins) if self._doubt_pins else ()
        self._contact_px = self._step(image)
        if not self._is_good(self._contact_px):
            return False
        self.first_contact = contact
        self._initial, self._region, notes = self._contact()
        self._notes = (*doubts, *self._tracker.notes, *notes)
        self._flow.start(image, self._region, self._contact_px)
        self._took(self._contact_px)
        return True

    def load(self, image: NDArray[Any]) -> FlowStep | None:
        """Growth from the last good frame to the next one, (H, W) or (H, W, 3); None for a bad frame.

        Raises PinsError at the third bad frame in a row. ImageError : not an image, or of another size.
        """
        before = self._steps[-1].region if self._steps else self._region
        pins_px = self._step(image) if self._follow_pins else self._contact_px
        if not self._is_good(pins_px):
            return None
        try:
            step = self._flow.step(image, pins_px)
        except PinsError as trouble:
            self._bad(trouble)
            return None
        step = replace(step, notes=(*step.notes, *self._tracker.notes))
        if self._camera is not None and self._camera.distortion and not self._whole_image:
            growth = _flat(step.region, self._camera).area_px2 / _flat(before, self._camera).area_px2
            step = replace(step, log_growth=float(np.log(growth)))
        self._steps.append(step)
        self._took(pins_px)
        self.log_growth += step.log_growth
        self._divergence += step.divergence
        return step

    def _step(self, image: NDArray[Any]) -> Array:
        """(N, 2) pins of the next frame."""
        pins_px = self._tracker.step(image)
        away_px = self._tracker.away_px(pins_px)
        self.moved_px.append(float(away_px.mean()) if away_px.size else np.nan)
        self.same.append(np.array_equal(self._last, image))
        self._last = np.array(image)  # a camera may write its next frame into the same memory
        return pins_px

    def _is_good(self, pins_px: Array) -> bool:
        if np.isfinite(pins_px).any():
            return True
        wanted = "most of the pins of the frame before"
        found = "none, or places that no press takes them to, as in a black, torn or foreign frame"
        self._bad(PinsError("pins", wanted=wanted, found=found, do=LOST))
        return False

    def _bad(self, trouble: PinsError) -> None:
        """A frame is skipped; raises what is wrong with it when there were too many in a row."""
        self._n_taken += 1
        self._n_bad += 1
        if self._n_bad > MOST_BAD_FRAMES:
            found = f"{trouble.found}, in {self._n_bad} frames in a row"
            raise PinsError(trouble.where, wanted=trouble.wanted, found=found, do=trouble.do)

    def _took(self, pins_px: Array) -> None:
        count("frames scored")
        self.pins_px.append(pins_px)
        self.good.append(self._n_taken)
        self._n_taken += 1
        self._n_bad = 0

    @property
    def rest_px(self) -> Array:
        """(N, 2) pins of the static frame."""
        return self._rest.centroids_px

    def areas(self, force_n: Array | None) -> Array:
        """(T,) area of the first contact's skin in ``area_unit`` in the good frames, as far as there are forces.
        Equation (1) of the paper, or its consistent form."""
        force_n = None if force_n is None else self._of_good(force_n)
        steps = self._steps if force_n is None else self._steps[: len(force_n) - 1]
        law = self.settings.area_law
        growth = [step.log_growth if law == "ode" else step.divergence for step in steps]
        return contact_areas(self._first_area, growth, force_n, law=law)

    def _of_good(self, of_frames: NDArray[Any]) -> NDArray[Any]:
        """Those of the good frames among values of the first frames since first contact."""
        good = np.array(self.good, np.intp)
        return of_frames[good[good < len(of_frames)]]

    def rate(self, force_n: Array) -> SpreadRate:
        """Rate (paper, eq. 2) at which the skin of the first contact grows, over the first frames, whose forces (T,),
        N, these are."""
        return spread_rate(self.areas(force_n), self._of_good(force_n), **self._rule)

    @property
    def _rule(self) -> dict[str, Any]:
        """Rule of ``spread_rate``."""
        s = self.settings
        return {"rule": s.rate_rule, "area_unit": self.area_unit, "window_n": s.window_n}

    @cached_property
    def _front_so_far(self) -> FrontSoFar:
        return FrontSoFar(self._camera, self._worlds())

    def _worlds(self) -> Library:
        return worlds_for(self._camera, self.settings.domes, self.settings.specimen_height_mm)

    @property
    def _first_area(self) -> float:
        return self._initial.area_px2 if self._initial.area_mm2 is None else self._initial.area_mm2

    @property
    def area_unit(self) -> str:
        """``mm2``, or ``px2`` without a camera."""
        return "px2" if self._camera is None else "mm2"

    def result(
        self, name: str, phase: LoadingPhase, force_n: Array | None, force_zero_sd_n: float | None = None
    ) -> Score:
        """The score of the good frames of ``phase``. FramesError : fewer than two are good.

        force_n : (T,) forces of all frames of ``phase``, N; None without a force log.
        force_zero_sd_n : standard error of the resting level, N; None where none was taken off.
        Skin: equations (1) and (2) of the paper, by law and rule of the settings.
        """
        of_skin = self._of_skin(phase, force_n)
        frames, skin, by_front = of_skin["frames"], of_skin["skin"], self.settings.quantity == "front"
        if not by_front:
            self._check(skin.area)
        pins_px = np.array(self.pins_px[: len(frames)])
        front = contact_front(self._rest.centroids_px, pins_px, self._camera, self._worlds())
        doubt, spread = self._front_spread(front, force_n, force_zero_sd_n)
        notes = (*self._notes_on(phase, frames), *(front.notes if by_front else ()))
        return Score(
            **of_skin, name=name, settings=self.settings,
            log_growth=np.array([step.log_growth for step in self._steps[: len(frames) - 1]]), pins_px=pins_px,
            front=front, front_doubt=doubt, front_spread=spread,
            notes=_once(*notes, *_notes_of(skin, spread if by_front else None)),
        )  # fmt: skip

    def skin(self, phase: LoadingPhase, force_n: Array) -> SkinScore:
        """What the skin of the first contact says in the good frames of ``phase``; force_n : (T,) of all of its frames,
        N.

        FramesError : fewer than two frames are good, or their force does not rise.
        """
        of_skin = self._of_skin(phase, force_n)
        notes = _once(*self._notes_on(phase, of_skin["frames"]), *_notes_of(of_skin["skin"], None))
        return SkinScore(**of_skin, contact_px=self._contact_px, notes=notes)

    def _of_skin(self, phase: LoadingPhase, force_n: Array | None) -> dict[str, Any]:
        """What both kinds of scores hold, by name."""
        frames = self._of_good(phase.frames)
        if len(frames) < 2:
            wanted, found = "at least two frames in which the pins are seen", f"{len(frames)} of {len(phase.frames)}"
            raise FramesError("loading phase", wanted=wanted, found=found, do=LOST)
        steps = self._steps[: len(frames) - 1]
        return {
            "rest_frame": phase.rest,
            "frames": frames,
            "force_n": None if force_n is None else self._of_good(force_n),
            "divergence": np.array([step.divergence for step in steps]),
            "initial": self._initial,
            "rest": self._rest,
            "area_unit": self.area_unit,
            "skin": self._skin(force_n, len(frames)),
            "regions": (self._region.polygon_px, *(step.region.polygon_px for step in steps)),
        }

    def _notes_on(self, phase: LoadingPhase, frames: NDArray[np.intp]) -> tuple[str, ...]:
        """Notes on the press that hold for each quantity; frames : the good ones of the phase."""
        skipped = sorted(set(phase.frames.tolist()) - set(frames.tolist()))
        of_steps = notes_by_frame(frames[1:].tolist(), self._steps[: len(frames) - 1])
        return (*([] if self._camera else [NO_SCALE]), *phase.notes, *_skipped(skipped), *self._notes, *of_steps)

    def _check(self, area: Array) -> None:
        """AreaError where an area of the skin is above that of the pin array; a circle is the array's own."""
        if self.settings.area_rule == "circle":
            return
        largest = int(np.argmax(area))
        pins_px = undistorted(self.pins_px[largest], self._camera)
        law = "equation (1) as printed" if self.settings.area_law == "paper" else "its growth"
        area_px2 = float(area[largest]) * self._initial.area_px2 / self._first_area
        check_area(area_px2, pins_px, f"area of the skin by {law}", self._camera)

    def _skin(self, force_n: Array | None, n_frames: int) -> SkinSpread:
        area = self.areas(force_n)[:n_frames]
        if force_n is None:
            return SkinSpread(area, None, None)
        rate = self.rate(force_n)
        return SkinSpread(area, rate, skin_interval(rate, self._initial.relative_sd))

    def _front_spread(
        self, front: ContactFront, force_n: Array | None, force_zero_sd_n: float | None, some: slice = slice(None)
    ) -> tuple[str, FrontSpread | None]:
        """Why no area can be told from a front in the first good frames, and its rate where it can. some : of
        ``front_doubt``."""
        n = len(front.area)
        if doubt := front_doubt(front, self.pins_px[:n], self._camera, some):
            return doubt, None
        grown = np.array([step.log_growth for step in self._steps[: n - 1]])
        of_good = None if force_n is None else self._of_good(force_n)[:n]
        return "", front_spread(front, grown, of_good, force_zero_sd_n, **self._rule)

    def follow(self, force_n: Array) -> Array:
        """(T,) area of the good frames so far by the quantity of the settings, NaN where a front is not determined.

        force_n : (T,) of all frames since first contact, N. PinsError : fewer than seven pins in some frame.
        """
        if self.settings.quantity == "skin":
            return self.areas(force_n)
        if len(self.good) < FEWEST_FRAMES:  # so few tell no front
            return np.full(len(self.good), np.nan)
        front = self._front_so_far.of(self._rest.centroids_px, np.array(self.pins_px))
        doubt = front_doubt(front, self.pins_px, self._camera, slice(-1, None))
        return np.where(front.determined & (doubt == ""), front.area, np.nan)

    def so_far(self, force_n: Array) -> Spread | None:
        """What the quantity says after the last ``follow``; None where no rate is known yet. Forces (T,) of ``follow``,
        N."""
        try:
            if self.settings.quantity == "skin":
                rate = self.rate(force_n)
                return Spread("skin", self.areas(force_n), rate, skin_interval(rate, self._initial.relative_sd), "")
            if (front := self._front_so_far.front) is None:
                return None
            doubt, spread = self._front_spread(front, force_n, None, slice(-1, None))
        except FramesError:  # too few frames, or forces that have not risen
            return None
        return Spread("front", front.area, spread.rate, spread.interval, doubt) if spread else None

    def settle(self) -> None:
        """Work that ``so_far`` leaves for the time in which no frame waits."""
        if self.settings.quantity == "front" and len(self.good) > 1:
            self._front_so_far.settle(self._rest.centroids_px, np.array(self.pins_px))

    def _contact(self) -> tuple[InitialArea, Region, tuple[str, ...]]:
        """A_c0, the region that growth is measured in, and notes.

        The region is the edge of the contact whatever the rule of A_c0: pins that moved but lie outside come closer
        together as the contact grows, and a region that holds them grows too little.
        """
        settings = self.settings
        if isinstance(settings.region, Region):
            need_pins_inside(settings.region, self._contact_px)
            return self._given(settings.region), settings.region, ()
        contact = self.first_contact = self.first_contact or FirstContact.of(self._rest.centroids_px, self._contact_px)
        asked = self._area_by(settings.area_rule, contact)
        outline = asked if settings.area_rule == "edge" else self._area_by("edge", contact)
        notes = asked.notes if outline.rule == "edge" else (*asked.notes, *outline.notes)
        return asked, Region(outline.polygon_px), notes

    def _area_by(self, rule: str, contact: FirstContact) -> InitialArea:
        """Where the result is the front, skin that has hardly moved at first contact refuses no press."""
        threshold_px = self.settings.threshold_px
        try:
            return area_of(contact, self._camera, rule, threshold_px)
        except NoContactError:
            farthest_px = float(np.nanmax(np.hypot(*(self._contact_px - self._rest.centroids_px).T)))
            if self.settings.quantity != "front" or farthest_px < LEAST_MOVED_PX:
                raise
        found = area_of(contact, self._camera, rule, farthest_px / 2)
        said = (
            f"skin: no pin moved {threshold_px:g} px at first contact; those that moved {farthest_px / 2:.2g} px count"
        )
        return replace(found, notes=(*found.notes, said))

    def _given(self, region: Region) -> InitialArea:
        area_px2 = _flat(region, self._camera).area_px2
        check_area(area_px2, undistorted(self._contact_px, self._camera), "region", self._camera)
        return InitialArea(
            area_mm2=None if self._camera is None else area_px2 * self._camera.mm2_per_px2, area_px2=area_px2,
            rule="given", selected=np.flatnonzero(region.contains(self._contact_px)), polygon_px=region.polygon_px,
            notes=(),
        )  # fmt: skip


PinsAtRest = tuple[PinTracker, Pins]
"""What follows pins from a static frame on, which is to be copied, and the pins in it."""


def pins_at_rest(image: NDArray[Any], settings: PinSettings | None) -> PinsAtRest:
    """PinsError, ImageError as ``PinTracker.start``."""
    tracker = PinTracker(settings)
    return tracker, tracker.start(image)


def _flat(region: Region, camera: Camera | None) -> Region:
    """The region as a camera without distortion would see it."""
    return Region(undistorted(region.polygon_px, camera))


def _notes_of(skin: SkinSpread, front: FrontSpread | None) -> tuple[str, ...]:
    rates = {name: of.rate for name, of in (("front", front), ("skin", skin)) if of is not None}
    return tuple(f"{name}: {note}" for name, rate in rates.items() if rate is not None for note in rate.notes)


def _skipped(frames: list[int]) -> tuple[str, ...]:
    if not frames:
        return ()
    which = f"frame {frames[0]} is" if len(frames) == 1 else f"frames {', '.join(map(str, frames))} are"
    return (f"{which} skipped: the pins cannot be told there; growth is measured across the gap",)


def _once(*notes: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(notes))
