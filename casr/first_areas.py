"""The initial contact area of a press by every rule, from its rest frame and that of first contact."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from casr.contact_area import AS_PRINTED, RULES, InitialArea, initial_area
from casr.errors import AreaError, NoContactError, said_of
from casr.frames import FrameSequence, loading_phase
from casr.pins import Pins, PinTracker, pins_in_doubt
from casr.press_forces import press_forces
from casr.scored import NO_SCALE, ScoreSettings
from casr.skin_motion import first_touch


@dataclass(frozen=True, eq=False)
class FirstAreas:
    """Areas of the first contact.

    name : of the sequence. rest_frame, contact_frame : indices. rest : pins of the first; contact_px : (N, 2) the same
    in the second. areas : rule to area, or why it gives none. notes : what a reader of these numbers should know.
    """

    name: str
    rest_frame: int
    contact_frame: int
    rest: Pins
    areas: Mapping[str, InitialArea | AreaError | NoContactError]
    contact_px: Any
    notes: tuple[str, ...]

    @property
    def first(self) -> InitialArea | None:
        """Area by the first rule that finds a contact; None where no rule does."""
        return next((area for area in self.areas.values() if isinstance(area, InitialArea)), None)

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready; None for a rule that finds none."""
        return {
            "name": self.name, "rest_frame": self.rest_frame, "contact_frame": self.contact_frame,
            "pins": len(self.rest),
            "areas": {
                rule: {
                    "area_mm2": area.area_mm2, "area_px2": area.area_px2, "selected": len(area.selected),
                    "relative_sd": area.relative_sd, "saturated": bool(area.saturated), "notes": list(area.notes),
                } if isinstance(area, InitialArea) else None
                for rule, area in self.areas.items()
            },
        }  # fmt: skip


def first_areas(sequence: FrameSequence, settings: ScoreSettings, frames: tuple[int, int] | None = None) -> FirstAreas:
    """Areas by every rule; of the settings those of forces, threshold and pins count.

    frames : rest and first contact; None: by the force, or without one frame 0 and the first that is touched.

    FramesError : frames that are not there, or no contact by the force. NoContactError : no touch is seen.
    PinsError : too few pins at rest.
    """
    pins = settings.flow.pins
    rest_frame, contact_frame, notes = _frames(sequence, settings) if frames is None else (*frames, ())
    tracker = PinTracker(pins)
    rest = tracker.start(sequence[rest_frame])
    contact_px = tracker.step(sequence[contact_frame])
    notes = (*notes, *rest.notes, *pins_in_doubt(rest.centroids_px, pins.expect_pins), *tracker.notes)
    areas: dict[str, InitialArea | AreaError | NoContactError] = {}
    for rule in (*RULES, AS_PRINTED):
        try:
            threshold_px = settings.threshold_px
            areas[rule] = initial_area(rest, contact_px, camera=sequence.camera, rule=rule, threshold_px=threshold_px)
        except (AreaError, NoContactError) as error:
            areas[rule] = error
    scale = () if sequence.camera else (NO_SCALE,)
    return FirstAreas(sequence.name, rest_frame, contact_frame, rest, areas, contact_px, (*scale, *notes))


def _frames(sequence: FrameSequence, settings: ScoreSettings) -> tuple[int, int, tuple[str, ...]]:
    with said_of(sequence.name):
        if sequence.force_n is None:
            contact = first_touch(sequence, settings.threshold_px, settings.flow.pins)
            return 0, contact, (f"no force log: the pins are touched from frame {contact} on; others with --frames",)
        forces = press_forces(sequence, settings)
        phase = loading_phase(forces.force_n, start_n=settings.force_start_n)
    return phase.rest, int(phase.frames[0]), (*sequence.notes, *forces.notes, *phase.notes)
