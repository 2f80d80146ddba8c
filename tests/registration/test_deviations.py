"""Deviations from a registered plan: each planted one is named, with what it touches, and nothing else is."""

from __future__ import annotations

import json
import random
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.planted_deviations import JUDGED, PLANTS, Plant, RegisteredStudy, as_planted, harmless
from emg2vsa import fits
from emg2vsa.claims import arithmetic
from emg2vsa.claims.claim import OF_A_STUDY, judge
from emg2vsa.cli import main
from emg2vsa.pipeline import code
from emg2vsa.pipeline import registered as of_pipeline
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import Fingerprints, state_of
from emg2vsa.registration.deviations import CODE, TOUCHES, _hang_on
from emg2vsa.registration.plan import LEFT_OUT, _claims
from emg2vsa.session.open_session import folder_of, kept_settings
from emg2vsa.session.plan import PLAN_FILE, Plan, draw_presses, plan_bytes
from emg2vsa.settings import StageSettings
from emg2vsa.study_file import load_study
from tests.small import study_of_files


@pytest.mark.parametrize(("plant", "what", "touched"), [each[1:] for each in PLANTS], ids=[each[0] for each in PLANTS])
def test_a_planted_deviation_is_named(study: RegisteredStudy, plant: Plant, what: str, touched: set[str]) -> None:
    plant(study)
    found = study.found().deviations
    said = [str(each) for each in found]
    assert as_planted({each.what for each in found}, what), said
    assert touched <= {key for each in found for key in each.claims}, said
    assert all(each.registered != each.now for each in found), said


def test_a_recording_that_is_missing_at_the_end(study: RegisteredStudy) -> None:
    for specimen in ("S1", "S2", "S3", "S4", "S5"):
        study.record("P13", specimen)
        study.record("P14", specimen)
    assert not study.found(final=True).deviations
    study.recording("P14", "S3").unlink()
    found = study.found(final=True)
    assert [each.what for each in found.deviations] == ["recording P14/S3"]
    assert study.found().awaited == ("P14/S3",)
    assert not study.found().deviations


def test_other_code_is_a_deviation_of_its_own_kind(study: RegisteredStudy, monkeypatch: pytest.MonkeyPatch) -> None:
    real = of_pipeline._code

    def other(code: Any) -> dict[str, Any]:
        now = real(code)
        return now | {"digest": "0" * 16, "parts": now["parts"] | {"fits": "0" * 16}}

    monkeypatch.setattr(of_pipeline, "_code", other)
    found = study.found()
    (one,) = found.deviations
    assert (one.kind, one.what) == ("code", "code of fits")
    assert "emg2vsa" in one.registered
    assert "specimens_differ" in one.claims
    assert "casr_rigid" not in one.claims
    assert not found.of_plan


