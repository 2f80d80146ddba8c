"""In what the presses of an emulated run differ: each has draws of its own, the same whenever it is made again."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from casr.camera import Camera
from casr.dome.library import DEFAULT_WORLD
from casr.errors import SettingError as NoScene
from emg2vsa.arrays import Floats
from emg2vsa.devices.qbmove.springs import Springs
from emg2vsa.errors import SettingError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.controls import ArtificialEffect
from emg2vsa.worlds.bench.probe import Touch, WorldSettings
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.contact import Relaxation, adhesive_force_n, area_share, in_series, specimen_share
from emg2vsa.worlds.far_ends.camera import FrameTiming
from emg2vsa.worlds.tactile import Appearance, ContactState, ContactWorld, Drawn, PressSettings, Scene, TabulatedWorld
from emg2vsa.worlds.tactile.settings import SIMULATED_SENSOR

_OF_SENSOR, _OF_MOUNTING, _OF_FIRST_PRESS = range(3)
_LEAST_N, _MOST_N, _FORCES = 0.01, 400.0, 600
"Forces between which contacts of control worlds are looked up."
_MOST_SD = 2.0
"Draws stay within so many standard deviations, so that no press is one that a bench would not make."


class _OfMounting(NamedTuple):
    """Normal draws that all presses of a mounting share."""

    angle: float
    stiffness: float
    modulus: float
    depth: float
    friction: float
    softening: float
    latency: float
    force_zero: float


class _OfPress(NamedTuple):
    """Normal draws of one press."""

    stiffness: float
    gap: float
    area: float
    adhesion: float
    latency: float
    force_zero: float


@dataclass(frozen=True)
class SeenPress:
    """What the camera sees of one press.

    scene : skin and contact. modulus : of the sensor over that of the scene's world. specimen : share in the compliance
    of both. friction, adhesion_mj_per_m2 : of the skin. latency_s : from exposure to arrival of a frame, on average.
    effect : artificial, of a control world.
    """

    scene: Scene
    modulus: float
    specimen: float
    friction: float
    adhesion_mj_per_m2: float
    latency_s: float
    effect: ArtificialEffect | None = None

    def in_frame(self, touch: Touch, rng: np.random.Generator) -> ContactState:
        """`state` as one frame shows it, with the noise of a control world; rng : of that noise."""
        noise_sd = self.effect.noise_sd(self._along_n(touch)) if self.effect else 0.0
        return self.state(touch, math.exp(noise_sd * float(rng.standard_normal())) if noise_sd else 1.0)

    def state(self, touch: Touch, area_factor: float = 1.0) -> ContactState:
        """What area and pins follow: a contact as large as that of the elastic force, which adhesion enlarges and shear
        shrinks. Adhesion is left out of depth and force, where it is far below the noise."""
        if touch.normal_n <= 0:
            return self._apart
        # bodies of s times the modulus under s times the force have the same contact
        elastic_n = adhesive_force_n(touch.elastic_n, self.adhesion_mj_per_m2) / self.modulus
        if self.effect:
            elastic_n = self._as_large_n(elastic_n, area_factor * self.effect.factor(self._along_n(touch)))
        state = self.scene.skin.state(elastic_n)
        left = math.sqrt(area_share(touch.shear_n, touch.normal_n, self.friction))
        pulled_mm = (1 - self.specimen) * touch.sheared_mm
        return ContactState(radius_mm=left * state.radius_mm, normal_n=state.normal_n, tangential_mm=pulled_mm)

    def _along_n(self, touch: Touch) -> float:
        """Force down the probe's axis, by which a schedule changes the stiffness."""
        tilt_rad = math.radians(self.scene.settings.angle_deg)
        return touch.normal_n * math.cos(tilt_rad) + touch.shear_n * math.sin(tilt_rad)

    @cached_property
    def _apart(self) -> ContactState:
        return self.scene.skin.state(0.0)

    def area_mm2(self, touch: Touch) -> float:
        """True contact area, mm2."""
        return self.scene.area_mm2(self.state(touch))

    def _as_large_n(self, elastic_n: float, area_factor: float) -> float:
        """Force under which the contact is larger by the factor; pins follow it as they do any force."""
        force_n, area_mm2 = self._elastic
        asked = math.log(area_factor) + np.interp(elastic_n, force_n, np.log(area_mm2))
        return float(np.interp(asked, np.log(area_mm2), force_n))

    @cached_property
    def _elastic(self) -> tuple[Floats, Floats]:
        """Rising force and area, up to the largest contact that the scene can show."""
        force_n = np.geomspace(_LEAST_N, _MOST_N, _FORCES)
        area_mm2 = np.array([self.scene.area_mm2(self.scene.skin.state(force)) for force in force_n.tolist()])
        rising = np.append(True, np.diff(area_mm2) > 0)
        return force_n[rising], area_mm2[rising]


