"""The file of a registration: signed, never overwritten, and refused where it is not as it was written."""

from __future__ import annotations

import hashlib
import json
import multiprocessing
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from benchmarks.planted_deviations import RegisteredStudy
from casr.atomic import write_new
from emg2vsa.cli import main
from emg2vsa.errors import DataError
from emg2vsa.registration.document import _sha256, _signed, read_registration, write_registration

Edit = Callable[[dict[str, Any]], object]


def content_of(study: RegisteredStudy) -> dict[str, Any]:
    content: dict[str, Any] = json.loads(study.registration.read_text())
    return content


def refused(study: RegisteredStudy, name: str = "palpation") -> str:
    with pytest.raises(DataError) as error:
        read_registration(study.registration, name)
    return str(error.value)


def test_it_reads_back_as_it_was_written(study: RegisteredStudy) -> None:
    content = content_of(study)
    assert read_registration(study.registration, "palpation") == content
    study.registration.write_text(json.dumps(content))  # other blanks, other order
    assert read_registration(study.registration, "palpation") == content
    assert list(content) == sorted(content)
    assert content["claims"]["specimens_differ"]["margin"] == 10.0
    assert content["plan"]["tables"]["claims"]["slope_percent"] == 10.0
    assert content["collected"] == "60 of 70 planned recordings were there."
    assert str(study.folder.parent) not in study.registration.read_text()


def test_the_hash_is_of_json_with_sorted_keys_and_no_blanks() -> None:
    assert _sha256({"b": 1.5, "a": "κ"}) == hashlib.sha256('{"a":"κ","b":1.5}'.encode()).hexdigest()


@pytest.mark.parametrize("value", [0.1, 1 / 3, 1e-300, 4.3, 12345678901234567890.0])
def test_numbers_keep_every_digit(value: float) -> None:
    assert json.loads(json.dumps(_signed({"value": value})))["value"] == value


EDITS: list[tuple[Edit, str]] = [
    (lambda of: of["plan"]["tables"]["claims"].update(slope_percent=50.0), "edited: plan"),
    (lambda of: of["claims"]["specimens_differ"].update(margin=50.0), "edited: claims"),
    (lambda of: of["claims"].pop("specimens_differ"), "edited: claims"),
    (lambda of: of.update(registered_at="2020-01-01T00:00:00+00:00"), "edited: registered_at"),
    (lambda of: of["osf"].update(Other=""), "edited: osf"),
    (lambda of: of.update(sha256="0" * 64), "that SHA-256 000000000000 signs"),
    (lambda of: of["sha256_of"].update(plan="0" * 64), "edited: plan"),
    (lambda of: of.update(sha256_of=3), "edited: form"),
    (lambda of: of.pop("claims"), "but found no claims"),
    (lambda of: of.pop("sha256"), "but found no sha256"),
    (lambda of: of.update(note="mine"), "note besides"),
    (lambda of: of.update(form="emg2vsa registration 2"), "'emg2vsa registration 2'"),
    (lambda of: of.pop("form"), "another file"),
]


@pytest.mark.parametrize(("edit", "said"), EDITS, ids=range(len(EDITS)))
def test_an_edited_file_is_refused_with_what_differs(study: RegisteredStudy, edit: Edit, said: str) -> None:
    content = content_of(study)
    edit(content)
    study.registration.write_text(json.dumps(content))
    assert said in refused(study)
    assert main(["run", str(study.file), "--only", "fits"]) == 2


def test_a_signed_file_with_other_values_is_refused(study: RegisteredStudy) -> None:
    content = {name: value for name, value in content_of(study).items() if name not in ("sha256", "sha256_of")}
    study.registration.write_text(json.dumps(_signed(content | {"claims": []})))
    assert "other values of claims" in refused(study)


@pytest.mark.parametrize("text", ["", "{", "[]", "null", "3", "\x00", "[" * 100_000])
def test_what_is_no_registration_is_refused(study: RegisteredStudy, text: str) -> None:
    study.registration.write_text(text)
    assert "registration" in refused(study)


