"""``emg2vsa tools sample``: every sample is used here by the command it was made for.

``emg2vsa tools stiffness`` on logs as people export them.
"""

from __future__ import annotations

import hashlib
import json
import pkgutil
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import casr
import emg2vsa
from benchmarks.plate_force_range import rubber
from casr.specimens import SPECIMENS
from emg2vsa import fit, read, stats
from emg2vsa.cli import main
from emg2vsa.cli.tools.data import NAMES
from emg2vsa.errors import SettingError
from emg2vsa.sample_data import SAMPLES, write_sample
from emg2vsa.study import Specimen
from emg2vsa.study_file import load_study, missing_files


def test_the_command_offers_every_sample() -> None:
    assert tuple(SAMPLES) == NAMES


def test_recordings_hold_the_slopes_they_were_made_from(tmp_path: Path) -> None:
    made = write_sample("recordings", tmp_path)
    assert [path.name for path in made] == ["anna_hard.csv", "anna_soft.csv", "ben_hard.csv", "ben_soft.csv"]
    for path, b_v in ((made[0], 20e-6), (made[3], 7e-6)):
        found = fit(read(path, emg=["EDC", "FDS"], force="Fz"))
        assert list(found["verdict"]) == ["ok"] * 5
        assert found["b_v"].mean() == pytest.approx(b_v, rel=0.1)


def test_plate_logs_give_the_stiffness_of_the_specimens(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["tools", "sample", "plate", "--out", str(tmp_path), "--json"]) == 0
    files = json.loads(capsys.readouterr().out)["files"]
    assert main(["tools", "stiffness", "--json", *files]) == 0
    rows = json.loads(capsys.readouterr().out)["trials"]
    found = [row["stiffness_n_per_mm"] for row in rows]
    np.testing.assert_allclose(found, [SPECIMENS[row["specimen"]] for row in rows], rtol=0.01)
    assert len(rows) == 10


def test_slopes_differ_between_specimens(tmp_path: Path) -> None:
    (path,) = write_sample("slopes", tmp_path)
    assert stats(path, value="b", group="specimen", block="participant")["p"].min() < 1e-6
    assert len(path.read_text().splitlines()) == 1 + 10 * 3 * 3


def test_presses_score_and_the_soft_one_spreads_faster(tmp_path: Path) -> None:
    hard, soft = (casr.score(path).rate.value for path in write_sample("presses", tmp_path))
    assert hard == pytest.approx(65.2, rel=0.1)
    assert soft == pytest.approx(90.0, rel=0.1)


def test_the_study_has_all_its_recordings(tmp_path: Path) -> None:
    path, *recordings = write_sample("study", tmp_path)
    assert missing_files(load_study(path)) == ()
    assert len(recordings) == 12


def test_the_same_name_gives_the_same_bytes(tmp_path: Path) -> None:
    one, two = (write_sample("recordings", tmp_path / name)[0].read_bytes() for name in ("one", "two"))
    assert hashlib.sha256(one).digest() == hashlib.sha256(two).digest()


