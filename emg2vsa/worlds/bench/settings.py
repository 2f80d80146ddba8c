"""Settings of the emulated rig: table ``[emulated]`` of rig.toml. None has been tuned to a result."""

from __future__ import annotations

import math
import os
from collections.abc import Mapping
from dataclasses import asdict, field, fields, replace
from itertools import pairwise
from typing import Annotated, Any, Literal, Self

from casr.specimens import SPECIMENS
from emg2vsa.devices.device_settings import Text
from emg2vsa.settings import Ge, Gt, Le, Positive
from emg2vsa.settings_class import settings_class

Share = Annotated[float, Ge(0), Le(0.75)]
"Share of a force that a body loses between 0.1 and 10 s after a step of its depth; creep by a power law comes to 0.77."
RELAXATION = {"S1": 0.03, "S2": 0.04, "S3": 0.06, "S4": 0.06, "S5": 0.12}
"""Relaxation of the paper's specimens (guess: stiff, well cured silicone creeps little, soft mixtures more; Petet et
al. 2021).
"""


@settings_class
class EmulatedSettings:
    """The bench that stands in for a real one, and in what its presses differ from each other."""

    stiffness_n_per_mm: dict[str, Positive] = field(default_factory=lambda: dict(SPECIMENS))
    "Specimen to its stiffness by plate indentation, N/mm (paper, section IV.B); of one that creeps, that after 1 s."
    height_mm: dict[str, Annotated[float, Ge(1), Le(1000)]] = field(default_factory=dict)
    """Specimen to its height, mm: under the plate it is a Neo-Hookean cylinder between ends that slide, its stiffness
    above that at first contact, and kappa over a range of forces is larger. One not named here is as stiff at any
    depth. Under the dome its force over depth stays that of a linear specimen, and finite elements of the skin have
    Neo-Hookean ones of 25 mm, or with ``domes`` of this height. A press on a part of the face stiffens a specimen far
    less: by finite elements a punch of 20 mm width a third as much as the plate."""
    springs: Literal["qbmove-maker-pro", "qbmove-advanced"] = "qbmove-maker-pro"
    """Whose springs and firmware the actuator has (docs/decisions/0013-emulated-rig.md). Omitted in a rig file: those
    of the model in [actuator], which no other may contradict."""
    world: Literal["viscoelastic", "elastic"] = "viscoelastic"
    """Viscoelastic: bodies creep, the skin sticks and slides, commands and frames are late, and every mounting differs.
    Elastic: none of that; area follows from force alone, and the keys below from relaxation on keep their defaults."""
    gap_mm: Annotated[float, Ge(2), Le(100)] = 3.0
    "Gap from the retracted probe to the specimen's surface, mm (guess)."
    force_noise_n: Annotated[float, Gt(0), Le(1)] = 0.01
    "Standard deviation of the force sensor's noise in each record, N (guess). Without noise a sensor counts as dead."
    force_rate_hz: Annotated[float, Ge(200), Le(7000)] = 500.0
    "Records the force sensor sends a second, a whole fraction of 7000; well above the 200 turns of the control loop."
    camera_noise_grey: Annotated[float, Ge(0), Le(50)] = 2.0
    "Standard deviation of the camera's read noise, grey levels (guess)."
    skin: Literal["finite-elements", "sticking"] = "finite-elements"
    """How area and skin follow the force: tabulated finite elements of a dome, or a contact that sticks and then
    stretches, whose radius grows like force^(1/4). The force over depth is that of the second with both."""
    domes: Text | None = None
    """Folder of tables of one other dome (casr dome), whose skin is pressed in place of that of the finite elements
    that come with casr. Tables of several heights take a specimen by its height_mm."""
    dome_radius_mm: Annotated[float, Ge(1), Le(1000)] = 20.0
    "With domes: radius of the sensor, for the camera file; casr dome names it. Tables are of 20 mm, and are scaled."
    landing_sd_mm: Annotated[float, Ge(0), Le(2)] = 0.2
    "Standard deviation of where a press meets the specimen, along each axis of the image, mm (guess: guide's play)."
    gap_sd_mm: Annotated[float, Ge(0), Le(0.2)] = 0.1
    "Standard deviation of the gap from press to press, mm (guess: specimen and sensor set back slowly)."
    angle_sd_deg: Annotated[float, Ge(0), Le(5)] = 0.5
    "Standard deviation of the angle from mounting to mounting, degrees (guess: set by hand on a protractor)."
    stiffness_sd: Annotated[float, Ge(0), Le(0.2)] = 0.01
    "Relative standard deviation of the specimen's stiffness from press to press (guess: temperature and creep)."
    relaxation: dict[str, Share] = field(default_factory=dict)
    """Specimen to the share of its force that relaxes between 0.1 and 10 s; 0 is elastic. Omitted: S1 0.03, S2 0.04,
    S3 and S4 0.06, S5 0.12, and of another name what these have at its stiffness (guess)."""
    sensor_relaxation: Share = 0.15
    "The same of the sensor (guess: soft printed skin is markedly rate dependent; Slesarenko and Rudykh)."
    friction: Annotated[float, Ge(0), Le(2)] = 0.6
    "Coefficient between skin and specimen (guess: rubber on silicone); 0 is frictionless."
    friction_drop: Annotated[float, Ge(0), Le(0.5)] = 0.05
    "Drop of the coefficient while the skin slides (guess)."
    friction_sd: Annotated[float, Ge(0), Le(0.3)] = 0.1
    "Standard deviation of the coefficient from mounting to mounting (guess: dust, wear)."
    mount_n_per_mm: Annotated[float, Ge(1), Le(1e6)] = 30.0
    "Stiffness of the sensor's mount across the probe's axis, N/mm (guess: printed ABS)."
    adhesion_mj_per_m2: Annotated[float, Ge(0), Le(200)] = 10.0
    "Work of adhesion while loading, mJ/m2 (guess: matt print with dust; clean silicone has about 45)."
    adhesion_sd_mj_per_m2: Annotated[float, Ge(0), Le(50)] = 5.0
    "Standard deviation of it from press to press, mJ/m2 (guess); it is never below 0."
    softening: Annotated[float, Ge(0), Le(0.2)] = 0.02
    "Share by which the specimen is stiffer in the first press of a mounting (guess: Mullins; Liao et al. 2020)."
    softening_sd: Annotated[float, Ge(0), Le(0.1)] = 0.01
    "Standard deviation of that from mounting to mounting (guess)."
    preset_latency_s: Annotated[float, Ge(0), Le(0.02)] = 0.015
    """Time from a command until the motors' loop goes by it, s (guess: bus and firmware). With 0.03 the guard of
    following ends runs.
    """
    camera_latency_s: Annotated[float, Ge(0), Le(0.2)] = 0.035
    "Mean time from exposure to arrival of a frame, s, which the rig takes off (a USB camera; pupil-labs/pupil#152)."
    camera_latency_sd_s: Annotated[float, Ge(0), Le(0.02)] = 0.005
    "Standard deviation of it from mounting to mounting, and again from press to press, s; the rig does not know it."
    camera_jitter_s: Annotated[float, Ge(0), Le(0.02)] = 0.005
    "Standard deviation of the arrival of each frame, s (Miniscope_DAQ#12)."
    late_frames_share: Annotated[float, Ge(0), Le(0.5)] = 0.02
    "Share of the frames that arrive later still (seeing-things/track#78)."
    late_frames_s: Annotated[float, Ge(0), Le(0.04)] = 0.03
    "Time by which these frames are late, s; less than the time from frame to frame."
    force_zero_sd_n: Annotated[float, Ge(0), Le(0.2)] = 0.02
    "Standard deviation of the force sensor's zero, N: after the tare of a mounting, and again at each press (guess)."
    area_sd: Annotated[float, Ge(0), Le(0.1)] = 0.015
    "Relative standard deviation of the contact's area from press to press (guess: the skin is uneven)."
    depth_sd: Annotated[float, Ge(0), Le(0.1)] = 0.01
    "Relative standard deviation of the camera's depth about that in camera.toml, from mounting to mounting (guess)."
    mounting_stiffness_sd: Annotated[float, Ge(0), Le(0.2)] = 0.02
    "Relative standard deviation of the specimen's stiffness from mounting to mounting (guess: place, thickness)."
    sensor_modulus_sd: Annotated[float, Ge(0), Le(0.2)] = 0.03
    "Relative standard deviation of the sensor's modulus from mounting to mounting (guess: batch, 1 K)."
    seed: Annotated[int, Ge(0), Le(2**32 - 1)] = 0
    "Same seed, same bytes."
    control: Literal["none", "N1", "N2", "N3", "P1", "P2", "P3", "P4"] = "none"
    """A world with a known answer, to test the analysis with (docs/how-to/controls.md): without an effect N1 elastic
    bodies, N2 all defaults, N3 all defaults with swapped schedules; with one P1 on the area, P2 by timing, P3 on sums
    over frames, P4 on the noise of the area. The control sets the keys that its world needs."""
    control_exponent: Annotated[float, Ge(0), Le(0.2)] = 0.05
    "P1: areas are multiplied with the stiffness in N m/rad to minus this power."
    control_specimen: str = ""
    "P4: areas are least noisy with the stiffness of this specimen's modular schedule."
    exact: bool = False
    """true: in virtual time drivers and devices speak byte for byte in every turn. false: the drivers ask the devices
    without bytes. Guards look at every turn either way, and the same run comes out; a test compares the two."""
    behind_ports: bool = False
    "Set by emg2vsa rig emulate in the file it writes: the ports lead to emulated devices, and runs are marked so."

    def document(self) -> dict[str, Any]:
        """For emulated.json. over_bytes : actuator and force sensor were spoken to byte for byte in every turn."""
        domes = self.domes and os.path.basename(self.domes)
        return asdict(self) | {"domes": domes, "over_bytes": self.exact or self.behind_ports}

    def of(self, specimen: str) -> Self:
        """What matters for the runs of one specimen."""
        return replace(
            self,
            stiffness_n_per_mm=_only(specimen, self.stiffness_n_per_mm),
            height_mm=_only(specimen, self.height_mm),
            relaxation=_only(specimen, self.relaxation),
        )

    def relaxation_of(self, specimen: str) -> float:
        """Share of the force of a specimen that relaxes; of one that nobody names from its stiffness, N/mm."""
        named = RELAXATION | self.relaxation
        if specimen in named:
            return named[specimen]
        return relaxation_at(self.stiffness_n_per_mm[specimen])

    def as_used(self) -> Self:
        """With what the elastic world has not switched off."""
        if self.world != "elastic":
            return self
        none: dict[str, Any] = dict.fromkeys(VISCOELASTIC_KEYS, 0.0)
        stiff = {"relaxation": dict.fromkeys(self.stiffness_n_per_mm, 0.0), "mount_n_per_mm": self.mount_n_per_mm}
        return replace(self, **none | stiff)


def relaxation_at(stiffness_n_per_mm: float) -> float:
    """Share that relaxes, straight over the logarithm of the stiffness between the paper's specimens."""
    at = sorted((math.log(SPECIMENS[name]), share) for name, share in RELAXATION.items())
    asked = math.log(stiffness_n_per_mm)
    for (below, low), (above, high) in pairwise(at):
        if asked <= above:
            return low + (high - low) * max(0.0, asked - below) / (above - below)
    return at[-1][1]


def _only(name: str, table: Mapping[str, float]) -> dict[str, float]:
    return {name: table[name]} if name in table else {}


_NAMES = [each.name for each in fields(EmulatedSettings)]
VISCOELASTIC_KEYS = tuple(_NAMES[_NAMES.index("relaxation") : _NAMES.index("seed")])
"Keys that say nothing of the elastic world."
