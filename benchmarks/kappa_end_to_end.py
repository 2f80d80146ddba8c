"""How far is kappa of `tools stiffness` from that of the specimen, through rig, mountings and a material that stiffens?

``python -m benchmarks.kappa_end_to_end [--mountings 20] | python -m benchmarks.bench.record kappa_end_to_end``: six
minutes of one process. The emulated rig presses with its plate as ``emg2vsa rig run --plate`` does; logs are read and
fitted as ``emg2vsa tools stiffness`` does.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Literal

import numpy as np

from casr.specimens import SPECIMENS
from emg2vsa.arrays import Floats
from emg2vsa.curves.plate_tests import PlateTests, SpecimenPlates
from emg2vsa.curves.rubber import Cylinder
from emg2vsa.rig.experiment import ExperimentSettings, PlateSettings, plate_plan
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file.plate_logs import Asked, read_plates
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.virtual_run import run_virtual

World = Literal["elastic", "viscoelastic"]
PRESSED = ("S1", "S3", "S5")
CASES: tuple[tuple[World, float | None], ...] = (
    ("elastic", None), ("viscoelastic", None), ("viscoelastic", 30.0), ("viscoelastic", 10.0),
)  # fmt: skip
"Worlds, and heights of the specimen in mm."
TOGETHER = 4
"Mountings that are fitted at once."
DIAMETER_MM = 50.0
STARTED = datetime(2026, 1, 5, 9, tzinfo=UTC)


@dataclass(frozen=True)
class Specimen:
    """height_mm : None where it is linear."""

    name: str
    height_mm: float | None

    @property
    def kappa(self) -> float:
        """At first contact, N/mm."""
        return SPECIMENS[self.name]

    def __str__(self) -> str:
        return f"{self.name}, {self.height_mm:g} mm" if self.height_mm else f"{self.name}, linear"

    @property
    def modulus_kpa(self) -> float:
        """Young's, of its cylinder; NaN where it is linear."""
        return self.kappa / self.cylinders[self.name].n_per_mm_per_kpa if self.height_mm else np.nan

    @property
    def cylinders(self) -> Mapping[str, Cylinder]:
        """As the study file would state it."""
        return {self.name: Cylinder(DIAMETER_MM, self.height_mm)} if self.height_mm else {}

    def depth_mm(self, force_n: Floats) -> Floats:
        """By the law itself."""
        if self.height_mm is None:
            return force_n / self.kappa
        cylinder, deep = self.cylinders[self.name], np.linspace(0, 0.8 * self.height_mm, 100_001)
        return np.interp(force_n, cylinder.force_n(deep, self.modulus_kpa), deep)

    def secant(self, range_n: tuple[float, float]) -> float:
        """N/mm."""
        return float(np.diff(range_n)[0] / np.diff(self.depth_mm(np.array(range_n)))[0])

    def change(self, range_n: tuple[float, float]) -> float:
        """Of the tangent over the range, as a share of the secant."""
        ends = [self.secant((force - 0.01, force + 0.01)) for force in range_n]
        return (ends[1] - ends[0]) / self.secant(range_n)


def pressed(specimen: Specimen, world: World, mountings: int, root: Path) -> list[Path]:
    """Folders of runs, one a mounting."""
    height_mm = {specimen.name: specimen.height_mm} if specimen.height_mm else {}
    emulated = EmulatedSettings(world=world, height_mm=height_mm)
    plan = plate_plan(PlateSettings(), ExperimentSettings(specimens=PRESSED), specimen.name)
    folders = [root / f"mounting-{number}" for number in range(1, mountings + 1)]
    for number, folder in enumerate(folders, start=1):
        run_virtual(replace(plan, mounting=number), RigSettings(), emulated, folder, started=STARTED)
    return folders


def fitted(specimen: Specimen, folders: list[Path]) -> PlateTests:
    """What `tools stiffness` makes of these runs."""
    return read_plates(folders, Asked(cylinders=specimen.cylinders))


