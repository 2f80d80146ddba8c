"""The form of a participant: what is asked, what is refused, and where the answers are, and are not."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import pytest

from emg2vsa import session
from emg2vsa.cli import main
from emg2vsa.errors import DataError, SettingError
from emg2vsa.session.form import is_answered, read_form, store_answers
from emg2vsa.study_file import load_study
from tests.session.conftest import STUDY

FORM = """
[session.form.age]
description = "Age at the first visit."
range = [18, 99]
unit = "year"
[session.form.handedness]
description = "Hand that writes."
levels = { sinister = "left", dexter = "right" }
"""
ANSWERS = 'participant_id = "P03"\nage = 43.2187\nhandedness = "sinister"\n'


@pytest.fixture
def study(tmp_path):
    (tmp_path / "study.toml").write_text(STUDY + "repetitions = 1\n" + FORM, encoding="utf-8")
    return load_study(tmp_path / "study.toml")


def filled(folder: Path, text: str) -> Path:
    (folder / "P03.toml").write_text(text, encoding="utf-8")
    return folder / "P03.toml"


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('participant_id = "P03"\nage = 17\n', r"form .*, handedness: expected the columns .* but found no such line"),
        (ANSWERS + 'name = "Ann"\n', r"P03.toml, name: expected the columns .* but found another one"),
        (ANSWERS.replace("43.2187", "17"), r"age: expected 18 to 99 year, but found a number out of range"),
        (ANSWERS.replace("43.2187", "true"), r"age: expected 18 to 99 year, but found something else"),
        (ANSWERS.replace("43.2187", "nan"), r"age: expected 18 to 99 year, but found a number out of range"),
        (ANSWERS.replace("sinister", "Ann Lee"), r"handedness: expected one of 'sinister' \(left\), .*something else"),
        (ANSWERS.replace('"sinister"', '["dexter"]'), r"handedness: expected one of .* but found something else"),
        (ANSWERS.replace("P03", "P01"), r"participant_id: expected \"P03\", but found another person's form"),
        (ANSWERS[23:], r"participant_id: expected \"P03\", but found no such line"),
        ("age =\n", r"expected a form in TOML, but found"),
    ],
)
def test_an_answer_that_cannot_be_is_refused_and_not_repeated(study, tmp_path, text, said):
    with pytest.raises(SettingError, match=said) as caught:
        read_form(filled(tmp_path, text), study.session.form, "P03")
    assert "Ann" not in str(caught.value)


def test_a_session_with_devices_wants_the_answers_first(study, tmp_path):
    with pytest.raises(SettingError, match=r"--form: expected answers of P03 to \[session.form\] \(age, handedness\)"):
        session.run(study, "P03", pages=session.Pages(port=0))
    with pytest.raises(SettingError, match=r"--form .*P03.toml: expected a form in TOML, but found no file"):
        session.run(study, "P03", form=tmp_path / "P03.toml", virtual=session.Virtual())
    assert not study.data.exists()


def test_the_empty_form_is_one(study, tmp_path, capsys):
    assert main(["session", "form", str(study.path), "--participant", "P03"]) == 0
    answers = read_form(filled(tmp_path, capsys.readouterr().out), study.session.form, "P03")
    assert answers == {"age": "n/a", "handedness": "n/a"}
    assert main(["session", "form", str(study.path), "--participant", "P99"]) == 2
    assert "--participant P99: expected one of P01, P03" in capsys.readouterr().err
    (tmp_path / "none.toml").write_text(STUDY, encoding="utf-8")
    assert main(["session", "form", str(tmp_path / "none.toml"), "--participant", "P03"]) == 2
    assert "expected a table [session.form], but found none" in capsys.readouterr().err


def test_answers_stand_beside_what_others_wrote(study):
    study.data.mkdir()
    (study.data / "participants.tsv").write_text('participant_id\tgroup\nsub-P01\tA, "q\n')
    (study.data / "participants.json").write_text('{"group": {"Description": "Group."}}')
    form = study.session.form
    assert not is_answered(study.data, "P03", form)
    store_answers(study.data, "P03", form, {"age": "43.2187", "handedness": "n/a"})
    table = 'participant_id\tgroup\tage\thandedness\nsub-P01\tA, "q\tn/a\tn/a\nsub-P03\tn/a\t43.2187\tn/a\n'
    assert (study.data / "participants.tsv").read_text() == table
    told = json.loads((study.data / "participants.json").read_text())
    assert told["group"] == {"Description": "Group."}
    assert told["age"] == {"Description": "Age at the first visit.", "Units": "year"}
    assert told["handedness"]["Levels"] == {"sinister": "left", "dexter": "right"}
    assert is_answered(study.data, "P03", form)
    assert (study.data / "participants.tsv").stat().st_mode & 0o777 == 0o600
    (study.data / "participants.tsv").write_text(table + "sub-P03\tB\n")
    with pytest.raises(DataError, match=r"participants.tsv: expected one row each, but found sub-P03 twice"):
        store_answers(study.data, "P03", form, {"age": "1", "handedness": "n/a"})
    (study.data / "participants.tsv").write_text(table)
    (study.data / "participants.json").write_text("[]")
    with pytest.raises(DataError, match=r"participants.json: expected a JSON object"):
        store_answers(study.data, "P03", form, {"age": "43.2187", "handedness": "n/a"})


def test_answers_are_in_participants_tsv_and_nowhere_else(study, tmp_path, capsys):
    form = filled(tmp_path, ANSWERS)
    done = session.run(study, "P03", form=form, virtual=session.Virtual(seed=1))
    assert done.good
    form.unlink()
    text = study.path.read_text(encoding="utf-8")
    text = text.replace('ids = ["P01", "P03"]', 'file = "data/participants.tsv"')
    study.path.write_text(text.replace("sinister", "other"), encoding="utf-8")  # the word is of the form, too
    assert main(["run", str(study.path), "--jobs", "1"]) in (0, 1)
    assert main(["report", str(study.path), "--paper", "--out", str(tmp_path / "package"), "--jobs", "1"]) in (0, 1)
    said = "".join(capsys.readouterr())
    assert "43.2187" not in said
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    held = [path for path in files if b"43.2187" in path.read_bytes() or b"sinister" in path.read_bytes()]
    assert {path.name for path in held} == {"participants.tsv", "participants.json"}
    assert len(files) > 30


def test_a_number_has_all_its_digits(study, tmp_path):
    answers = read_form(filled(tmp_path, ANSWERS.replace("43.2187", "43.218712345")), study.session.form, "P03")
    assert answers["age"] == "43.218712345"


def test_a_band_above_half_the_rate_is_refused_before_the_first_press(study, tmp_path):
    about = replace(study.session.about, band_hz=(20.0, 2000.0))
    band = replace(study, session=replace(study.session, about=about))
    with pytest.raises(SettingError, match=r"about.band_hz: expected at most half the rate of the EMG, .* found 2000"):
        session.run(band, "P03", form=filled(tmp_path, ANSWERS), virtual=session.Virtual(seed=1))
