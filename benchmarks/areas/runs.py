"""Whole processes: start-up, a run of the people of the demo from nothing, with nothing changed, with one change."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.bench.case import Area, Case, Size, Way
from benchmarks.experts import stat_of_all
from benchmarks.small_study import small_study

EXPERT = Path(stat_of_all.__file__)
STUDY = Path(__file__).resolve().parents[2] / "studies" / "palpation"


def start_up(size: Size) -> Iterator[Case]:
    """Interpreter and imports of a command that does nothing."""
    commands = {
        ("emg2vsa", "--help"): ["-m", "emg2vsa.cli", "--help"],
        ("emg2vsa", "run --help"): ["-m", "emg2vsa.cli", "run", "--help"],
        ("casr", "--help"): ["-m", "casr.cli", "--help"],
        ("Python", "pass"): ["-c", "pass"],
        ("Python", "import numpy"): ["-c", "import numpy"],
    }
    ways = tuple(
        Way(library, name, lambda words=words: python(*words), "equal" if library in ("emg2vsa", "casr") else "as used",
            "" if library in ("emg2vsa", "casr") else "the floor")
        for (library, name), words in commands.items()
    )  # fmt: skip
    yield Case("start-up", 1, "process", ways, float, "exit status", "0")


def people(size: Size) -> Iterator[Case]:
    """A study's people: from files to the report."""
    study = _study(size.value)
    kept = _results(study)
    ways = (
        Way("emg2vsa", "nothing changed", lambda: _run(study), "equal"),
        Way(
            "emg2vsa",
            "one recording changed and put back",
            lambda: _changed(study),
            "as used",
            "two runs: change, put back",
        ),
        Way("Python", "expert: sizes and times of all files", lambda: _asked(study, kept), "as used", "as make asks"),
        Way("emg2vsa", "from nothing", lambda: _cold(study), "as used", "all steps, one process at a time"),
    )
    recordings = len(list(study.parent.glob("data/sub-*/emg/*_emg.*df")))
    yield Case(
        "emg2vsa run --human-only", recordings, "recordings", ways, lambda found: float(differing(found, kept)),
        "numbers of results.json unlike the first run's", "the first run of the same study",
    )  # fmt: skip


@cache
def _study(size: str) -> Path:
    """A simulated study, run once; its folder lasts as long as this process."""
    folder = _folder() / size
    folder.mkdir()
    study = folder / "study.toml"
    if size == Size.SMOKE.value:
        study.write_text(small_study())
    else:
        for name in ("study.toml", "rig.toml"):
            shutil.copy(STUDY / name, folder)
    python("-m", "emg2vsa.cli", "simulate", str(study))  # as other revisions spell it too
    _run(study)
    return study


@cache
def _kept() -> Any:
    return tempfile.TemporaryDirectory()


def _folder() -> Path:
    return Path(_kept().name)


def _run(study: Path) -> dict[str, Any]:
    python("-m", "emg2vsa.cli", "run", str(study), "--human-only", "--jobs", "1")
    return _results(study)


def _asked(study: Path, kept: dict[str, Any]) -> dict[str, Any]:
    """What is stored, where no file changed since the first time; CalledProcessError where one did."""
    state = study.parent.with_suffix(".states")
    state.unlink(missing_ok=True)
    python(str(EXPERT), str(study.parent), str(state))
    python(str(EXPERT), str(study.parent), str(state))
    return kept


def _cold(study: Path) -> dict[str, Any]:
    shutil.rmtree(study.parent / ".emg2vsa", ignore_errors=True)
    return _run(study)


def _changed(study: Path) -> dict[str, Any]:
    """Run with the last bit of one sample flipped, and again with the recording as it was."""
    path = sorted(study.parent.glob("data/sub-*/emg/*_emg.*df"))[-1]
    original = path.read_bytes()
    data = bytearray(original)
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    _run(study)
    path.write_bytes(original)
    return _run(study)


def _results(study: Path) -> dict[str, Any]:
    (path,) = study.parent.rglob("results.json")
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def differing(found: Any, kept: Any) -> int:
    """Numbers that are not the same, to the last bit, in two trees of results."""
    if isinstance(kept, dict) and isinstance(found, dict):
        return sum(differing(found.get(key), kept.get(key)) for key in {*found, *kept})
    if isinstance(kept, list) and isinstance(found, list) and len(kept) == len(found):
        return sum(differing(one, other) for one, other in zip(found, kept, strict=True))
    return int(found != kept)


def python(*arguments: str) -> int:
    """Exit status of a Python process; CalledProcessError where it is not 0."""
    return subprocess.run([sys.executable, "-P", *arguments], check=True, capture_output=True).returncode


AREA = Area(
    name="runs",
    question="What does a whole process cost, and does every way to a result give the same numbers?",
    parts=(start_up, people),
    peers={},
    meaning=(
        "Times are processor times of whole processes, children included. A run with nothing changed reads what is "
        "stored; one changed recording costs its own steps and those that rest on it. The results of all three "
        "ways must be the same to the last bit. Whether any file changed can be asked sooner by its size and times "
        "alone, which miss a damage that keeps them; no expert's run from files to a report exists."
    ),
)
