"""A whole simulated press: force over time, frames drawn when asked for, force log, and what is true."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.errors import SettingError
from casr.frames import FrameSequence, force_per_frame
from casr.spread import WINDOW_N
from emg2vsa.worlds.tactile.appearance import Surface, draw_surface, drawn, exposed
from emg2vsa.worlds.tactile.settings import Drawn, PressSettings, TimelineSettings
from emg2vsa.worlds.tactile.world import ContactEllipse, ContactState, Points, Pressing, Rim

FloatArray = NDArray[np.float64]
FIRST_FRAME_ROW = 4.5
"The first frame is exposed between the fifth and the sixth row of the log, so rows and frames never tie."
_EVEN_FORCES = 4001


class Scene:
    """Sensor, specimen and contact of one press.

    Parameters
    ----------
    settings : the press, as it was meant; ``drawn`` is in what it differs.

    Raises
    ------
    SettingError : the world has no such contact at ``peak_n``.
    """

    def __init__(self, settings: PressSettings) -> None:
        self.settings = settings
        self.drawn = drawn = settings.drawn or settings.scatter.drawn(settings)
        camera = settings.camera
        self.rim = Rim((camera.cx_px, camera.cy_px), settings.skin.mask_radius_px)
        self.rest_px = settings.skin.pins_px(self.rim.centre_px)
        pressing = Pressing(
            stiffness_n_per_mm=settings.stiffness_n_per_mm * drawn.stiffness,
            angle_deg=abs(settings.angle_deg + drawn.angle_deg),
            centre_mm=self._landing_mm(),
            camera=replace(camera, depth_mm=camera.depth_mm * drawn.depth),
            mask_radius_px=settings.skin.mask_radius_px,
            start_n=settings.timeline.start_n,
            peak_n=settings.timeline.peak_n,
            area_factor=drawn.area,
            specimen_height_mm=settings.specimen_height_mm,
        )
        self.skin = settings.world.press(pressing)
        self._still: tuple[ContactState, NDArray[np.float32]] | None = None
        "State and grey levels of the newest image, which off contact is many frames long the same."
        self._room = np.empty((camera.height_px, camera.width_px), np.float32)
        self.centre_px = self.skin.contact(self.skin.state(settings.timeline.start_n)).centre_px

    @cached_property
    def surface(self) -> Surface:
        """The look of this press."""
        s = self.settings
        return draw_surface(s.appearance, s.skin, s.camera, s.draws_of_sensor(), s.draws("brightness"))

    def contact(self, pressed: float | ContactState) -> ContactEllipse:
        """Contact in the image; a point at 0 N and below."""
        return self.skin.contact(self._state(pressed))

    def area_mm2(self, pressed: float | ContactState) -> float:
        """True area of the contact; 0 at 0 N and below."""
        return self.skin.area_mm2(self._state(pressed))

    def pins_px(self, pressed: float | ContactState) -> Points:
        """(n_pins, 2) pin tips, px, those of missing pins too. pressed : by a force, N, or in a state."""
        return self.skin.moved_px(self.rest_px, self._state(pressed))

    def image(self, pressed: float | ContactState, frame: int) -> NDArray[np.uint8]:
        """(H, W) frame number ``frame`` of that contact; the number chooses the noise only."""
        state, still = self._state(pressed), self._still
        if still is None or still[0] != state:
            texture_px = self.surface.speckle_px
            moved_px = self.skin.texture_px(texture_px, state) if texture_px.size else texture_px
            still = self._still = state, drawn(self.pins_px(state), self.surface, self.settings.skin, moved_px)
        noise_grey, rng = self.settings.appearance.noise_grey, self.settings.draws("frame", frame)
        return exposed(still[1], noise_grey, rng, self._room)

    def skin_growth(self, before_n: float, after_n: float) -> float:
        """ln of how much larger the skin of the first contact becomes in the image between two forces, N."""
        return self.skin.skin_growth(self._state(before_n), self._state(after_n))

    def _state(self, pressed: float | ContactState) -> ContactState:
        return pressed if isinstance(pressed, ContactState) else self.skin.state(max(pressed, 0.0))

    def _landing_mm(self) -> tuple[float, float]:
        """How far from where it was meant to the contact lands."""
        x, y = np.clip(self.settings.draws("centre").standard_normal(2), -2, 2) * self.settings.centre_sd_mm
        return float(x), float(y)


@dataclass(frozen=True, eq=False)
class Timeline:
    """Frames and force of one press.

    frame_time_s, frame_force_n : (T,) exposure and true force there.
    peak_time_s : end of loading.
    log_time_s, log_force_n, log_frame_index : (n,) rows of the force log; the index is that of the last frame saved,
        -1 before the first.
    """

    frame_time_s: FloatArray
    frame_force_n: FloatArray
    peak_time_s: float
    log_time_s: FloatArray
    log_force_n: FloatArray
    log_frame_index: NDArray[np.int64]


def make_timeline(press: PressSettings, drawn: Drawn) -> Timeline:
    """Timeline of a press: its speed, its start against the frame clock, its noise and its delays."""
    settings, frame_rate_hz, rng = press.timeline, press.camera.frame_rate_hz, press.draws("timing")
    even = (settings.peak_n - settings.start_n) / settings.loading_s
    rate = even * (1 + rng.uniform(-settings.speed_share, settings.speed_share))
    first_frame_s = FIRST_FRAME_ROW / settings.log_rate_hz
    touch_s = first_frame_s + (settings.rest_frames - 1 + rng.uniform()) / frame_rate_hz
    peak_s = touch_s + settings.peak_n / rate + settings.rounding_s
    n_frames = math.floor((peak_s + settings.unloading_s - first_frame_s) * frame_rate_hz) + 2
    frame_s = first_frame_s + np.arange(n_frames) / frame_rate_hz
    log_s = np.arange(math.ceil((frame_s[-1] + 1 / frame_rate_hz) * settings.log_rate_hz)) / settings.log_rate_hz
    noise_n = settings.force_noise_n * press.draws("force").standard_normal(log_s.size)
    jitter_s = press.scatter.jitter_sd_s * press.draws("jitter").standard_normal(n_frames)
    counted_s = np.maximum.accumulate(frame_s + drawn.latency_s + jitter_s)
    return Timeline(
        frame_time_s=frame_s,
        frame_force_n=_force(frame_s, touch_s, peak_s, rate, settings),
        peak_time_s=peak_s,
        log_time_s=log_s,
        log_force_n=_force(log_s, touch_s, peak_s, rate, settings) + drawn.force_zero_n + noise_n,
        log_frame_index=np.searchsorted(counted_s, log_s).astype(np.int64) - 1,
    )


def _force(time_s: FloatArray, touch_s: float, peak_s: float, rate: float, settings: TimelineSettings) -> FloatArray:
    """True force, N: the rate rises linearly within ``rounding_s``, stays, and falls the same way to 0 at the peak."""
    rounding = settings.rounding_s
    since = np.clip(time_s - touch_s, 0.0, peak_s - touch_s)
    left = (peak_s - touch_s) - since
    rise = np.minimum(since, rounding) ** 2 / (2 * rounding) + np.maximum(since - rounding, 0.0)
    loading = rate * (rise - np.maximum(rounding - left, 0.0) ** 2 / (2 * rounding))
    unloading = (1 + np.cos(np.pi * np.clip((time_s - peak_s) / settings.unloading_s, 0.0, 1.0))) / 2
    return np.asarray(loading * unloading)


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
    SettingError : another rule.
    """
    area, force = np.asarray(area_mm2, dtype=np.float64), np.asarray(force_n, dtype=np.float64)
    if rule == "slope":
        even = np.linspace(force[0], force[-1], _EVEN_FORCES)
        centred = even - even.mean()
        return float(centred @ np.interp(even, force, area) / (centred @ centred))
    if rule == "paper":
        return float((np.diff(area) / np.diff(np.append(0.0, force[1:]))).sum())
    raise SettingError("rule", wanted="slope or paper", found=repr(rule), do="Choose one of these.")


