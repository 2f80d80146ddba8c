"""A whole simulated press: frames drawn when asked for, force log, truth."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from casr.frames import FrameSequence, force_per_frame
from emg2vsa.worlds.tactile.scene import Scene
from emg2vsa.worlds.tactile.settings import PressSettings
from emg2vsa.worlds.tactile.timeline import Timeline, make_timeline
from emg2vsa.worlds.tactile.truth import PressTruth, press_truth


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
        """(H, W) frame ``index``."""
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
    timeline = make_timeline(
        settings.timeline, settings.camera.frame_rate_hz, scene.draws, scene.drawn, settings.scatter.jitter_sd_s
    )
    frames = SimulatedFrames(scene, timeline.frame_force_n)
    return SimulatedPress(settings, scene, timeline, press_truth(scene, timeline), frames)
