"""In what the presses of an emulated run differ: each has draws of its own, the same whenever it is made again."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from casr.errors import SettingError as NoScene
from casr.synthetic import Appearance, PressSettings, Scene, TabulatedWorld
from emg2vsa.actuator import SPRINGS
from emg2vsa.errors import SettingError
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.emulated.world_settings import WorldSettings
from emg2vsa.rig.rig_settings import RigSettings

_OF_SENSOR, _OF_RUN, _OF_FIRST_PRESS = range(3)
_MOST_SD = 2.0
"Draws stay within so many standard deviations, so that no press is one that a bench would not make."


@dataclass(frozen=True)
class PressDraws:
    """World and skin of every press of one run.

    Parameters
    ----------
    emulated : the bench. specimen : on it; SettingError when its stiffness is not known.
    angle_deg : as it was meant to be. rigid : under the rigid motor. rig : its gear, and which way it turns.
    run : name of the run; other names, other draws. plate : a flat plate presses, in place of the dome.
    """

    emulated: EmulatedSettings
    specimen: str
    angle_deg: float
    rigid: bool
    rig: RigSettings
    run: str = ""
    plate: bool = False

    def __post_init__(self) -> None:
        known = self.emulated.stiffness_n_per_mm
        if self.specimen not in known:
            raise SettingError(
                f"emulated.stiffness_n_per_mm, {self.specimen}",
                wanted="the stiffness of the specimen on the bench",
                found=f"stiffness of {', '.join(known) or 'none'}",
                do="Add it to rig.toml, or choose another specimen.",
            )

    def world(self, press: int) -> WorldSettings:
        """The bench during press number ``press``, from 0."""
        e = self.emulated
        (angle,) = self._normal(_OF_RUN, 1)
        stiffness, gap = self._normal(_OF_FIRST_PRESS + press, 2)
        return WorldSettings(
            stiffness_n_per_mm=e.stiffness_n_per_mm[self.specimen] * (1 + e.stiffness_sd * stiffness),
            angle_deg=abs(self.angle_deg + e.angle_sd_deg * angle),
            springs=None if self.rigid else SPRINGS[e.springs],
            mm_per_degree=self.rig.gear_mm_per_degree,
            turns_to_push=self.rig.push_sign,
            plate=self.plate,
            gap_mm=e.gap_mm + e.gap_sd_mm * gap,
        )

    def scene(self, press: int) -> Scene:
        """What the camera sees of it. SettingError when the specimen is so soft that its contact leaves the image."""
        world = self.world(press)
        settings = PressSettings(
            stiffness_n_per_mm=world.stiffness_n_per_mm,
            angle_deg=world.angle_deg,
            repetition=press,
            seed=self.emulated.seed,
            centre_sd_mm=self.emulated.landing_sd_mm,
            world=TabulatedWorld() if self.emulated.skin == "finite-elements" else world.contact,
            appearance=replace(Appearance(), noise_grey=self.emulated.camera_noise_grey),
        )
        try:
            return Scene(settings)
        except NoScene as error:
            raise SettingError(
                f"{self.specimen} at {self.angle_deg:g} degrees", wanted=error.wanted, found=error.found, do=error.do
            ) from error

    @property
    def sensor_seed(self) -> int:
        """Of the force sensor's noise."""
        return int(self._seeds(_OF_SENSOR).generate_state(1)[0])

    def _normal(self, stream: int, count: int) -> list[float]:
        rng = np.random.default_rng(self._seeds(stream))
        drawn: list[float] = rng.standard_normal(count).clip(-_MOST_SD, _MOST_SD).tolist()
        return drawn

    def _seeds(self, stream: int) -> np.random.SeedSequence:
        name = f"{self.specimen}, {self.angle_deg:g}, {self.run}".encode()
        return np.random.SeedSequence(self.emulated.seed, spawn_key=(stream, *name))
