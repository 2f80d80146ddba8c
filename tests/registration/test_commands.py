"""``emg2vsa register``, and what run, status, session, the report and verify say of a registered study."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from benchmarks.planted_deviations import RegisteredStudy
from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa import session
from emg2vsa.cli import main
from emg2vsa.deposit import verification
from emg2vsa.session.journal import JOURNAL_FILE, Told, read_journal
from emg2vsa.study_file import load_study
from tests.once import Once
from tests.small import run_all, study_of_files, study_of_runs

Said = pytest.CaptureFixture[str]


def told(capsys: Said, *words: str, status: int = 0) -> dict[str, Any]:
    capsys.readouterr()
    assert main([*words, "--json"]) == status
    said: dict[str, Any] = json.loads(capsys.readouterr().out)
    return said


@pytest.fixture
def finished(built_once: Once, tmp_path: Path) -> RegisteredStudy:
    """A small study with a rig that was registered, and run to its report."""
    folder = Path(shutil.copytree(built_once("finished", run_all), tmp_path / "copy")) / "studies" / "small"
    assert main(["register", str(folder / "study.toml"), "--json"]) == 0
    return RegisteredStudy(folder)


def results(study: RegisteredStudy) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((load_study(study.file).reports / "results.json").read_text())
    return found


def test_a_clean_run_names_nothing_and_every_verdict_is_registered(
    finished: RegisteredStudy, capsys: Said, blank_drawings: None
) -> None:
    run = told(capsys, "run", str(finished.file), "--jobs", "1")
    said, found = run["registration"], results(finished)
    assert (run["ran"], said["deviations"], said["awaited_runs"]) == (["report/study"], [], [])
    assert (found["registration.deviations"], found["registration.awaited_runs"]) == (0, 0)
    states = {value for key, value in found.items() if key.startswith("claims.") and key.endswith(".registered")}
    assert states == {"registered after data"}
    assert found["registration.sha256"] == json.loads(finished.registration.read_text())["sha256"]
    assert told(capsys, "run", str(finished.file), "--jobs", "1")["ran"] == []


def test_three_deviations_are_named_by_the_run_its_report_and_its_package(
    finished: RegisteredStudy, capsys: Said, monkeypatch: pytest.MonkeyPatch, blank_drawings: None
) -> None:
    finished.add("claims", "slope_percent = 30.0")
    finished.add("hypotheses", 'use = "ok+doubtful"')
    late = '[[exclude]]\nparticipant = "P01"\nspecimen = "S1"\nrepetition = 2\nreason = "late"\n'
    finished.edit("[study]", late + "[study]")
    assert main(["run", str(finished.file), "--jobs", "1"]) == 0
    said = capsys.readouterr().out
    assert "SHA-256" in said
    assert said.count("deviation: ") == 3
    for line in (
        "deviation: [claims] slope_percent: 10.0 when registered, 30.0 now; may touch ",
        "deviation: [hypotheses] use: ok when registered, ok+doubtful now; may touch ",
        'deviation: P01/S1, press 2: absent when registered, "rejected by hand: late" now; may touch ',
    ):
        assert line in said
    assert main(["status", str(finished.file)]) == 0
    assert capsys.readouterr().out.count("deviation: ") == 3
    assert len(told(capsys, "status", str(finished.file))["registration"]["deviations"]) == 3

    found, reports = results(finished), load_study(finished.file).reports
    assert found["registration.deviations"] == 3
    deviates = found["claims.specimens_differ.registered"]
    assert deviates == "registered after data, deviates: P01/S1, press 2; [claims] slope_percent; [hypotheses] use"
    assert found["claims.casr_rigid.registered"] == "registered after data"
    table = (reports / "tables" / "deviations.csv").read_text().splitlines()
    named = [row.partition(",")[0].strip('"') for row in table[1:]]
    assert named == ["P01/S1", "[claims] slope_percent", "[hypotheses] use"]
    page = (reports / "index.html").read_text()
    assert "The plan of this study was registered on" in page
    assert "Deviations from the registered plan" in page

    assert main(["report", str(finished.file), "--paper", "--jobs", "1", "-q"]) == 0
    package = reports / "paper"
    assert (package / "registration.json").read_bytes() == finished.registration.read_bytes()
    monkeypatch.setattr(verification, "recompute", lambda *_: reports)
    verified = told(capsys, "verify", str(package), "--data", str(finished.folder))
    assert [each["what"] for each in verified["registration"]["deviations"]] == [
        "P01/S1, press 2", "[claims] slope_percent", "[hypotheses] use",
    ]  # fmt: skip
    finished.recording("P02").unlink()
    finished.registration.unlink()  # that of the package counts
    verified = told(capsys, "verify", str(package), "--data", str(finished.folder), status=2)
    assert len(verified["registration"]["deviations"]) == 4
    content = json.loads((package / "registration.json").read_text())
    content["plan"]["tables"]["claims"]["slope_percent"] = 30.0
    (package / "registration.json").write_text(json.dumps(content))
    capsys.readouterr()
    assert main(["verify", str(package), "--data", str(finished.folder)]) == 2
    assert "(edited: plan)" in capsys.readouterr().err


def test_a_change_of_the_registration_makes_the_report_anew(
    finished: RegisteredStudy, capsys: Said, blank_drawings: None
) -> None:
    assert main(["run", str(finished.file), "--jobs", "1", "--json"]) == 0
    finished.registration.unlink()
    assert told(capsys, "run", str(finished.file), "--jobs", "1")["ran"] == ["report/study"]
    assert "registration.sha256" not in results(finished)


def test_a_second_registration_names_the_first(study: RegisteredStudy, capsys: Said) -> None:
    study.add("fit", "bin_n = 0.6")
    second = study.folder / "registration-2.json"
    assert main(["register", str(study.file), "--out", str(second)]) == 0
    assert 'under [study]: registration = "registration-2.json"' in capsys.readouterr().out
    first = json.loads(study.registration.read_text())["sha256"]
    assert json.loads(second.read_text())["amends"] == first
    assert first in second.with_suffix(".md").read_text()
    assert [each.what for each in study.found().deviations] == ["[fit] bin_n"]
    study.edit("[study]\n", '[study]\nregistration = "registration-2.json"\n')
    found = study.found()
    assert (found.deviations, found.amends, found.file) == ((), first, "registration-2.json")
    (was,) = found.from_amended
    assert was.startswith("registration.json, [fit] bin_n: 0.3 when registered, 0.6 now; may touch ")
    said = "\n".join(found.lines())
    assert f"registration-2.json, SHA-256 {found.sha256[:12]}, which amends {first[:12]}: no deviations" in said
    assert f"deviation from the plan that was amended: {was}" in said
    assert "Data when it was registered: 60 of 70 planned recordings were there." in said
    study.add("claims", "casr_percent = 3.0")
    assert main(["register", str(study.file), "--out", str(study.folder / "registration-3.json"), "--json"]) == 0
    study.edit("registration-2.json", "registration-3.json")
    assert [each.partition(":")[0] for each in study.found().from_amended] == [
        "registration-2.json, [claims] casr_percent",
        "registration.json, [claims] casr_percent",
        "registration.json, [fit] bin_n",
    ]
    (study.folder / "registration.json").unlink()
    assert len(study.found().from_amended) == 1
    assert main(["register", str(study.file)]) == 2


def test_a_registration_that_is_named_must_be_there(study: RegisteredStudy, capsys: Said) -> None:
    study.edit("[study]\n", '[study]\nregistration = "mine.json"\n')
    assert main(["run", str(study.file), "--only", "fits"]) == 2
    assert "mine.json: expected a registration, but found no such file." in capsys.readouterr().err
    assert main(["register", str(study.file), "--json"]) == 0
    first = json.loads(study.registration.read_text())["sha256"]
    assert json.loads((study.folder / "mine.json").read_text())["amends"] == first


def test_after_renaming_a_second_registration_amends_the_first(study: RegisteredStudy, capsys: Said) -> None:
    study.edit('name = "palpation"', 'name = "pressing"')
    second = study.folder / "registration-2.json"
    assert main(["status", str(study.file)]) == 2
    said = capsys.readouterr().err
    assert "expected the registration of the study 'pressing', but found that of 'palpation'" in said
    assert "If you renamed the study, write a registration with emg2vsa register --out FILE" in said
    assert main(["register", str(study.file), "--out", str(second), "--json"]) == 0
    assert json.loads(second.read_text())["amends"] == json.loads(study.registration.read_text())["sha256"]
    study.edit("[study]\n", '[study]\nregistration = "registration-2.json"\n')
    assert not study.found().deviations


@pytest.mark.parametrize("kind", ["folder", "broken link"])
def test_what_is_no_file_is_told(study: RegisteredStudy, capsys: Said, kind: str) -> None:
    study.registration.unlink()
    if kind == "folder":
        study.registration.mkdir()
    else:
        study.registration.symlink_to("gone.json")
    found = "a folder" if kind == "folder" else "no such file"
    for words in (["run", "--only", "fits"], ["status"]):
        assert main([words[0], str(study.file), *words[1:]]) == 2
        assert f"registration.json: expected a registration, but found {found}." in capsys.readouterr().err


def test_studies_of_one_folder_have_their_own(study: RegisteredStudy) -> None:
    other = study.folder / "other.toml"
    other.write_text(study.file.read_text().replace('name = "palpation"', 'name = "other"'))
    assert load_study(other).registration is None
    assert main(["register", str(other), "--json"]) == 0
    assert load_study(other).registration == study.folder / "other.registration.json"
    assert load_study(study.file).registration == study.registration


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--out", "plan.txt"], "--out plan.txt: expected a name that ends in .json, but found .txt"),
        (["--out", "plan"], "but found no ending"),
        (["--rig", "rig.toml"], "--rig: expected the rig file of the study alone, but found rig = rig.toml in [runs]"),
    ],
)
def test_options_that_cannot_be(study: RegisteredStudy, capsys: Said, words: list[str], said: str) -> None:
    assert main(["register", str(study.file), *words]) == 2
    assert said in capsys.readouterr().err


def test_bad_files_are_refused(study: RegisteredStudy, tmp_path: Path, capsys: Said) -> None:
    assert main(["register", str(tmp_path / "none.toml")]) == 2
    study.edit("seed = 20260105", "seed = -1")
    assert main(["register", str(study.file), "--out", str(tmp_path / "r.json")]) == 2
    study.edit("seed = -1", "seed = 1")
    study.registration.write_text("{")  # which the second would amend
    assert main(["register", str(study.file), "--out", str(tmp_path / "r.json")]) == 2
    assert "restore" in capsys.readouterr().err.lower()
    assert not (tmp_path / "r.json").exists()
    (tmp_path / "file").write_text("")
    study.registration.unlink()
    out = tmp_path / "file" / "r.json"
    assert main(["register", str(study.file), "--out", str(out)]) == 2
    assert f"emg2vsa: {out}: " in capsys.readouterr().err


def record_run(root: Path, name: str, *, folder: str = "", mounting: int | None = 1, force: str = "") -> Path:
    """A measured run, with the plan that the rig writes beside its presses."""
    specimen, angle, condition = name.rsplit("_", 2)
    plan = {"specimen": specimen, "angle_deg": float(angle), "condition": condition}
    path = root / (folder or name)
    path.mkdir(parents=True)
    (path / "plan.json").write_text(json.dumps({"plan": plan | ({"mounting": mounting} if mounting else {})}))
    (path / "force.csv").write_text(force or path.name)
    return path


@pytest.fixture
def to_measure(registered_once: RegisteredStudy, tmp_path: Path) -> RegisteredStudy:
    """A study of runs that are to be measured, of which one is there, registered with the rig file of the demo."""
    study = RegisteredStudy(tmp_path)
    study.file.write_text(study_of_runs("measured", "lab", ("S1", "S3", "S5", "S_new")))
    load_study(study.file).results.mkdir(parents=True)  # where digests of code are remembered
    for name in ("rig.toml", "rig-2.toml"):
        shutil.copy(registered_once.folder / "rig.toml", tmp_path / name)
    record_run(tmp_path / "lab", "S1_0_modular")
    assert main(["register", str(study.file), "--rig", str(tmp_path / "rig-2.toml"), "--json"]) == 0
    return study


def test_runs_that_are_to_be_measured(to_measure: RegisteredStudy) -> None:
    """Their rig file is registered by an option; measured runs are data."""
    content = json.loads(to_measure.registration.read_text())
    assert (content["rig_file"], content["collected"]) == ("rig-2.toml", "1 measured runs of the rig were there.")
    assert content["plan"]["runs"]["S3_45_modular_mounting-3"] == {
        "specimen": "S3", "angle_deg": 45, "condition": "modular", "mounting": 3,
    }  # fmt: skip
    assert not to_measure.found().deviations
    record_run(to_measure.folder / "lab", "S3_0_modular")
    (to_measure.folder / "lab" / "notes").mkdir()
    (to_measure.folder / "lab" / "notes" / "weather.txt").write_text("windy")
    assert not to_measure.found().deviations
    to_measure.edit("[experiment]\n", "[experiment]\nseed = 9\n", "rig-2.toml")
    (to_measure.folder / "lab" / "S1_0_modular" / "force.csv").write_text("3")
    assert [each.what for each in to_measure.found().deviations] == ["rig file, [experiment] seed", "run S1_0_modular"]
    for change in (lambda file: file.write_text("[rig"), Path.unlink):
        change(to_measure.folder / "rig-2.toml")
        assert [(each.what, each.registered, each.now) for each in to_measure.found().deviations] == [
            ("run S1_0_modular", "recorded", "other files"), ("rig file", "rig-2.toml", "absent"),
        ]  # fmt: skip


def test_planned_runs_are_awaited_and_missing_at_the_end(to_measure: RegisteredStudy, capsys: Said) -> None:
    found = to_measure.found()
    assert len(found.awaited_runs) == 4 * 9 * 3 - 1
    assert "S1_0_modular" not in found.awaited_runs
    assert next(found.lines()).endswith(": no deviations, 107 planned runs of the rig are not there yet")
    assert len(told(capsys, "status", str(to_measure.file))["registration"]["awaited_runs"]) == 107
    final = to_measure.found(final=True)
    (missing,) = final.deviations
    assert missing.what == f"run {', '.join(found.awaited_runs[:5])} and 102 more"
    assert (missing.registered, missing.now, final.awaited_runs) == ("planned", "absent", ())
    assert "casr_rigid" in missing.claims
    for run in json.loads(to_measure.registration.read_text())["plan"]["runs"].values():
        if run != {"specimen": "S1", "angle_deg": 0, "condition": "modular", "mounting": 1}:
            name, mounting = f"{run['specimen']}_{run['angle_deg']:g}_{run['condition']}", run["mounting"]
            more = f"_mounting-{mounting}" if mounting > 1 else ""
            record_run(to_measure.folder / "lab", name, folder=name + more, mounting=mounting)
    assert not to_measure.found(final=True).deviations
    shutil.rmtree(to_measure.folder / "lab" / "S1_0_modular")  # named once
    assert [(each.what, each.now) for each in to_measure.found(final=True).deviations] == [
        ("run S1_0_modular", "absent")
    ]  # fmt: skip


def test_runs_that_are_not_planned_are_named_together(to_measure: RegisteredStudy) -> None:
    lab = to_measure.folder / "lab"
    record_run(lab, "S1_0_modular", folder="S1_0_modular-2", force="the rest of its presses")
    record_run(lab, "S1_30_modular", folder="any-name", mounting=2)
    assert not to_measure.found().deviations
    shutil.copytree(lab / "S1_0_modular", lab / "S1_0_modular-3")
    shutil.copytree(lab / "S1_0_modular", lab / "S1_0_amodular")
    record_run(lab, "S1_0_modular", folder="S1_0_other", force="pressed again")
    record_run(lab, "S1_0_modular", folder="S1_0_modular_mounting-4", mounting=4)
    (one,) = to_measure.found().deviations
    assert (one.registered, one.now) == ("not planned", "there")
    again = [f"S1_0_modular in {folder}" for folder in ("S1_0_amodular", "S1_0_modular-3", "S1_0_other")]
    assert sorted(one.what.removeprefix("run ").split(", ")) == [*again, "S1_0_modular_mounting-4"]
    for angle in (10, 20, 50):
        record_run(lab, f"S1_{angle}_modular")
    (one,) = to_measure.found().deviations
    assert one.what.endswith(" and 2 more")


def test_hand_picked_runs_in_place_of_the_planned_ones(study: RegisteredStudy) -> None:
    """The attack: three runs in another folder, and no rig file in the study."""
    few = study.folder / "few"
    for name in ("S1_0_modular", "S1_30_modular", "S3_0_modular"):
        record_run(few, name)
    study.edit('rig = "rig.toml"', 'root = "few"')
    (source,) = study.found().deviations
    assert (source.what, source.registered, source.now) == (
        "[runs] source", '"emulated rig"', '"measured runs in few"'
    )  # fmt: skip
    assert {"casr_rigid", "kappa_error_rigid"} <= {*source.claims}
    assert len(study.found().awaited_runs) == 4 * 9 * 3 - 3
    assert "planned recordings and 105 planned runs of the rig are not there yet" in next(study.found().lines())
    (study.folder / "rig.toml").unlink()
    assert {each.what for each in study.found().deviations} == {"[runs] source", "rig file"}


@pytest.mark.parametrize("table", [True, False], ids=["runs.tsv", "plans"])
def test_without_a_rig_file_the_runs_that_are_there_are_the_plan(tmp_path: Path, table: bool) -> None:
    study = RegisteredStudy(tmp_path)
    study.file.write_text(study_of_runs("measured", "lab"))
    rows = ["folder\tspecimen\tangle_deg\tcondition"]
    for folder in ("a", "b"):
        record_run(tmp_path / "lab", "S1_0_modular", folder=folder, mounting=None)
        rows.append(f"{folder}\tS1\t0\tmodular")
    if table:
        (tmp_path / "lab" / "runs.tsv").write_text("\n".join(rows))
    assert main(["register", str(study.file), "--json"]) == 0
    plan = json.loads(study.registration.read_text())["plan"]
    assert list(plan["runs"]) == ["S1_0_modular", "S1_0_modular_mounting-2"]
    assert plan["tables"]["runs"]["source"] == "measured runs in lab"
    assert (study.found(final=True).deviations, study.found().awaited_runs) == ((), ())
    record_run(tmp_path / "lab", "S3_0_modular")
    if table:
        (tmp_path / "lab" / "runs.tsv").write_text("\n".join([*rows, "S3_0_modular\tS3\t0\tmodular"]))
    assert [each.what for each in study.found().deviations] == ["run S3_0_modular"]
    (tmp_path / "lab").rename(tmp_path / "lab-2")
    study.edit('root = "lab"', 'root = "lab-2"')
    assert [each.what for each in study.found().deviations] == ["[runs] source", "run S3_0_modular"]


def test_before_any_run_and_without_a_rig_file_no_run_is_planned(tmp_path: Path) -> None:
    study = RegisteredStudy(tmp_path)
    study.file.write_text(study_of_runs("measured", "lab"))
    assert main(["register", str(study.file), "--json"]) == 0
    record_run(tmp_path / "lab", "S1_0_modular")
    assert not study.found(final=True).deviations


def test_people_are_registered_before_any_recording_is_listed(tmp_path: Path) -> None:
    text = study_of_files(participants=["P01", "P02"], specimens=["S1", "S2"])
    file, layout = tmp_path / "study.toml", 'layout = "pattern"\npattern = "{participant}_{specimen}.csv"'
    assert layout in text
    first = '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\nemg = "one.csv"\n'
    file.write_text(text.replace(layout, 'layout = "files"\n' + first))
    assert main(["register", str(file), "--json"]) == 0
    of = RegisteredStudy(tmp_path)
    assert "specimens_differ" in json.loads(of.registration.read_text())["claims"]
    file.write_text(
        text.replace(layout, 'layout = "files"\n' + first + first.replace("P01", "P02").replace("one", "two"))
    )
    assert not of.found().deviations


# sessions


@pytest.fixture
def pressing(tmp_path: Path) -> RegisteredStudy:
    """A study with a session for emulated people, registered before anybody pressed."""
    text = small_study(
        participants=["P01", "P03"], specimens=["S1"], task="press", simulation="seed = 5\n",
        tables=f"[session]\n{SIMULATED_SESSION}pause_s = 1.0\nrepetitions = 2\n",
    )  # fmt: skip
    (tmp_path / "study.toml").write_text(text)
    load_study(tmp_path / "study.toml").results.mkdir(parents=True)  # where digests of code are remembered
    assert main(["register", str(tmp_path / "study.toml"), "--json"]) == 0
    assert json.loads((tmp_path / "registration.json").read_text())["collected"].startswith("0 of 2 planned")
    return RegisteredStudy(tmp_path)


def said_in(study: RegisteredStudy, participant: str) -> list[str]:
    """What a session says of its plan before the first press, where it is stopped."""

    def stop(state: object) -> None:
        raise KeyboardInterrupt

    done = session.run(load_study(study.file), participant, virtual=session.Virtual(seed=1), seen=stop)
    assert done.how == "ended"
    lines = read_journal(done.folder / JOURNAL_FILE)[0]
    return [each.event.text for each in lines if isinstance(each.event, Told) and "registered plan" in each.event.text]


def test_a_session_as_planned_names_nothing(pressing: RegisteredStudy) -> None:
    assert said_in(pressing, "P01") == []
    assert not pressing.found().after_data
    assert not any("Data when" in line for line in pressing.found().lines())
    pressing.record("P01", "S1")
    assert pressing.found().awaited == ("P03/S1",)
    assert pressing.found().deviations == ()


def test_a_session_names_what_it_does_otherwise_and_goes_on(pressing: RegisteredStudy) -> None:
    pressing.add("session", "seed = 4")
    pressing.edit('"P03"', '"P03", "P04"')
    pressing.edit("repetitions = 2", "repetitions = 3")
    pressing.add("fit", "bin_n = 0.6")  # which is no matter of a session
    said = said_in(pressing, "P04")
    assert len(said) == 3
    assert all(each.startswith("Deviation from the registered plan: ") for each in said)
    assert [word in " ".join(said) for word in ("participant P04", "[session] seed", "[session] repetitions")] == [
        True
    ] * 3
    assert len(said_in(pressing, "P01")) == 2
    assert "session of P04, seed" not in {each.what for each in pressing.found().deviations}  # not planned
    assert "session of P01, seed" in {each.what for each in pressing.found().deviations}


def test_a_session_goes_on_without_a_registration_that_can_be_read(pressing: RegisteredStudy, capsys: Said) -> None:
    pressing.registration.write_text("{")
    (said,) = said_in(pressing, "P01")
    assert said.startswith("The registered plan cannot be read: ")
    words = ["session", "run", str(pressing.file), "--participant", "P03", "--virtual", "--no-page", "--resume"]
    assert main(words) == 2  # there is none to resume
    assert "The registered plan cannot be read: " in capsys.readouterr().out
