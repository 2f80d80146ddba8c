"""A change re-runs what it changes and nothing behind a result that stays the same; changes during a run count too."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

import emg2vsa
from benchmarks.small_study import SIMULATED_SESSION
from emg2vsa import artifacts
from emg2vsa.cli import main
from emg2vsa.pipeline.plan import Step, survey
from emg2vsa.pipeline.stage_order import ORDER, stage
from emg2vsa.study_file import load_study
from tests.small import change_a_sample

pytestmark = pytest.mark.usefixtures("blank_drawings")

PRODUCT = Path(emg2vsa.__file__).parent.parent
RECORDING = "data/sub-P01/emg/sub-P01_task-palpation_acq-S1_emg.bdf"


def look(study: Path) -> dict[str, Step]:
    return survey(load_study(study), ORDER, lambda text: pytest.fail(text)).steps


def result_of(study: Path, step: str) -> Path:
    (path,) = (study.parent / ".emg2vsa" / "small" / "store" / step).glob("*.result")
    return path


def test_one_changed_sample_runs_no_emulation(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """P01's recording; the profile takes P02."""
    change_a_sample(study.parent / RECORDING)
    capsys.readouterr()
    assert main(["status", str(study), "--explain"]) == 0
    told = capsys.readouterr().out
    assert f"stale: trials/P01/S1: changed file {RECORDING}" in told
    assert "waits: fits/P01/S1: input trials/P01/S1" in told
    assert "waits: emulation/S1_0_modular: input schedules/study" in told
    assert "fresh" not in told.partition("stale: ")[2]
    assert main(["run", str(study), "--jobs", "1", "--json"]) == 0
    ran = json.loads(capsys.readouterr().out)["ran"]
    assert ran == [
        "trials/P01/S1",
        "fits/P01/S1",
        "screening/study",
        "pages/P01",
        "hypotheses/study",
        "exemplary/study",
        "profiles/study",
        "report/study",
    ]
    assert {step.status for step in look(study).values()} == {"fresh"}


def test_the_order_of_acquisition_enters_the_tests_and_a_changed_order_makes_them_stale(study: Path) -> None:
    scans = study.parent / "data" / "sub-P01" / "sub-P01_scans.tsv"
    rows = scans.read_text().splitlines()
    tested = artifacts.load(result_of(study, "hypotheses/study"))
    by_time = [row.partition("acq-")[2].partition("_")[0] for row in rows[1:]]
    assert [tested.places()["P01", name] for name in by_time] == [1, 2, 3]
    assert tested.drift.order in ("differs", "same")
    times = [row.split("\t")[1] for row in rows[1:]]
    own = [artifacts.load(result_of(study, f"trials/P01/{name}")).began for name in by_time]
    assert own == [time.replace("T", " ") for time in times]
    swapped = [f"{row.split(chr(9))[0]}\t{time}" for row, time in zip(rows[1:], times[::-1], strict=True)]
    scans.write_text("\n".join([rows[0], *swapped]) + "\n")
    stale = {name for name, step in look(study).items() if step.status != "fresh"}
    assert stale == {"hypotheses/study", "paths/study", "report/study"}


def test_stiffness_of_one_emulated_specimen_concerns_its_runs_and_what_stiffness_can_do(study: Path) -> None:
    rig = study.parent / "rig.toml"
    text = rig.read_text()
    assert "S1 = 7.63" in text
    rig.write_text(text.replace("S1 = 7.63", "S1 = 7.0"))
    steps = look(study)
    not_fresh = {step.id: step.status for step in steps.values() if step.status != "fresh"}
    own = {f"{name}/S1_0_{c}": "stale" for name in ("emulation", "runs") for c in ("high-stiffness", "modular")}
    behind = [f"{name}/study" for name in ("discrimination", "calibration", "paths", "report")]
    behind += ["kappa/0_high-stiffness", "kappa/0_modular"]
    assert not_fresh == own | dict.fromkeys(behind, "waits") | {"stiffness/study": "stale"}
    assert steps["emulation/S1_0_modular"].reasons == ("setting emulated.stiffness_n_per_mm.S1: 7.63 -> 7.0",)


def test_a_further_mounting_is_an_emulation_of_its_own(study: Path) -> None:
    rig = study.parent / "rig.toml"
    rig.write_text(rig.read_text().replace("repetitions = 2", "repetitions = 2\nmountings = 2"))
    steps = look(study)
    emulated = {step.item for step in steps.values() if step.stage == "emulation"}
    scored = {step.item: step for step in steps.values() if step.stage == "runs"}
    assert emulated == {*scored, *(f"{item}_mounting-2" for item in scored)}
    assert {steps[f"emulation/{item}_mounting-2"].status for item in scored} == {"stale"}
    assert all("setting folders: 1 -> 2" in step.reasons for step in scored.values())


@pytest.fixture
def hook(monkeypatch: pytest.MonkeyPatch) -> Callable[[str, Callable[[int], None], Callable[[int], None]], None]:
    """Have something done before and after a stage runs, given how often it ran before."""

    def put(name: str, before: Callable[[int], None], after: Callable[[int], None]) -> None:
        declared, counts = stage(name), Counter[str]()

        def run(given: Any) -> Any:
            before(counts[name])
            try:
                return declared.run(given)
            finally:
                after(counts[name])
                counts[name] += 1

        monkeypatch.setattr(f"emg2vsa.pipeline.stages.{name}.STAGE", replace(declared, run=run))

    return put


