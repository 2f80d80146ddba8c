"""What the public functions do with tables, options and settings as people give them, right and wrong."""

from __future__ import annotations

from decimal import Decimal
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

import casr
import emg2vsa

N, FS_HZ = 4000, 1000.0
TABLE = pd.DataFrame({"e": np.random.default_rng(0).normal(size=N) * 1e-4, "f": np.full(N, 2.0)})
TIME_S = np.arange(N) / FS_HZ
LEVEL = np.linspace(1.0, 8.0, 200)
SAMPLES = pd.DataFrame(
    {
        "participant": np.repeat(["B", "A"], 400),
        "specimen": np.tile(np.repeat(["S1", "S2"], 200), 2),
        "repetition": 1,
        "force_n": np.tile(LEVEL, 4),
        "activity_v": np.concatenate([1e-3 + b * np.log(LEVEL) for b in (1e-4, 2e-4, 3e-4, 4e-4)]),
    }
)
FITS = pd.DataFrame({"specimen": ["S1", "S1", "S2"], "a_v": 1e-4, "b_v": [3e-5, 3e-5, 2e-5]})
STIFFNESS = {"S1": 1.4, "S2": 0.6}
NOTHING: Any = None
THREE: Any = 3
TABLES: Any = {}
NAME: Any = "press"
GROUPS = pd.DataFrame({"b": [1.0, 2.0, 3.0, 5.0], "g": list("xxyy")})


def read(table: Any = TABLE, **options: Any) -> emg2vsa.Recording:
    return emg2vsa.read(table, **{"emg": ["e"], "force": "f", "fs_hz": FS_HZ, **options})


def stats(table: Any = GROUPS, **options: Any) -> pd.DataFrame:
    return emg2vsa.stats(table, **{"value": "b", "group": "g", **options})


def refused(ask: Any, said: str) -> None:
    with pytest.raises((emg2vsa.Emg2vsaError, casr.CasrError)) as error:
        ask()
    assert said in str(error.value)
    assert ": expected " in str(error.value)
    assert ", but found " in str(error.value)


@pytest.mark.parametrize(
    ("options", "newtons"),
    [
        ({}, 2.0), ({"force_unit": "mN"}, 2e-3), ({"force_unit": "kgf"}, 2 * 9.80665),
        ({"force_unit": "lbf"}, 2 * 0.45359237 * 9.80665), ({"newtons_per_unit": 3, "sign": -1}, -6.0),
        ({"force_unit": "V", "newtons_per_unit": 3}, 6.0), ({"fs_hz": np.float32(1000), "sign": np.int64(-1)}, -2.0),
    ],
)  # fmt: skip
def test_the_force_of_a_table_is_in_newtons(options: dict[str, Any], newtons: float) -> None:
    force = read(**options).roles.force
    assert force.unit == "N"
    np.testing.assert_allclose(force.samples, newtons, rtol=1e-14)
    assert (TABLE["f"] == 2.0).all()


def test_the_emg_of_a_table_is_in_volts_and_columns_may_have_numbers_for_names() -> None:
    emg = read(emg_unit="mV", gain=np.int64(100)).roles.emg["e"]
    np.testing.assert_allclose(emg.samples, TABLE["e"] * 1e-5, rtol=1e-14)
    found = read(TABLE.set_axis([0, 1], axis=1), emg=[np.int64(0)], force=1)
    np.testing.assert_array_equal(found.roles.emg["0"].samples, TABLE["e"])


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"force_unit": "V"}, "a force (N, mN, kN, lbf, kgf, gf), but found unit 'V'"),
        ({"force_unit": "N", "newtons_per_unit": 3}, "either a force unit or newtons_per_unit"),
        ({"emg": 3}, "read, emg: expected names"),
        ({"emg": [3.5]}, "read, emg: expected names of columns"),
        ({"emg": ["e", "e"]}, "found 'e' twice"),
        ({"emg": ["e", "f"]}, "found 'f' twice"),
        ({"emg": ["x"]}, "a column 'x'"),
        ({"table": np.zeros(3)}, "a file or a DataFrame, but found ndarray"),
        ({"table": {}}, "a file or a DataFrame, but found dict"),
        ({"table": None}, "a file or a DataFrame, but found NoneType"),
        ({"table": pd.concat([TABLE, TABLE], axis=1)}, "one column 'e', but found 2"),
        ({"table": TABLE.assign(e="a")}, "column 'e': expected numbers"),
        ({"table": TABLE.assign(f=np.nan)}, "finite samples"),
        ({"force_file": "f.csv"}, "none beside a DataFrame"),
        ({"settings": {"fit": {}}}, "expected emg2vsa.Settings, but found dict"),
        ({"fs_hz": "1000"}, "fs_hz: expected a number"),
        ({"table": TABLE.assign(time_s=TIME_S), "fs_hz": 500}, "1000 Hz, as time_s says, but found 500 Hz"),
    ],
)
def test_tables_that_cannot_be_read(options: dict[str, Any], said: str) -> None:
    refused(lambda: read(**options), said)


