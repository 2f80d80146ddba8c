"""The front of a press by the analytic field of ``displacement_field``: pins lever on a flattened, stretched skin."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from casr.camera import Camera, undistorted
from casr.contact_area.edge import ContactEdge, fit_edge
from casr.contact_area.front import PARTS, ContactFront
from casr.contact_area.front_edge import as_a_whole
from casr.contact_area.library_front import DEPTH_SHARE_SD, FREE_MISFIT, SD_PER_MISFIT
from casr.contact_area.motion import pin_motion
from casr.flow.region import Region
from casr.pins import pin_pitch_px

Array = NDArray[np.float64]

_FITTED_FRAMES = 16
"Areas between them follow along lines of ln A over the number of the frame."
ANALYTIC_SD = 0.05
"Relative standard error of an area although the field explains the motion: 3 % was seen in the worlds that move so."


def analytic_front(rest_px: Array, pins_px: Array, camera: Camera | None) -> ContactFront:
    """The contact in T frames, as the ellipse whose field is nearest to the motion of the pins.

    Parameters
    ----------
    rest_px : (N, 2) pins at rest. pins_px : (T, N, 2) the same pins in contact; NaN where one is lost.
    camera : None leaves areas in px^2.
    """
    n_frames = len(pins_px)
    fitted = np.unique(np.linspace(0, n_frames - 1, _FITTED_FRAMES).round().astype(np.intp))
    edges: list[ContactEdge] = []
    outlines: list[Array] = []
    near: ContactEdge | None = None
    for frame in fitted[::-1].tolist():  # the last is the largest, and the surest to begin with
        motion = pin_motion(rest_px, pins_px[frame])
        near = fit_edge(motion.rest_px, motion.displacement_px, motion.pitch_px, near)
        shift = np.median(motion.contact_px - motion.rest_px - motion.displacement_px, axis=0) + near.shift_px
        edges.insert(0, near)
        outlines.insert(0, _outline(near, shift))
    areas = np.array([Region(undistorted(outline, camera)).area_px2 for outline in outlines])
    scale = 1.0 if camera is None else camera.mm2_per_px2
    area = scale * np.exp(np.interp(np.arange(n_frames), fitted, np.log(areas)))
    outline_px = _between(np.array(outlines), fitted, n_frames)
    size = np.interp(np.arange(n_frames), fitted, [np.sqrt(edge.a_px * edge.b_px) for edge in edges])
    grown = np.interp(np.arange(n_frames), fitted, [1 + edge.stretch for edge in edges])
    centre = np.mean([edge.centre_px for edge in edges], axis=0)
    away = np.hypot(*(rest_px - centre).T)
    inside = away <= size[:, None]
    left = np.array([1 - edge.explained for edge in edges])
    moved = np.array([float(np.nansum((pins_px[frame] - rest_px) ** 2)) for frame in fitted])
    shear, torsion = as_a_whole(rest_px, pins_px, inside)
    scatter = np.interp(np.arange(n_frames), fitted, [edge.area_error for edge in edges])
    misfit = float(np.sqrt(max(left @ moved, 0.0) / max(moved.sum(), 1e-12)))
    parts = (
        scatter,
        np.full(n_frames, ANALYTIC_SD),
        np.full(n_frames, SD_PER_MISFIT * max(misfit - FREE_MISFIT, 0.0)),
        np.zeros(n_frames),
        np.full(n_frames, 0.0 if camera is None else 2 * DEPTH_SHARE_SD),
    )
    return ContactFront(
        area=area,
        candidates=area[None],
        weight=np.ones(1),
        spread_weight=np.ones(1),
        parts=dict(zip(PARTS, parts, strict=True)),
        centre_px=centre,
        edge_px=outline_px,
        inside=inside,
        pins_inside=inside.sum(axis=1),
        pitches=size * grown / pin_pitch_px(rest_px),
        misfit=misfit,
        off_library=np.nan,
        model="analytic",
        model_sd=ANALYTIC_SD,
        dome="",
        stiffness_n_per_mm=np.nan,
        log_misfit={},
        shear_px=shear,
        torsion_deg=torsion,
        notes=(),
    )


def _outline(edge: ContactEdge, shift_px: Array) -> Array:
    """(M, 2) the edge as it lies in the frame: inside it the rest frame is stretched about the centre."""
    grow = 1 + edge.stretch
    x_px, y_px = (edge.centre_px + shift_px).tolist()
    return Region.ellipse(x_px, y_px, edge.a_px * grow, edge.b_px * grow, turn_deg=edge.turn_deg).polygon_px


def _between(outlines: Array, fitted: NDArray[np.intp], n_frames: int) -> Array:
    after = np.clip(np.searchsorted(fitted, np.arange(n_frames)), 1, len(fitted) - 1)
    share = ((np.arange(n_frames) - fitted[after - 1]) / (fitted[after] - fitted[after - 1]))[:, None, None]
    return np.asarray((1 - share) * outlines[after - 1] + share * outlines[after])