def test_an_edited_module_changes_the_digest_of_what_imports_it(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    def parts() -> dict[str, str]:
        now: dict[str, str] = of_pipeline._code(Code(Fingerprints(tmp_path / "none.json")))["parts"]
        return now

    before = parts()
    real, edited = code._files_of, tmp_path / "fits.py"
    edited.write_text(Path(fits.__file__).read_text() + "\nCERTAIN = 0.06\n")

    def files_of(package: str) -> list[Any]:
        found = dict(real(package))
        if "emg2vsa.fits" in found:
            found["emg2vsa.fits"] = (str(edited), state_of(edited))
        return list(found.items())

    monkeypatch.setattr(code, "_files_of", files_of)
    changed = {name for name, value in parts().items() if value != before[name]}
    assert {"fits", "tests", "claims"} <= changed
    assert "presses" not in changed


@pytest.mark.parametrize("version", ["0.1", "absent"])
def test_another_library(study: RegisteredStudy, monkeypatch: pytest.MonkeyPatch, version: str) -> None:
    real = of_pipeline._code

    def other(code: Any) -> dict[str, Any]:
        now = real(code)
        return now | {"libraries": now["libraries"] | {"numpy": version}}

    monkeypatch.setattr(of_pipeline, "_code", other)
    named = [each.what for each in study.found().deviations]
    assert named == ([] if version == "absent" else ["library numpy"])


def test_another_python_tells_of_code_by_the_version_alone(
    study: RegisteredStudy, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = of_pipeline._code

    def other(code: Any, version: str = "") -> dict[str, Any]:
        now = real(code)
        libraries = now["libraries"] | {"python": "3.99"}
        return now | {"parts": dict.fromkeys(CODE, "0"), "libraries": libraries, "emg2vsa": version or now["emg2vsa"]}

    monkeypatch.setattr(of_pipeline, "_code", other)
    assert [each.what for each in study.found().deviations] == ["library python"]
    monkeypatch.setattr(of_pipeline, "_code", lambda code: other(code, "99"))
    assert len(study.found().deviations) == 2


def test_a_session_that_was_run_otherwise(study: RegisteredStudy) -> None:
    settings = load_study(study.file)
    assert settings.session is not None
    for seed, count in ((1, 0), (2, 1)):
        own = replace(settings, session=replace(settings.session, seed=seed))
        assert own.session is not None
        presses = draw_presses("palpation", "P13", ["S1", "S2"], own.session)
        plan = Plan("palpation", "P13", seed, "2026-01-05T09:00:00+00:00", presses, kept_settings(own))
        folder = folder_of(settings, "P13")
        folder.mkdir(parents=True, exist_ok=True)
        (folder / PLAN_FILE).write_bytes(plan_bytes(plan))
        found = study.found().deviations
        assert len(found) == count
    assert str(found[0]).startswith("session of P13, seed: 1 when registered, 2 now")
    (folder / PLAN_FILE).write_text("{")
    assert not study.found().deviations


def test_a_claim_whose_words_changed(study: RegisteredStudy, monkeypatch: pytest.MonkeyPatch) -> None:
    real = arithmetic._claim
    monkeypatch.setattr(arithmetic, "_claim", lambda key, says, *rest, **more: real(key, says + "!", *rest, **more))
    named = {each.what for each in study.found().deviations}
    assert "claim schedule_range, says" in named
    assert all(name.startswith("claim ") for name in named)


def test_a_verdict_says_how_it_was_registered(study: RegisteredStudy) -> None:
    settings = load_study(study.file)
    judged = {each.claim.key: each for each in judge(_claims(settings, None), 0.1, OF_A_STUDY)}
    found = study.found()
    assert found.state(judged["specimens_differ"]) == "registered after data"
    other = replace(judged["specimens_differ"], claim=replace(judged["specimens_differ"].claim, estimand="another"))
    assert found.state(other) == "registered after data, deviates: its estimand"
    new = replace(judged["curves"], claim=replace(judged["curves"].claim, key="mine"))
    assert found.state(new) == "not registered"
    study.add("fit", "bin_n = 0.6")
    assert study.found().state(judged["specimens_differ"]) == "registered after data, deviates: [fit] bin_n"
    assert study.found().state(judged["casr_rigid"]) == "registered after data"


def test_every_table_of_settings_says_what_hangs_on_it(study: RegisteredStudy) -> None:
    plan = json.loads(study.registration.read_text())["plan"]
    assert plan["tables"].keys() <= TOUCHES.keys()
    assert {each.name for each in fields(StageSettings)} - set(LEFT_OUT) <= plan["tables"].keys()
    assert plan.keys() - {"tables"} <= TOUCHES.keys()


def test_a_deviation_says_values_and_claims(study: RegisteredStudy) -> None:
    own = '[[recordings.files]]\nparticipant = "P13"\nspecimen = "S1"\nfilters.band_hz = [30.0, 400.0]\n'
    study.edit("[study]", f"{own}{JUDGED.format('exclude')}")
    judged, filters = study.found().deviations
    assert (filters.registered, filters.now) == ("absent", "{band_hz = [30.0, 400.0]}")
    assert (judged.what, judged.now) == ("P03/S2, press 4", '"rejected by hand: coughed"')
    names, more = ", ".join(filters.claims[:5]), len(filters.claims) - 5
    assert str(filters).endswith(f"; may touch {more + 5} claims ({names} and {more} more)")


@pytest.mark.parametrize(
    ("table", "touched"),
    [
        ("filters", {"specimens_differ", "curves"}),
        ("profile", {"interpolation_rmse", "interpolation_weight", "human_like_contrast"}),
        ("schedule", {"schedule_range", "human_like_contrast"}),
        ("hypotheses", {"specimens_differ"}),
    ],
)
def test_claims_on_settings_are_touched_by_their_own(study: RegisteredStudy, table: str, touched: set[str]) -> None:
    of = json.loads(study.registration.read_text())
    found = {*_hang_on(of, TOUCHES[table])}
    assert touched <= found
    others = {"power", "plate_r2", "force_filter", "curves", "interpolation_weight", "schedule_range"} - touched
    assert not others & found
    assert of["claims"].keys() >= others | touched


# which file a recording is


def registered_files(folder: Path, pattern: str, *names: str, more: str = "") -> RegisteredStudy:
    """P01 and P02 on S1, of whom some files are there."""
    study = RegisteredStudy(folder)
    study.file.write_text(study_of_files(pattern, participants=["P01", "P02"]) + more)
    for name in names:
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_text(name)
    load_study(study.file).results.mkdir(parents=True, exist_ok=True)
    assert main(["register", str(study.file), "--json"]) == 0
    return study


def named(study: RegisteredStudy) -> list[tuple[str, str, str]]:
    return [(each.what, each.registered, each.now) for each in study.found().deviations]


def test_another_pattern_is_one_deviation(tmp_path: Path) -> None:
    study = registered_files(tmp_path, "raw/{participant}_{specimen}.csv")
    study.edit("_{specimen}.csv", "_{specimen}_retake.csv")
    assert named(study) == [
        ("recording P01/S1 and 1 more, files", '["raw/P01_S1.csv"]', '["raw/P01_S1_retake.csv"]')
    ]  # fmt: skip


def test_a_file_of_another_person_is_named(tmp_path: Path) -> None:
    study = registered_files(tmp_path, "raw/{participant}_{specimen}.csv")
    study.add("[recordings.files]", 'participant = "P01"\nspecimen = "S1"\nemg = "raw/P02_S1.csv"')
    assert named(study) == [("recording P01/S1, files", '["raw/P01_S1.csv"]', '["raw/P02_S1.csv"]')]


@pytest.mark.parametrize(
    ("files", "other"), [("raw/P02_1.csv", "raw/P02_1.csv"), ("raw/P02_1.csv", "raw/P01_1.csv")], ids=["own", "shared"]
)
def test_a_recording_that_is_listed_later_has_a_file_of_its_own(tmp_path: Path, files: str, other: str) -> None:
    listed = '[[recordings.files]]\nparticipant = "{}"\nspecimen = "S1"\nemg = "{}"\n'
    study = registered_files(tmp_path, "{participant}")
    study.registration.unlink()
    study.registration.with_suffix(".md").unlink()
    study.edit('layout = "pattern"\npattern = "{participant}"', 'layout = "files"')
    study.file.write_text(study.file.read_text() + listed.format("P01", "raw/P01_1.csv"))
    assert main(["register", str(study.file), "--json"]) == 0
    study.file.write_text(study.file.read_text() + listed.format("P02", other))
    assert [what for what, *_ in named(study)] == ([] if other == files else ["recording P02/S1"])


@pytest.mark.parametrize(
    ("pattern", "before", "after", "count"),
    [
        ("raw/{participant}_{specimen}_*.csv", [], ["raw/P01_S1_0105.csv"], 0),
        ("raw/{participant}_{specimen}_*.csv", ["raw/P01_S1_0105.csv"], ["raw/P02_S1_0106.csv"], 0),
        ("raw/{participant}/{specimen}_{repetition}.csv", [], ["raw/P01/S1_1.csv", "raw/P01/S1_2.csv"], 0),
        ("raw/{participant}/{specimen}_{repetition}.csv", ["raw/P01/S1_1.csv"], ["raw/P01/S1_2.csv"], 0),
        ("raw/{participant}/{specimen}_{repetition}.csv", ["raw/P01/S1_2.csv"], ["raw/P01/S1_1.csv"], 2),
    ],
)
def test_files_that_are_found_later_are_the_planned_ones(
    tmp_path: Path, pattern: str, before: list[str], after: list[str], count: int
) -> None:
    """But one that comes before what was registered is not."""
    study = registered_files(tmp_path, pattern, *before)
    for name in after:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("new")
    assert len(named(study)) == count
    for name in after:
        (tmp_path / name).unlink()
    assert named(study) == []


def test_a_planned_recording_may_come_in_numbered_runs(study: RegisteredStudy) -> None:
    single = study.recording("P13")
    runs = [single.with_name(single.name.replace("_emg.", f"_run-{n}_emg.")) for n in ("01", "02")]
    runs[0].parent.mkdir(parents=True)
    for run in runs:
        run.write_text(run.name)
    assert study.found().deviations == ()
    listed = f'participant = "P13"\nspecimen = "S1"\nemg = "{runs[1].relative_to(study.folder).as_posix()}"'
    study.add("[recordings.files]", listed)
    assert [each.what for each in study.found().deviations] == ["recording P13/S1, files"]


@pytest.mark.parametrize("absolute", [True, False])
def test_recordings_outside_of_the_folder_may_move(tmp_path: Path, absolute: bool) -> None:
    (tmp_path / "study").mkdir()
    place = (tmp_path / "recordings").as_posix() if absolute else "../recordings"
    study = registered_files(
        tmp_path / "study", f"{place}/{{participant}}/{{specimen}}.csv", "../recordings/P01/S1.csv"
    )
    assert str(tmp_path) not in study.registration.read_text()
    (tmp_path / "recordings").rename(tmp_path / "archive")
    study.edit("recordings/{", "archive/{")
    assert named(study) == []
    study.edit("{participant}/{specimen}", "{participant}/{specimen}_2")
    assert len(named(study)) == 2


# no deviation


def test_no_false_deviation_in_a_hundred_harmless_changes(study: RegisteredStudy) -> None:
    numbers = random.Random(33)
    for n in range(100):
        study = harmless(study, numbers)
        found = study.found()
        assert not found.deviations, (n, [str(each) for each in found.deviations])
