"""Spelling of units and their factors.

The clock found in time stamps.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.errors import RecordingError
from emg2vsa.readers.timing import even_clock
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


def clock(time: np.ndarray, resolution_s: float = 0.0) -> tuple[float, float]:
    return even_clock(time, "x.csv, time", lambda row: f"line {row + 2}", resolution_s)


@given(st.floats(1.0, 20000.0), st.integers(3, 4000), st.floats(-100.0, 1000.0), st.integers(0, 2**32 - 1))
def test_rate_and_start_come_back_whatever_the_jitter(fs: float, n: int, start: float, seed: int) -> None:
    """Of a tenth of an interval: then no step exceeds 1.5 times the median of however few steps."""
    jitter = np.random.default_rng(seed).uniform(-0.099, 0.099, n) / fs
    jitter[[0, -1]] = 0.0
    fs_hz, start_s = clock(start + np.arange(n) / fs + jitter)
    assert fs_hz == pytest.approx(fs, rel=1e-7)
    assert start_s == pytest.approx(start, abs=1e-9)


def test_stamps_rounded_to_a_tenth_of_a_millisecond_do_not_bend_the_rate() -> None:
    fs = 1925.925926  # every step is 0.5 or 0.6 ms, so the median step would say 2000 Hz
    assert clock(np.round(np.arange(20000) / fs, 4))[0] == pytest.approx(fs, rel=1e-5)


def test_stamps_with_seven_digits_beyond_a_thousand_seconds() -> None:
    fs = 1925.925926
    time = np.array([float(f"{i / fs:.7g}") for i in range(1930000, 1960000)])
    assert (np.diff(time) == 0).any()
    assert clock(time, resolution_s=1e-3)[0] == pytest.approx(fs, rel=1e-4)
    with pytest.raises(RecordingError, match="same stamp again"):
        clock(time)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        (lambda t: np.insert(t, 5, t[4]), r"line 7: .*same stamp again"),
        (lambda t: np.delete(t, [10, 11]), r"line 12: .*a gap of 0.003 s after 0.009 s"),
        (lambda t: t[::-1], r"line 3: .*a step back"),
        (lambda t: np.where(np.arange(t.size) == 3, np.nan, t), r"line 5: expected a time stamp"),
        (lambda t: t[:1], r"at least two"),
    ],
)
def test_faults_are_named_with_their_line(fault, message: str) -> None:
    with pytest.raises(RecordingError, match=message):
        clock(fault(np.arange(100) / 1000.0))


@pytest.mark.parametrize(("fs_hz", "digits"), [(1000.0, 3), (1259.259, 4), (2000.0, 4), (2148.148, 4)])
@pytest.mark.parametrize("lost", [1, 27])
def test_samples_lost_in_the_middle_of_rounded_stamps_are_found(fs_hz: float, digits: int, lost: int) -> None:
    whole = np.round(np.arange(20000) / fs_hz, digits)
    assert clock(whole)[0] == pytest.approx(fs_hz, rel=1e-5)
    with pytest.raises(RecordingError, match=r"line 9002: .*found a gap of .*\(1 gaps\)"):
        clock(np.delete(whole, slice(9000, 9000 + lost)))


def test_a_rate_that_drifts_is_refused() -> None:
    with pytest.raises(RecordingError, match="evenly spaced"):
        clock(np.cumsum(np.linspace(1e-3, 1.2e-3, 1000)))
