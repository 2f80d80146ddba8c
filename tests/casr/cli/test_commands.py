"""Options, ``casr bench``, ``casr simulate``, and the how-to: its commands run, and print what it says."""

from __future__ import annotations

import json
import re
import shlex
from pathlib import Path
from typing import Any

import pytest

import benchmarks.tactile
from benchmarks.tactile.table import Table
from casr import command_line
from casr.cli import PROGRAM, main
from casr.command_line import parsers_of


def test_choices_are_those_of_the_modules() -> None:
    from benchmarks.tactile import KINDS
    from casr.camera_calibration.intrinsics import OPENCV_FLAGS
    from casr.contact_area import RULES
    from casr.flow.step import ENGINES
    from casr.frames import FORCE_RULES
    from casr.scored import QUANTITIES
    from casr.spread import AREA_LAWS, RATE_RULES
    from emg2vsa.worlds.tactile import SCATTERS

    wanted = {
        "score": {
            "engine": ENGINES, "area": RULES, "force_rule": FORCE_RULES, "law": AREA_LAWS, "rate": RATE_RULES,
            "quantity": QUANTITIES,
        },
        "bench": {"what": KINDS},
        "calibrate": {"distortion": OPENCV_FLAGS},
        "simulate": {"scatter": SCATTERS},
    }  # fmt: skip
    parsers = {parser.prog: parser for parser in parsers_of(PROGRAM.parser())}
    for command, options in wanted.items():
        actions = {action.dest: action for action in parsers[f"casr {command}"]._actions}
        for option, known in options.items():
            assert tuple(actions[option].choices or ()) == tuple(known)


def test_what_is_not_given_is_the_default_of_the_modules() -> None:
    """Of scoring, of pins and of simulated presses; the window of the mean rate too."""
    from casr.cli.arguments import of_fields, score_settings
    from casr.scored import ScoreSettings
    from emg2vsa.worlds.tactile import Appearance, PressPlan

    parser = PROGRAM.parser()
    assert score_settings(parser.parse_args(["score", "x"])) == ScoreSettings()
    simulate = parser.parse_args(["simulate", "x"])
    assert PressPlan(**of_fields(simulate, PressPlan)) == PressPlan()
    assert Appearance(**of_fields(simulate, Appearance)) == Appearance()


def test_options_reach_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []
    monkeypatch.setattr(benchmarks.tactile, "run", lambda *args, **kwargs: asked.append((args, kwargs)))
    assert main(["bench", "presses", "--out", "d", "--repetitions", "2", "--jobs", "3"]) == 0
    words = {"n_seeds": 6, "n_repetitions": 2, "n_jobs": 3, "show": True}
    assert main(["bench", "presses", "--world", "tabulated,front"]) == 0
    assert asked == [
        (("presses", Path("d")), words | {"worlds": ()}),
        (("presses", None), words | {"n_repetitions": 10, "n_jobs": 1, "worlds": ("tabulated", "front")}),
    ]


