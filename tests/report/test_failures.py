from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from emg2vsa.report.failures import Failure, ShortPaths


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