class SimulatedFrames:
    """Frames of ``scene``, one for each force; a frame source that holds no images.

    Parameters
    ----------
    force_n : (T,) true force of each frame. ``np.resize(press.truth.force_n, 100_000)`` presses over and over.
    """

    def __init__(self, scene: Scene, force_n: ArrayLike) -> None:
        s = scene.settings
        self.scene, self.force_n = scene, np.asarray(force_n, dtype=np.float64)
        self.name = f"simulated-{s.stiffness_n_per_mm:g}-{s.angle_deg:g}-{s.repetition}"
        self.shape = (s.camera.height_px, s.camera.width_px)

    def __len__(self) -> int:
        return int(self.force_n.size)

    def read(self, index: int) -> NDArray[np.uint8]:
        """(H, W) frame ``index``. IndexError : there is none."""
        if not 0 <= index < len(self):
            raise IndexError(index)
        return self.scene.image(float(self.force_n[index]), index)


@dataclass(frozen=True, eq=False)
class SimulatedPress:
    """One press.

    settings : what it was made from. scene : draws any frame. timeline : frames and force log. truth : what is true.
    frames : the frame source.
    """

    settings: PressSettings
    scene: Scene
    timeline: Timeline
    truth: PressTruth
    frames: SimulatedFrames

    def __repr__(self) -> str:
        return f"SimulatedPress({len(self.frames)} frames up to {np.max(self.frames.force_n):.3g} N)"

    def sequence(self) -> FrameSequence:
        """The press as a scorer gets it: frames, camera, and the logged force of each frame."""
        log = self.timeline
        by_rule = [
            force_per_frame(log.log_force_n, log.log_frame_index, len(self.frames), rule=rule)
            for rule in ("exposure", "mean")
        ]
        return FrameSequence(self.frames, self.settings.camera, by_rule[0], mean_force_n=by_rule[1])


def simulate_press(settings: PressSettings | None = None) -> SimulatedPress:
    """Press of ``settings``; no frame is drawn yet.

    Raises
    ------
    SettingError : the contact would reach the rim of the image.
    """
    settings = settings or PressSettings()
    scene = Scene(settings)
    timeline = make_timeline(settings, scene.drawn)
    frames = SimulatedFrames(scene, timeline.frame_force_n)
    return SimulatedPress(settings, scene, timeline, press_truth(scene, timeline), frames)
