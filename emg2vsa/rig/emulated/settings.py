"""Settings of the emulated rig: table ``[emulated]`` of rig.toml. None has been tuned to a result."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from casr.specimens import SPECIMENS
from emg2vsa.settings import Ge, Gt, Le, Positive


@dataclass(frozen=True, kw_only=True)
class EmulatedSettings:
    """The bench that stands in for a real one, and in what its presses differ from each other."""

    stiffness_n_per_mm: dict[str, Positive] = field(default_factory=lambda: dict(SPECIMENS))
    "Specimen to its stiffness by plate indentation, N/mm (paper, section IV.B)."
    springs: Literal["qbmove-maker-pro", "qbmove-advanced"] = "qbmove-maker-pro"
    "Whose springs and firmware the actuator has (docs/decisions/0013-emulated-rig.md)."
    gap_mm: Annotated[float, Ge(2), Le(100)] = 3.0
    "From the retracted probe to the specimen's surface, mm (guess)."
    force_noise_n: Annotated[float, Gt(0), Le(1)] = 0.01
    "Standard deviation of the force sensor's noise in each record, N (guess). Without noise a sensor counts as dead."
    force_rate_hz: Annotated[float, Ge(200), Le(7000)] = 500.0
    "Records the force sensor sends a second, a whole fraction of 7000; well above the 200 turns of the control loop."
    camera_noise_grey: Annotated[float, Ge(0), Le(50)] = 2.0
    "Standard deviation of the camera's read noise, grey levels (guess)."
    skin: Literal["finite-elements", "sticking"] = "finite-elements"
    """How the skin moves that the camera sees: tabulated finite elements of a dome, or a contact that sticks and then
    stretches. The force over depth is that of casr's elastic dome with both."""
    landing_sd_mm: Annotated[float, Ge(0), Le(2)] = 0.2
    "Standard deviation of where a press meets the specimen, along each axis of the image, mm (guess: guide's play)."
    gap_sd_mm: Annotated[float, Ge(0), Le(0.2)] = 0.1
    "Standard deviation of the gap from press to press, mm (guess: specimen and sensor set back slowly)."
    angle_sd_deg: Annotated[float, Ge(0), Le(5)] = 0.5
    "Standard deviation of the angle from run to run, degrees (guess: set by hand on a protractor)."
    stiffness_sd: Annotated[float, Ge(0), Le(0.2)] = 0.01
    "Relative standard deviation of the specimen's stiffness from press to press (guess: temperature and creep)."
    seed: Annotated[int, Ge(0)] = 0
    "Same seed, same bytes."
    exact: bool = False
    """true: in virtual time devices and drivers speak byte for byte also while nothing touches the probe. The same run
    comes out, in three times the time; a test compares the two."""
    behind_ports: bool = False
    "Set by emg2vsa rig emulate in the file it writes: the ports lead to emulated devices, and runs are marked so."
