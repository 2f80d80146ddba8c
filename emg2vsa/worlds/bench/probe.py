"""What the emulated rig is made of, and its moving part: a cogwheel on the shaft drives the sensor down."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Literal, NamedTuple

from casr.specimens import SPECIMENS
from emg2vsa.devices.qbmove.springs import SPRINGS, Springs
from emg2vsa.dome_contact import SHEAR_OVER_NORMAL
from emg2vsa.errors import SettingError
from emg2vsa.worlds.contact import ELASTIC, ContactHistory, Relaxation
from emg2vsa.worlds.tactile import ContactWorld


@dataclass(frozen=True, kw_only=True)
class WorldSettings:
    """One specimen under one actuator. SettingError for an angle that cannot be.

    Nothing here has been tuned to a result; what nobody has published is a guess.

    Parameters
    ----------
    stiffness_n_per_mm : of the specimen by plate indentation (paper, section IV.B; here its S3).
    angle_deg : between the probe's axis and the normal of the specimen's surface (paper: 0, 30, 45 degrees).
    contact : of soft sensor and specimen, as the emulated camera draws it, with its own sources and guesses.
    springs : of the actuator (source: in `SPRINGS`); None is a rigid motor, the paper's high stiffness.
    friction_nm : Coulomb friction of the shaft (source: nickparnenzini/qbmove_plugin, qbmove_project.pdf); 0 is none.
    settling_s : time constant with which the shaft comes to rest, 0 is at once (guess).
    mm_per_degree : of the probe per turn of the shaft: a cogwheel of 11.5 mm pitch radius (guess; the paper is silent).
    turns_to_push : which way the shaft turns to move the probe down, 1 or -1.
    relaxation : of sensor and specimen in series; the elastic one remembers nothing.
    skin_friction, friction_drop, mount_n_per_mm : between skin and specimen, and the sensor's mount across the probe's
        axis, as ``emg2vsa.worlds.contact.ContactHistory`` has them; friction 0 is a skin that slides freely.
    plate : a flat plate presses, in place of the dome of the tactile sensor.
    height_mm : of the specimen, which stiffens under the plate with its strain; infinite where it does not.
    gap_mm : from the probe with the shaft at 0 to first contact, along the probe's axis (guess).
    """

    stiffness_n_per_mm: float = SPECIMENS["S3"]
    angle_deg: float = 0.0
    contact: ContactWorld = field(default_factory=ContactWorld)
    springs: Springs | None = SPRINGS["qbmove-maker-pro"]
    friction_nm: float = 0.01
    settling_s: float = 0.01
    mm_per_degree: float = 0.2
    turns_to_push: Literal[1, -1] = 1
    gap_mm: float = 5.0
    plate: bool = False
    height_mm: float = math.inf
    relaxation: Relaxation = ELASTIC
    skin_friction: float = 0.0
    friction_drop: float = 0.0
    mount_n_per_mm: float = math.inf

    def __post_init__(self) -> None:
        if not 0 <= self.angle_deg < 90:
            do = "Correct the emulated rig."
            raise SettingError("angle_deg", wanted="0 to below 90 degrees", found=repr(self.angle_deg), do=do)


_MOST_STRAIN = 0.8
"Largest strain of a cylinder; beyond it the force grows on as it did there."


class PlateContact:
    """Force of a flat plate on a specimen, F = kappa d: what stiffness by plate indentation means (paper, IV.B).

    With a height H that of a Neo-Hookean cylinder, F = kappa H / 3 (s^-2 - s) with s = 1 - d / H (Treloar 1975, The
    Physics of Rubber Elasticity): kappa is the slope at first contact.
    """

    def __init__(self, stiffness_n_per_mm: float, height_mm: float = math.inf) -> None:
        self._stiffness_n_per_mm, self._height_mm = stiffness_n_per_mm, height_mm

    def force_n(self, depth_mm: float) -> float:
        """Force, N, at a depth, mm; as `PowerLaw`."""
        return self.resistance(depth_mm)[0]

    def resistance(self, depth_mm: float) -> tuple[float, float]:
        """Force, N, at a depth, mm, and its growth, N/mm (Treloar 1975); as `PowerLaw`."""
        if depth_mm <= 0:
            return 0.0, 0.0
        kappa, height_mm = self._stiffness_n_per_mm, self._height_mm
        if math.isinf(height_mm):
            return kappa * depth_mm, kappa
        cylinder_mm = min(depth_mm, _MOST_STRAIN * height_mm)
        stretch = 1 - cylinder_mm / height_mm
        growth = kappa / 3 * (2 * stretch**-3 + 1)
        return kappa * height_mm / 3 * (stretch**-2 - stretch) + growth * (depth_mm - cylinder_mm), growth


Force = tuple[float, float, float]


class Touch(NamedTuple):
    """A contact at one moment; all 0 without one.

    normal_n : force along the normal of the surface. shear_n : along the surface, against the probe's way.
    elastic_n : normal force of an elastic contact as deep and as large. sheared_mm : way of both bodies' surfaces
    against each other's middle, less what has slid.
    """

    normal_n: float = 0.0
    shear_n: float = 0.0
    elastic_n: float = 0.0
    sheared_mm: float = 0.0


APART = Touch()
_SAME_MM = 1e-7
"Depths nearer to each other tell no slope."


class Probe:
    """Where the probe is with the shaft at an angle, and what pushes back. A larger angle is further down.

    Elastic bodies without friction push back by the angle alone. Others remember: a step begins with ``begin``, is
    looked at with ``torque_nm`` for any angle at its end, and ends with ``settle``.
    """

    def __init__(self, settings: WorldSettings) -> None:
        self._contact = (
            PlateContact(settings.stiffness_n_per_mm, settings.height_mm)
            if settings.plate
            else settings.contact.on(settings.stiffness_n_per_mm)
        )
        self._resistance = self._contact.resistance
        self._mm_per_rad = math.degrees(settings.mm_per_degree)
        self._mm2_per_rad2 = self._mm_per_rad**2
        tilt_rad = math.radians(settings.angle_deg)
        self._sin, self._cos = math.sin(tilt_rad), math.cos(tilt_rad)
        # work along the axis is work along the normal: both the force and the indentation take a cosine
        self._depth_mm_per_rad = self._cos * self._mm_per_rad
        self._lever_m_per_rad = self._depth_mm_per_rad / 1000
        self._stiffer = self._cos**2 + SHEAR_OVER_NORMAL * self._sin**2
        self.touch_rad = settings.gap_mm / self._mm_per_rad
        "Shaft angle at first contact."
        self.remembers = settings.relaxation != ELASTIC or settings.skin_friction > 0
        "Whether the force depends on more than the angle."
        self._history = ContactHistory(
            settings.relaxation,
            friction=settings.skin_friction,
            mount_n_per_mm=settings.mount_n_per_mm,
            friction_drop=settings.friction_drop,
        )
        self._step_s, self._begun = 0.0, False
        "Whether the history has begun that step: it need not while nothing is touched."
        self._at_rad, self._elastic_n, self._touch = self.touch_rad, 0.0, APART

    def position_mm(self, shaft_rad: float) -> float:
        """Way down, mm, from where the shaft is at 0. shaft_rad : rad."""
        return shaft_rad * self._mm_per_rad

    def above_mm(self, shaft_rad: float) -> float:
        """Way down, mm, from there to first contact. shaft_rad : rad."""
        return (self.touch_rad - shaft_rad) * self._mm_per_rad

    def elastic_touch(self, shaft_rad: float) -> Touch:
        """The contact of elastic bodies without friction, N, with the shaft at an angle, rad."""
        normal_n = self._contact.force_n((shaft_rad - self.touch_rad) * self._depth_mm_per_rad)
        return Touch(normal_n, 0.0, normal_n, 0.0)

    def force_n(self, touch: Touch) -> Force:
        """Force on the specimen: x the way its surface falls off, y, and z down the probe's axis, so pressing is +."""
        normal_n, shear_n = touch.normal_n, touch.shear_n
        return normal_n * self._sin - shear_n * self._cos, 0.0, self.along_n(normal_n, shear_n)

    def along_n(self, normal_n: float, shear_n: float) -> float:
        """Part of both forces that goes down the probe's axis, N."""
        return normal_n * self._cos + shear_n * self._sin

    def begin(self, step_s: float) -> None:
        """A step of that length begins where the last one has ended."""
        self._step_s, self._begun = step_s, False

    def torque_nm(self, shaft_rad: float) -> tuple[float, float]:
        """What holds the shaft back at the end of the step, N m, and its growth, N m/rad. The tilted guide takes the
        force across it."""
        depth_mm = (shaft_rad - self.touch_rad) * self._depth_mm_per_rad
        if depth_mm <= 0:
            return 0.0, 0.0
        if not self.remembers:
            elastic_n, growth = self._resistance(depth_mm)
            return elastic_n * self._lever_m_per_rad, growth * self._depth_mm_per_rad * self._lever_m_per_rad
        elastic_n, slope, way_mm, growth = self._end_of_step(shaft_rad, depth_mm)
        normal_n, shear_n = self._history.forces(elastic_n, slope, way_mm)
        if normal_n <= 0:
            return 0.0, 0.0
        # of a contact that sticks to a rigid mount: what a solver goes by need not be exact
        growth_nm = growth / self._history.beta * self._stiffer * self._mm2_per_rad2 / 1000
        return (normal_n * self._cos + shear_n * self._sin) * self._mm_per_rad / 1000, growth_nm

    def settle(self, shaft_rad: float) -> Touch:
        """The step ends with the shaft at this angle, rad; the contact then. It ends where nothing pushes back any
        more; one that the probe has left altogether is forgotten, so that the next is a first one."""
        if not self.remembers:
            return self.elastic_touch(shaft_rad)
        depth_mm = (shaft_rad - self.touch_rad) * self._depth_mm_per_rad
        if depth_mm <= 0:
            if self._at_rad > self.touch_rad:
                self._history.reset()
            self._at_rad, self._elastic_n, self._touch = self.touch_rad, 0.0, APART
            return APART
        elastic_n, slope, way_mm, _ = self._end_of_step(shaft_rad, depth_mm)
        normal_n, shear_n = self._history.advance(elastic_n, slope, way_mm)
        self._at_rad, self._elastic_n = shaft_rad, elastic_n
        self._touch = Touch(normal_n, shear_n, elastic_n, self._history.way_mm) if normal_n > 0 else APART
        return self._touch

    def load_nm(self, shaft_rad: float) -> float:
        """What holds the shaft back now that it has settled there, N m."""
        if not self.remembers:
            return self.torque_nm(shaft_rad)[0]
        return self.along_n(self._touch.normal_n, self._touch.shear_n) * self._mm_per_rad / 1000

    def _end_of_step(self, shaft_rad: float, depth_mm: float) -> tuple[float, float, float, float]:
        """Elastic force, N, its slope, N/mm, and way along the surface, mm, with the shaft there at the end of the
        step; and the growth of the force there, N/mm."""
        if not self._begun:
            self._history.begin(self._step_s)
            self._begun = True
        elastic_n, growth = self._resistance(depth_mm)
        turned_rad = shaft_rad - self._at_rad
        deeper_mm, way_mm = turned_rad * self._depth_mm_per_rad, turned_rad * self._mm_per_rad * self._sin
        if -_SAME_MM <= deeper_mm <= _SAME_MM:
            return elastic_n, growth, way_mm, growth
        return elastic_n, (elastic_n - self._elastic_n) / deeper_mm, way_mm, growth
