"""A session as the paper's: two practice specimens, five specimens of ten presses, three mishaps, to a profile of b."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from emg2vsa import artifacts
from emg2vsa.cli import main
from emg2vsa.fits import usable
from emg2vsa.session.journal import JOURNAL_FILE, Judged, PressBegun, read_journal

SESSION = """
[session]
pause_s = 2.0
training_specimens = ["T1", "T2"]
training_repetitions = 1
emg.kind = "simulated"
force.kind = "simulated"
"""
STUDY = Path(__file__).parents[2] / "studies" / "palpation" / "study.toml"


@pytest.mark.slow
def test_a_session_like_the_papers_gives_back_a_and_b(tmp_path, capsys):
    study = tmp_path / "study.toml"
    text = STUDY.read_text(encoding="utf-8").partition("# The rig presses")[0]
    text += (
        "[simulation]"
        + STUDY.read_text(encoding="utf-8").rpartition("[simulation]")[2].partition("# `emg2vsa session`")[0]
    )
    text += SESSION
    ids = '"P01", "P02", "P03", "P04", "P05", "P06", "P07", "P08", "P09", "P10", "P11", "P12", "P13", "P14"'
    text = text.replace(ids, '"P03"').replace('participant = "P07"', 'participant = "P03"')
    study.write_text(text, encoding="utf-8")
    mishaps = ("dips@12", "electrode-off:FDS@25", "early@33")
    words = [word for mishap in mishaps for word in ("--mistake", mishap)]
    truth_file = tmp_path / "truth.json"
    words += ["--virtual", "--no-page", "--truth", str(truth_file)]
    assert main(["session", str(study), "--participant", "P03", *words]) in (0, 1), capsys.readouterr().out
    said = capsys.readouterr().out
    assert "completed" in said

    lines, _ = read_journal(tmp_path / "data" / "sourcedata" / "sub-P03" / "palpation" / JOURNAL_FILE)
    begun = {(e.press, e.attempt): e for line in lines if isinstance(e := line.event, PressBegun)}
    rejected = {
        (e.press, e.attempt) for line in lines if isinstance(e := line.event, Judged) and e.verdict == "rejected"
    }
    assert sorted(press - 2 for press, attempt in rejected if attempt == 1) == [12, 25, 33]
    assert len(begun) == 2 + 50 + 3

    if program := shutil.which("bids-validator-deno", path=str(Path(sys.executable).parent)):
        words = [program, str(tmp_path / "data"), "--format", "json"]
        done = subprocess.run(words, capture_output=True, text=True, timeout=600)
        issues = json.loads(done.stdout)["issues"]["issues"]
        assert [issue for issue in issues if issue["severity"] == "error"] == []

    assert main(["run", str(study), "--jobs", "1"]) in (0, 1)
    truth = json.loads(truth_file.read_text(encoding="utf-8"))
    capsys.readouterr()
    assert main(["check", str(study), "P03", "--json", "--jobs", "1"]) == 0
    (verdict,) = json.loads(capsys.readouterr().out).values()
    for specimen in verdict["specimens"]:
        assert specimen["ok"] + specimen["doubtful"] == 10, specimen
    _compare(study, truth)


def _compare(study_file, truth):
    """Mean b of each specimen within four standard errors of what was put in, and within 12 %."""
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.run_study import run_study
    from emg2vsa.study_file import load_study

    study = load_study(study_file)
    board = run_study(study, stages=("trials", "fits"), jobs=1, progress=progress(quiet=True))
    for entry in study.recordings:
        (path,) = board.done("fits", (entry.key,))
        fits = artifacts.load(path)
        used = usable(fits, "ok+doubtful")
        put_in = [p["b_v"] for p in truth["presses"] if p["specimen"] == entry.specimen and not p["mistake"]]
        error = fits.b_v[used].mean() / np.mean(put_in) - 1
        standard = fits.b_v[used].std(ddof=1) / np.sqrt(used.sum()) / np.mean(put_in)
        assert abs(error) < min(4 * standard, 0.12), (entry.specimen, error, standard)