def test_json_holds_the_tables_and_nothing_else(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    table = Table("flow", "Flow", (("way", ""), ("ms", ".2f")), [("ours", 1.5), ("theirs", None)], ("a note",))
    monkeypatch.setattr(benchmarks.tactile, "_measured", lambda *args: [table])
    assert main(["bench", "numerics", "--json"]) == 0
    (found,) = json.loads(capsys.readouterr().out)["tables"]
    assert (found["name"], found["rows"], found["notes"]) == ("flow", [["ours", 1.5], ["theirs", None]], ["a note"])


def test_without_a_checkout_it_says_where_the_benchmarks_are(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(command_line, "SOURCE", tmp_path)
    assert main(["bench"]) == 2
    complaint = capsys.readouterr().err
    assert complaint.count("\n") == 1
    assert "benchmarks/ beside" in complaint
    assert "Get the sources of emg2vsa" in complaint


SMALL = ["--specimens", "S3", "--angles", "30", "--repetitions", "1"]


def test_a_press_folder_holds_frames_force_camera_and_truth(presses: Path) -> None:
    names = [path.name for path in sorted(presses.iterdir())]
    assert names == ["S1_00deg_01", "S1_00deg_02", "S5_00deg_01", "S5_00deg_02"]
    files = sorted(path.name for path in (presses / names[0]).iterdir())
    assert files == ["camera.toml", "force.csv", "frames.tif", "truth.json"]


def test_softer_specimens_have_the_larger_rate(presses: Path) -> None:
    rate = {
        path.name: json.loads((path / "truth.json").read_text())["truth"]["casr_slope_mm2_per_n"]
        for path in presses.iterdir()
    }
    assert max(rate["S1_00deg_01"], rate["S1_00deg_02"]) < min(rate["S5_00deg_01"], rate["S5_00deg_02"])


def test_presses_that_are_there_are_kept_unless_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = str(tmp_path / "p")
    assert main(["simulate", out, *SMALL]) == 0
    frames = tmp_path / "p" / "S3_30deg_01" / "frames.tif"
    before = frames.read_bytes()
    assert main(["simulate", out, *SMALL, "--seed", "5"]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert frames.read_bytes() == before
    assert main(["simulate", out, *SMALL, "--seed", "5", "--overwrite"]) == 0
    assert frames.read_bytes() != before


def test_json_names_every_press(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(tmp_path / "p"), *SMALL, "--json"]) == 0
    (press,) = json.loads(capsys.readouterr().out)["presses"]
    assert press["press"] == "S3_30deg_01"
    assert press["casr_mm2_per_n"] > 0


def truth(folder: Path) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((folder / "S3_30deg_01" / "truth.json").read_text())
    return found


@pytest.mark.parametrize(
    ("words", "world"),
    [
        ([], "tabulated, stick"),
        (["--world", "tabulated-frictionless"], "tabulated, frictionless"),
        (["--world", "stick"], "stick from 0.43 N"),
        (["--world", "stick", "--stick-force-n", "2"], "stick from 2 N"),
        (["--world", "front", "--force-max-n", "5"], "stick from 5 N"),
    ],
)
def test_the_world_is_the_one_asked_for(words: list[str], world: str, tmp_path: Path) -> None:
    assert main(["simulate", str(tmp_path), *SMALL, *words]) == 0
    assert truth(tmp_path)["truth"]["world"] == world


def test_scatter_is_realistic_unless_there_is_none(tmp_path: Path) -> None:
    for name, words in (("usual", []), ("other", ["--mounting", "3"]), ("none", ["--scatter", "none"])):
        assert main(["simulate", str(tmp_path / name), *SMALL, *words]) == 0
    usual, other, none = (truth(tmp_path / name)["truth"]["drawn"] for name in ("usual", "other", "none"))
    assert set(none.values()) == {0.0, 1.0}
    assert 0 < abs(usual["depth"] - 1) < 0.05
    assert usual["depth"] != other["depth"]
    assert usual["latency_s"] == other["latency_s"], "which belongs to the press"


HOW_TO = Path(__file__).parents[3] / "docs" / "how-to" / "tactile.md"


def steps() -> list[tuple[str, str]]:
    """Every command of the console blocks in turn, and its output."""
    blocks = re.findall(r"```console\n(.*?)```", HOW_TO.read_text(encoding="utf-8"), flags=re.S)
    found = [part.partition("\n") for block in blocks for part in re.split(r"^\$ ", block, flags=re.M)[1:]]
    return [(command, output) for command, _, output in found]


def shape(text: str) -> list[str]:
    """Lines without their numbers and the spaces that line them up; notes aside."""
    return [re.sub(r"[-+\d.e ]+", " ", line).strip() for line in text.splitlines()]


@pytest.mark.slow
def test_every_command_does_what_the_page_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for command, output in steps():
        program, *words = shlex.split(command)
        assert (program, main(words)) == ("casr", 0), command
        said = shape(capsys.readouterr().out)
        assert said == shape(output) or not output.strip(), command
    assert {path.name for path in tmp_path.iterdir()} == {
        "presses",
        "scores.html",
        "scores_pages",
        "press.html",
        "pictures",
        "pins.csv",
        "frames.csv",
    }
