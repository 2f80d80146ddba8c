"""What is true of a simulated press, frame by frame, and its contact area spread rate."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import SettingError
from casr.spread import WINDOW_N
from emg2vsa.worlds.tactile.scene import Scene
from emg2vsa.worlds.tactile.timeline import Timeline

FloatArray = NDArray[np.float64]
_EVEN_FORCES = 4001


@dataclass(frozen=True, eq=False)
class PressTruth:
    """Truth of one press of T frames, n of them in the loading phase.

    Parameters
    ----------
    time_s, force_n : (T,) exposure, and force there without noise.
    world : name. assumptions : of it. drawn : what this press differs in from what was meant (``scatter.Drawn``).
    area_mm2 : (T,) contact area. area_px2 : (T,) the contact's ellipse in the image.
    centre_px : (x, y) of the contact, the same in all frames.
    semi_axes_px : (T, 2) of the contact's ellipse along x and y.
    loading_frames : (n,) frames from the first at ``start_n`` or more to the last before the peak.
    log_growth : (n-1,) ln(A_i / A_{i-1}) over the loading frames.
    skin_log_growth, divergence : (n-1,) growth of the skin of the first contact from each loading frame to the next, as
        the logarithm of its area's ratio and as the divergence of its displacement.
    casr_power_mm2_per_n : mean rate of the true area over ``casr.spread.WINDOW_N``, whatever was loaded.
    casr_slope_mm2_per_n, casr_paper_mm2_per_n : ``casr_truth`` of the loading frames.
    """

    world: str
    assumptions: tuple[str, ...]
    drawn: dict[str, float]
    time_s: FloatArray
    force_n: FloatArray
    area_mm2: FloatArray
    area_px2: FloatArray
    centre_px: tuple[float, float]
    semi_axes_px: FloatArray
    loading_frames: NDArray[np.int64]
    log_growth: FloatArray
    skin_log_growth: FloatArray
    divergence: FloatArray
    casr_power_mm2_per_n: float
    casr_slope_mm2_per_n: float
    casr_paper_mm2_per_n: float

    def to_dict(self) -> dict[str, Any]:
        """JSON-ready, one key per field."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return {key: value.tolist() if isinstance(value, np.ndarray) else value for key, value in values.items()}


def press_truth(scene: Scene, timeline: Timeline) -> PressTruth:
    """Truth of the frames of ``timeline``."""
    force = timeline.frame_force_n
    contacts = [scene.contact(value) for value in force.tolist()]
    area_px2 = np.array([contact.area_px2 for contact in contacts])
    area_mm2 = np.array([scene.area_mm2(value) for value in force.tolist()])
    rising = timeline.frame_time_s <= timeline.peak_time_s
    loading = np.flatnonzero(rising & (force >= scene.settings.timeline.start_n))
    steps = zip(force[loading[:-1]].tolist(), force[loading[1:]].tolist(), strict=True)
    skin_growth = np.array([scene.skin_growth(before, after) for before, after in steps])
    return PressTruth(
        world=scene.settings.world.name,
        assumptions=scene.settings.world.assumptions,
        drawn=asdict(scene.drawn),
        time_s=timeline.frame_time_s,
        force_n=force,
        area_mm2=area_mm2,
        area_px2=area_px2,
        centre_px=scene.centre_px,
        semi_axes_px=np.array([contact.semi_axes_px for contact in contacts]),
        loading_frames=loading,
        log_growth=np.diff(np.log(area_mm2[loading])),
        skin_log_growth=skin_growth,
        divergence=2 * np.expm1(skin_growth / 2),
        casr_power_mm2_per_n=_mean_rate(scene),
        casr_slope_mm2_per_n=casr_truth(area_mm2[loading], force[loading]),
        casr_paper_mm2_per_n=casr_truth(area_mm2[loading], force[loading], rule="paper"),
    )


def _mean_rate(scene: Scene) -> float:
    first, last = (scene.skin.area_mm2(scene.skin.state(force_n)) for force_n in WINDOW_N)
    return (last - first) / (WINDOW_N[1] - WINDOW_N[0])


def casr_truth(area_mm2: ArrayLike, force_n: ArrayLike, *, rule: str = "slope") -> float:
    """Contact area spread rate of true areas at true forces.

    Parameters
    ----------
    area_mm2, force_n : (n,) of the loading frames, force rising.
    rule : ``slope``: slope of the least-squares line through the curve A(F) over the force axis, mm^2/N.
        ``paper``: eq. (2) for the last frame,
        the sum of (A_j - A_{j-1}) / (F_j - F_{j-1}) over j = 1 ... n-1 with F_0 = 0, so that the first quotient is
        (A_1 - A_0) / F_1 although A_0 is the area at the first contact; mm^2/N summed over frames.
    """
    area, force = np.asarray(area_mm2, dtype=np.float64), np.asarray(force_n, dtype=np.float64)
    if rule == "slope":
        even = np.linspace(force[0], force[-1], _EVEN_FORCES)
        centred = even - even.mean()
        return float(centred @ np.interp(even, force, area) / (centred @ centred))
    if rule == "paper":
        return float((np.diff(area) / np.diff(np.append(0.0, force[1:]))).sum())
    raise SettingError("rule", wanted="slope or paper", found=repr(rule), do="Choose one of these.")
