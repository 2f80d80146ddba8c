"""Deviations from a registered plan: each planted one is named, with what it touches, and nothing else is."""

from __future__ import annotations

import json
import random
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

from benchmarks.planted_deviations import PLANTS, Plant, RegisteredStudy, as_planted, harmless
from emg2vsa.claims import arithmetic
from emg2vsa.claims.claim import OF_A_STUDY, judge
from emg2vsa.pipeline import code
from emg2vsa.pipeline import registered as of_pipeline
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import Fingerprints
from emg2vsa.registration.deviations import CODE, TOUCHES
from emg2vsa.registration.plan import LEFT_OUT, _claims
from emg2vsa.session.open_session import folder_of, kept_settings
from emg2vsa.session.plan import PLAN_FILE, Plan, draw_presses, plan_bytes
from emg2vsa.settings import StageSettings
from emg2vsa.study_file import load_study


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
    real, edited = code.module_file, tmp_path / "fits.py"
    edited.write_text(Path(str(real("emg2vsa.fits"))).read_text() + "\nCERTAIN = 0.06\n")
    monkeypatch.setattr(code, "module_file", lambda name: str(edited) if name == "emg2vsa.fits" else real(name))
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
    assert found.state(judged["specimens_differ"]) == "registered"
    other = replace(judged["specimens_differ"], claim=replace(judged["specimens_differ"].claim, estimand="another"))
    assert found.state(other) == "registered, deviates: its estimand"
    new = replace(judged["curves"], claim=replace(judged["curves"].claim, key="mine"))
    assert found.state(new) == "not registered"
    study.add("fit", "bin_n = 0.6")
    assert study.found().state(judged["specimens_differ"]) == "registered, deviates: [fit] bin_n"
    assert study.found().state(judged["casr_rigid"]) == "registered"


def test_every_table_of_settings_says_what_hangs_on_it(study: RegisteredStudy) -> None:
    plan = json.loads(study.registration.read_text())["plan"]
    assert plan["tables"].keys() <= TOUCHES.keys()
    assert {each.name for each in fields(StageSettings)} - set(LEFT_OUT) <= plan["tables"].keys()
    assert plan.keys() - {"tables"} <= TOUCHES.keys()


# no deviation


def test_no_false_deviation_in_a_hundred_harmless_changes(study: RegisteredStudy) -> None:
    numbers = random.Random(33)
    for n in range(100):
        study = harmless(study, numbers)
        found = study.found()
        assert not found.deviations, (n, [str(each) for each in found.deviations])
