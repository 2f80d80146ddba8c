"""A flow engine of another package: in ``casr flow`` and ``casr score``; and its faults."""

from __future__ import annotations

import importlib
import importlib.metadata
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import casr
from casr.cli import main
from casr.errors import PluginError, SettingError
from casr.flow.estimate import FlowSettings, FlowTracker
from casr.flow.region import Region
from casr.images import as_grey
from casr.plugins import made_worlds
from tests.once import Once

Install = Callable[..., Path]


@pytest.fixture(scope="module")
def press(built_once: Once) -> Path:
    words = ("--scatter", "none", "--angles", "0", "--specimens", "S3", "--repetitions", "1")
    made = built_once("press", lambda folder: main(["simulate", str(folder / "presses"), *words]))
    return made / "presses" / "S3_00deg_01"


def told(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main([*words, "--json"]) == 0
    found: dict[str, Any] = json.loads(capsys.readouterr().out)
    return found


def test_flow_and_score_take_the_engine(install: Install, press: Path, capsys: pytest.CaptureFixture[str]) -> None:
    install()
    frames = ("flow", str(press), "--frames", "20,24", "--region", "150,150,40")
    steps = told(capsys, *frames, "--engine", "farneback")["steps"]
    engine, sequence = importlib.import_module("lab_tools").Farneback(None), casr.open_frames(press)
    engine.start(as_grey(sequence[20]), Region.circle(150, 150, 40), None)
    by_hand = [engine.step(as_grey(sequence[i]), None).log_growth for i in range(21, 25)]
    assert [step["log_growth"] for step in steps] == by_hand
    assert sum(by_hand) > 0
    assert main(["score", str(press), "--engine", "farneback", "--quantity", "skin"]) == 0
    said = capsys.readouterr()
    assert "farneback, area rule" in said.out
    assert "growth is measured by the flow engine farneback of lab-tools 1.0" in said.err


def test_an_engine_that_nobody_has_is_refused(
    install: Install, press: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    install()
    with pytest.raises(SystemExit):
        main(["score", str(press), "--engine", "farnebak"])
    assert "Did you mean farneback?" in capsys.readouterr().err
    with pytest.raises(SettingError, match="or dis or farneback, but found 'none'"):
        FlowSettings(engine="none")


def test_none_of_our_engines_is_replaced(install: Install) -> None:
    install(entries={"casr.flow_engines": {"dis": "lab_tools:no_such_name"}})
    FlowTracker(FlowSettings(engine="dis"))


def test_the_whole_image_is_for_our_dense_engines(install: Install) -> None:
    install()
    with pytest.raises(SettingError, match="farneback, which follows a region"):
        FlowTracker(FlowSettings(engine="farneback"), whole_image=True)


HEAD = "class Farneback:\n    def __init__(self, settings): ...\n    def start(self, image, region, pins_px): "
FINITE = "FlowStep with finite growth from step"
BROKEN = {
    "import no_such_module_at_all": "expected a module that can be imported",
    "Farneback = 3": "an engine that can be made, but found TypeError",
    f"{HEAD}1 / 0": "takes the first frame, but found ZeroDivisionError",
    f"{HEAD}...\n    def step(self, image, pins_px): 1 / 0": "takes the next frame, but found ZeroDivisionError",
    f"{HEAD}...\n    def step(self, image, pins_px): return 0.1": f"{FINITE}, but found 0.1",
    "from casr.flow.step import FlowStep\n"
    f"{HEAD}...\n    def step(self, image, pins_px): return FlowStep(float('nan'), 0.0, None, 1)": FINITE,
}


@pytest.mark.parametrize("code", BROKEN)
def test_a_broken_engine_is_one_error(
    install: Install, press: Path, code: str, capsys: pytest.CaptureFixture[str]
) -> None:
    install(code=code)
    words = ["flow", str(press), "--frames", "20,21", "--region", "150,150,40", "--engine", "farneback"]
    assert main(words) == 2
    said = capsys.readouterr().err
    assert "Traceback" not in said
    assert "plugin farneback of lab-tools 1.0: expected" in said
    assert BROKEN[code] in said
    assert "Tell the authors of lab-tools, or uninstall it." in said


def test_an_engine_that_cannot_be_imported_is_an_error_in_python(install: Install) -> None:
    install(code="1 / 0")
    with pytest.raises(PluginError, match="ZeroDivisionError"):
        FlowTracker(FlowSettings(engine="farneback"))


def test_another_package_never_takes_the_place_of_our_worlds(install: Install) -> None:
    install(code="class Worlds: ...", entries={"casr.worlds": {"tactile": "lab_tools:Worlds"}})
    assert made_worlds().__name__ == "emg2vsa.worlds.tactile"


def test_a_copy_without_its_entry_point_says_what_to_do(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.metadata, "entry_points", lambda **_: ())
    with pytest.raises(PluginError, match=r"casr\.worlds: expected the maker .* Install it again"):
        made_worlds()
