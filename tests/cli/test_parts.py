"""A part of a study that the study has not."""

from __future__ import annotations

from pathlib import Path

import pytest

from emg2vsa.cli import main
from tests.small import study_of_files, study_of_runs


@pytest.mark.parametrize(
    ("text", "option", "said"),
    [
        (
            study_of_files(),
            "--casr-only",
            "expected runs of a rig, but found a study of people only. Leave --casr-only out",
        ),
        (study_of_runs("lab", "lab"), "--human-only", "expected recordings of people, but found a study of runs only."),
    ],
)
def test_a_part_that_is_not_there_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], text: str, option: str, said: str
) -> None:
    (tmp_path / "study.toml").write_text(text)
    assert main(["run", str(tmp_path / "study.toml"), option]) == 2
    assert said in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]
