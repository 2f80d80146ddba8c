"""The truth kit: silicones that have a wanted stiffness, as published, as written, and as measured."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from casr.specimens import SPECIMENS
from emg2vsa.cli import main
from emg2vsa.curves.rubber import Cylinder
from emg2vsa.rig_file.plate_logs import Asked, read_plates
from emg2vsa.rig_file.silicone_kit import OFF_SD, SILICONES, kappa_of, recipe_for
from emg2vsa.study_file import load_study

ROOT = Path(__file__).resolve().parents[2]
RANGE_N = (0.5, 7.0)


def test_kappa_is_the_secant_of_a_neo_hookean_cylinder() -> None:
    silicone, size = SILICONES[2], Cylinder(50, 30)
    kappa, change, strain = kappa_of(silicone, size, RANGE_N)
    # F = E A / 3 (s^-2 - s), s = 1 - strain, by bisection
    area = np.pi / 4 * 50**2

    def depth(force: float) -> float:
        low, high = 0.0, 29.0
        for _ in range(60):
            middle = (low + high) / 2
            s = 1 - middle / 30
            low, high = (
                (middle, high) if silicone.modulus_kpa * 1e-3 * area / 3 * (s**-2 - s) < force else (low, middle)
            )
        return low

    assert kappa == pytest.approx(6.5 / (depth(7) - depth(0.5)), rel=1e-4)
    assert strain == pytest.approx(depth(7) / 30, rel=1e-4)
    ends = [0.01 / (depth(force + 0.005) - depth(force - 0.005)) for force in RANGE_N]
    assert change == pytest.approx((ends[1] - ends[0]) / kappa, rel=1e-3)


@pytest.mark.parametrize("wanted", [*SPECIMENS.values(), 0.6, 10.0])
def test_the_cylinder_has_the_wanted_stiffness(wanted: float) -> None:
    found = recipe_for("S", wanted)
    assert found.kappa_n_per_mm == pytest.approx(wanted, rel=3e-3)
    assert 20 <= found.size.height_mm <= 50
    assert found.low < wanted < found.high
    others = [kappa_of(each, Cylinder(50, height), RANGE_N) for each in SILICONES for height in range(20, 51)]
    alike = [strain for kappa, _, strain in others if abs(kappa / wanted - 1) < 5e-3]
    assert found.strain < 1.05 * min(alike, default=1.0)


def test_of_one_height_the_nearest_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "cast", "--height", "30", "--stiffness", "S1=7.6", "--stiffness", "A=20"]) == 0
    said = capsys.readouterr().out
    assert "note: A: no silicone at this height is nearer to 20 N/mm" in said
    assert "A and S1 may come out in either order" in said or "S1 and A may come out in either order" in said
    assert main(["tools", "cast", "--height", "30", "--stiffness", "S1=7.6", "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)
    assert (row["silicone"]["name"], row["size"]["height_mm"]) == ("EF50_12_5T", 30)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--stiffness", "A=20"], "stiffness of A: expected 0.42 to 11 N/mm, as cylinders of 50 mm have"),
        (["--to", "70"], "expected 1.9 to 15 N/mm"),
        (["--diameter", "0"], "--diameter: expected millimetres above 0, but found 0"),
        (["--height", "-3"], "--height: expected millimetres above 0, but found -3"),
        (["--from", "9"], "range of force: expected 0 < F0 < F1, newtons, but found 9 to 7"),
        (["--stiffness", "A"], "--stiffness: expected NAME=NUMBER in N/mm"),
    ],
)
def test_what_cannot_be_cast_is_one_line(words: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "cast", *words]) == 2
    assert said in capsys.readouterr().err


def test_the_study_s_specimens_are_what_the_command_writes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    kept, written = ROOT / "studies" / "silicone" / "specimens.toml", tmp_path / "specimens.toml"
    assert main(["tools", "cast", "--write", str(written)]) == 0
    assert written.read_text() == kept.read_text()
    assert main(["tools", "cast", "--write", str(written)]) == 2
    assert "expected a new file" in capsys.readouterr().err
    study = tmp_path / "study.toml"
    study.write_text(
        f'[study]\nname = "kit"\n\n[participants]\nids = ["P1"]\n\n{kept.read_text()}\n'
        '[channels.emg.EDC]\nname = "a"\n\n[channels.emg.FDS]\nname = "b"\n\n[channels.force]\nname = "Fz"\n\n'
        '[recordings]\nlayout = "pattern"\npattern = "{participant}_{specimen}.csv"\n'
    )
    specimens = load_study(study).specimens
    assert {each.name: each.stiffness_n_per_mm for each in specimens} == pytest.approx(SPECIMENS)
    assert specimens[0].size_mm == (50, 29.8)


def test_the_page_has_the_kappa_of_the_code() -> None:
    page = (ROOT / "docs" / "how-to" / "known-softness.md").read_text()
    for each in SILICONES:
        kappa = kappa_of(each, Cylinder(50, 30), RANGE_N)[0]
        assert f"| {each.name} | {each.recipe} | {each.modulus_kpa:g} ± {each.sd_kpa:g} | {kappa:.3g} |" in page


def test_real_castings_are_as_soft_as_the_kit_says(shared_data: Callable[[str], Path]) -> None:
    found = read_plates(sorted(shared_data("phantoms").glob("*/*.csv")), Asked())
    off = []
    for each in SILICONES:
        of = found.specimen(each.name)
        assert of is not None
        off.append(of.kappa.mean / kappa_of(each, Cylinder(50, 30), RANGE_N)[0] - 1)
    assert np.sqrt(np.mean(np.square(off))) == pytest.approx(OFF_SD, abs=5e-4)
    assert max(map(abs, off)) < 2 * OFF_SD
