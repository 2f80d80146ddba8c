from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from emg2vsa.report.inputs import Failure, short_paths, with_short_paths


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
        assert short_paths(said.format(root), study_at(root)) == shown


def test_the_rest_of_a_failure_stays(study_at):
    failure = Failure("P01/S1", "trials", "/srv/lab/a.csv: wanted /srv/lab/b.csv")
    assert with_short_paths([failure], study_at("/srv")) == (replace(failure, message="a.csv: wanted b.csv"),)