def test_a_force_of_a_file_of_its_own_may_have_the_name_of_an_emg(tmp_path: Path) -> None:
    for name, column in (("emg", "e"), ("force", "f")):
        table = pd.DataFrame({"time (s)": TIME_S, "ch1": TABLE[column]})
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    found = emg2vsa.read(
        tmp_path / "emg.csv", emg=["ch1"], force="ch1", force_file=tmp_path / "force.csv", emg_unit="V", force_unit="N"
    )
    np.testing.assert_array_equal(found.roles.force.samples, 2.0)


@pytest.mark.parametrize(
    ("time", "said"),
    [
        *((time, "'time_s': expected seconds as numbers") for time in (
            pd.to_timedelta(TIME_S, unit="s"), pd.to_datetime(TIME_S, unit="s"), TIME_S.astype(str),
            TIME_S.astype(str).astype(object),
        )),
        *((time, "times that rise by one step") for time in (
            TIME_S[::-1], np.zeros(N), np.append(TIME_S[1:], np.nan), TIME_S**2,
        )),
    ],
)  # fmt: skip
def test_times_that_are_no_numbers_or_not_even(time: Any, said: str) -> None:
    refused(lambda: read(TABLE.assign(time_s=time), fs_hz=None), said)


@pytest.mark.parametrize("fs_hz", [2148.15, 1925.93, 1259.26, 1111.11, 1000.0, 800.0, 148.148])
def test_times_rounded_to_milliseconds(fs_hz: float) -> None:
    time_s = np.round(5.1234 + np.arange(N) / fs_hz, 3)
    rounded = TABLE.assign(time_s=time_s)
    found = read(rounded, fs_hz=None).roles.force
    assert found.fs_hz == pytest.approx(fs_hz, rel=2e-3 / (time_s[-1] - time_s[0]))
    assert found.start_s == time_s[0]
    assert read(rounded, fs_hz=fs_hz).roles.force.fs_hz == fs_hz
    for lost in (1, 2, 50):
        gap = rounded.drop(range(N // 3, N // 3 + lost))
        refused(lambda gap=gap: read(gap, fs_hz=None), "times that rise by one step")


def test_a_table_of_many_people_is_fitted_press_by_press() -> None:
    found = emg2vsa.fit(SAMPLES)
    assert (found["participant"] + found["specimen"]).tolist() == ["BS1", "BS2", "AS1", "AS2"]
    np.testing.assert_allclose(found["b_v"], [1e-4, 2e-4, 3e-4, 4e-4], rtol=1e-2)
    mixed = emg2vsa.fit(SAMPLES.sample(frac=1.0, random_state=3)).sort_values("b_v")
    np.testing.assert_allclose(mixed["b_v"], found["b_v"], rtol=1e-9)
    plain = emg2vsa.fit(SAMPLES.iloc[:200][["force_n", "activity_v"]])
    assert plain["repetition"].tolist() == [1]
    assert plain["b_v"][0] == found["b_v"][0]


@pytest.mark.parametrize(
    ("table", "said"),
    [
        *((SAMPLES.assign(**{name: [None, *range(799)]}), f"column '{name}': expected a name in every row")
          for name in ("participant", "specimen", "repetition")),
        (SAMPLES.assign(activity_v="x"), "column 'activity_v': expected numbers"),
        (pd.concat([SAMPLES, SAMPLES[["force_n"]]], axis=1), "one column 'force_n', but found 2"),
        (SAMPLES.drop(columns="force_n"), "a column 'force_n'"),
        (SAMPLES.iloc[:0], "found no row"),
        (SAMPLES.assign(force_n=-1.0), "a force above 0 N"),
    ],
)  # fmt: skip
def test_samples_that_cannot_be_fitted(table: pd.DataFrame, said: str) -> None:
    refused(lambda: emg2vsa.fit(table), said)


@pytest.mark.parametrize("settings", [{}, "paper", 0])
@pytest.mark.parametrize("ask", [emg2vsa.fit, emg2vsa.trials, emg2vsa.samples])
def test_settings_of_another_kind(ask: Any, settings: Any) -> None:
    refused(lambda: ask(SAMPLES, settings), "settings: expected emg2vsa.Settings")


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"window": {"force_n": (6, 1)}}, "window.force_n: expected the smaller number first"),
        ({"filters": {"band_hz": (400, 10)}}, "filters.band_hz: expected the smaller number first"),
        ({"schedule": {"stiffness_percent": (80, 20)}}, "schedule.stiffness_percent: expected the smaller"),
        ({"fit": {"bin_n": 3}}, "fit.bin_n: expected at most"),
        ({"paper": "no"}, "paper: expected True or False"),
        ({"window": {1: 2}}, "window: expected keys as text, but found 1"),
    ],
)
def test_settings_that_contradict_each_other(tables: dict[str, Any], said: str) -> None:
    refused(lambda: emg2vsa.Settings(**tables), said)