def test_a_file_that_was_cut_off_is_refused(study: RegisteredStudy) -> None:
    data = study.registration.read_bytes()
    for end in range(0, len(data) - 2, len(data) // 40):
        study.registration.write_bytes(data[:end])
        assert "JSON" in refused(study)
    study.registration.write_bytes(b"\xff" + data)
    assert "JSON" in refused(study)


@pytest.mark.parametrize(
    ("old", "new"), [('"amends"', '"amends": "mine",\n "amends"'), ('"margin"', '"margin": 1, "margin"')]
)
def test_a_key_that_stands_twice_is_refused(study: RegisteredStudy, old: str, new: str) -> None:
    study.edit(old, new, "registration.json")
    assert f"(the key {old.strip(chr(34))!r} twice)" in refused(study)


def test_the_text_of_another_registration_is_refused(study: RegisteredStudy) -> None:
    text = study.registration.with_suffix(".md")
    text.write_text(text.read_text().replace(content_of(study)["sha256"], "0" * 64))
    assert "registration.md: expected the text of registration.json, SHA-256" in refused(study)
    text.unlink()
    assert read_registration(study.registration, "palpation")


def test_the_registration_of_another_study_is_refused(study: RegisteredStudy) -> None:
    assert "expected the registration of the study 'other', but found that of 'palpation'" in refused(study, "other")


def test_nothing_is_overwritten(study: RegisteredStudy, capsys: pytest.CaptureFixture[str]) -> None:
    before = {path: path.read_bytes() for path in study.folder.glob("registration.*")}
    assert len(before) == 2
    assert main(["register", str(study.file)]) == 2
    assert "expected a name for a new registration, but found a file" in capsys.readouterr().err
    study.registration.unlink()  # the text alone
    assert main(["register", str(study.file)]) == 2
    assert study.registration.with_suffix(".md").read_bytes() == before[study.registration.with_suffix(".md")]


def _try_to_write(path: Path, go: Any, written: Any) -> None:
    go.wait()
    said: dict[str, Any] = {"title": "a", "registered_at": str(os.getpid()), "amends": ""}
    try:
        write_registration(path, _signed(said | {name: {} for name in ("aspredicted", "osf", "claims")}))
        written.put(os.getpid())
    except DataError:
        written.put(0)


def test_of_two_processes_one_writes_and_the_other_is_refused(tmp_path: Path) -> None:
    several = multiprocessing.get_context("fork")
    go, written = several.Event(), several.Queue()
    path = tmp_path / "registration.json"
    processes = [several.Process(target=_try_to_write, args=(path, go, written)) for _ in range(6)]
    for process in processes:
        process.start()
    go.set()
    told = [written.get(timeout=30) for _ in processes]
    for process in processes:
        process.join()
    (winner,) = filter(None, told)
    assert json.loads(path.read_text())["registered_at"] == str(winner)
    assert sorted(each.name for each in tmp_path.iterdir()) == ["registration.json", "registration.md"]


def test_a_new_file_on_a_disk_without_hard_links(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def no_links(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "link", no_links)
    write_new(tmp_path / "file", b"data")
    assert (tmp_path / "file").read_bytes() == b"data"
    with pytest.raises(FileExistsError):
        write_new(tmp_path / "file", b"other")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_the_text_answers_both_forms(study: RegisteredStudy) -> None:
    text, content = study.registration.with_suffix(".md").read_text(), content_of(study)
    assert [question[:2] for question in content["aspredicted"]] == [f"{n})" for n in range(1, 9)]
    for heading in ("Study information", "Design plan", "Sampling plan", "Variables", "Analysis plan", "Other"):
        assert f"## OSF: {heading}\n\n{content['osf'][heading]}" in text
    for said in (
        content["sha256"], "60 of 70 planned recordings were there.", "14 people press S1, S2, S3, S4, S5, 10 times",
        "3 mountings of 3 presses each", "rises from 0.5 to 7 N", "seed 1", "Power for repetitions, f = 0.25", "99.2",
    ):  # fmt: skip
        assert said in text, said
    assert all(answer for answer in (content["aspredicted"] | content["osf"]).values())
