"""A study whose people come twice, each time in the order of another row of a Latin square, from plan to report."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa import session
from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.session.open_session import missed_visits, place_of
from emg2vsa.session.plan import PLAN_FILE, read_plan
from emg2vsa.session.record import session_folder
from emg2vsa.study_file import load_study

PEOPLE, VISITS = ("P01", "P02"), ("1", "2")


@pytest.fixture(scope="module")
def study_file(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("visits")
    text = small_study(
        participants=PEOPLE, specimens=["S1", "S3"], task="press", simulation="seed = 5\n",
        tables=f'[session]\n{SIMULATED_SESSION}pause_s = 1.0\nrepetitions = 3\norder = "latin-square"\n'
        "[window]\nexpected_trials = 3\n",
    ).replace('task = "press"', 'task = "press"\nvisits = ["1", "2"]')  # fmt: skip
    (folder / "study.toml").write_text(text, encoding="utf-8")
    for visit in VISITS:
        for participant in PEOPLE:
            words = ["session", str(folder / "study.toml"), "--participant", participant, "--visit", visit]
            assert main([*words, "--virtual", "--no-page"]) == 0
    assert main(["run", str(folder / "study.toml"), "--jobs", "1"]) == 0
    return folder / "study.toml"


def table(path: Path) -> list[dict[str, str]]:
    with path.open(newline="") as file:
        return list(csv.DictReader(file, delimiter="," if path.suffix == ".csv" else "\t"))


def test_every_specimen_is_first_equally_often_at_each_visit_and_of_each_person(study_file):
    study = load_study(study_file)
    plans = {
        (who, visit): read_plan(session_folder(study.data, who, "press", visit) / PLAN_FILE)
        for who in PEOPLE
        for visit in VISITS
    }
    first = {at: plan.presses[0].specimen for at, plan in plans.items()}
    assert all({first[who, visit] for who in PEOPLE} == {"S1", "S3"} for visit in VISITS)
    assert all({first[who, visit] for visit in VISITS} == {"S1", "S3"} for who in PEOPLE)
    assert plans["P02", "2"].order == {"kind": "latin-square", "place": 3, "row": 1, "rows": 2}
    assert plans["P02", "2"].visit == "2"
    path = study.data / "sub-P02" / "ses-2" / "emg" / "sub-P02_ses-2_task-press_acq-S1_emg.json"
    told = json.loads(path.read_text())["SpecimenOrder"]
    assert told["Row"] == 1
    assert told["Specimens"][0] == first["P02", "2"]


def test_visits_are_apart_in_the_data_set(study_file):
    data = study_file.parent / "data"
    assert [row["session_id"] for row in table(data / "sub-P01" / "sub-P01_sessions.tsv")] == ["ses-1", "ses-2"]
    scans = table(data / "sub-P01" / "ses-2" / "sub-P01_ses-2_scans.tsv")
    names = {f"emg/sub-P01_ses-2_task-press_acq-{name}_emg.bdf" for name in ("S1", "S3")}
    assert {row["filename"] for row in scans} == names
    assert [row["participant_id"] for row in table(data / "participants.tsv")] == ["sub-P01", "sub-P02"]
    assert sorted(path.name for path in (data / "sourcedata" / "sub-P01").iterdir()) == ["ses-1", "ses-2"]


def test_two_visits_are_one_person_and_their_differences_are_shown(study_file):
    reports = study_file.parent / "reports" / "small"
    results = json.loads((reports / "results.json").read_text())
    assert (results["study.participants"], results["trials.total"]) == (2, 24)
    rows = table(next(reports.rglob("sessions.csv")))
    assert [(row["participant"], row["visit"], row["found"]) for row in rows] == [
        (who, visit, "6") for who in PEOPLE for visit in VISITS
    ]
    told = " ".join((reports / "methods.txt").read_text().split())
    assert "at each of 2 visits on each specimen; 24 presses of 24 were found" in told
    assert "the next row at the next visit" in told
    rows = table(next(reports.rglob("visits.csv")))
    assert [(row["specimen"], row["visit"], row["people"]) for row in rows] == [("S1", "2", "2"), ("S3", "2", "2")]
    study = load_study(study_file)
    assert all(-3e-6 < float(row["mean_v"]) < 3e-6 and float(row["mean_v"]) for row in rows), (
        "b is the same, noise is not"
    )
    page = (reports / "participants" / "P01.html").read_text()
    assert "usable presses 6 of 6" in page
    assert [len(entry.parts) for entry in study.recordings] == [2] * 4


def test_a_visit_is_named_where_there_are_several(study_file, capsys):
    words = ["session", "finish", str(study_file), "--participant", "P01"]
    for more, said in (([], "one of 1, 2, but found none"), (["--visit", "3"], "one of 1, 2, but found 3")):
        assert main([*words, *more]) == 2
        assert said in capsys.readouterr().err
    assert main([*words, "--visit", "2"]) == 0
    assert "6/6" in capsys.readouterr().out


def test_the_operator_sees_which_visit_it_is(study_file):
    study = load_study(study_file)
    done = session.replay(study, session_folder(study.data, "P01", "press", "2"))
    assert done.same
    assert done.operator.study == "A small study, visit 2"


def test_a_study_without_visits_takes_none(study_file):
    study = replace(load_study(study_file), visits=())
    assert study.at_visit(None) is study
    with pytest.raises(SettingError, match=r"--visit 1: expected no visit.*Add visits = .* to \[recordings\]"):
        study.at_visit("1")


def test_a_visit_before_another_one_is_told(study_file):
    study = load_study(study_file).at_visit("2")
    assert missed_visits(study, "P01") == ()
    assert missed_visits(study.at_visit("1"), "P09") == ()
    assert missed_visits(study, "P09") == (
        "P09 is at visit 2, but visit 1 has not begun. Is this the right one?",
    )  # fmt: skip


def test_another_order_at_another_visit_is_told(study_file):
    study = load_study(study_file).at_visit("2")
    (told,) = missed_visits(replace(study, session=replace(study.session, order="blocked")), "P01")
    assert told == "The order of P01 was 'latin-square' at visit 1, and the study file now says 'blocked'."


def test_a_visit_that_is_recorded_but_not_of_the_study_is_refused(study_file):
    text = study_file.read_text()
    for visits in ('visits = ["1"]', ""):
        study_file.write_text(text.replace('visits = ["1", "2"]', visits))
        with pytest.raises(SettingError, match=r"found ses-. of P01, which is recorded but not in"):
            load_study(study_file)
    study_file.write_text(text)


def test_a_study_converted_keeps_its_visits(study_file, tmp_path):
    assert main(["tools", "convert", str(study_file), "--out", str(tmp_path / "shared")]) == 0
    made = sorted(path.name for path in (tmp_path / "shared" / "sub-P01").rglob("*.bdf"))
    assert made == [f"sub-P01_ses-{v}_task-palpation_acq-{s}_emg.bdf" for v in VISITS for s in ("S1", "S3")]


def test_a_place_in_a_design_stays_when_others_are_planned_before_it(study_file):
    path = study_file.with_name("more.toml")
    path.write_text(study_file.read_text().replace('ids = ["P01"', 'ids = ["P09", "P01"'), encoding="utf-8")
    study = load_study(path).at_visit("2")
    assert [place_of(study, who) for who in ("P09", "P01", "P02")] == [1, 1, 2]