@pytest.mark.parametrize("put_back", [True, False])
def test_a_recording_replaced_while_its_step_runs_is_read_again(
    study: Path, hook: Any, put_back: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    path, stored = study.parent / RECORDING, result_of(study, "trials/P01/S1")
    before, truth, was = path.read_bytes(), artifacts.digest_of(stored), path.stat()
    stored.unlink()

    def other(times: int) -> None:
        if not times:
            change_a_sample(path)

    def same(times: int) -> None:
        if put_back and not times:
            path.write_bytes(before)
            os.utime(path, ns=(was.st_atime_ns, was.st_mtime_ns))

    hook("trials", other, same)
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--json", "--only", "trials"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["ran"], told["failures"]) == (["trials/P01/S1"], [])
    assert (artifacts.digest_of(result_of(study, "trials/P01/S1")) == truth) == put_back
    path.write_bytes(before)
    assert main(["run", str(study), "--jobs", "1", "--json", "--only", "trials"]) == 0
    assert artifacts.digest_of(sorted(stored.parent.glob(stored.name))[0]) == truth


def test_a_recording_that_never_rests_leaves_no_result(
    study: Path, hook: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    path, stored = study.parent / RECORDING, result_of(study, "trials/P01/S1")
    stored.unlink()
    hook("trials", lambda times: change_a_sample(path), lambda times: change_a_sample(path))
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--json", "--only", "trials"]) == 0
    ((failure),) = json.loads(capsys.readouterr().out)["failures"]
    assert f"{path} changed while the step ran. Run the study again." in failure["message"]
    assert list(stored.parent.iterdir()) == []
    assert look(study)["trials/P01/S1"].status == "stale"


def test_a_frame_replaced_while_it_is_scored_and_put_back_is_read_again(study: Path, hook: Any) -> None:
    frames = study.parent / "runs-virtual" / "S1_0_modular" / "press-001" / "frames.tif"
    before, stored = frames.read_bytes(), result_of(study, "runs/S1_0_modular")
    truth = artifacts.digest_of(stored)
    stored.unlink()
    other = (frames.parent.parent / "press-002" / "frames.tif").read_bytes()
    hook(
        "runs",
        lambda times: None if times else frames.write_bytes(other),
        lambda times: None if times else frames.write_bytes(before),
    )
    assert main(["run", str(study), "--jobs", "1", "--json", "--only", "runs"]) == 0
    assert artifacts.digest_of(result_of(study, "runs/S1_0_modular")) == truth


EDIT = """
import sys
from dataclasses import replace
from pathlib import Path
from emg2vsa.cli import main
from emg2vsa.pipeline.stages import trials
import emg2vsa.extraction.extract as edited

declared = trials.STAGE
def run(given):
    path = Path(edited.__file__)
    path.write_text(path.read_text() + "\\n1 + 1\\n")
    return declared.run(given)
trials.STAGE = replace(declared, run=run)
sys.exit(main(["run", sys.argv[1], "--jobs", "1", "--only", "trials"]))
"""


@pytest.mark.slow
def test_a_module_edited_while_a_step_runs_leaves_no_result(study: Path, tmp_path: Path) -> None:
    copy = tmp_path / "product"
    for package in ("emg2vsa", "casr"):
        shutil.copytree(PRODUCT / package, copy / package)
    stored = result_of(study, "trials/P01/S1")
    stored.unlink()
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy), *sys.path])}
    program = [sys.executable, "-c", EDIT, str(study)]
    done = subprocess.run(program, capture_output=True, text=True, env=environment, check=False, cwd=copy)
    assert "The program's code changed (" in done.stderr
    assert ") while the step ran. Run the study again." in done.stderr
    assert "Traceback" not in done.stderr
    assert list(stored.parent.iterdir()) == []
    assert look(study)["trials/P01/S1"].status == "stale"


TWICE = """
import sys
from pathlib import Path
from emg2vsa.cli import main

study, stored, more = sys.argv[1:]
def run():
    for path in Path(stored).parents[2].glob("*/*/*.result"):
        path.unlink()
    return main(["run", study, "--jobs", "1", "--only", "trials"])

assert run() == 0
name = "emg2vsa.extraction.extract"
edited = Path(sys.modules[name].__file__)
edited.write_text(edited.read_text() + more)
sys.exit(run())
"""


@pytest.mark.slow
def test_code_that_changed_since_it_was_loaded_makes_no_result(study: Path, tmp_path: Path) -> None:
    stored = result_of(study, "trials/P01/S1")
    for place, more in enumerate(("\n1 + 1\n", "\n# a comment\n")):
        copy = tmp_path / f"product{place}"
        for package in ("emg2vsa", "casr"):
            shutil.copytree(PRODUCT / package, copy / package)
        time.sleep(1.1)  # digests of younger files are not kept, and nothing tells then that only a comment came
        environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(copy), *sys.path])}
        program = [sys.executable, "-c", TWICE, str(study), str(stored), more]
        done = subprocess.run(program, capture_output=True, text=True, env=environment, check=False, cwd=copy)
        assert "Traceback" not in done.stderr
        refused = ".py: expected the program's code as it is loaded, but found that it changed since. Start"
        kept = bool(list(stored.parent.iterdir()))
        assert (refused in done.stderr, done.returncode != 0, kept) == (not place, not place, bool(place))


def test_of_a_session_table_the_report_says_order_and_rests_and_no_other_result_hangs_on_it(study: Path) -> None:
    """A session makes recordings, and what they hold counts. Its texts and devices are said nowhere."""
    text, said = study.read_text(), []
    assert {step.status for step in look(study).values()} == {"fresh"}
    for more in ("", 'texts.start = "Los"\nsound = true\n', "seed = 7\n"):
        study.write_text(f"{text}\n[session]\n{SIMULATED_SESSION}repetitions = 3\n{more}")
        steps = look(study)
        assert {name for name, step in steps.items() if step.status != "fresh"} == {"report/study"}
        said.append(steps["report/study"].reasons)
    assert said[0] == said[1] != said[2]
