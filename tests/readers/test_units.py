"""Spelling of units and their factors."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.readers.units import si_factor, split_unit


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("V", ("V", 1.0)), ("Volts", ("V", 1.0)), ("mV", ("V", 1e-3)), ("uV", ("V", 1e-6)), ("µV", ("V", 1e-6)),
        ("μV", ("V", 1e-6)), ("Âµ" + "V", ("V", 1e-6)), ("N", ("N", 1.0)), ("mN", ("N", 1e-3)), ("kN", ("N", 1e3)),
        ("kgf", ("N", 9.80665)), ("gf", ("N", 9.80665e-3)), ("lbf", ("N", 4.4482216152605)),
    ],
)  # fmt: skip
def test_voltages_and_forces(unit: str, expected: tuple[str, float]) -> None:
    kind, factor = si_factor(unit) or ("", 0.0)
    assert (kind, factor) == (expected[0], pytest.approx(expected[1], rel=1e-15))


@pytest.mark.parametrize("plural", ["", "s"])
@pytest.mark.parametrize(
    ("word", "expected"),
    [("volt", ("V", 1.0)), ("millivolt", ("V", 1e-3)), ("microvolt", ("V", 1e-6)), ("newton", ("N", 1.0))],
)
def test_units_as_words_in_any_case(word: str, plural: str, expected: tuple[str, float]) -> None:
    for spelling in (word + plural, (word + plural).capitalize(), (word + plural).upper()):
        assert si_factor(spelling) == expected


@pytest.mark.parametrize("unit", [None, "", "MN", "g", "%MVC", "Nmm", "counts", "lb"])
def test_all_else_is_no_voltage_and_no_force(unit: str | None) -> None:
    assert si_factor(unit) is None


@pytest.mark.parametrize(
    ("label", "expected"),
    [
        ("EMG (mV)", ("EMG", "mV")), ("Fz [N]", ("Fz", "N")), ("Fz[N]", ("Fz", "N")),
        ("EDC (left)", ("EDC (left)", None)),
        ("acquired data[ %(MVC)]", ("acquired data", "%(MVC)")), ("GYRO X (deg/s)", ("GYRO X", "deg/s")),
        ("VL (Channel 1->1) - GR08 (64)[uV]", ("VL (Channel 1->1) - GR08 (64)", "uV")),
        ("Ambient Pressure ()", ("Ambient Pressure", None)),
        ("EMG", ("EMG", None)), ("EMG [µV]", ("EMG", "uV")),
    ],
)  # fmt: skip
def test_unit_in_a_label(label: str, expected: tuple[str, str | None]) -> None:
    assert split_unit(label) == expected


@given(st.text(max_size=40))
def test_any_label_is_split_without_error_and_keeps_its_name(label: str) -> None:
    name, _ = split_unit(label)
    assert label.strip().startswith(name)
