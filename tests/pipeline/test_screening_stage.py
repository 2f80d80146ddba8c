"""What a comparison of recordings finds reaches the tests, the pages and the verdicts; who accepts overrules it."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import numpy as np
import pytest

import emg2vsa
from emg2vsa import artifacts
from emg2vsa.cli import main

pytestmark = pytest.mark.usefixtures("blank_drawings")

ACCEPT = """
[[accept]]
participant = "P02"
specimen = "S1"
reason = "this one is right"
"""


def product(study: Path, step: str):
    """The newest result of a step."""
    found = (study.parent / ".emg2vsa" / "small" / "store" / step).glob("*.result")
    return artifacts.load(max(found, key=lambda path: path.stat().st_mtime_ns))


@pytest.fixture
def copied(study: Path) -> Path:
    """P01's recording of S1 under the name of P02."""
    data = study.parent / "data"
    for source in (data / "sub-P01").rglob("*acq-S1_*"):
        target = data / "sub-P02" / source.relative_to(data / "sub-P01").as_posix().replace("P01", "P02")
        if source.suffix == ".bdf" or target.exists():
            shutil.copyfile(source, target)
    return study


def test_a_copy_is_unreadable_and_enters_no_test_until_one_is_accepted(
    copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["run", str(copied), "--human-only", "--jobs", "1", "--json"])
    found = product(copied, "screening/study").found
    assert {(e.participant, e.specimen, e.verdict) for e in found if e.cause == "copy"} == {
        ("P01", "S1", "unreadable"), ("P02", "S1", "unreadable")
    }  # fmt: skip
    (page,) = (path.read_text(encoding="utf-8") for path in copied.parents[2].rglob("participants/P02.html"))
    assert "the same recording as P01/S1" in page
    capsys.readouterr()
    main(["check", str(copied), "--json"])
    verdicts = json.loads(capsys.readouterr().out)
    assert [verdicts[who]["verdict"] for who in ("P01", "P02")] == ["unreadable", "unreadable"]
    before = product(copied, "hypotheses/study")
    fits = emg2vsa.load(copied).fits
    spoilt = fits[(fits["specimen"] == "S1") & fits["participant"].isin(["P01", "P02"])]
    assert set(spoilt["verdict"]) == {"rejected"}

    copied.write_text(copied.read_text(encoding="utf-8") + ACCEPT, encoding="utf-8")
    main(["run", str(copied), "--human-only", "--jobs", "1", "--json"])
    verdicts_now = {(e.participant, e.specimen): e.verdict for e in product(copied, "screening/study").found}
    assert (verdicts_now["P01", "S1"], verdicts_now["P02", "S1"]) == ("unreadable", "ok")
    after = product(copied, "hypotheses/study")
    assert np.sum(after.count) > np.sum(before.count)
