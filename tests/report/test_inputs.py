from __future__ import annotations

from dataclasses import dataclass, fields, replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.report.failures import Failure, ShortPaths
from emg2vsa.report.inputs import Runs, origin, without_samples
from emg2vsa.report.sections.participants import PARTICIPANTS
from emg2vsa.settings import SimulationSettings


def test_trials_without_samples_keep_what_is_told_of_them(results):
    full = results.people.trials[0]
    light = without_samples(full)
    assert (light.notes, light.reasons, light.verdict.tolist()) == (full.notes, full.reasons, full.verdict.tolist())
    assert light.force_n.size == light.overview_force_n.size == 0
    assert light.envelopes_v.size == light.peak_force_n.size == len(light.overviews) == 0
    assert not np.shares_memory(light.start_s, full.start_s)
    held = (light, light.bias, light.traits, light.delay)
    arrays = {each.name: getattr(of, each.name) for of in held for each in fields(of)}
    kept = {name for name, value in arrays.items() if isinstance(value, np.ndarray) and value.size}
    assert kept <= {"repetition", "start_s", "verdict", "visit"}  # any other keeps its whole file in memory


def test_each_participant_gets_own_trials_and_failures(results):
    failures = (
        Failure("P01/S1", "trials", "cut"),
        Failure("study", "profiles", "none"),
        Failure("P02", "pages", "full"),
    )
    own = replace(results, failures=failures).by_participant()
    assert list(own) == ["P01", "P02", "P03"]
    assert [[t.participant for t in trials] for _, trials, _ in own.values()] == [[name] * 4 for name in own]
    assert [failed for *_, failed in own.values()] == [[failures[0]], [failures[2]], []]


@dataclass
class Run:
    simulated: bool


SIMULATED, PART = "These data are simulated.", "Part of these data is simulated."


@pytest.mark.parametrize(
    ("people", "study", "made", "strong"),
    [
        ({}, {}, None, SIMULATED),
        ({"truth": {}}, {}, None, SIMULATED),
        # without a truth the report says what it saw and claims no more
        ({"truth": None}, {}, None, "No sign of a simulation was found, so the data are taken as measured."),
        ({"truth": None}, {"simulation": SimulationSettings()}, None, "These data may be simulated."),
        ({"truth": None}, {}, (True, True), PART),
        (None, {}, (True, True), SIMULATED),
        (None, {}, (False, True), PART),
    ],
)
def test_the_first_line_says_what_was_simulated(results, people, study, made, strong):
    shown = replace(
        results, study=replace(results.study, **study), runs=Runs(tuple(map(Run, made))) if made else None,
        people=None if people is None else replace(results.people, **people),
    )  # fmt: skip
    kind, first_words, text = origin(shown)
    assert first_words == strong
    assert kind == ("" if strong.startswith("No") else "repeat" if "may" in strong else "usable")
    assert not made or ("the runs" if all(made) else "1 of 2 runs") in text


def test_the_table_of_participants_looks_through_all_recordings_a_fixed_number_of_times(results):
    class Counted(tuple):
        looks = 0

        def __iter__(self):
            Counted.looks += 1
            return super().__iter__()

    def looks(count: int) -> int:
        names = tuple(f"P{i:03}" for i in range(count))
        entries, trials = results.study.recordings[:4], results.people.trials[:4]
        study = replace(
            results.study, participants=names,
            recordings=Counted(replace(entry, participant=name) for name in names for entry in entries),
        )  # fmt: skip
        people = replace(results.people, trials=Counted(replace(t, participant=name) for name in names for t in trials))
        failures = Counted(Failure(f"{name}/S1", "fits", "cut") for name in names)
        many = replace(results, study=study, people=people, failures=failures)
        Counted.looks = 0
        sessions = next(table for table in PARTICIPANTS.tables(many, {}) if table.name == "sessions")
        assert len(sessions.rows) == count
        return Counted.looks

    assert looks(20) == looks(5) > 0


@pytest.fixture
def study_at(results):
    def at(root: str):
        study, lab = results.study, Path(root) / "lab"
        first, *rest = study.recordings
        recordings = (replace(first, emg_file=Path(root) / "shared" / "far.c3d"), *rest)
        recordings = tuple(replace(r, emg_file=lab / "data" / "sub" / r.emg_file.name) for r in rest) + recordings[:1]
        return replace(study, path=lab / "study.toml", data=lab / "data", recordings=recordings)

    return at


@pytest.mark.parametrize(
    ("said", "shown"),
    [
        ("{}/lab/data/sub/P01.csv, channel 'Fz'", "data/sub/P01.csv, channel 'Fz'"),
        ("{}/lab/data/participants.tsv: empty", "data/participants.tsv: empty"),
        ("{}/lab/other.csv", "other.csv"),
        ("of '{}/shared/far.c3d'", "of '../shared/far.c3d'"),
        ("no path, 3 N/mm", "no path, 3 N/mm"),
    ],
)
def test_messages_do_not_tell_where_the_project_lies(study_at, said, shown):
    for root in ("/home/someone", "/srv"):
        assert ShortPaths(study_at(root)).text(said.format(root)) == shown


def test_the_rest_of_a_failure_stays(study_at):
    failure = Failure("P01/S1", "trials", "/srv/lab/a.csv: expected /srv/lab/b.csv")
    assert ShortPaths(study_at("/srv")).failures([failure]) == (replace(failure, message="a.csv: expected b.csv"),)


def test_folders_around_the_study_and_beside_it_are_told_apart(study_at):
    study = study_at("/srv")
    outer = (Path("/srv/a.csv"), Path("/srv/lab2/b.csv"), Path("/srv/lab2/deep/c.csv"))
    entries = (*(replace(study.recordings[0], emg_file=file) for file in outer), *study.recordings)
    short = ShortPaths(replace(study, recordings=entries))
    said = "/srv/lab/x, /srv/lab2/b.csv, /srv/lab2/deep/c.csv, /srv/a.csv, /srv/lab3/y"
    assert short.text(said) == "x, ../lab2/b.csv, ../lab2/deep/c.csv, ../a.csv, ../lab3/y"


def test_a_study_in_the_root_folder_leaves_messages_as_they_are(study_at):
    study = study_at("/srv")
    alone = replace(study, path=Path("/study.toml"), data=Path("/data"), recordings=())
    assert ShortPaths(alone).text("/data/a.csv and /etc/b") == "data/a.csv and /etc/b"
