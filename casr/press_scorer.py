"""The one way a press is scored, frame by frame; recordings and a running rig both feed it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area import InitialArea, initial_area
from casr.contact_area.array import check_area
from casr.contact_area.follow import contact_front
from casr.contact_area.front import ContactFront
from casr.dome.library import worlds
from casr.errors import AreaError
from casr.flow.estimate import FlowStep, FlowTracker
from casr.flow.region import Region
from casr.flow.step import notes_by_frame
from casr.frames import LoadingPhase
from casr.front_spread import FrontSpread, front_doubt, front_spread
from casr.pins import PinTracker
from casr.scored import NO_SCALE, WHOLE_IMAGE, Score, ScoreSettings, SkinSpread, skin_interval
from casr.spread import SpreadRate, contact_areas, spread_rate

Array = NDArray[np.float64]


class PressScorer:
    """Scores one press from its rest frame, its first contact and the frames after; holds one image.

    Attributes
    ----------
    log_growth : of the region since first contact.
    pins_px : of every frame since first contact, (N, 2): the place of each pin of the rest frame, NaN where it is lost.

    Parameters
    ----------
    camera : None leaves areas in px^2.
    settings : how.
    """

    def __init__(self, camera: Camera | None, settings: ScoreSettings) -> None:
        self._camera, self._settings = camera, settings
        # a region that is given is meant whole; the core is for a contact edge, where the flow has a kink
        flow = replace(settings.flow, core_fraction=1.0) if isinstance(settings.region, Region) else settings.flow
        self._whole_image = settings.region == WHOLE_IMAGE
        self._flow = FlowTracker(flow, whole_image=self._whole_image)
        self._steps: list[FlowStep] = []
        self.log_growth = self._divergence = 0.0
        self.pins_px: list[Array] = []

    def touch(self, rest_image: NDArray[Any], contact_image: NDArray[Any]) -> None:
        """Initial area and contact region from the static frame and the frame of first contact.

        Raises
        ------
        NoContactError : no pin moved, and no region is given.
        PinsError : too few pins. ImageError : not an image.
        """
        self._tracker = PinTracker(self._settings.flow.pins)
        self._rest = self._tracker.start(rest_image)
        self._contact_px = self._tracker.step(contact_image)
        self._initial, self._region, self._notes = self._contact()
        self._flow.start(contact_image, self._region, self._contact_px)
        self.pins_px.append(self._contact_px)

    def load(self, image: NDArray[Any]) -> FlowStep:
        """Growth up to the next frame. Raises PinsError when too few of the region's pins are left."""
        before = self._steps[-1].region if self._steps else self._region
        pins_px = self._tracker.step(image)
        step = self._flow.step(image, pins_px)
        if self._camera is not None and self._camera.distortion and not self._whole_image:
            growth = self._flat(step.region).area_px2 / self._flat(before).area_px2
            step = replace(step, log_growth=float(np.log(growth)))
        self._steps.append(step)
        self.pins_px.append(pins_px)
        self.log_growth += step.log_growth
        self._divergence += step.divergence
        return step

    def areas(self, force_n: Array | None) -> Array:
        """(T,) area of the first contact's skin, ``area_unit``, in all frames so far, or as many as there are forces."""
        steps = self._steps if force_n is None else self._steps[: len(force_n) - 1]
        law = self._settings.area_law
        growth = [step.log_growth if law == "ode" else step.divergence for step in steps]
        return contact_areas(self._first_area, growth, force_n, law=law)

    def area_now(self, force_n: float) -> float:
        """Area of the first contact's skin, in ``area_unit``, in the last frame, whose force this is."""
        law = self._settings.area_law
        growth = self.log_growth if law == "ode" else self._divergence
        return float(contact_areas(self._first_area, [growth], [0.0, force_n], law=law)[-1])

    def rate(self, force_n: Array) -> SpreadRate:
        """Rate at which the skin of the first contact grows, over the first T frames, whose forces these are."""
        return self._rate_of(self.areas(force_n), force_n)

    def _rate_of(self, area: Array, force_n: Array) -> SpreadRate:
        s = self._settings
        return spread_rate(area, force_n, rule=s.rate_rule, area_unit=self.area_unit, window_n=s.rate_window_n)

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
        """The score of the frames of ``phase``, whose forces are ``force_n`` (T,), or None without a force log.

        force_zero_sd_n : standard error of the resting level; None where none was taken off.
        """
        steps = self._steps[: len(phase.frames) - 1]
        skin = self._skin(force_n, len(phase.frames))
        front = self._front(len(phase.frames))
        doubt = front_doubt(front) or self._beyond_pins(front)
        spread = None
        if not doubt:
            growth = np.array([step.log_growth for step in steps])
            spread = front_spread(front, growth, force_n, self._rate_of, force_zero_sd_n)
        of_steps = notes_by_frame(phase.frames[1:].tolist(), steps)
        return Score(
            name=name,
            settings=self._settings,
            rest_frame=phase.rest,
            frames=phase.frames,
            force_n=force_n,
            divergence=np.array([step.divergence for step in steps]),
            log_growth=np.array([step.log_growth for step in steps]),
            initial=self._initial,
            rest=self._rest,
            pins_px=np.array(self.pins_px[: len(phase.frames)]),
            area_unit=self.area_unit,
            skin=skin,
            front=front,
            front_doubt=doubt,
            front_spread=spread,
            regions=(self._region.polygon_px, *(step.region.polygon_px for step in steps)),
            notes=_once(
                *([] if self._camera else [NO_SCALE]),
                *phase.notes,
                *self._notes,
                *of_steps,
                *front.notes,
                *_notes_of(skin, spread),
            ),
        )

    def _skin(self, force_n: Array | None, n_frames: int) -> SkinSpread:
        area = self.areas(force_n)[:n_frames]
        if self._settings.quantity == "skin":
            largest = int(np.argmax(area))
            scale = self._initial.area_px2 / self._first_area
            pins_px = undistorted(self.pins_px[largest], self._camera)
            check_area(float(area[largest]) * scale, pins_px, "area of the skin", self._camera)
        if force_n is None:
            return SkinSpread(area, None, None)
        rate = self.rate(force_n)
        return SkinSpread(area, rate, skin_interval(rate, self._initial.relative_sd))

    def _front(self, n_frames: int) -> ContactFront:
        pins_px = np.array(self.pins_px[:n_frames])
        return contact_front(self._rest.centroids_px, pins_px, self._camera, worlds(self._settings.domes))

    def _beyond_pins(self, front: ContactFront) -> str:
        """Why a front that is larger than the pin array cannot be; empty where it is not."""
        for frame in np.flatnonzero(front.determined):
            area_px2 = self._flat(Region(front.edge_px[frame])).area_px2
            try:
                check_area(area_px2, undistorted(self.pins_px[frame], self._camera), "front", self._camera)
            except AreaError as error:
                return f"the edge lies beyond the pins ({error})"
        return ""

    def _contact(self) -> tuple[InitialArea, Region, tuple[str, ...]]:
        """A_c0, the region that growth is measured in, and notes.

        The region is the edge of the contact whatever the rule of A_c0: pins that moved but lie outside come closer
        together as the contact grows, and a region that holds them grows too little.
        """
        settings = self._settings
        if isinstance(settings.region, Region):
            return self._given(settings.region), settings.region, ()
        asked = self._area_by(settings.area_rule)
        outline = asked if settings.area_rule == "edge" else self._area_by("edge")
        notes = asked.notes if outline.rule == "edge" else (*asked.notes, *outline.notes)
        return asked, Region(outline.polygon_px), notes

    def _area_by(self, rule: str) -> InitialArea:
        return initial_area(
            self._rest, self._contact_px, camera=self._camera, rule=rule, threshold_px=self._settings.threshold_px
        )

    def _given(self, region: Region) -> InitialArea:
        area_px2 = self._flat(region).area_px2
        check_area(area_px2, undistorted(self._contact_px, self._camera), "region", self._camera)
        return InitialArea(
            area_mm2=None if self._camera is None else area_px2 * self._camera.mm2_per_px2,
            area_px2=area_px2,
            rule="given",
            selected=np.flatnonzero(region.contains(self._contact_px)),
            polygon_px=region.polygon_px,
            notes=(),
        )

    def _flat(self, region: Region) -> Region:
        """The region as a camera without distortion would see it."""
        return region if self._camera is None else Region(self._camera.undistorted_px(region.polygon_px))


def _notes_of(skin: SkinSpread, front: FrontSpread | None) -> tuple[str, ...]:
    rates = {name: of.rate for name, of in (("front", front), ("skin", skin)) if of is not None}
    return tuple(f"{name}: {note}" for name, rate in rates.items() if rate is not None for note in rate.notes)


def _once(*notes: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(notes))
