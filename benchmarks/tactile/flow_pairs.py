"""Two frames with an exactly known flow between them: what optical flow is measured on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera
from emg2vsa.worlds.tactile import TACTIP_127, Appearance, ContactEllipse, Points, Skin, draw_surface, drawn, exposed

CONTACT_RADIUS_PX = 80.0
"Edge of the contact of the benchmark."


@dataclass(frozen=True, eq=False)
class FlowPair:
    """Two frames and what moved between them.

    first, second : (H, W) uint8. flow : (H, W, 2) float32, true displacement in px; 0 beyond the mask.
    divergence : true, everywhere inside ``contact``, per frame pair.
    contact : in the first frame. pins_first_px, pins_second_px : (n_pins, 2), those of missing pins too.
    mask : (H, W) bool, where the skin is seen.
    """

    first: NDArray[np.uint8]
    second: NDArray[np.uint8]
    flow: NDArray[np.float32]
    divergence: float
    contact: ContactEllipse
    pins_first_px: Points
    pins_second_px: Points
    mask: NDArray[np.bool_]


def contact_pair(
    rim_motion_px: float,
    seed: int = 0,
    *,
    appearance: Appearance | None = None,
    skin: Skin = TACTIP_127,
    camera: Camera | None = None,
) -> FlowPair:
    """A contact of radius b = 80 px growing by ``rim_motion_px``: u = k r inside, k b^2 / r (no divergence) outside.

    Pins move rigidly; texture moves with the skin; noise of the two frames is independent. ``seed`` draws brightness,
    texture, dirt and noise, and shifts the field by up to half a pixel along x and y.
    """

    def displacement(from_centre: Points) -> Points:
        distance_sq = np.maximum((from_centre**2).sum(axis=-1, keepdims=True), CONTACT_RADIUS_PX**2)
        return np.asarray(from_centre * (rim_motion_px * CONTACT_RADIUS_PX / distance_sq))

    return _pair(displacement, rim_motion_px / CONTACT_RADIUS_PX, seed, appearance, skin, skin, camera)


def linear_pair(
    rim_motion_px: float,
    seed: int = 0,
    *,
    appearance: Appearance | None = None,
    skin: Skin = TACTIP_127,
    camera: Camera | None = None,
) -> FlowPair:
    """The whole image dilated, pins too, single speckles of a texture not: u = k r with ``rim_motion_px`` at 80 px."""
    stretch = rim_motion_px / CONTACT_RADIUS_PX
    dilated = replace(skin, pin_radius_px=skin.pin_radius_px * (1 + stretch), edge_px=skin.edge_px * (1 + stretch))
    return _pair(lambda from_centre: from_centre * stretch, stretch, seed, appearance, skin, dilated, camera)


def _pair(
    displacement: Callable[[Points], Points],
    stretch: float,
    seed: int,
    appearance: Appearance | None,
    first_skin: Skin,
    second_skin: Skin,
    camera: Camera | None,
) -> FlowPair:
    appearance, camera = appearance or Appearance(), camera or Camera()
    sensor, press, *noise = (np.random.default_rng(s) for s in np.random.SeedSequence(seed).spawn(4))
    middle = (camera.cx_px, camera.cy_px)
    centre = np.asarray(middle) + press.uniform(-0.5, 0.5, 2)
    surface = draw_surface(appearance, first_skin, camera, sensor, press)
    rest = first_skin.pins_px(middle)
    moved, speckles = (points + displacement(points - centre) for points in (rest, surface.speckle_px))
    first = exposed(drawn(rest, surface, first_skin), appearance.noise_grey, noise[0])
    second = exposed(drawn(moved, surface, second_skin, speckles), appearance.noise_grey, noise[1])
    rows, columns = np.mgrid[: camera.height_px, : camera.width_px]
    flow = displacement(np.stack([columns, rows], axis=-1) - centre)
    mask = surface.visible > 0
    return FlowPair(
        first=first,
        second=second,
        flow=np.where(mask[..., None], flow, 0).astype(np.float32),
        divergence=2 * stretch,
        contact=ContactEllipse((float(centre[0]), float(centre[1])), (CONTACT_RADIUS_PX, CONTACT_RADIUS_PX)),
        pins_first_px=rest,
        pins_second_px=moved,
        mask=mask,
    )
