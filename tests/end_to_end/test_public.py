"""``import emg2vsa`` and ``import casr``: what they offer, what they load, and that they agree with the commands."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import casr
import emg2vsa
from emg2vsa.cli import main

OFFERED = {
    emg2vsa: "Emg2vsaError Recording Results Settings __version__ channels fit load plot_fits plot_press "
    "plot_specimens read run samples schedule stats trials",
    casr: "CasrError Score ScoreSettings StreamScorer __version__ find_presses frame_table open_frames read_camera "
    "score simulate_press",
}


def test_the_names_on_offer() -> None:
    for package, names in OFFERED.items():
        assert sorted(package.__all__) == sorted(names.split())
        assert dir(package) == sorted(names.split())
        assert all(getattr(package, name).__doc__ for name in package.__all__ if name != "__version__")
        with pytest.raises(AttributeError, match="no attribute 'scroe'"):
            _ = package.scroe


@pytest.mark.parametrize("package", ["emg2vsa", "casr"])
def test_an_import_loads_nothing(package: str) -> None:
    code = f"import sys; import {package}; print([n for n in ('numpy', 'pandas', 'scipy', 'cv2') if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.fixture(scope="module")
def file(simulated: Path) -> Path:
    return sorted(simulated.rglob("*.bdf"))[0]


@pytest.fixture(scope="module")
def recording(file: Path) -> emg2vsa.Recording:
    return emg2vsa.read(file, emg=["EDC", "FDS"], force="Fz", sign=-1)


def test_a_file_to_b_agrees_with_the_command(
    file: Path, recording: emg2vsa.Recording, capsys: pytest.CaptureFixture[str]
) -> None:
    fits = emg2vsa.fit(recording)
    main(["fit", str(file), "--emg", "EDC", "--emg", "FDS", "--force", "Fz", "--sign", "-1", "--json"])
    told = pd.DataFrame(json.loads(capsys.readouterr().out)["trials"])
    for name in ("repetition", "start_s", "a_v", "b_v", "b_lo_v", "b_hi_v", "adj_r2"):
        np.testing.assert_array_equal(fits[name], told[name])
    assert (fits["b_lo_v"] < fits["b_v"]).all()
    assert fits.attrs["activity_unit"] == "V"
    assert len(emg2vsa.trials(recording)) == len(fits)


def test_settings_are_one_object_and_say_what_they_change(recording: emg2vsa.Recording) -> None:
    settings = emg2vsa.Settings(window={"force_n": (1.0, 6.0)}, fit={"bin_n": 0.5})
    assert repr(settings) == "Settings(window={'force_n': (1.0, 6.0)}, fit={'bin_n': 0.5})"
    assert repr(emg2vsa.Settings()) == "Settings()"
    assert emg2vsa.Settings(paper=True).fit.points == "samples"
    assert not emg2vsa.fit(recording, settings)["b_v"].equals(emg2vsa.fit(recording)["b_v"])


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"windwo": {}}, "Did you mean 'window'?"),
        ({"fit": {"bin_m": 1}}, "bin_n"),
        ({"fit": {"bin_n": -1}}, "fit.bin_n: expected"),
        ({"fit": 3}, "expected a mapping of keys to values, but found 3"),
    ],
)
def test_settings_that_cannot_be(tables: dict[str, object], said: str) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError, match=r".") as refused:
        emg2vsa.Settings(**tables)  # type: ignore[arg-type]
    assert said in str(refused.value)


def test_a_table_of_samples_is_as_good_as_the_file(recording: emg2vsa.Recording) -> None:
    table = recording.to_frame()
    assert list(table.columns) == ["time_s", "EDC_v", "FDS_v", "force_n"]
    again = emg2vsa.read(table, emg={"EDC": "EDC_v", "FDS": "FDS_v"}, force="force_n")
    pd.testing.assert_frame_equal(emg2vsa.fit(again), emg2vsa.fit(recording), rtol=1e-9)


def test_samples_fit_as_their_recording_does(recording: emg2vsa.Recording) -> None:
    fits = emg2vsa.fit(recording)
    of_samples = emg2vsa.fit(emg2vsa.samples(recording))
    np.testing.assert_allclose(of_samples["b_v"], fits["b_v"], rtol=1e-12)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"emg": ["EDX"]}, "EDX"),
        ({"force": "F"}, "F"),
        ({"emg": []}, "channels.emg"),
        ({"sign": 2}, "channels.force.sign: expected"),
    ],
)
def test_channels_that_are_not_there(file: Path, change: dict[str, object], said: str) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError) as refused:
        emg2vsa.read(file, **{"emg": ["EDC"], "force": "Fz", **change})  # type: ignore[arg-type]
    assert said in str(refused.value)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"e": [0.0] * 9, "f": [0.0] * 9}, "sampling rate"),
        ({"e": [0.0] * 9, "f": [0.0] * 9, "time_s": [0, 1, 2, 3, 9, 10, 11, 12, 13]}, "times that rise by one step"),
        ({"x": [0.0] * 9, "f": [0.0] * 9, "time_s": range(9)}, "a column 'e', but found columns x, f, time_s"),
    ],
)
def test_tables_that_are_no_recording(table: dict[str, object], said: str) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError) as refused:
        emg2vsa.read(pd.DataFrame(table), emg=["e"], force="f")
    assert said in str(refused.value)


def test_what_is_no_recording_is_told(file: Path) -> None:
    with pytest.raises(emg2vsa.Emg2vsaError, match=r"expected a Recording.*Read the file first"):
        emg2vsa.trials(file)  # type: ignore[arg-type]


def test_the_results_of_a_study(ran_once: Path) -> None:
    study = ran_once / "studies" / "small" / "study.toml"
    found = emg2vsa.load(study)
    assert repr(found).startswith("Results('small', default mode: trials, fits")
    assert set(found.steps["status"]) <= {"fresh"}
    slopes = found.fits["b_v"].copy()
    changed = found.fits
    changed["b_v"], changed.attrs["study"] = 0.0, "none"
    pd.testing.assert_series_equal(found.fits["b_v"], slopes)
    assert len(found.trials) == len(found.fits) == 2 * 3 * 4
    assert found.fits.attrs["study"] == str(study)
    assert set(found.fits.attrs["results"]) == {
        f"{p}/{s}" for p in ("P01", "P02") for s in found.fits["specimen"].unique()
    }
    assert found.tests["p"].dropna().between(0, 1).all()
    assert set(found.schedules["condition"]) >= {"modular"}
    assert found.samples.groupby(["participant", "specimen", "repetition"]).ngroups == 24
    report = json.loads((ran_once / "reports" / "small" / "results.json").read_text())
    assert found.study.name in json.dumps(report)


def test_samples_of_a_study_are_fitted_as_the_study_does(ran_once: Path) -> None:
    found = emg2vsa.load(ran_once / "studies" / "small" / "study.toml")
    fits = emg2vsa.fit(found.samples, found.study)
    told = ["participant", "specimen", "repetition"]
    assert fits[told].to_numpy().tolist() == found.fits[told].to_numpy().tolist()
    np.testing.assert_allclose(fits["b_v"], found.fits["b_v"], rtol=1e-12)


def test_schedules_from_a_table_of_fits_are_those_of_the_study(ran_once: Path) -> None:
    found = emg2vsa.load(ran_once / "studies" / "small" / "study.toml")
    made = emg2vsa.schedule(found.fits, found.study.stiffness_n_per_mm, found.study)
    pd.testing.assert_frame_equal(made, found.schedules, rtol=1e-12)


def test_a_study_that_was_not_run(study: Path) -> None:
    found = emg2vsa.load(study)
    assert repr(found).endswith("nothing yet)")
    with pytest.raises(emg2vsa.Emg2vsaError, match=r"expected results of the stage fits.*emg2vsa run STUDY"):
        _ = found.fits


def test_a_study_runs_from_python(study: Path) -> None:
    assert len(emg2vsa.run(study, only="fits", jobs=1).fits) == 24
    with pytest.raises(emg2vsa.Emg2vsaError, match="but found 'fitz'"):
        emg2vsa.run(study, only="fitz")


def test_tests_on_a_frame_and_on_its_file_agree(tmp_path: Path) -> None:
    rng = np.random.default_rng(1)
    table = pd.DataFrame({"b": rng.normal(size=24), "g": np.tile(["x", "y", "z"], 8), "p": np.repeat(list("abcd"), 6)})
    table.to_csv(tmp_path / "t.csv", index=False)
    of_frame = emg2vsa.stats(table, value="b", group="g", block="p")
    pd.testing.assert_frame_equal(of_frame, emg2vsa.stats(tmp_path / "t.csv", value="b", group="g", block="p"))
    assert "Kruskal-Wallis" in " ".join(of_frame["method"])
    assert of_frame.attrs["text"]


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"value": "c"}, "a column 'c'"), ({"group": "gg"}, "Did you mean 'g'?"), ({"alpha": 2}, "between 0 and 0.5"),
        ({"margin": -1}, "above 0"), ({"value": "g"}, "finite numbers or NaN, but found 'x'"),
    ],
)  # fmt: skip
def test_tests_that_cannot_be(change: dict[str, object], said: str) -> None:
    table = pd.DataFrame({"b": [1.0, 2.0, 3.0, 5.0], "g": ["x", "x", "y", "y"]})
    with pytest.raises(emg2vsa.Emg2vsaError) as refused:
        emg2vsa.stats(table, **{"value": "b", "group": "g", **change})  # type: ignore[arg-type]
    assert said in str(refused.value)


def test_frames_to_casr_agrees_with_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from casr.cli import main as tactile

    assert tactile(["simulate", str(tmp_path / "presses"), "--repetitions", "1", "--specimens", "S3", "-q"]) == 0
    press, *_ = casr.find_presses(tmp_path / "presses")
    found = casr.score(press)
    capsys.readouterr()
    assert tactile(["score", str(press), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    told = told[0] if isinstance(told, list) else told
    assert found.rate is not None
    assert found.rate.value == pytest.approx(told["rate"]["value"], rel=1e-12)
    assert f"CASR {found.rate.value:.4g} mm2/N [" in repr(found)
    assert len(repr(found)) < 160
    table = pd.DataFrame(casr.frame_table(found))
    assert len(table) == len(found.frames)
    assert casr.score(casr.open_frames(press)).rate == found.rate
    with pytest.raises(casr.CasrError, match="no files beside frames that are open, but found camera"):
        casr.score(casr.open_frames(press), camera="camera.toml")
