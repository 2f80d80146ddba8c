"""Whole sessions in virtual time: an emulated participant and operator, and everything else as in a real one."""

from __future__ import annotations

import shutil
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.session.open_session import folder_of, open_session
from emg2vsa.session.views import OperatorState
from emg2vsa.study import Study
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.mistakes import parse_mistakes
from emg2vsa.worlds.people.pages import EmulatedOperator
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.sensors import simulate

STUDY = small_study(
    participants=["P01", "P03"], specimens=["S1", "S3"], task="press", simulation="seed = 5\n",
    tables=f"[session]\n{SIMULATED_SESSION}pause_s = 1.0\n",
)  # fmt: skip
LONGEST_S = 900.0


@dataclass
class Played:
    """A session that has been played. verdicts : (number, attempt) to verdict and problems."""

    study_file: Path
    study: Study
    folder: Path
    person: EmulatedParticipant
    state: OperatorState
    session: object

    @property
    def verdicts(self) -> dict[tuple[int, int], tuple[str, list[str]]]:
        tried = [press for press in self.state.presses if press.verdict]
        return {(p.number, p.attempt): (p.verdict, [found for found, _ in p.problems]) for p in tried}


def write_study(folder: Path, session: str = "") -> Path:
    """A study file with further lines for its table [session]."""
    path = folder / "study.toml"
    path.write_text(STUDY + (session if session.startswith("repetitions") else f"repetitions = 3\n{session}"))
    return path


def play_in(
    folder, *mistakes, session="", resume=False, beside=None, source=None, operator=True, most_presses=None
) -> Played:
    """Play a session to its end. mistakes : as of --mistake. beside : called after each turn with desk and time."""
    path = write_study(folder, session)
    study = load_study(path)
    clock = VirtualClock()
    planned = parse_mistakes(mistakes, {"EDC": 1.0, "FDS": 1.0})
    person, emg, force = simulate(study, study.session, "P03", clock, planned)
    emg, force = source(emg, force) if source else (emg, force)
    with open_session(study, "P03", clock, (lambda: emg, lambda: force), resume=resume, at_once=True) as desk:
        person.watch(desk)
        helper = EmulatedOperator(desk, person.place, most_presses)

        def turn(now_s):
            if operator:
                helper.turn(now_s)
            if beside is not None:
                beside(desk, now_s)
            assert now_s < LONGEST_S, desk.operator()[1].message

        desk.run(clock, turn)
    return Played(path, study, folder_of(study, "P03"), person, desk.operator()[1], desk.session)


@pytest.fixture
def study_file(tmp_path):
    return partial(write_study, tmp_path)


@pytest.fixture
def play(tmp_path):
    return partial(play_in, tmp_path)


@pytest.fixture(scope="session")
def played_once(tmp_path_factory):
    """Of two presses planned on each specimen the first one was done."""
    return play_in(tmp_path_factory.mktemp("played"), session="repetitions = 2", most_presses=1)


@pytest.fixture
def played(played_once, tmp_path):
    """The same in a folder of the test's own."""
    copy = tmp_path / "copy"
    shutil.copytree(played_once.study_file.parent, copy)
    study = load_study(copy / "study.toml")
    return replace(played_once, study_file=study.path, study=study, folder=folder_of(study, "P03"))
