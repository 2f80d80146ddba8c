"""``emg2vsa verify`` finds what was changed in a package or its data, and nothing else."""

from __future__ import annotations

import contextlib
import csv
import hashlib
import io
import json
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from emg2vsa.cli import main
from emg2vsa.deposit import verification
from emg2vsa.deposit.crate import METADATA
from tests.once import Once

Verify = Callable[..., tuple[int, dict[str, Any]]]
DATA = "data/sub-P01/emg/sub-P01_task-palpation_acq-S1_emg.bdf"


@pytest.fixture(scope="module")
def published(packaged_once: Path) -> Path:
    """A package beside its study; copied, never changed."""
    return packaged_once / "reports" / "small" / "paper"


@pytest.fixture(scope="module")
def untouched(published: Path, built_once: Once) -> tuple[Path, str]:
    """The report that the package's study gives, recomputed once for all tests, and what the command said of it."""

    def build(folder: Path) -> None:
        root = published.parents[2]
        before = {path: path.stat().st_mtime_ns for path in root.rglob("*")}
        with contextlib.redirect_stdout(io.StringIO()) as said:
            assert main(["verify", str(published), "--work", str(folder / "work"), "--jobs", "1"]) == 0
        assert {path: path.stat().st_mtime_ns for path in root.rglob("*")} == before
        (folder / "said.txt").write_text(said.getvalue())

    folder = built_once("recomputed", build)
    return next((folder / "work").iterdir()) / "report", (folder / "said.txt").read_text()


@pytest.fixture
def package(published: Path, tmp_path: Path) -> Path:
    """A copy of the package, to be changed."""
    return Path(shutil.copytree(published, tmp_path / "paper"))


@pytest.fixture
def study_folder(published: Path) -> Path:
    return published.parents[2] / "studies" / "small"


@pytest.fixture
def verify(
    untouched: tuple[Path, str], study_folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> Verify:
    """Exit status and JSON of a verification whose data give what they gave before: nothing is run."""
    monkeypatch.setattr(verification, "recompute", lambda *_: untouched[0])

    def run(package: Path, *options: str) -> tuple[int, dict[str, Any]]:
        capsys.readouterr()
        status = main(["verify", str(package), "--data", str(study_folder), "--json", *options])
        return status, json.loads(capsys.readouterr().out)

    return run


def change(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))


def forge(package: Path) -> None:
    """Make the manifest and the archive say what the files now hold, as somebody would who hides a change."""
    crate = json.loads((package / METADATA).read_text())
    for entity in crate["@graph"]:
        if entity["@type"] == "File":
            entity["sha256"] = hashlib.sha256((package / entity["name"]).read_bytes()).hexdigest()
    (package / METADATA).write_text(json.dumps(crate))
    (package / "supplement.zip").unlink()


def set_value(package: Path, key: str, value: object) -> None:
    results = json.loads((package / "results.json").read_text())
    assert key in results
    (package / "results.json").write_text(json.dumps(results | {key: value}))


def test_an_untouched_package_verifies_and_nothing_beside_it_changes(
    published: Path, untouched: tuple[Path, str]
) -> None:
    count = len(json.loads((published / "results.json").read_text()))
    assert f"Numbers: {count} equal, 0 within tolerance, 0 differ, 0 not checked" in untouched[1]
    assert untouched[1].endswith("Verified.\n")


def test_the_archive_verifies_too(published: Path, verify: Verify) -> None:
    status, found = verify(published / "supplement.zip")
    assert (status, found["files"]) == (0, [])


def test_a_number_that_was_changed(package: Path, verify: Verify) -> None:
    before = json.loads((package / "results.json").read_text())["fit.S1.b_v.mean"]
    set_value(package, "fit.S1.b_v.mean", before * 1.001)
    status, found = verify(package)
    assert status == 1
    assert {each["file"] for each in found["files"]} == {"results.json", "supplement.zip: results.json"}
    (one,) = found["numbers"]["differ"]
    assert (one["where"], one["recomputed"]) == ("fit.S1.b_v.mean", before)
    assert one["relative"] == pytest.approx(1e-3, rel=1e-2)
    assert {each["where"].partition(":")[0] for each in found["restated"]} == {"results.csv", "numbers.tex"}


