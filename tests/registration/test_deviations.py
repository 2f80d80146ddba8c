"""Deviations from a registered plan: each planted one is named, with what it touches, and nothing else is."""

from __future__ import annotations

import json
import random
import re
import shutil
from collections.abc import Callable
from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import pytest

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
from tests.registration.conftest import RegisteredStudy

Plant = Callable[[RegisteredStudy], None]


def line(table: str, text: str) -> Plant:
    return lambda study: study.add(table, text)


def swap(old: str, new: str, name: str = "study.toml") -> Plant:
    return lambda study: study.edit(old, new, name)


def both(*plants: Plant) -> Plant:
    def plant(study: RegisteredStudy) -> None:
        for each in plants:
            each(study)

    return plant


JUDGED = '[[{}]]\nparticipant = "P03"\nspecimen = "S2"\nrepetition = 4\nreason = "coughed"\n\n[study]'
S4 = '[[specimens]]\nname = "S4"\nstiffness_n_per_mm = 3.12\n\n'
S5 = '[[specimens]]\nname = "S5"\nstiffness_n_per_mm = 1.11\n'
WITHOUT_S4 = both(swap(S4, ""), swap(", S4 = 27e-6", ""), swap(", S4 = 12.5e-6", ""))
WITH_S6 = both(
    swap(S5, S5 + '\n[[specimens]]\nname = "S6"\n'),
    swap("S5 = 16e-6", "S5 = 16e-6, S6 = 1e-6"),
    swap("S5 = 7e-6", "S5 = 7e-6, S6 = 1e-6"),
)

PEOPLE = {"specimens_differ", "equal_participants", "log_fit_r2"}
RIG = {"casr_rigid", "human_like_contrast", "kappa_error_rigid"}
KAPPA = {"kappa_error_rigid"}
PLANTS: list[tuple[str, Plant, str, set[str]]] = [
    ("margin of the slope", line("claims", "slope_percent = 30.0"), "[claims] slope_percent", {"specimens_differ"}),
    ("false verdicts", line("claims", "false_verdict_percent = 25"), "[claims] false_verdict_percent", PEOPLE | RIG),
    ("alpha", line("hypotheses", "alpha = 0.1"), "[hypotheses] alpha", PEOPLE),
    ("verdicts that count", line("hypotheses", 'use = "ok"'), "[hypotheses] use", PEOPLE),
    ("force window", swap("force_n = [0.5, 7.0]", "force_n = [1.0, 6.0]"), "[window] force_n", PEOPLE),
    ("shortest press", line("window", "min_duration_s = 0.2"), "[window] min_duration_s", PEOPLE),
    ("presses asked", both(swap("expected_trials = 10", "expected_trials = 8"), line("session", "repetitions = 8")),
     "[window] expected_trials; [session] repetitions", PEOPLE),
    ("bins", line("fit", "bin_n = 0.6"), "[fit] bin_n", PEOPLE),
    ("weights of the law", line("fit", 'weights = "none"'), "[fit] weights", PEOPLE),
    ("points of the fit", line("fit", 'points = "samples"'), "[fit] points", PEOPLE),
    ("least R²", line("fit", "min_adj_r2 = 0.5"), "[fit] min_adj_r2", PEOPLE),
    ("index", line("cocontraction", 'index = "minimum"'), "[cocontraction] index", PEOPLE),
    ("band", line("filters", "band_hz = [20.0, 400.0]"), "[filters] band_hz", PEOPLE),
    ("sign of the force", swap("sign = -1", "sign = 1"), "recording P01/S1 and 69 more, channels.force.sign", PEOPLE),
    ("muscle", swap('name = "FDS"', 'name = "FCR"'), "recording P01/S1 and 69 more, channels.emg.FDS.name", PEOPLE),
    ("stiffness", swap("stiffness_n_per_mm = 3.12", "stiffness_n_per_mm = 2.12"), "specimen S4, stiffness_n_per_mm",
     PEOPLE | RIG),
    ("specimen added", WITH_S6, "specimen S6", PEOPLE),
    ("specimen removed", WITHOUT_S4, "specimen S4", PEOPLE),
    ("specimens in another order", both(swap(S4, ""), swap(S5, S5 + "\n" + S4)),
     "order of [[specimens]], from which orders of pressing are drawn", PEOPLE),
    ("participant added", swap('"P14"', '"P14", "P15"'), "participant P15", PEOPLE),
    ("participant removed", swap('"P01", ', ""), "participant P01", PEOPLE),
    ("order of pressing", line("session", 'order = "listed"'), "[session] order", PEOPLE),
    ("seed of pressing", line("session", "seed = 2"), "[session] seed", PEOPLE),
    ("pause of a session", line("session", "rest_s = 0.5"), "[session] rest_s", PEOPLE),
    ("seed of the runs", swap("[experiment]\n", "[experiment]\nseed = 3\n", "rig.toml"), "rig file, [experiment] seed",
     RIG),
    ("mountings", swap("mountings = 3", "mountings = 5", "rig.toml"), "rig file, [experiment] mountings", RIG),
    ("largest force of the rig", swap("f_max_n = 7.0", "f_max_n = 6.0", "rig.toml"),
     "rig file, [experiment] f_max_n", RIG),
    ("SD between mountings", line("calibration", "mounting_sd_percent = 1.0"), "[calibration] mounting_sd_percent",
     RIG),
    ("algorithm", line("runs", 'algorithm = "hexagon"'), "[runs] algorithm", RIG),
    ("rate rule", both(line("runs", 'algorithm = "hexagon"'), line("runs", 'rate = "slope"')),
     "[runs] algorithm; [runs] rate", RIG),
    ("law of kappa", line("calibration", 'law = "power"'), "[calibration] law", KAPPA),
    ("range of schedules", swap("[20.0, 80.0]", "[10.0, 90.0]"), "[schedule] stiffness_percent", RIG),
    ("specimens that are kept", swap('kept_specimens = ["S1", "S3", "S5"]', 'kept_specimens = ["S1", "S5"]'),
     "[hypotheses] kept_specimens", PEOPLE),
    ("stiffness of the new specimen", swap("new_stiffness_n_per_mm = 5.32", "new_stiffness_n_per_mm = 4.0"),
     "[profile] new_stiffness_n_per_mm", PEOPLE | RIG),
    ("mode", swap('mode = "default"', 'mode = "paper"'), "[study] mode", PEOPLE | RIG),
    ("press rejected by hand", swap("[study]", JUDGED.format("exclude")), "P03/S2, press 4", PEOPLE),
    ("press accepted by hand", swap("[study]", JUDGED.format("accept")), "P03/S2, press 4", PEOPLE),
    ("recording replaced", lambda study: study.recording("P02").write_text("another"), "recording P02/S1", PEOPLE),
    ("recording removed", lambda study: study.recording("P02").unlink(), "recording P02/S1", PEOPLE),
]  # fmt: skip


