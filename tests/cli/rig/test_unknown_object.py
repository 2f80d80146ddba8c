"""The how-to from a calibration to an unknown object: its files are read, its commands run."""

from __future__ import annotations

import csv
import json
import re
import shlex
from pathlib import Path

import pytest

from emg2vsa.cli import main

HOW_TO = Path(__file__).parents[3] / "docs" / "how-to" / "unknown-object.md"


@pytest.mark.slow
def test_every_command_does_what_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = HOW_TO.read_text(encoding="utf-8")
    for name, content in zip(
        ("rig.toml", "study.toml"), re.findall(r"```toml\n(.*?)```", text, flags=re.S), strict=True
    ):
        Path(name).write_text(content)
    said = ""
    for command in re.findall(r"```console\n\$ (.*?)\n", text):
        program, *words = shlex.split(command)
        assert (program, main(words)) == ("emg2vsa", 0), command
        said = capsys.readouterr().out
    assert said.startswith("kappa: by high-stiffness_0.json (S1, S3, S5, 9 presses); at best ±")
    assert len(re.findall(r"^kappa after press \d: [\d.]+ N/mm, 95 %: .*; stopped: ", said, flags=re.M)) == 2
    folder = Path("runs-virtual/S4_0_high-stiffness")
    for name in re.findall(r"^\| `([^`]+)` \|", text, flags=re.M):
        assert (folder / name).is_file(), name
    low, high = re.findall(r"95 %: ([\d.]+) to ([\d.]+|rigid)", said)[-1]
    assert float(low) < 3.12 < float("inf" if high == "rigid" else high)
    with (folder / "kappa.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert {row["cues"] for row in rows if row["stop"]} == {"area and travel"}, "the first answers may be by area alone"
    assert all(0 < float(row["half_width"]) <= 0.4 for row in rows if row["stop"])
    assert json.loads((folder / "kappa.json").read_text())["dropped"] == 0