def test_a_number_within_the_tolerance_is_counted(package: Path, verify: Verify) -> None:
    before = json.loads((package / "results.json").read_text())["fit.S1.b_v.mean"]
    set_value(package, "fit.S1.b_v.mean", before * (1 + 1e-13))
    forge(package)
    _, found = verify(package)
    assert (found["numbers"]["within_tolerance"], found["numbers"]["differ"]) == (1, [])


@pytest.mark.parametrize("value", [None, "0", True, 0])
def test_a_number_of_another_kind(package: Path, verify: Verify, value: object) -> None:
    set_value(package, "fit.S1.b_v.mean", value)
    forge(package)
    status, found = verify(package)
    assert (status, [each["where"] for each in found["numbers"]["differ"]]) == (1, ["fit.S1.b_v.mean"])


def test_a_key_that_vanished_and_one_that_was_added(package: Path, verify: Verify) -> None:
    results = json.loads((package / "results.json").read_text())
    del results["fit.S1.b_v.mean"]
    (package / "results.json").write_text(json.dumps(results | {"fit.S9.b_v.mean": 1.0}))
    forge(package)
    status, found = verify(package)
    said = {each["where"]: (each["published"], each["recomputed"]) for each in found["numbers"]["differ"]}
    assert status == 1
    assert said.keys() == {"fit.S1.b_v.mean", "fit.S9.b_v.mean"}
    assert said["fit.S1.b_v.mean"][0] == said["fit.S9.b_v.mean"][1] == "nothing"


def test_a_table_cell_alone(package: Path, verify: Verify) -> None:
    table = package / "tables" / "fits.csv"
    first = next(csv.DictReader(table.open()))
    change(table, first["b_v"], str(float(first["b_v"]) * 1.0001))
    forge(package)
    status, found = verify(package)
    assert status == 1
    assert [each["where"] for each in found["lines"]["differ"]] == ["tables/fits.csv, line 2"]


@pytest.mark.parametrize("name", ["tables/profiles.tex", "schedules/S1_modular.csv", "statements.tex"])
def test_a_digit_of_another_file_alone(package: Path, verify: Verify, name: str) -> None:
    text = (package / name).read_text()
    places = [i for i in range(len(text)) if text[i].isdigit()]
    place = places[-1] if name.endswith(".tex") else text.rstrip().rindex("\n") + 1  # the first of many digits
    (package / name).write_text(text[:place] + str((int(text[place]) + 1) % 10) + text[place + 1 :])
    forge(package)
    status, found = verify(package)
    assert (status, len(found["lines"]["differ"])) == (1, 1)
    assert found["lines"]["differ"][0]["where"].startswith(name)


def test_a_macro_alone(package: Path, verify: Verify) -> None:
    line = next(row for row in (package / "numbers.tex").read_text().splitlines() if "FitSOneBVMean}" in row)
    change(package / "numbers.tex", line, line.replace("emgquantity{", "emgquantity{9"))
    forge(package)
    status, found = verify(package)
    assert (status, [each["where"] for each in found["restated"]]) == (1, [r"numbers.tex: \emgFitSOneBVMean"])


def test_missing_and_added_files(package: Path, verify: Verify) -> None:
    (package / "methods.txt").unlink()
    (package / "tables" / "mine.csv").write_text("a\n1\n")
    status, found = verify(package)
    assert status == 1
    assert {(each["file"], each["found"]) for each in found["files"]} == {
        ("methods.txt", "missing"), ("tables/mine.csv", "not in the manifest"),
    }  # fmt: skip


def test_a_manifest_that_was_changed_alone(package: Path, verify: Verify) -> None:
    change(package / METADATA, '"contentSize": "', '"contentSize": "1')
    status, found = verify(package)
    assert (status, found["files"][0]["file"]) == (1, f"supplement.zip: {METADATA}")


