"""Small simulated data for every snippet of the documentation; the same bytes each time."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from os import PathLike
from pathlib import Path

import numpy as np

from casr.atomic import write_text_atomic
from casr.command_line import nearest
from casr.specimens import SPECIMENS
from emg2vsa.errors import SettingError
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.formats import write_csv
from emg2vsa.worlds.people.plan import plan_study
from emg2vsa.worlds.people.study import simulate_study
from emg2vsa.worlds.tactile import REALISTIC, PressSettings, simulate_press, write_press

_CHANNELS = """
[channels.emg.EDC] # extensor digitorum communis
name = "EDC"

[channels.emg.FDS] # flexor digitorum superficialis
name = "FDS"

[channels.force]
name = "Fz"
"""
_RECORDINGS = f"""
[study]
name = "mine"

[participants]
ids = ["anna", "ben"]

[[specimens]]
name = "hard"

[[specimens]]
name = "soft"

[recordings]
layout = "pattern"
pattern = "{{participant}}_{{specimen}}.csv"
{_CHANNELS}
[simulation]
seed = 1
repetitions = 5
a_v = {{ hard = 42e-6, soft = 16e-6 }}
b_v = {{ hard = 20e-6, soft = 7e-6 }}
"""
_STUDY = f"""# A small study with simulated recordings. Every key is explained in docs/reference/study-file.md.

[study]
name = "sample"
title = "A small simulated study"

[participants]
ids = ["P01", "P02", "P03", "P04"]

[[specimens]]
name = "S1"
stiffness_n_per_mm = 7.63

[[specimens]]
name = "S3"
stiffness_n_per_mm = 3.35

[[specimens]]
name = "S5"
stiffness_n_per_mm = 1.11

[recordings]
layout = "pattern"
pattern = "recordings/{{participant}}_{{specimen}}.csv"
{_CHANNELS}
[window]
expected_trials = 4

[profile]
new_specimen = "S_new"
new_stiffness_n_per_mm = 5.32

[simulation]
seed = 2
repetitions = 4
rest_s = [1.2, 1.6]
participant_sd = 0.05
a_v = {{ S1 = 42e-6, S3 = 28e-6, S5 = 16e-6 }}
b_v = {{ S1 = 20e-6, S3 = 13e-6, S5 = 7e-6 }}
"""
_SLOPE_UV = {"S1": 20.0, "S3": 13.0, "S5": 7.0}


def write_sample(name: str, folder: str | PathLike[str], *, overwrite: bool = False) -> tuple[Path, ...]:
    """Write the sample of this name into ``folder``; the files, or folders of presses, that were written.

    Raises SettingError: no such sample, or ``folder`` holds files and ``overwrite`` was not asked for.
    """
    folder = Path(folder)
    if name not in SAMPLES:
        wanted = f"one of {', '.join(SAMPLES)}"
        raise SettingError(
            "sample", wanted=wanted, found=repr(name), do=nearest(name, SAMPLES).strip() or "Choose one."
        )
    if folder.exists() and not folder.is_dir():
        raise SettingError(folder, wanted="a folder", found="a file", do="Choose another with --out.")
    if folder.is_dir() and any(folder.iterdir()) and not overwrite:
        raise SettingError(
            folder, wanted="an empty or absent folder", found="files in it",
            do="Choose another with --out, or replace files of the same names with --overwrite.",
        )  # fmt: skip
    return SAMPLES[name][1](folder, overwrite)


def _recordings(folder: Path, overwrite: bool) -> tuple[Path, ...]:
    with tempfile.TemporaryDirectory() as scratch:
        path = Path(scratch, "study.toml")
        path.write_text(_RECORDINGS, encoding="utf-8")
        settings, plan = plan_study(load_study(path))
    return tuple(write_csv(folder, planned, planned.make(settings)) for planned in plan)


def _plate(folder: Path, overwrite: bool) -> tuple[Path, ...]:
    """Two trials for each specimen: 0.3 mm through air, then Hooke's law to 1.2 mm, with noise of the force sensor."""
    rng = np.random.default_rng(3)
    indentation_mm = np.linspace(-0.3, 1.2, 151)
    paths = []
    for specimen, kappa in SPECIMENS.items():
        rows = ["specimen,trial,indentation_mm,force_n"]
        for trial in (1, 2):
            force_n = kappa * np.maximum(indentation_mm, 0) + 0.005 * rng.standard_normal(indentation_mm.size)
            rows += [f"{specimen},{trial},{x:.4f},{f:.5f}" for x, f in zip(indentation_mm, force_n, strict=True)]
        paths.append(_table(folder / f"{specimen}.csv", rows))
    return tuple(paths)


def _slopes(folder: Path, overwrite: bool) -> tuple[Path, ...]:
    """b of ten participants on three specimens; people differ by 15 %, repeated values by 8 %."""
    rng = np.random.default_rng(4)
    rows = ["participant,specimen,repetition,b"]
    for person in range(1, 11):
        scale = 1 + 0.15 * rng.standard_normal()
        for specimen, slope in _SLOPE_UV.items():
            drawn = slope * scale * (1 + 0.08 * rng.standard_normal(3))
            rows += [f"P{person:02d},{specimen},{n},{b:.3f}" for n, b in enumerate(drawn, 1)]
    return (_table(folder / "slopes.csv", rows),)


def _table(path: Path, rows: list[str]) -> Path:
    write_text_atomic(path, "\n".join(rows) + "\n")
    return path


def _presses(folder: Path, overwrite: bool) -> tuple[Path, ...]:
    paths = []
    for specimen in ("S1", "S5"):
        press = simulate_press(PressSettings(stiffness_n_per_mm=SPECIMENS[specimen], scatter=REALISTIC))
        paths.append(write_press(press, folder / f"{specimen}_00deg_01", overwrite=overwrite))
    return tuple(paths)


def _study(folder: Path, overwrite: bool) -> tuple[Path, ...]:
    path = folder / "study.toml"
    write_text_atomic(path, _STUDY)
    made = simulate_study(load_study(path), folder / "recordings", format="csv")
    return (path, *made.recordings)


SAMPLES: dict[str, tuple[str, Callable[[Path, bool], tuple[Path, ...]]]] = {
    "recordings": ("EMG and force of two people on two specimens, CSV", _recordings),
    "plate": ("plate indentation logs of the five specimens, two trials each, CSV", _plate),
    "slopes": ("a table of b by participant and specimen, for emg2vsa stats", _slopes),
    "presses": ("two tactile presses, of a stiff and of a soft specimen", _presses),
    "study": ("a study file with recordings of four people on three specimens", _study),
}
"""Name to what the sample is, and what writes it into a folder."""