def off(specimen: Specimen, of: SpecimenPlates) -> float:
    """Its kappa against that of the law over the same forces, a share."""
    return of.kappa.mean / specimen.secant(of.range_n) - 1


def held(specimen: Specimen, found: list[SpecimenPlates]) -> str:
    """Intervals that hold the truth."""
    inside = [abs(off(specimen, of)) * specimen.secant(of.range_n) <= of.half for of in found]
    return f"{sum(inside)} of {len(inside)}"


def row(specimen: Specimen, world: str, folders: list[Path]) -> str:
    """Of one specimen: what is true, and how far off what is told is."""
    tests = [fitted(specimen, [folder]) for folder in folders]
    alone = [of for each in tests if (of := each.specimen(specimen.name))]
    batches = [fitted(specimen, folders[i : i + TOGETHER]) for i in range(0, len(folders), TOGETHER)]
    several = [of for each in batches if (of := each.specimen(specimen.name))]
    trials = [(i, each) for each in tests for i in range(len(each.trials))]
    scatter = [np.std([own.secant for own in each.ranges], ddof=1) for each in tests]
    range_n, errors = alone[0].range_n, [off(specimen, of) for of in alone]
    line = np.mean([each.fit.kappa[i] for i, each in trials]) / specimen.kappa - 1
    moduli = [of.modulus.mean / specimen.modulus_kpa - 1 for of in alone if of.modulus]
    cells = [f"{specimen.secant(range_n):.3f}", f"{round(100 * specimen.change(range_n))}"]
    cells += [f"{100 * float(each):.1f}" for each in (np.mean(errors), np.std(errors, ddof=1))]
    cells += [f"{100 * float(np.mean(scatter)) / alone[0].kappa.mean:.1f}"]
    cells += [f"{100 * float(np.mean([of.error / of.kappa.mean for of in alone])):.1f}"]
    cells += [held(specimen, alone), held(specimen, several), f"{100 * line:.1f}"]
    cells += [f"{100 * float(np.mean(moduli)):.1f}" if moduli else ""]
    cells += [f"{100 * np.mean([each.ranges[i].nonlinear for i, each in trials]):.0f}"]
    cells += [f"{100 * np.mean([each.ranges[i].rating == 'good' for i, each in trials]):.0f}"]
    return f"| {world}, {specimen} | {' | '.join(cells)} |"


def page(mountings: int) -> Iterator[str]:
    yield "# Kappa of a plate from the press to the study file\n"
    plate = PlateSettings()
    yield f"{mountings} mountings ({TOGETHER} in the elastic world, where they do not differ), each of"
    yield f"{plate.trials} presses up to {plate.f_max_n:g} N. Secant: of the law over the forces that they reach."
    yield "In percent of it: how the tangent changes, error of a mounting's kappa (mean and SD), SD of the presses of a"
    yield "mounting, standard error that is stated. Held: 95 % intervals that hold the truth, with one mounting and"
    yield "with several. Line, modulus: by how much the paper's line and the modulus miss the stiffness at first"
    yield "contact. Then presses that are named nonlinear, and that are rated good.\n"
    head = "specimen | secant (N/mm) | change (%) | error (%) | its SD (%) | presses (%) | stated (%) | held | held by"
    yield f"| {head} {TOGETHER} | line (%) | modulus (%) | named nonlinear (%) | good (%) |"
    yield "|---|" + "---:|" * 12
    for world, height_mm in CASES:
        for name in PRESSED:
            specimen = Specimen(name, height_mm)
            with TemporaryDirectory() as root:
                count = TOGETHER if world == "elastic" else mountings
                yield row(specimen, world, pressed(specimen, world, count, Path(root)))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--mountings", type=int, default=20)
    for text in page(parser.parse_args().mountings):
        print(text, flush=True)


if __name__ == "__main__":
    main()
