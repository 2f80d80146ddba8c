"""Many simulated presses: every specimen at every angle, each as often as asked, in folders of their names."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from casr.errors import SettingError
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile.appearance import Appearance
from emg2vsa.worlds.tactile.contact import ContactWorld
from emg2vsa.worlds.tactile.press import simulate_press
from emg2vsa.worlds.tactile.scatter import REALISTIC, Scatter
from emg2vsa.worlds.tactile.settings import PressSettings, TimelineSettings
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld
from emg2vsa.worlds.tactile.world import World
from emg2vsa.worlds.tactile.write import write_press

SCATTERS = {"realistic": REALISTIC, "none": Scatter()}


@dataclass(frozen=True, kw_only=True)
class PressPlan:
    """What ``casr simulate`` asks for, by the names of its options; equal plans give equal bytes.

    Raises
    ------
    SettingError : no such specimen; an angle, a peak force or a stick force that cannot be.
    """

    specimens: tuple[str, ...] = ("S1", "S3", "S5", "S2")
    angles: tuple[float, ...] = (0.0, 30.0, 45.0)
    repetitions: int = 10
    force_max_n: float = 7.0
    world: str = "tabulated"
    stick_force_n: float | None = None
    scatter: str = "realistic"
    mounting: int = 0
    seed: int = 0
    appearance: Appearance = field(default_factory=Appearance)

    def __post_init__(self) -> None:
        unknown, start_n = [name for name in self.specimens if name not in SPECIMENS], TimelineSettings.start_n
        if unknown:
            wanted, found = f"specimens of the paper, {', '.join(SPECIMENS)}", ", ".join(unknown)
            raise SettingError("--specimens", wanted=wanted, found=found, do="Check the spelling.")
        if not all(0 <= angle < 90 for angle in self.angles):
            found, do = ", ".join(f"{angle:g}" for angle in self.angles), "The paper presses at 0, 30 and 45."
            raise SettingError("--angles", wanted="degrees from 0 to below 90", found=found, do=do)
        if self.force_max_n <= start_n:
            wanted, do = f"more than the force of first contact, {start_n:g} N", "The paper presses up to 7 N."
            raise SettingError("--force-max-n", wanted=wanted, found=f"{self.force_max_n:g} N", do=do)
        if self.stick_force_n is not None and self.world != "stick":
            found, do = f"--world {self.world}", "Leave it out, or simulate that world."
            raise SettingError("--stick-force-n", wanted="it with --world stick", found=found, do=do)

    def presses(self) -> dict[str, PressSettings]:
        """Name to settings of every press."""
        world, timeline = self._world(), TimelineSettings(peak_n=self.force_max_n)
        every = itertools.product(self.specimens, self.angles, range(self.repetitions))
        return {
            f"{specimen}_{angle:02g}deg_{repetition + 1:02d}": PressSettings(
                stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition, seed=self.seed,
                mounting=self.mounting, world=world, scatter=SCATTERS[self.scatter], appearance=self.appearance,
                timeline=timeline,
            )
            for specimen, angle, repetition in every
        }  # fmt: skip

    def _world(self) -> World:
        if self.world == "front":
            return ContactWorld(stick_force_n=self.force_max_n)
        if self.world == "stick":
            return ContactWorld(stick_force_n=self.stick_force_n or ContactWorld.stick_force_n)
        return TabulatedWorld(friction="frictionless" if self.world == "tabulated-frictionless" else "stick")


def write_presses(
    presses: Mapping[str, PressSettings], out: Path, told: Callable[[int], object], *, overwrite: bool = False
) -> list[dict[str, Any]]:
    """Write each press into a folder of its name, and say what is true of it; ``told`` hears how many are done.

    SettingError : without ``overwrite``, a press of that name is there; nothing is written.
    """
    there = [] if overwrite else [name for name in presses if (out / name).exists()]
    if there:
        found = f"{len(there)} of them, the first {there[0]}"
        do = "Choose another folder, or replace them with --overwrite."
        raise SettingError(out, wanted="no press of the same name", found=found, do=do)
    made = []
    for done, (name, settings) in enumerate(presses.items()):
        told(done)
        press = simulate_press(settings)
        folder, truth = write_press(press, out / name, overwrite=overwrite), press.truth
        made.append({
            "press": name, "folder": str(folder), "frames": len(press.frames),
            "initial_area_mm2": float(truth.area_mm2[truth.loading_frames[0]]),
            "casr_mm2_per_n": truth.casr_power_mm2_per_n,
        })  # fmt: skip
    told(len(presses))
    return made
