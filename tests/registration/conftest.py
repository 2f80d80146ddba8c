"""A registered study: the study and rig files of the demo, with files in place of recordings that nobody decodes."""

from __future__ import annotations

import shutil
from dataclasses import dataclass
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.registered import registered
from emg2vsa.registration import Registered
from emg2vsa.study_file import load_study

STUDIES = Path(__file__).resolve().parents[2] / "studies" / "palpation"
RECORDED = [f"P{n:02d}" for n in range(1, 13)]
"""Of fourteen planned people, those who had been when the study was registered."""


@dataclass(frozen=True)
class RegisteredStudy:
    """Its folder, and what is done to it."""

    folder: Path

    @property
    def file(self) -> Path:
        return self.folder / "study.toml"

    @property
    def registration(self) -> Path:
        return self.folder / "registration.json"

    def recording(self, participant: str, specimen: str = "S1") -> Path:
        """Where it is, or will be."""
        name = f"sub-{participant}_task-{load_study(self.file).task}_acq-{specimen}_emg.bdf"
        return self.folder / "data" / f"sub-{participant}" / "emg" / name

    def record(self, participant: str, specimen: str) -> None:
        path = self.recording(participant, specimen)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{participant} {specimen}")

    def edit(self, old: str, new: str, name: str = "study.toml") -> None:
        path = self.folder / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    def add(self, table: str, line: str) -> None:
        """A line below the head of a table of the study file, which may be new."""
        text = self.file.read_text()
        head = f"[{table}]\n"
        self.file.write_text(text.replace(head, head + line + "\n") if head in text else f"{text}\n{head}{line}\n")

    def found(self, *, final: bool = False) -> Registered:
        found = registered(load_study(self.file), final=final)
        assert found is not None
        return found


@pytest.fixture(scope="session")
def registered_once(tmp_path_factory: pytest.TempPathFactory) -> RegisteredStudy:
    study = RegisteredStudy(tmp_path_factory.mktemp("registered") / "palpation")
    study.folder.mkdir()
    for name in ("study.toml", "rig.toml"):
        shutil.copy(STUDIES / name, study.folder)
    for participant in RECORDED:
        for specimen in ("S1", "S2", "S3", "S4", "S5"):
            study.record(participant, specimen)
    load_study(study.file).results.mkdir(parents=True)  # where digests of code are remembered
    assert main(["register", str(study.file), "--json"]) == 0
    return study


@pytest.fixture
def study(registered_once: RegisteredStudy, tmp_path: Path) -> RegisteredStudy:
    """A copy in another place, to be changed."""
    return RegisteredStudy(Path(shutil.copytree(registered_once.folder, tmp_path / "elsewhere")))
