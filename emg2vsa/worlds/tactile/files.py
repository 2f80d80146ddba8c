"""Simulated presses on disk, as the rig would have saved them, with the truth beside them."""

from __future__ import annotations

import itertools
import json
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import tifffile

from casr.camera import Camera
from casr.dome.library import DEFAULT_WORLD
from casr.dome.view import OUTER_RADIUS_MM
from casr.errors import FramesError, SettingError
from casr.specimens import SPECIMENS
from emg2vsa.worlds.tactile.appearance import Appearance
from emg2vsa.worlds.tactile.contact import ContactWorld
from emg2vsa.worlds.tactile.press import SimulatedPress, Timeline, simulate_press
from emg2vsa.worlds.tactile.settings import REALISTIC, SIMULATED_SENSOR, PressSettings, Scatter, TimelineSettings
from emg2vsa.worlds.tactile.tabulated import TabulatedWorld
from emg2vsa.worlds.tactile.world import World, check

SCATTERS = {"realistic": REALISTIC, "none": Scatter()}


@dataclass(frozen=True, kw_only=True)
class PressPlan:
    """What ``casr simulate`` asks for, by the names of its options; equal plans give equal bytes.

    Raises
    ------
    SettingError : no such specimen; an angle, a peak force or a stick force that cannot be; what tables of domes have
    to do with, without any.
    """

    specimens: tuple[str, ...] = ("S1", "S3", "S5", "S2")
    angles: tuple[float, ...] = (0.0, 30.0, 45.0)
    repetitions: int = 10
    force_max_n: float = 7.0
    world: str = "tabulated"
    stick_force_n: float | None = None
    domes: str | None = None
    dome_radius_mm: float = OUTER_RADIUS_MM
    specimen_height_mm: float | None = None
    scatter: str = "realistic"
    mounting: int = 0
    seed: int = 0
    appearance: Appearance = field(default_factory=Appearance)

    def __post_init__(self) -> None:
        unknown = ", ".join(name for name in self.specimens if name not in SPECIMENS)
        check(
            not unknown,
            "--specimens",
            f"specimens of the paper, {', '.join(SPECIMENS)}",
            unknown,
            "Check the spelling.",
        )
        angles, do = ", ".join(f"{angle:g}" for angle in self.angles), "The paper presses at 0, 30 and 45."
        check(all(0 <= each < 90 for each in self.angles), "--angles", "degrees from 0 to below 90", angles, do)
        most_n, start_n, do = self.force_max_n, TimelineSettings.start_n, "The paper presses up to 7 N."
        wanted = f"more than the force of first contact, {start_n:g} N"
        check(most_n > start_n, "--force-max-n", wanted, f"{most_n:g} N", do)
        found, do = f"--world {self.world}", "Leave it out, or simulate that world."
        fits = self.stick_force_n is None or self.world == "stick"
        check(fits, "--stick-force-n", "it with --world stick", found, do)
        fits = self.domes is None or self.world.startswith("tabulated")
        check(fits, "--domes", "them with --world tabulated or tabulated-frictionless", found, "Leave one of them out.")
        of_domes = {"--dome-radius-mm": self.dome_radius_mm, "--specimen-height-mm": self.specimen_height_mm}
        for option, value in of_domes.items():
            if value not in (None, OUTER_RADIUS_MM):
                check(self.domes is not None, option, "it with --domes", f"{value:g} without", "Give the tables.")
                check(1 <= value <= 1000, option, "1 to 1000 mm", f"{value:g}", "Correct it.")

    def presses(self) -> dict[str, PressSettings]:
        """Name to settings of every press."""
        world, timeline = self._world(), TimelineSettings(peak_n=self.force_max_n)
        camera = Camera(sensor=replace(SIMULATED_SENSOR, dome_radius_mm=self.dome_radius_mm))
        every = itertools.product(self.specimens, self.angles, range(self.repetitions))
        return {
            f"{specimen}_{angle:02g}deg_{repetition + 1:02d}": PressSettings(
                stiffness_n_per_mm=SPECIMENS[specimen], angle_deg=angle, repetition=repetition, seed=self.seed,
                mounting=self.mounting, world=world, scatter=SCATTERS[self.scatter], appearance=self.appearance,
                timeline=timeline, camera=camera, specimen_height_mm=self.specimen_height_mm,
            )
            for specimen, angle, repetition in every
        }  # fmt: skip

    def _world(self) -> World:
        if self.world == "front":
            return ContactWorld(stick_force_n=self.force_max_n)
        if self.world == "stick":
            return ContactWorld(stick_force_n=self.stick_force_n or ContactWorld.stick_force_n)
        friction = "frictionless" if self.world == "tabulated-frictionless" else "stick"
        return TabulatedWorld(friction=friction, tables=self.domes or DEFAULT_WORLD)


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


def write_press(press: SimulatedPress, folder: Path, *, overwrite: bool = False) -> Path:
    """Write ``frames.tif``, ``force.csv``, ``camera.toml`` and ``truth.json`` into ``folder``, whole or not at all.

    Frames are written one by one, so memory does not grow with their number.

    Returns
    -------
    The folder.

    Raises
    ------
    FramesError : the folder is there and ``overwrite`` was not asked for, or it is no simulated press.
    """
    _check_free(folder, overwrite)
    folder.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=folder.parent, prefix=f".{folder.name}.") as temporary:
        new, old = Path(temporary, "new"), Path(temporary, "old")
        new.mkdir()
        _write_frames(press, new / "frames.tif")
        (new / "force.csv").write_text(_force_csv(press.timeline), encoding="utf-8")
        (new / "camera.toml").write_text(press.settings.camera.to_toml(), encoding="utf-8")
        (new / "truth.json").write_text(_truth_json(press), encoding="utf-8")
        replaced = folder.exists()
        if replaced:
            folder.rename(old)
        try:
            new.rename(folder)
        except OSError:
            if replaced:
                old.rename(folder)
            raise
    return folder


def _check_free(folder: Path, overwrite: bool) -> None:
    if folder.exists() and not overwrite:
        do = "Remove the folder, or ask to overwrite."
        raise FramesError(folder, wanted="a new folder", found="an existing folder", do=do)
    if folder.exists() and not (folder / "truth.json").is_file():
        found = "something else, without truth.json"
        raise FramesError(folder, wanted="a simulated press to replace", found=found, do="Choose another folder.")


def _write_frames(press: SimulatedPress, path: Path) -> None:
    frames = press.frames
    with tifffile.TiffWriter(path) as tiff:
        for index in range(len(frames)):
            tiff.write(frames.read(index), photometric="minisblack", contiguous=True, metadata=None)


def _force_csv(timeline: Timeline) -> str:
    rows = zip(timeline.log_time_s, timeline.log_force_n, timeline.log_frame_index, strict=True)
    return "time_s,force_n,frame_index\n" + "".join(f"{time:.4f},{force:.6f},{frame}\n" for time, force, frame in rows)


def _truth_json(press: SimulatedPress) -> str:
    settings: dict[str, Any] = asdict(press.settings)
    return json.dumps({"settings": settings, "truth": press.truth.to_dict()}, indent=1) + "\n"
