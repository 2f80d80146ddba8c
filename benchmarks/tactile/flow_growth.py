"""Growth of a contact followed through a press, by its radius: what dense flow loses at the edge of a small one."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchmarks.tactile.metrics import percent_error
from casr.camera import Camera
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.region import Region
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, draw_surface, drawn, exposed

RADII_PITCHES = (1.25, 1.6, 2.0, 3.0, 4.0)
LOG_GROWTH, N_STEPS = 0.3, 10
CENTRE_PX = 10.0
"The contact's centre is drawn within this of the middle: pins lie in it in every way."
LOOKS = {"clean": Appearance(), "dirty": Appearance(noise_grey=4.0, dirt_grey=5.0, n_missing=8)}


@dataclass(frozen=True, eq=False)
class GrowingContact:
    """Frames (N_STEPS + 1) of (H, W) uint8 and the region in the first; its area grows by ``LOG_GROWTH`` in log."""

    frames: list[NDArray[np.uint8]]
    region: Region


def growing_contact(radius_px: float, seed: int, *, power: int, look: Appearance) -> GrowingContact:
    """A disc of skin stretched evenly; beyond its edge the motion falls as r^-power.

    ``seed`` draws brightness, dirt, noise, missing pins and the centre.
    """
    camera = Camera()
    place, sensor, press, *noise = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(N_STEPS + 4))
    middle = (camera.cx_px, camera.cy_px)
    centre = np.asarray(middle) + place.uniform(-CENTRE_PX, CENTRE_PX, 2)
    surface = draw_surface(look, TACTIP_127, camera, sensor, press)
    from_centre = TACTIP_127.pins_px(middle) - centre
    inverse = radius_px / np.maximum(np.hypot(*from_centre.T), radius_px)
    frames = []
    for step in range(N_STEPS + 1):
        stretch = np.expm1(LOG_GROWTH / 2 * step / N_STEPS) * inverse ** (power + 1)
        pins = centre + from_centre * (1 + stretch[:, None])
        frames.append(exposed(drawn(pins, surface, TACTIP_127), look.noise_grey, noise[step]))
    return GrowingContact(frames, Region.circle(float(centre[0]), float(centre[1]), radius_px))


def growth_error_percent(engine: str, contact: GrowingContact) -> float:
    """Of the summed log growth, the region of the first frame given."""
    tracker = FlowTracker(FlowSettings(engine=engine))
    tracker.start(contact.frames[0], contact.region)
    found = sum(tracker.step(frame).log_growth for frame in contact.frames[1:])
    return float(percent_error(found, LOG_GROWTH))
