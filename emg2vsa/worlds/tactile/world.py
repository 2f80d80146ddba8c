"""What a world of the simulator is: how the skin moves, and how large the contact is, in a state of the contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

from casr.camera import Camera
from emg2vsa.worlds.tactile.region import ContactEllipse, Points


@dataclass(frozen=True)
class ContactState:
    """A contact at one moment.

    radius_mm : of its edge, seen along the normal of the specimen. normal_n : force on the skin.
    tangential_mm : how far friction has pulled the skin of the contact along the surface, the way that surface climbs.
    """

    radius_mm: float
    normal_n: float
    tangential_mm: float = 0.0


@dataclass(frozen=True, kw_only=True)
class Pressing:
    """Where and on what a sensor presses.

    stiffness_n_per_mm : of the specimen. angle_deg : of the sensor's axis from the normal, towards +x. centre_mm : how
    far along x and y the contact lands from where it was meant to. camera, mask_radius_px : what sees it. start_n,
    peak_n : forces between which the press counts as loading. area_factor : of the contact in this press against that
    of the world.
    """

    stiffness_n_per_mm: float
    angle_deg: float
    centre_mm: tuple[float, float]
    camera: Camera
    mask_radius_px: float
    start_n: float
    peak_n: float
    area_factor: float


class PressedSkin(Protocol):
    """The skin of one press."""

    def state(self, force_n: float) -> ContactState:
        """Of a contact that a normal force presses; the shipped worlds know no history."""

    def moved_px(self, rest_px: Points, state: ContactState) -> Points:
        """(N, 2) where tips of pins, at rest at (N, 2), are in that state."""

    def texture_px(self, points_px: Points, state: ContactState) -> Points:
        """(N, 2) where marks on the skin go that lie at (N, 2) at rest."""

    def contact(self, state: ContactState) -> ContactEllipse:
        """The edge as the camera sees it, as an ellipse."""

    def area_mm2(self, state: ContactState) -> float:
        """True area of the contact."""

    def skin_growth(self, before: ContactState, after: ContactState) -> float:
        """ln of how much larger the skin that was inside the contact at first becomes in the image between two states.

        At first: when the press counts as loading.
        """


class World(Protocol):
    """Mechanics of sensors and specimens."""

    @property
    def name(self) -> str:
        """In results."""

    @property
    def assumptions(self) -> tuple[str, ...]:
        """What is not known to be so."""

    def press(self, pressing: Pressing) -> PressedSkin:
        """The skin of one press."""
