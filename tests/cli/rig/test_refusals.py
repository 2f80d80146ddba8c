"""What ``emg2vsa rig`` refuses: one line says what was wanted and found; nothing moves, nothing is written."""

from __future__ import annotations

import json
import os
import shlex
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.rig.plans import known_calibration
from emg2vsa.calibration_file import write_calibration

REFUSED = """
dry-run rig.toml --specimen S31                           | rig.toml, specimen: expected S1, S3, but found S31. Did you mean 'S3'?
dry-run rig.toml --specimen Q                             | rig.toml, specimen: expected S1, S3, but found Q. Add it to [experiment], or choose another.
dry-run rig.toml --angle 45                               | rig.toml, angle: expected 0, 30, but found 45. Add it to [experiment], or choose another.
dry-run rig.toml --angle 30 --condition high-stiffness    | expected a run of the experiment, but found angle 30, condition high-stiffness. See [experiment.angles_deg].
dry-run rig.toml --condition constant-min                 | rig.toml, condition: expected high-stiffness, modular, but found constant-min.
dry-run advanced.toml                                     | schedule of S1, modular, limits.actuator: expected qbmove-advanced, the actuator
run ADVANCED                                              | schedule of S1, modular, limits.actuator: expected qbmove-advanced, the actuator
run ADVANCED --virtual                                    | schedule of S1, modular, limits.actuator: expected qbmove-advanced, the actuator
emulate not-emulated.toml                                 | a table [emulated]
emulate rig.toml --specimen S9                            | stiffness of the specimen
emulate rig.toml --angle 90                               | 0 to below 90
emulate controlled.toml                                   | a world that needs no schedule, but found P1
emulate rig.toml --fault "gain lots" --write e.toml       | fault gain: expected off, or a number from -100 to 100, but found 'lots'
run not-emulated.toml --virtual                           | not-emulated.toml: expected a table [emulated], but found none.
run strong.toml --virtual                                 | schedule of S1, modular, stiffness preset: expected 20 to 80 % of the device's maximum, but found 85.7143 %.
run listed.toml --all --virtual --seed 1                  | --seed: expected a seed for a random order, but found 1.
run rig.toml --virtual --plate S9                         | --plate: expected S1, S3, S2, S4, S5, but found S9.
run rig.toml --virtual --plate S1 --all                   | --plate: expected --plate alone, but found a choice of runs beside it.
run far-plate.toml --virtual --plate S1                   | plate.f_max_n: expected a force above contact, 0.3 N, and below the guard rig.guards.force_n, 50 N
run rig.toml --virtual --plate S3 --calibration good.json | --calibration: expected presses of the tactile sensor
run rig.toml --virtual --order random                     | --order: expected --all beside this option, but found one run.
run rig.toml --virtual --seed 1                           | --seed: expected --all beside this option, but found one run.
run rig.toml --virtual --all --repetitions 3              | --repetitions: expected one run, but found --all.
run ONE --stop-at 5                                       | --stop-at: expected --calibration beside this option, but found none.
run ONE --camera c.toml                                   | --camera: expected --calibration beside this option, but found none.
run ONE --calibration none.json                           | none.json: expected a calibration file, but found No such file
run ONE --calibration broken.json                         | broken.json: expected a JSON object
run ONE --calibration old.json                            | old.json, version: expected version
run ONE --calibration edited.json                         | edited.json, sha256: expected the digest
run ONE --calibration other.json                          | --calibration: expected one calibration for 0 degrees, high-stiffness, but found other.json: 30 degrees, modular.
run ONE --calibration good.json --calibration twice.json  | expected one calibration for 0 degrees
run ONE --calibration pixels.json --camera c.toml         | --camera: expected a calibration in mm2
run ONE --calibration good.json --camera c.toml           | c.toml
run ONE --domes mine                                      | --domes: expected --calibration beside this option, but found none.
run ONE --calibration good.json --domes mine              | --domes: expected no tables of domes, but found mine.
run ONE --calibration own.json                            | --domes: expected the tables of domes that own.json was made with, mine, but found none.
run ONE --calibration own.json --domes none               | none: expected tables of domes
run ONE --calibration good.json --specimen-height-mm 9    | specimen_height_mm: expected tables of one dome, stiffness and friction on both sides of 9 mm, but found heights of 25 mm
run ONE --calibration quantity.json                       | quantity.json, quantity: expected front or edge
run ONE --calibration unit.json                           | unit.json, area_unit: expected mm2 or px2
run ADAPTIVE --specimen S3                                | --adaptive: expected --calibration beside this option, but found none.
run ADAPTIVE --calibration good.json                      | --specimen: expected one specimen, but found none.
run ADAPTIVE --specimen S1 --specimen S3 GOOD             | one specimen, but found S1, S3.
run ADAPTIVE --specimen S9 GOOD                           | specimen: expected S1, S3, but found S9.
run ADAPTIVE --specimen S3 --angle 0 GOOD                 | --angle: expected no choice of runs
run ADAPTIVE --specimen S3 --condition modular GOOD       | --condition: expected no choice of runs
run ADAPTIVE --specimen S3 --mounting 1 GOOD              | --mounting: expected no choice of runs
run ADAPTIVE --specimen S3 --all GOOD                     | --adaptive: expected no other choice of runs
run ADAPTIVE --plate S3                                   | --adaptive: expected no other choice of runs, but found --plate.
run ADAPTIVE --specimen S3 --calibration far.json         | angle: expected 0, 30, but found 45.
run ADAPTIVE --specimen S3 GOOD --calibration twice.json  | expected one calibration
run ADAPTIVE --specimen S3 --calibration none.json        | none.json: expected a calibration file
off                                                       | rig off: expected a rig file or --port, but found both or neither.
next none.json                                            | none.json: expected a calibration file
next good.json --done .                                   | plan.json: expected the plan of a run
"""  # noqa: E501
MISSPELT = """
scan --id -1                          | expected a device id of 0 to 255, but found '-1'
scan --id 256                         | expected a device id of 0 to 255, but found '256'
scan --id one                         | expected a device id of 0 to 255, but found 'one'
parameters rig.toml --set 13=a        | expected a number and its values, 13=1200, but found '13=a'
parameters rig.toml --set 1=7         | expected a parameter from 2; the id is changed with qbadmin
next good.json --presses 0            | expected a number of presses from 1 to 100, but found '0'
next good.json --presses many         | but found 'many'
next good.json --stop-at -3           | expected a percentage of kappa
run ONE GOOD --stop-at=0              | expected a percentage of kappa from 0.5 to 100, such as 5, but found
run ONE GOOD --stop-at=0.05           | expected a percentage of kappa
run ONE GOOD --stop-at=101            | expected a percentage of kappa
run ONE GOOD --stop-at=-5             | expected a percentage of kappa
run ONE GOOD --stop-at=five           | expected a percentage of kappa
run ONE GOOD --stop-at=nan            | expected a percentage of kappa
run ONE GOOD "--stop-at=5 N"          | expected a percentage of kappa
"""
SHORT = {
    "ONE": "rig.toml --virtual --specimen S3 --condition high-stiffness --jobs 1",
    "ADVANCED": "advanced.toml --specimen S1 --angle 0 --condition modular",
    "ADAPTIVE": "rig.toml --virtual --adaptive", "GOOD": "--calibration good.json",
}  # fmt: skip
CHANGED = {
    "advanced": ("[actuator]\n", '[actuator]\nmodel = "advanced"\n'),
    "not-emulated": ("[emulated]\ngap_mm = 2\n", ""),
    "controlled": (
        'modular = [0, 30] }\nrepetitions = 2\nf_max_n = 5\nramp_mm_per_s = 8\npause_s = 0.1\nschedules = "schedules"\n'
        "\n[emulated]",
        'modular = [0] }\nrepetitions = 2\nf_max_n = 5\nramp_mm_per_s = 8\npause_s = 0.1\nschedules = "schedules"\n'
        '\n[emulated]\ncontrol = "P1"',
    ),
    "strong": ("[rig.guards]", "[rig]\nmax_preset_ticks = 2800\n[rig.guards]"),
    "listed": ("repetitions = 2", 'repetitions = 1\norder = "listed"'),
    "far-plate": ("[emulated]", "[plate]\nf_max_n = 60\n\n[emulated]"),
    "rig": ("", ""),
}


