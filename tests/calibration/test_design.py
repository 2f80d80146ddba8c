"""How many specimens and presses are enough."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from emg2vsa.calibration.design import Situation, smallest, try_designs
from emg2vsa.cli import main
from emg2vsa.errors import SettingError

PAPER = Situation(kappa=5.32, kappa_range=(1.11, 7.63), noise=0.02, sensor_n_per_mm=4.0)


def test_more_presses_narrow_the_interval_by_their_root():
    few, many = try_designs(PAPER, (3,), (10, 40))
    assert few.half_width / many.half_width == pytest.approx(2, rel=0.1)
    assert many.error < few.error
    assert few.presses == 40


def test_intervals_of_every_design_cover():
    designs = try_designs(PAPER, (3, 6), (5, 20), experiments=2000)
    assert all(0.93 < design.coverage < 0.975 for design in designs)


def test_noise_that_is_twice_as_large_takes_four_times_the_presses():
    noisy = dataclasses.replace(PAPER, noise=0.04)
    (quiet,), (loud,) = try_designs(PAPER, (4,), (10,)), try_designs(noisy, (4,), (40,))
    assert loud.half_width == pytest.approx(quiet.half_width, rel=0.1)


def test_errors_of_the_known_stiffnesses_set_a_floor():
    off = dataclasses.replace(PAPER, kappa_error=0.03)
    (design,) = try_designs(off, (3,), (100,))
    assert design.half_width > 0.03
    assert 0.93 < design.coverage < 0.97


def test_mountings_set_a_floor_that_presses_do_not_lower():
    mounted = dataclasses.replace(PAPER, mounting_sd=0.025)
    few, many = try_designs(mounted, (3,), (10, 40), experiments=2000)
    assert few.half_width / many.half_width == pytest.approx(1, rel=0.1)
    assert many.half_width > 2 * try_designs(PAPER, (3,), (40,))[0].half_width
    assert 0.93 < many.coverage < 0.98


def test_the_smallest_design_that_is_good_enough():
    designs = try_designs(PAPER, (3, 4), (3, 10, 20), experiments=300)
    chosen = smallest(designs, 0.07)
    assert chosen is not None
    assert (chosen.specimens, chosen.repetitions) == (3, 10)
    assert smallest(designs, 0.001) is None


@pytest.mark.parametrize(
    "change",
    [{"noise": 0.0}, {"mounting_sd": -0.1}, {"mounting_sd": 0.6}, {"kappa_range": (2.0, 1.0)}, {"kappa": np.nan}],
)
def test_situations_that_cannot_be_are_named(change):
    with pytest.raises(SettingError, match="design"):
        dataclasses.replace(PAPER, **change)
    with pytest.raises(SettingError, match="2 or more"):
        try_designs(PAPER, (1,), (10,))


def test_the_command_prints_a_table_and_the_smallest(capsys):
    assert main(["tools", "design", "--experiments", "100", "--precision", "0.07"]) == 0
    said = capsys.readouterr().out
    assert said.startswith("specimens  presses each")
    assert "smallest design for 7%: 3 specimens, 10 presses" in said
    assert main(["tools", "design", "--experiments", "50", "--precision", "0.0001", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["smallest"] is None
    assert main(["tools", "design", "--noise", "-1"]) == 2
    assert "noise above 0" in capsys.readouterr().err
    assert main(["tools", "design", "--mounting", "0.7"]) == 2
    assert "a spread of mountings from 0 to below 0.5" in capsys.readouterr().err
    assert main(["tools", "design", "--experiments", "50", "--mounting", "0.025"]) == 0
    assert "every specimen is mounted once" in capsys.readouterr().out
