"""Studies that tests of several folders write, and the small one with people and an emulated rig, run to its report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from benchmarks.small_study import WITH_A_RIG, small_rig, small_study
from casr.specimens import SPECIMENS
from emg2vsa.cli import main

STUDY = small_study(tables=WITH_A_RIG)
RIG = small_rig("high-stiffness = [0]\nmodular = [0]\n")


def simulated(root: Path, text: str) -> Path:
    """The study file ``root``/studies/small/study.toml with this text, and its recordings."""
    study = root / "studies" / "small" / "study.toml"
    study.parent.mkdir(parents=True)
    study.write_text(text)
    assert main(["tools", "simulate", str(study), "--json"]) == 0
    return study


def run_all(root: Path) -> None:
    """Simulate and run the small study in ``root``, for the fixture ``built_once``."""
    study = simulated(root, STUDY)
    study.with_name("rig.toml").write_text(RIG)
    assert main(["run", str(study), "--jobs", "1", "--json", "--paths"]) == 0


def study_of_files(
    pattern: str = "{participant}_{specimen}.csv", *, name: str = "small", participants: Sequence[str] = ("P01",),
    specimens: Sequence[str] = ("S1",), emg: str = '[channels.emg.EDC]\nname = "EDC"\n', force: str = 'name = "Fz"\n',
) -> str:  # fmt: skip
    """The text of a study whose recordings are files of somebody's own. emg, force : lines of its channels."""
    people = ", ".join(f'"{one}"' for one in participants)
    pressed = "".join(f'[[specimens]]\nname = "{one}"\n' for one in specimens)
    return (
        f'[study]\nname = "{name}"\n[participants]\nids = [{people}]\n{pressed}[recordings]\nlayout = "pattern"\n'
        f'pattern = "{pattern}"\n{emg}[channels.force]\n{force}'
    )


def study_of_runs(name: str, root: str, specimens: Sequence[str] = ("S1", "S3")) -> str:
    """The text of a study of measured runs alone."""
    known = {**SPECIMENS, "S_new": 5.32}
    pressed = (f'[[specimens]]\nname = "{one}"\nstiffness_n_per_mm = {known[one]}\n' for one in specimens)
    return f'[study]\nname = "{name}"\n{"".join(pressed)}[runs]\nroot = "{root}"\n'


def change_a_sample(path: Path) -> None:
    """One bit of a recording."""
    data = bytearray(path.read_bytes())
    data[len(data) // 2] ^= 0x40
    path.write_bytes(data)
