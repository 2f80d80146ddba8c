"""A DataFrame with the headers of a file gives the recording that the file gives."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import emg2vsa

N = 4000
_DRAWN = np.random.default_rng(0)


def table(*headers: str, time: float = 1.0, emg: float = 1.0, force: float = 1.0) -> pd.DataFrame:
    """Columns of a time in s, an EMG in V and a force in N, each times a factor."""
    columns = np.arange(N) / 1000 * time, _DRAWN.normal(size=N) * 1e-4 * emg, np.full(N, 2.0) * force
    return pd.DataFrame(np.column_stack(columns), columns=list(headers))


@pytest.mark.parametrize(
    "given",
    [
        table("time [s]", "EDC [V]", "Fz [N]"), table("time (ms)", "EDC (mV)", "Fz (mN)", time=1e3, emg=1e3, force=1e3),
        table("time_ms", "EDC_mV", "Fz_N", time=1e3, emg=1e3), table("X [s]", "EDC (uV)", "Fz (kgf)", emg=1e6),
        table("timestamp (s)", "EDC [Volts]", "Fz [Newtons]"),
    ],
    ids=lambda given: given.columns[0],
)  # fmt: skip
@pytest.mark.parametrize("whole", [False, True], ids=["names", "headers"])
def test_headers_of_a_table_mean_what_those_of_a_file_mean(given: pd.DataFrame, whole: bool, tmp_path: Path) -> None:
    given.to_csv(tmp_path / "a.csv", index=False, float_format="%.12g")
    emg, force = ("EDC", "Fz")
    of_file = emg2vsa.read(tmp_path / "a.csv", emg=[emg], force=force)
    if whole:
        emg, force = given.columns[1:]
    of_table = emg2vsa.read(given, emg={"EDC": emg}, force=force)
    for one, other in (
        (of_table.roles.emg["EDC"], of_file.roles.emg["EDC"]),
        (of_table.roles.force, of_file.roles.force),
    ):
        assert (one.unit, one.fs_hz, one.start_s) == (other.unit, pytest.approx(other.fs_hz), other.start_s)
        np.testing.assert_allclose(one.samples, other.samples, rtol=1e-9, atol=1e-15)


def test_what_is_said_may_be_what_the_header_says() -> None:
    given = table("time [s]", "EDC [µV]", "Fz [Newtons]")
    said = emg2vsa.read(given, emg=["EDC"], force="Fz", emg_unit="uV", force_unit="N")
    np.testing.assert_allclose(said.roles.emg["EDC"].samples, given["EDC [µV]"] * 1e-6)
    np.testing.assert_allclose(said.roles.force.samples, 2.0)


def test_a_time_without_a_unit_counts_only_where_no_rate_is_given() -> None:
    given = table("time", "EDC", "Fz", time=7.0)
    assert emg2vsa.read(given, emg=["EDC"], force="Fz").roles.force.fs_hz == pytest.approx(1000 / 7)
    assert emg2vsa.read(given, emg=["EDC"], force="Fz", fs_hz=1000).roles.force.fs_hz == 1000


@pytest.mark.parametrize(
    ("given", "options", "said"),
    [
        (table("time [s]", "EDC [V]", "Fz [N]"), {"emg": ["FDS"]}, "a column 'FDS', but found columns time [s]"),
        (table("EDC [V]", "EDC (mV)", "Fz"), {"fs_hz": 1000}, "expected a column 'EDC'"),
        (table("t [s]", "time [s]", "Fz"), {"emg": ["Fz"], "force": "t [s]"}, "a rate in Hz for a DataFrame"),
        (table("time [s]", "EDC [counts]", "Fz"), {}, "but found unit 'counts'"),
        (table("time [s]", "EDC", "Fz [counts]"), {}, "but found unit 'counts'"),
        (table("time [s]", "EDC", "Fz"), {"fs_hz": 500}, "1000 Hz, as time [s] says"),
        (table("time [s]", "EDC", "Fz").iloc[::-1], {}, "DataFrame, time [s]: expected times that rise"),
        (
            table("time [s]", "EDC (mV)", "Fz"), {"emg_unit": "uV"},
            "read, emg_unit: expected mV, as EDC (mV) says, but found 'uV'. Leave emg_unit out, or rename the column.",
        ),
        (table("time [s]", "EDC", "Fz [N]"), {"force_unit": "kgf"}, "force_unit: expected N, as Fz [N] says"),
        (table("time [s]", "EDC", "Fz").assign(EDC=True), {}, "column 'EDC': expected numbers, but found bool values"),
        (
            table("time [s]", "EDC", "Fz").assign(EDC=np.array([True, 1.0] * (N // 2), dtype=object)), {},
            "column 'EDC': expected numbers, but found True",
        ),
    ],
)  # fmt: skip
def test_headers_that_tell_nothing_or_too_much_are_refused(
    given: pd.DataFrame, options: dict[str, object], said: str
) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError) as error:
        emg2vsa.read(given, **{"emg": ["EDC"], "force": "Fz", **options})
    assert said in str(error.value)
