"""Where outcomes go: a study that cannot be written to, a folder of another study's, a report that is not whole."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from emg2vsa.cli import main
from emg2vsa.errors import DataError
from emg2vsa.pipeline import places
from emg2vsa.pipeline.stage_order import stage
from emg2vsa.study_file import load_study

pytestmark = pytest.mark.usefixtures("blank_drawings")

READ_ONLY = """
import sys
from emg2vsa.cli import main
study, work = sys.argv[1], sys.argv[2]
for command in (
    ["status", study], ["check", study], ["schedule", study, "--out", f"{work}/schedules"],
    ["run", study, "--jobs", "1"], ["run", study, "--work", work, "--jobs", "1", "--only", "pages"],
):
    print(f"## {command[0]}: {main(command)}", flush=True)
"""


def listing(folder: Path) -> dict[str, tuple[int, int]]:
    return {str(p): (p.stat().st_size, p.stat().st_mtime_ns) for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.slow
def test_a_study_on_a_read_only_disk_is_read_and_run_elsewhere(study: Path, tmp_path: Path) -> None:
    """On a read-only mount, for real: permissions do not stop root."""
    mount = 'mount --bind "$1" "$1" && mount -o remount,bind,ro "$1" && shift && exec "$@"'
    inside = ["unshare", "-rm", "sh", "-c", mount, "sh", str(tmp_path / "copy")]
    if not shutil.which("unshare") or subprocess.run([*inside, "true"], capture_output=True, check=False).returncode:
        pytest.skip("no mount of its own for a process here: unshare -rm is missing or forbidden")
    (store,) = study.parent.glob(".emg2vsa/*/store/schedules/study")
    shutil.rmtree(store)
    before, work = listing(tmp_path / "copy"), tmp_path / "work"
    work.mkdir()
    program = [*inside, sys.executable, "-c", READ_ONLY, str(study), str(work)]
    done = subprocess.run(program, capture_output=True, text=True, check=False, cwd=work)
    assert "Traceback" not in done.stderr
    ended = [line for line in done.stdout.splitlines() if line.startswith("## ")]
    assert ended == ["## status: 0", "## check: 0", "## schedule: 0", "## run: 2", "## run: 0"], done.stderr
    assert (
        "found Read-only file system. Give another place for everything that is written with --work DIR" in done.stderr
    )
    assert len(list((work / "schedules").iterdir())) > 0
    assert list((work / "report").rglob("*P01*"))
    assert listing(tmp_path / "copy") == before


def test_a_run_that_cannot_write_says_so_in_one_line_before_it_computes(
    study: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(study.parent / ".emg2vsa" / "small" / "store")
    inside = tmp_path / "copy"
    monkeypatch.setattr(
        places, "_refusal", lambda folder: "Read-only file system" if folder.is_relative_to(inside) else ""
    )
    before = listing(inside)
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--work DIR" in line
    assert listing(inside) == before
    assert main(["check", str(study), "P01", "--jobs", "1"]) == 0
    assert "P01    GOOD" in capsys.readouterr().out
    assert listing(inside) == before


def test_what_can_be_written_to_is_found_out_without_a_trace(tmp_path: Path) -> None:
    assert places.is_writable(tmp_path / "not" / "yet" / "there")
    assert list(tmp_path.iterdir()) == []
    (tmp_path / "file").write_text("")
    assert not places.is_writable(tmp_path / "file" / "below")


def test_the_report_of_another_study_is_left_alone(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    second = study.parent.parent / "second" / "study.toml"
    second.parent.mkdir()
    text = study.read_text().replace('name = "small"', 'name = "second"\nreports = "../../reports/small"')
    second.write_text(
        text.replace('root = "data"', 'root = "../small/data"').replace('"rig.toml"', '"../small/rig.toml"')
    )
    capsys.readouterr()
    assert main(["run", str(second), "--jobs", "1"]) == 2
    told = capsys.readouterr().err
    assert f"the report of the study 'small' in {study}" in told
    assert "Give this study another folder" in told
    assert not (second.parent / ".emg2vsa" / "second" / "store").exists()
    study.unlink()
    places.check_places(load_study(second), ["report"])  # nobody's any more
    assert json.loads((load_study(second).reports / places.OWNER_FILE).read_text())["study"] == "second"


def test_where_the_report_is_is_said_although_a_step_failed(
    study: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(given: Any) -> Any:
        raise DataError("calibration", wanted="spread", found="none", do="Press again.")

    monkeypatch.setattr("emg2vsa.pipeline.stages.calibration.STAGE", replace(stage("calibration"), run=fail))
    shutil.rmtree(study.parent / ".emg2vsa" / "small" / "store" / "calibration")
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1"]) == 1
    told = capsys.readouterr().out.splitlines()
    page = study.parent.parent.parent / "reports" / "small" / "index.html"
    assert told[-2:] == [
        f"Report: {page}",
        "  The stiffness of the new specimen is missing from it: calibration: expected spread, but found none. Press "
        "again.",
    ]
    results = json.loads((page.parent / "results.json").read_text())
    assert results


def test_the_report_names_the_versions_that_made_it(finished: Path) -> None:
    page = (finished.parent.parent / "reports" / "small" / "index.html").read_text()
    for name, version in (("python", f"{sys.version_info.major}.{sys.version_info.minor}"), ("numpy", np.__version__)):
        assert f"<dt>{name}</dt><dd><code>{version}</code></dd>" in page