@pytest.mark.slow  # everything is computed from the changed data
def test_data_that_were_changed_are_named_and_what_follows_differs(
    package: Path, study_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = Path(shutil.copytree(study_folder, tmp_path / "data"))
    recording = bytearray((folder / DATA).read_bytes())
    recording[-600:-300] = bytes(300)
    (folder / DATA).write_bytes(recording)
    assert main(["verify", str(package), "--data", str(folder), "--jobs", "1", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["data"]["changed"] == [DATA]
    assert any(each["where"].startswith("fit.S1.") for each in found["numbers"]["differ"])


def test_numbers_of_a_missing_recording_are_not_checked(
    package: Path, study_folder: Path, tmp_path: Path, verify: Verify
) -> None:
    folder = Path(shutil.copytree(study_folder, tmp_path / "data"))
    (folder / DATA).unlink()
    status, found = verify(package, "--data", str(folder))
    assert status == 2
    assert found["data"]["missing"] == [DATA]
    assert "fit.S1.b_v.mean" in found["not_checked"]
    assert "fit.S3.b_v.mean" not in found["not_checked"]
    assert found["numbers"]["equal"] > 0


def test_a_package_without_data_cannot_be_verified(package: Path, tmp_path: Path, verify: Verify) -> None:
    status, found = verify(package, "--data", str(tmp_path))
    assert (status, found["numbers"]["equal"], found["files"]) == (2, 0, [])
    assert set(json.loads((package / "results.json").read_text())) <= set(found["not_checked"])
    set_value(package, "fit.S1.b_v.mean", 1.0)
    assert verify(package, "--data", str(tmp_path))[0] == 1


def test_only_some_keys(package: Path, verify: Verify) -> None:
    status, found = verify(package, "--keys", "fit.S1.*")
    keys = [key for key in json.loads((package / "results.json").read_text()) if key.startswith("fit.S1.")]
    assert (status, found["numbers"]["equal"]) == (0, len(keys))


@pytest.mark.usefixtures("verify")
def test_another_version_is_said_and_compared(
    package: Path, study_folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    ours = '"name": "emg2vsa",\n   "softwareVersion": "'
    change(package / METADATA, ours, f"{ours}0.0.")
    (package / "supplement.zip").unlink()
    assert main(["verify", str(package), "--data", str(study_folder)]) == 0
    assert "so methods may differ" in capsys.readouterr().out


def test_what_is_no_package_is_one_clear_line(
    package: Path, study_folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    whole = (package / "supplement.zip").read_bytes()
    (tmp_path / "cut.zip").write_bytes(whole[: len(whole) // 2])
    with zipfile.ZipFile(tmp_path / "other.zip", "w") as archive:
        archive.writestr("a.txt", "a")
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("text")
    broken = Path(shutil.copytree(package, tmp_path / "broken"))
    (broken / METADATA).write_text('{"@graph": []}')
    no_json = Path(shutil.copytree(package, tmp_path / "no_json"))
    (no_json / "results.json").write_text("{")
    bad_study = Path(shutil.copytree(package, tmp_path / "bad_study"))
    (bad_study / "study.toml").write_text("[study]\n")
    data = ["--data", str(study_folder)]
    for words in (
        [str(tmp_path / "cut.zip")], [str(tmp_path / "other.zip")], [str(tmp_path / "empty")], [str(tmp_path / "file")],
        [str(tmp_path / "absent")], [str(broken)], [str(no_json)], [str(bad_study), *data],
        [str(package), "--data", str(tmp_path / "absent")], [str(package), "--data", str(tmp_path / "file")],
        [str(package), "--keys", "no.such.*", *data], [str(package), "--work", str(tmp_path / "file"), *data],
        [str(package), "--work", str(package / "inside"), *data],
    ):  # fmt: skip
        capsys.readouterr()
        assert main(["verify", *words]) == 2, words
        said = capsys.readouterr()
        assert "expected" in said.err, words
        assert "Traceback" not in said.err
        assert not said.out
    with pytest.raises(SystemExit):
        main(["verify", str(package), "--jobs", "0"])


def test_a_package_beside_another_study(package: Path, study_folder: Path, tmp_path: Path, verify: Verify) -> None:
    other = Path(shutil.copytree(study_folder, tmp_path / "other"))
    for recording in other.rglob("*_emg.bdf"):
        recording.write_bytes(recording.read_bytes()[:-3] + b"\1\2\3")
    status, found = verify(package, "--data", str(other))
    assert status == 1
    assert len(found["data"]["changed"]) == 6