@dataclass(frozen=True)
class PressDraws:
    """World and skin of every press of one run.

    Parameters
    ----------
    emulated : the bench. specimen : on it; SettingError when its stiffness is not known.
    angle_deg : as it was meant to be. springs : of the actuator, None without. rig : its gear, and which way it turns.
    run : name of the run; other names, other draws. plate : a flat plate presses, in place of the dome.
    mounting : which of the times, from 1, that sensor and specimen were mounted for the run; each has draws of its own.
    effect : artificial, of a control world.
    mounted : name of the run for which the mounting was made; the run's own where none is given. A run that goes on
    under another name presses what is mounted, which is no longer at its first press.
    """

    emulated: EmulatedSettings
    specimen: str
    angle_deg: float
    springs: Springs | None
    rig: RigSettings
    run: str = ""
    plate: bool = False
    mounting: int = 1
    effect: ArtificialEffect | None = None
    mounted: str = ""

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
        e, mounting, drawn = self._used, self._mounting, self._press(press)
        first = press == 0 and self.mounted in ("", self.run)
        virgin = (e.softening + e.softening_sd * mounting.softening) if first else 0.0
        stiffness_n_per_mm = (
            e.stiffness_n_per_mm[self.specimen]
            * (1 + e.stiffness_sd * drawn.stiffness)
            * (1 + e.mounting_stiffness_sd * mounting.stiffness)
            * (1 + virgin)
        )
        usual = ContactWorld()
        contact = replace(usual, sensor_modulus_mpa=usual.sensor_modulus_mpa * self._modulus)
        specimen = 1.0 if self.plate else _specimen_share(stiffness_n_per_mm, contact)
        of_specimen = Relaxation.of_share(e.relaxation_of(self.specimen))
        friction = 0.0 if self.plate else max(0.0, e.friction + e.friction_sd * mounting.friction)
        return WorldSettings(
            stiffness_n_per_mm=stiffness_n_per_mm,
            angle_deg=abs(self.angle_deg + e.angle_sd_deg * mounting.angle),
            contact=contact,
            springs=self.springs,
            mm_per_degree=self.rig.gear_mm_per_degree,
            turns_to_push=self.rig.push_sign,
            plate=self.plate,
            height_mm=e.height_mm.get(self.specimen, math.inf),
            gap_mm=e.gap_mm + e.gap_sd_mm * drawn.gap,
            relaxation=in_series([(specimen, of_specimen), (1 - specimen, Relaxation.of_share(e.sensor_relaxation))]),
            skin_friction=friction,
            friction_drop=min(e.friction_drop, friction / 2),
            mount_n_per_mm=e.mount_n_per_mm,
        )

    def scene(self, press: int) -> Scene:
        """The camera's scene. SettingError when the specimen is so soft that its contact leaves the image."""
        world, e = self.world(press), self._used
        settings = PressSettings(
            stiffness_n_per_mm=world.stiffness_n_per_mm / self._modulus,
            angle_deg=world.angle_deg,
            repetition=press,
            seed=e.seed,
            drawn=Drawn(
                depth=math.exp(e.depth_sd * self._mounting.depth), area=math.exp(e.area_sd * self._press(press).area)
            ),
            centre_sd_mm=e.landing_sd_mm,
            specimen_height_mm=e.height_mm.get(self.specimen) if e.domes else None,
            world=TabulatedWorld(tables=e.domes or DEFAULT_WORLD) if e.skin == "finite-elements" else ContactWorld(),
            camera=Camera(sensor=replace(SIMULATED_SENSOR, dome_radius_mm=e.dome_radius_mm)),
            appearance=replace(Appearance(), noise_grey=e.camera_noise_grey),
        )
        try:
            return Scene(settings)
        except NoScene as error:
            raise SettingError(
                f"{self.specimen} at {self.angle_deg:g} degrees", wanted=error.wanted, found=error.found, do=error.do
            ) from error

    def seen(self, press: int) -> SeenPress:
        """What the camera sees of it. SettingError as `scene`."""
        e, world, drawn = self._used, self.world(press), self._press(press)
        return SeenPress(
            scene=self.scene(press),
            modulus=self._modulus,
            specimen=_specimen_share(world.stiffness_n_per_mm, world.contact),
            friction=world.skin_friction,
            adhesion_mj_per_m2=max(0.0, e.adhesion_mj_per_m2 + e.adhesion_sd_mj_per_m2 * drawn.adhesion),
            latency_s=max(0.0, e.camera_latency_s + e.camera_latency_sd_s * (self._mounting.latency + drawn.latency)),
            effect=self.effect,
        )

    def force_zero_n(self, press: int) -> float:
        """What the force sensor reads too much along the push axis, N."""
        return self._used.force_zero_sd_n * (self._mounting.force_zero + self._press(press).force_zero)

    @property
    def frame_timing(self) -> FrameTiming:
        """Timing of the frames of the camera."""
        e = self._used
        seed = int(self._seeds(_OF_SENSOR).generate_state(2)[1])
        return FrameTiming(e.camera_latency_s, e.camera_jitter_s, e.late_frames_share, e.late_frames_s, seed)

    @property
    def preset_latency_s(self) -> float:
        """Latency of the actuator's commands."""
        return self._used.preset_latency_s

    @cached_property
    def _used(self) -> EmulatedSettings:
        return self.emulated.as_used()

    @cached_property
    def _mounting(self) -> _OfMounting:
        return _OfMounting(*self._normal(_OF_MOUNTING, len(_OfMounting._fields)))

    def _press(self, press: int) -> _OfPress:
        return _OfPress(*self._normal(_OF_FIRST_PRESS + press, len(_OfPress._fields)))

    @property
    def _modulus(self) -> float:
        return 1 + self._used.sensor_modulus_sd * self._mounting.modulus

    @property
    def sensor_seed(self) -> int:
        """Seed of the force sensor's noise."""
        return int(self._seeds(_OF_SENSOR).generate_state(1)[0])

    def _normal(self, stream: int, count: int) -> list[float]:
        rng = np.random.default_rng(self._seeds(stream))
        drawn: list[float] = rng.standard_normal(count).clip(-_MOST_SD, _MOST_SD).tolist()
        return drawn

    def _seeds(self, stream: int) -> np.random.SeedSequence:
        run = (self.mounted if stream == _OF_MOUNTING else "") or self.run
        name = f"{self.specimen}, {self.angle_deg:g}, {run}".encode()
        # a list with one number gives the seeds of that number
        entropy = [self.emulated.seed, self.mounting][: 1 if self.mounting == 1 else 2]
        return np.random.SeedSequence(entropy, spawn_key=(stream, *name))


def _specimen_share(stiffness_n_per_mm: float, contact: ContactWorld) -> float:
    """Share of the specimen in the compliance of sensor and specimen."""
    return specimen_share(contact.specimen_mpa(stiffness_n_per_mm), contact.sensor_modulus_mpa)