def test_settings_and_schedules_of_numpy_and_of_numbers_held_as_objects() -> None:
    settings = emg2vsa.Settings(window={"force_n": np.array([1.0, 6.0])}, fit={"bin_n": np.float64(0.25)})
    assert settings == emg2vsa.Settings(window={"force_n": (1.0, 6.0)}, fit={"bin_n": 0.25})
    made = emg2vsa.schedule(FITS, STIFFNESS)
    pd.testing.assert_frame_equal(emg2vsa.schedule(FITS.astype({"b_v": object}), STIFFNESS), made)
    alone = emg2vsa.Settings(profile={"specimens": ["S1"]})
    assert set(emg2vsa.schedule(FITS, {"S1": np.float64(1.4), "S2": np.nan}, alone)["specimen"]) == {"S1"}


def test_schedules_have_the_interval_of_their_stiffness_where_every_specimen_was_pressed_twice() -> None:
    ends = ["stiffness_low_percent", "stiffness_high_percent"]
    assert emg2vsa.schedule(FITS, STIFFNESS)[ends].isna().all(axis=None)
    twice = pd.concat([FITS.assign(b_v=[2.8e-5, 3.2e-5, 1.9e-5]), FITS.tail(1)])
    made = emg2vsa.schedule(twice, STIFFNESS)
    assert (made[ends[0]] <= made["stiffness_percent"]).all()
    assert (made["stiffness_percent"] <= made[ends[1]]).all()
    assert (made[ends[1]] - made[ends[0]]).max() > 1


@pytest.mark.parametrize(
    ("fits", "stiffness", "settings", "said"),
    [
        (FITS, {"S1": 1.4}, None, "specimen 'S2': expected a number above 0, in N/mm, but found none"),
        *((FITS, {"S1": 1.4, "S2": value}, None, "specimen 'S2': expected a number above 0")
          for value in (None, np.nan, np.inf, -1, 0, "3", True)),
        (FITS, 3, None, "specimen to its stiffness, but found int"),
        ([FITS], STIFFNESS, None, "a DataFrame, but found list"),
        (FITS, STIFFNESS, {}, "emg2vsa.Settings, but found dict"),
        (FITS.assign(b_v="q"), STIFFNESS, None, "column 'b_v': expected numbers"),
        (FITS.assign(specimen=["S1", NOTHING, "S2"]), STIFFNESS, None, "column 'specimen': expected a name"),
        (FITS.assign(participant=np.nan), STIFFNESS, None, "column 'participant': expected a name"),
    ],
)  # fmt: skip
def test_schedules_that_cannot_be(fits: Any, stiffness: Any, settings: Any, said: str) -> None:
    refused(lambda: emg2vsa.schedule(fits, stiffness, settings), said)


def test_tests_are_exact_for_whole_numbers_and_decimals() -> None:
    small = [1, 2, 4, 3, 5, 8]
    groups = list("xxxyyy")
    of_small = stats(pd.DataFrame({"b": small, "g": groups}))
    between = of_small["of"].isin(["groups", "x - y"])
    for shift in (2**60, Decimal(2**60)):
        large = pd.DataFrame({"b": [shift + one for one in small], "g": groups})
        found = stats(large)
        np.testing.assert_allclose(found["p"][between], of_small["p"][between], rtol=1e-9)
        assert found["p"][between].notna().any()


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"alpha": "0.05"}, "alpha: expected a level"), ({"alpha": None}, "alpha: expected a level"),
        ({"margin": "1"}, "margin: expected a number above 0"), ({"group": None}, "group: expected a column's name"),
        ({"value": ["b"]}, "value: expected a column's name"), ({"table": GROUPS["b"]}, "but found Series"),
        ({"table": np.zeros(3)}, "but found ndarray"), ({"table": None}, "but found NoneType"),
        ({"table": "nowhere.csv"}, "nowhere.csv: expected a readable file"),
        *(({"table": GROUPS.assign(b=pd.Series([bad, 1, 2, 3], dtype=object))}, "'b': expected finite numbers or NaN")
          for bad in (10**400, 10**5000, Decimal("1e400"), Decimal("sNaN"), np.inf, [1], (0, (1,), 0))),
    ],
)  # fmt: skip
def test_tests_of_what_is_no_table(change: dict[str, Any], said: str) -> None:
    refused(lambda: stats(**change), said)


@pytest.mark.parametrize(
    ("ask", "said"),
    [
        (lambda: emg2vsa.channels(NOTHING), "the path of a file, but found NoneType"),
        (lambda: emg2vsa.load(NOTHING), "the path of a study file, but found NoneType"),
        (lambda: emg2vsa.run(THREE), "the path of a study file, but found int"),
        *((lambda jobs=jobs: emg2vsa.run("s.toml", jobs=jobs), "jobs: expected a whole number from 1")
          for jobs in ("2", -1, 0, 1.5, True)),
        (lambda: emg2vsa.read("nowhere.csv", emg=["e"], force="f"), "No such file or directory. Check the path."),
        (lambda: casr.score(NOTHING), "a path or open frames, but found NoneType"),
        (lambda: casr.score("press", TABLES), "casr.ScoreSettings, but found dict"),
        (lambda: casr.score("press", NAME), "casr.ScoreSettings, but found str"),
        (lambda: casr.frame_table(NAME), "a Score, but found str"),
    ],
)  # fmt: skip
def test_what_is_of_another_kind(ask: Any, said: str) -> None:
    refused(ask, said)
