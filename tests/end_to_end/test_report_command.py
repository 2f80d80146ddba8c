"""What ``emg2vsa report`` says of a report that is up to date."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from emg2vsa.cli import main


def test_the_page_and_the_folders_are_told(ran: Path, capsys: pytest.CaptureFixture[str]) -> None:
    capsys.readouterr()
    assert main(["report", str(ran), "--jobs", "1"]) == 0
    page, *folders = capsys.readouterr().out.splitlines()
    reports = ran.parents[2] / "reports" / "small"
    assert page == str(reports / "index.html")
    assert f"{reports / 'participants'}: 2 files" in folders
    assert main(["report", str(ran), "--jobs", "1", "--json"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert sum(int(line.rpartition(": ")[2].split()[0]) for line in folders) == len(files)