@pytest.mark.parametrize(("plant", "what", "touched"), [each[1:] for each in PLANTS], ids=[each[0] for each in PLANTS])
def test_a_planted_deviation_is_named(study: RegisteredStudy, plant: Plant, what: str, touched: set[str]) -> None:
    plant(study)
    found = study.found().deviations
    said = [str(each) for each in found]
    named = {each.what for each in found}
    assert named == set(what.split("; ")) or (what == "[study] mode" and what in named), said
    assert touched <= {key for each in found for key in each.claims}, said
    assert all(each.registered != each.now for each in found), said


def test_thirty_are_planted() -> None:
    assert len(PLANTS) + 5 >= 30 + 5  # and those below: missing at the end, code, library, session, file


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


def shuffled_tables(text: str, numbers: random.Random) -> str:
    """The tables in another order, and the keys of each; comments go, blanks come."""
    head, *tables = re.split(r"\n(?=\[)", re.sub(r"(?m)^#.*\n|(?<=[\]\d}\"]) #.*$", "", text))
    arrays = [table for table in tables if table.startswith("[[")]  # their order counts
    others = []
    for table in (table for table in tables if not table.startswith("[[")):
        name, *lines = filter(None, table.split("\n"))
        numbers.shuffle(lines)
        others.append("\n".join([name, *lines]))
    numbers.shuffle(others)
    at = numbers.randrange(len(others) + 1)
    return "\n\n".join([head, *others[:at], *arrays, *others[at:]]) + "\n" * numbers.randrange(3)


def harmless(study: RegisteredStudy, numbers: random.Random) -> RegisteredStudy:
    """One of many things that change no plan."""
    n = numbers.randrange(10**6)
    edits: list[Callable[[], object]] = [
        lambda: study.file.write_text(shuffled_tables(study.file.read_text(), numbers)),
        lambda: study.file.write_text(study.file.read_text().replace("\n", "\r\n")),
        lambda: study.edit("[study]", f"# looked at {n} times\n[study]"),
        lambda: study.edit("7.0]", "7]") if "7.0]" in study.file.read_text() else None,
        lambda: study.edit("# ", f"# {n} ", "rig.toml"),
        lambda: study.edit('title = "', f'title = "{n} '),
        lambda: study.record(numbers.choice(["P13", "P14"]), numbers.choice(["S1", "S2", "S3", "S4", "S5"])),
        lambda: (study.folder / "data" / f"notes-{n}.txt").write_text("windy"),
        lambda: (
            study.add("reading", f"max_seconds = {10 + n % 99}") if "[reading]" not in study.file.read_text() else None
        ),
        lambda: study.edit("seed = 20260105", f"seed = {n}") if "seed = 20260105" in study.file.read_text() else None,
        lambda: study.add("session", f'texts.wait = "{n}"') if "texts.wait" not in study.file.read_text() else None,
        lambda: (
            study.edit('# port = "/dev/ttyUSB0"', 'port = "/dev/ttyUSB7"', "rig.toml")
            if "ttyUSB0" in (study.folder / "rig.toml").read_text()
            else None
        ),
        lambda: shutil.rmtree(study.folder / ".emg2vsa", ignore_errors=True) if n % 50 == 0 else None,
        lambda: study.registration.write_bytes(study.registration.read_bytes()),
    ]
    numbers.choice(edits)()
    if n % 3:
        return study
    place = study.folder.parent / f"moved-{n}"
    return RegisteredStudy(Path((shutil.move if n % 2 else shutil.copytree)(study.folder, place)))


def test_no_false_deviation_in_a_hundred_harmless_changes(study: RegisteredStudy) -> None:
    numbers = random.Random(33)
    for n in range(100):
        study = harmless(study, numbers)
        found = study.found()
        assert not found.deviations, (n, [str(each) for each in found.deviations])