@pytest.fixture
def lab(rig_file: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with rig files and calibrations of every kind."""
    monkeypatch.chdir(tmp_path)
    for name, change in CHANGED.items():
        rig_file(change).rename(tmp_path / f"{name}.toml")
    document = json.loads(write_calibration(tmp_path / "good.json", known_calibration()).read_text())
    (tmp_path / "broken.json").write_text("{")
    (tmp_path / "old.json").write_text(json.dumps(document | {"version": 0}))
    (tmp_path / "edited.json").write_text(json.dumps(document | {"angle_deg": 30}))
    write_calibration(tmp_path / "other.json", known_calibration("modular", 30.0))
    write_calibration(tmp_path / "far.json", known_calibration("modular", 45.0))
    write_calibration(tmp_path / "twice.json", known_calibration())
    write_calibration(tmp_path / "pixels.json", known_calibration(area_unit="px2"))
    write_calibration(tmp_path / "quantity.json", known_calibration(quantity="hexagons"))
    write_calibration(tmp_path / "own.json", replace(known_calibration(), provenance={"domes": "mine"}))
    write_calibration(tmp_path / "unit.json", known_calibration(area_unit="in2"))
    return tmp_path


def cases(table: str) -> Iterator[object]:
    for row in table.strip().splitlines():
        words, _, said = row.partition("|")
        for short, long in SHORT.items():
            words = words.replace(short, long)
        yield pytest.param(shlex.split(words), said.strip(), id=words.strip())


@pytest.mark.parametrize(("words", "said"), [*cases(REFUSED)])
def test_bad_input_is_one_line_and_nothing_is_written(
    lab: Path, rig: Callable[..., tuple[int, str, str]], words: list[str], said: str
) -> None:
    before = sorted(os.listdir(lab))
    status, out, err = rig(*words)
    assert (status, out) == (2, "")
    assert said in err
    assert len([line for line in err.strip().splitlines() if line != "1 problem; nothing was run."]) == 1
    assert sorted(os.listdir(lab)) == before


@pytest.mark.parametrize(("words", "said"), [*cases(MISSPELT)])
def test_what_is_misspelt_is_named(
    lab: Path, rig: Callable[..., tuple[int, str, str]], capsys: pytest.CaptureFixture[str], words: list[str], said: str
) -> None:
    with pytest.raises(SystemExit, match="2"):
        rig(*words)
    assert said in " ".join(capsys.readouterr().err.split())