def test_files_are_replaced_on_request_only(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (path,) = write_sample("slopes", tmp_path)
    path.write_text("mine")
    assert main(["tools", "sample", "slopes", "--out", str(tmp_path)]) == 2
    assert "expected an empty or absent folder, but found files in it. Choose another" in capsys.readouterr().err
    assert path.read_text() == "mine"
    assert main(["tools", "sample", "slopes", "--out", str(tmp_path), "--overwrite"]) == 0
    assert path.read_text() != "mine"


def test_presses_are_replaced_on_request(tmp_path: Path) -> None:
    first = write_sample("presses", tmp_path)
    assert write_sample("presses", tmp_path, overwrite=True) == first


def test_an_unknown_name_is_told_with_the_nearest(tmp_path: Path) -> None:
    with pytest.raises(SettingError, match=r"expected one of .*, but found 'slope'. Did you mean slopes\?"):
        write_sample("slope", tmp_path / "new")
    assert not (tmp_path / "new").exists()


def test_no_module_hides_a_public_name() -> None:
    for package in (emg2vsa, casr):
        modules = {module.name for module in pkgutil.iter_modules(package.__path__)}
        assert modules.isdisjoint(package.__all__)


def write_log(path: Path, text: str) -> Path:
    path.write_text(text)
    return path


def rows(kappa: float, prefix: str = "", separator: str = ",", decimal: str = ".") -> str:
    depth = np.linspace(-0.2, 1.5, 120)
    lines = (f"{prefix}{x:.4f}{separator}{kappa * max(x, 0):.5f}" for x in depth)
    return "\n".join(line.replace(".", decimal) for line in lines) + "\n"


def test_a_file_for_each_specimen(tmp_path, capsys):
    for name, kappa in (("S1", 7.63), ("S5", 1.11)):
        write_log(tmp_path / f"{name}.csv", "indentation_mm,force_n\n" + rows(kappa))
    assert main(["tools", "stiffness", str(tmp_path / "S1.csv"), str(tmp_path / "S5.csv")]) == 0
    said = capsys.readouterr().out
    assert 'name = "S1"\nstiffness_n_per_mm = 7.6' in said
    assert "worst adjusted R2 1.0000" in said


def test_many_trials_in_one_table_with_decimal_commas(tmp_path, capsys):
    text = "specimen;trial;indentation_mm;force_n\n"
    text += rows(3.30, "S3;1;", ";", ",") + rows(3.40, "S3;2;", ";", ",")
    assert main(["tools", "stiffness", "--json", str(write_log(tmp_path / "plate.csv", text))]) == 0
    found = json.loads(capsys.readouterr().out)["trials"]
    assert [(row["specimen"], row["trial"]) for row in found] == [("S3", "1"), ("S3", "2")]
    np.testing.assert_allclose([row["stiffness_n_per_mm"] for row in found], [3.30, 3.40], rtol=1e-3)


def test_a_force_of_the_wrong_sign_is_said_and_fails(tmp_path, capsys):
    path = write_log(tmp_path / "S1.csv", "indentation_mm,force_n\n" + rows(-7.63))
    assert main(["tools", "stiffness", str(path)]) == 1
    assert "is the sign of either right?" in capsys.readouterr().out


def test_kappa_over_a_range_of_force_goes_into_the_study_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A rubber of 30 kPa as a testing machine logs it up to 11.9 N, over the forces of the study, and over others."""
    deep = np.arange(0, 8, 0.0167)
    force = rubber(30)(deep)

    def kappa(from_n: float, to_n: float) -> float:
        return float((to_n - from_n) / np.diff(np.interp([from_n, to_n], force, deep))[0])

    table = "".join(f"{t / 10:.1f},{x:.5f},{f:.5f}\n" for t, (x, f) in enumerate(zip(deep[:300], force, strict=False)))
    head = "S1_sample_1\nCylinder Height: 30mm;\nTime (s),Compression (mm),Load (N)\n"
    log = write_log(tmp_path / "a.csv", head + table)
    study = write_log(tmp_path / "study.toml", '[window]\nforce_n = [1, 5]\n\n[[specimens]]\nname = "S1"\n')
    assert main(["tools", "stiffness", str(log), "--write", str(study), "--json"]) == 0
    (row,) = json.loads(capsys.readouterr().out)["trials"]
    assert row["stiffness_n_per_mm"] == pytest.approx(kappa(1, 5), rel=1e-3)
    assert (row["force_from_n"], row["force_to_n"], row["height_mm"], row["rating"]) == (1, 5, 30, "good")
    ends = [(each["force_n"], each["low"] <= each["kappa_n_per_mm"] <= each["high"]) for each in row["tangent"]]
    assert (ends[0], ends[-1]) == ((1, True), (5, True))
    assert row["nonlinear"]
    (specimen,) = tomllib.loads(study.read_text())["specimens"]
    assert specimen["stiffness_n_per_mm"] == pytest.approx(kappa(1, 5), rel=1e-3)
    assert specimen["stiffness_range_n"] == [1, 5]

    study.write_text('[window]\nforce_n = [1, 15]\n\n[[specimens]]\nname = "S1"\n')
    assert main(["tools", "stiffness", str(log), "--write", str(study)]) == 0
    (specimen,) = tomllib.loads(study.read_text())["specimens"]
    assert specimen["stiffness_n_per_mm"] == pytest.approx(kappa(*specimen["stiffness_range_n"]), rel=1e-3)
    keys = ("stiffness_n_per_mm", "stiffness_se_n_per_mm", "plate_adjusted_r2", "stiffness_range_n", "stiffness_change")
    over, error = Specimen("S1", *map(specimen.get, keys)).stiffness_over((1, 15))
    assert abs(over - kappa(1, 15)) < 0.5 * abs(specimen["stiffness_n_per_mm"] - kappa(1, 15))
    assert abs(over - kappa(1, 15)) < error

    capsys.readouterr()
    assert main(["tools", "stiffness", str(log), "--to", "20"]) == 1
    assert "unusable: the force reaches " in capsys.readouterr().out
    study.write_text('[window]\nforce_n = 5\n\n[[specimens]]\nname = "S1"\n')
    assert main(["tools", "stiffness", str(log), "--write", str(study)]) == 2
    assert "study.toml, window.force_n: expected two forces, but found 5" in capsys.readouterr().err


CASTINGS = """specimen;casting;mounting;trial;indentation_mm;force_n
"""


def told(capsys: pytest.CaptureFixture[str], *words: str) -> dict[str, Any]:
    assert main(["tools", "stiffness", "--json", *words]) == 0
    (found,) = json.loads(capsys.readouterr().out)["specimens"]
    return found


def test_presses_mountings_and_castings_are_counted_and_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    cells = [("A", "1", 3.3), ("A", "1", 3.31), ("A", "2", 3.36), ("B", "1", 3.6), ("B", "1", 3.61)]
    text = CASTINGS + "".join(
        rows(kappa, f"S3;{casting};{mounting};{trial};", ";") for trial, (casting, mounting, kappa) in enumerate(cells)
    )
    log = str(write_log(tmp_path / "all.csv", text))
    found = told(capsys, log)
    assert [found[level] for level in ("presses", "mountings", "castings")] == [5, 3, 2]
    assert found["stiffness_n_per_mm"] == pytest.approx(((3.305 + 3.36) / 2 + 3.605) / 2, rel=2e-3)
    assert (found["holds_for_further"], found["modulus"], found["notes"]) == ("castings", None, [])
    ends = [found["intervals"][level] for level in ("presses", "mountings", "castings")]
    widths = [each["high"] - each["low"] for each in ends]
    assert widths == sorted(widths)
    assert widths[-1] == pytest.approx(found["high"] - found["low"])

    one = write_log(tmp_path / "one.csv", CASTINGS + rows(3.3, "S3;A;1;1;", ";"))
    wide = told(capsys, str(one))
    assert [note.split(":")[0] for note in wide["notes"]] == ["one press", "one mounting", "one casting"]
    assert wide["standard_error"] == pytest.approx(3.3 * np.sqrt(0.01**2 + 0.02**2 + 0.035**2), rel=0.01)
    this = told(capsys, str(one), "--castings", "0", "--mountings", "5")
    assert this["standard_error"] == pytest.approx(3.3 * np.sqrt(0.01**2 + 0.05**2), rel=0.01)


def test_a_study_file_gives_the_size_of_a_cylinder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    deep = np.arange(-0.5, 8, 0.0167)
    force = rubber(30, 40, 60)(deep)
    table = "".join(f"{x:.5f},{f:.5f}\n" for x, f in zip(deep, force, strict=True))
    log = str(write_log(tmp_path / "S1.csv", "indentation_mm,force_n\n" + table))
    study = tmp_path / "study.toml"
    study.write_text('[[specimens]]\nname = "S1"\ndiameter_mm = 60\nheight_mm = 40\n')
    loose = told(capsys, log, "--study", str(study))
    assert loose["modulus"]["kpa"] == pytest.approx(31, rel=0.03)  # a line over 5 % of strain, of a press that stiffens
    assert loose["law"] == "neo-hooke"
    assert "ends that slide" in loose["notes"][-1]
    bonded = told(capsys, log, "--study", str(study), "--ends", "bonded")
    assert loose["modulus"]["kpa"] / bonded["modulus"]["kpa"] == pytest.approx(1 + 2 * (60 / 160) ** 2)
    study.write_text(study.read_text() + 'ends = "bonded"\n')
    assert told(capsys, log, "--study", str(study))["modulus"] == bonded["modulus"]


def test_real_silicone_is_told_with_its_modulus(
    shared_data: Callable[[str], Path], capsys: pytest.CaptureFixture[str]
) -> None:
    found = told(capsys, *map(str, sorted(shared_data("phantoms").glob("EF10_0T/*.csv"))))
    assert [found[level] for level in ("presses", "mountings", "castings")] == [5, 1, 1]
    assert found["modulus"]["low"] < 56.27 < found["modulus"]["high"]
    assert found["modulus"]["ends"] == "frictionless"
    assert main(["tools", "stiffness", *map(str, sorted(shared_data("phantoms").glob("EF10_0T/*.csv")))]) == 0
    said = capsys.readouterr().out
    assert "which holds for further castings (5 presses, 1 mounting, 1 casting)" in said
    assert "one casting: a stated SD of 3.5 % between castings enters, --castings says otherwise" in said
    assert "5 of 5 logs begin in contact: that the first force is zero is taken from the file." in said
    assert "note: pressed at 0.167 mm/s\n" in said  # 10 mm a minute


def rubber_press(path: Path, deepest_mm: float, head: str = "", modulus_kpa: float = 20) -> str:
    deep = np.arange(-0.5, deepest_mm, 0.0167)
    force = rubber(modulus_kpa)(deep) + 0.002 * np.random.default_rng(int(100 * deepest_mm)).standard_normal(deep.size)
    table = "".join(f"{x:.5f},{f:.5f}\n" for x, f in zip(deep, force, strict=True))
    return str(write_log(path, f"{head}indentation_mm,force_n\n{table}"))


def test_presses_of_different_reach_are_taken_over_the_forces_of_all(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    names = [f"X_A_sample_{trial}" for trial in (1, 2, 3)]
    reach = (2.2, 6.0, 6.1)
    logs = [rubber_press(tmp_path / f"{n}.csv", mm, f"{n}\n") for n, mm in zip(names, reach, strict=True)]
    found = told(capsys, *logs)
    deep = np.linspace(0, 8, 80001)
    ends = np.interp([0.5, found["force_to_n"]], rubber(20)(deep), deep)
    assert found["force_to_n"] < 3.5
    assert found["stiffness_n_per_mm"] == pytest.approx((found["force_to_n"] - 0.5) / np.diff(ends)[0], rel=0.01)


def test_the_paper_s_line_ends_where_the_range_does_whatever_other_presses_reach(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    short, deep = (
        rubber_press(tmp_path / f"{trial}.csv", mm, f"X_A_sample_{trial}\n") for trial, mm in ((1, 2.2), (2, 14.0))
    )
    lines = []
    for logs in ([deep], [short, deep]):
        assert main(["tools", "stiffness", "--json", *logs]) == 0
        lines.append(json.loads(capsys.readouterr().out)["trials"][-1]["line_n_per_mm"])
    assert lines[0] == lines[1]


def test_a_press_counts_once(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    one = rubber_press(tmp_path / "a.csv", 6.0)
    copied = shutil.copy(one, tmp_path / "b.csv")
    for again in (one, str(copied)):
        assert main(["tools", "stiffness", one, again]) == 2
        assert "expected another press, but found that of" in capsys.readouterr().err


def test_a_plate_s_diameter_is_not_the_specimen_s(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head = "Plate diameter: 100 mm\nCylinder Diameter: 50,0mm\nCylinder Height: 30mm\n"
    found = told(capsys, rubber_press(tmp_path / "a.csv", 6.0, head))
    assert found["modulus"]["kpa"] == pytest.approx(21, rel=0.03)
    this = told(capsys, str(tmp_path / "a.csv"), "--castings", "0")
    assert (found["holds_for_further"], this["holds_for_further"]) == ("castings", "mountings")


def test_a_stiffness_that_is_no_one_number_is_not_written(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("emg2vsa.rig_file.specimen_stiffness.MOST_CHANGE", 0.1)  # 5 takes a press that locks
    log = rubber_press(tmp_path / "S1.csv", 6.0)
    study = write_log(tmp_path / "study.toml", '[[specimens]]\nname = "S1"\n')
    assert main(["tools", "stiffness", log, "--write", str(study)]) == 2
    said = "S1, stiffness: expected one number for the range of force, but found one that changes by "
    assert said in capsys.readouterr().err
    assert study.read_text() == '[[specimens]]\nname = "S1"\n'
