"""What ``emg2vsa new`` takes from a folder, and that it says what it leaves out."""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from benchmarks.folders_apart import press
from emg2vsa.cli import main
from emg2vsa.pipeline.places import recordings_in
from emg2vsa.settings import ReadingSettings
from emg2vsa.study_file import load_study
from emg2vsa.study_file.drafting import MOST_EMG, Found, look
from emg2vsa.study_file.plain_names import plain_parts

EMG, FORCE_N = press(0, 0, 1000.0, presses=1)
TIME = np.arange(FORCE_N.size) / 1000
Columns = dict[str, np.ndarray]
PLAIN: Columns = {"EDC [V]": EMG[0], "FDS [V]": EMG[1], "Fz [N]": FORCE_N}


def write(path: Path, columns: Columns, noise: int = 0) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    rows = np.column_stack([TIME, *columns.values()])
    rows[0, 1] += 1e-7 * noise
    np.savetxt(path, rows, "%.6g", ",", header=",".join(["time [s]", *columns]), comments="", encoding="utf-8")


def found_in(folder: Path, columns: Columns, names: Sequence[str] = ("P1_soft.csv", "P1_hard.csv")) -> Found:
    for number, name in enumerate(names):
        write(folder / name, columns, number)
    return look(folder, recordings_in([folder]), folder, ReadingSettings(), None)


@pytest.mark.parametrize("name", ["Biceps", "EMG2", "F1", "F-dig", "F. carpi", "Ext load side"])
def test_every_channel_that_looks_like_emg_is_used(name: str, tmp_path: Path) -> None:
    """One name of a muscle drops no other channel, and no name that sounds like force beats volts and a spectrum."""
    found = found_in(tmp_path, {"EDC [V]": EMG[0], f"{name} [V]": EMG[1], "Fz [N]": FORCE_N})
    assert [channel.name for channel in found.emg_channels.values()] == ["EDC", name]
    assert found.force_channel is not None
    assert (found.force_channel.name, found.left_out) == ("Fz", ())


def test_a_force_in_volts_stays_a_force(tmp_path: Path) -> None:
    found = found_in(tmp_path, {"EDC [V]": EMG[0], "Load cell [V]": 0.2 * FORCE_N})
    assert found.force_channel is not None
    assert (found.force_channel.name, list(found.emg_channels)) == ("Load cell", ["EDC"])


LEFT_OUT: dict[str, tuple[Columns, str]] = {
    "many": (
        {**{f"Ch{i} [V]": EMG[i % 2] for i in range(MOST_EMG + 2)}, "Fz [N]": FORCE_N},
        "2 channels that look like EMG, as a draft takes 8: Ch8, Ch9",
    ),
    "one muscle twice": ({**PLAIN, "EDC raw [V]": EMG[0]}, "EDC raw, looks like EMG of EDC as EDC does"),
    "no number": ({**PLAIN, "ECR [V]": np.full(TIME.size, np.nan)}, "ECR (empty: hardly a sample is a number)"),
    "constant": ({**PLAIN, "ECR [V]": np.zeros(TIME.size)}, "ECR (flat: nothing was connected)"),
    "envelope": ({**PLAIN, "EMG rms [V]": FORCE_N / 1e3}, "EMG rms (EMG, by its name, but slow as an envelope is)"),
}


@pytest.mark.parametrize("kind", LEFT_OUT)
def test_channels_that_are_left_out_are_told(kind: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    columns, said = LEFT_OUT[kind]
    assert found_in(tmp_path, columns).left_out == (said,)
    assert main(["new", str(tmp_path), "--no-questions"]) == 0
    assert f"  left out: {said}\n" in capsys.readouterr().out
    marked = f"# FILL IN a table as those below where it is to be used; left out: {said}\n"
    assert marked in (tmp_path / "study.toml").read_text(encoding="utf-8")


RIVALS: dict[str, tuple[Columns, tuple[str, str]]] = {
    "names": ({"Grip [N]": 2 * FORCE_N + 5, "Press [N]": FORCE_N}, ("Grip", "Press")),
    "magnitude": ({"Fx [N]": 0.9 * FORCE_N, "Fz [N]": 0.3 * FORCE_N}, ("Fz", "Fx")),
    "no names": ({"Feedback": FORCE_N + 1, "Sensor": 2 * FORCE_N}, ("Feedback", "Sensor")),
}


@pytest.mark.parametrize("kind", RIVALS)
def test_forces_as_likely_are_told(kind: str, tmp_path: Path) -> None:
    columns, names = RIVALS[kind]
    found = found_in(tmp_path, {"EDC [V]": EMG[0], "FDS [V]": EMG[1], **columns})
    assert found.force_channel is not None
    assert {found.force_channel.name, *found.force_channel.rivals} == set(names)
    assert found.force_channel.rival in found.told
    assert f"# FILL IN another where it is the one: {found.force_channel.rival}\n" in found.text("s", {})


def test_small_forces_across_the_pressing_are_no_rivals(tmp_path: Path) -> None:
    found = found_in(tmp_path, {**PLAIN, "Fx [N]": 0.05 * FORCE_N})
    assert found.force_channel is not None
    assert found.force_channel.rivals == ()


def test_who_pressed_what_is_told_with_names_that_sound_otherwise(tmp_path: Path) -> None:
    found = found_in(tmp_path, PLAIN, [f"{p}_{s}.csv" for p in ("ama", "bob") for s in ("hard", "MVC")])
    assert found.told[:2] == ["who pressed: ama, bob", "what was pressed: MVC, hard"]
    assert any(line.startswith("MVC sounds like neither a person nor a specimen") for line in found.told)
    assert "# FILL IN: MVC sounds like neither" in found.text("s", {})


PEOPLE = {
    "Ä1 Ö1": ({"Ae1", "Oe1"}, {"hard", "soft"}), "王 李": ({"P01", "P02"}, {"hard", "soft"}),
    "Müller Grün": ({"Mueller", "Gruen"}, {"hard", "soft"}), "José Jose": ({"Jose", "Jose-2"}, {"hard", "soft"}),
}  # fmt: skip


@pytest.mark.parametrize("people", PEOPLE)
def test_people_keep_apart_whatever_their_letters(people: str, tmp_path: Path) -> None:
    names = [f"{p}_{s}.csv" for p in people.split() for s in ("hard", "soft")]
    found = found_in(tmp_path, PLAIN, names)
    (tmp_path / "study.toml").write_text(found.text("s", {}), encoding="utf-8")
    study = load_study(tmp_path / "study.toml")
    assert (set(study.participants), set(found.specimens)) == PEOPLE[people]
    cells = {(entry.participant, entry.emg_file.name) for entry in study.recordings}
    assert {file for _, file in cells} == set(names)
    assert all(len({p for p, file in cells if file.startswith(f"{name}_")}) == 1 for name in people.split())


def test_no_two_names_become_one() -> None:
    parts = ["é", "e", "E", "王", "李", "x1", "#1", "1", "ö", "oe", "oe-2", "a\u0308", "ä"]
    written = plain_parts(f"{part}.csv" for part in parts)
    ids = [plain.casefold() for plain in written.values()]
    assert len(set(ids)) == len(ids)
    assert all(plain.isascii() and plain for plain in written.values())


def test_the_guess_depends_neither_on_depth_nor_on_where_the_study_file_is(tmp_path: Path) -> None:
    names = [f"{p}/{s}_{k}.csv" for p in ("ama", "bob") for s in ("hard", "soft") for k in ("emg", "force")]
    deep = tmp_path / "EMG_1 force" / "x_y"
    for number, name in enumerate(names):
        keys = ("EDC [V]", "FDS [V]") if name.endswith("emg.csv") else ("Fz [N]",)
        write(deep / name, {key: PLAIN[key] for key in keys}, number)
    texts = []
    for out in (deep / "study.toml", tmp_path / "a" / "b" / "study.toml"):
        out.parent.mkdir(parents=True, exist_ok=True)
        assert main(["new", str(deep), "--out", str(out), "--no-questions"]) == 0
        study = load_study(out)
        assert [entry.key for entry in study.recordings] == ["ama/hard", "ama/soft", "bob/hard", "bob/soft"]
        assert all(path.is_file() for entry in study.recordings for path in entry.files)
        texts.append(out.read_text(encoding="utf-8").replace("../../EMG_1 force/x_y/", ""))
    assert texts[0] == texts[1]


def test_copies_are_told_and_lock_files_are_none(tmp_path: Path) -> None:
    names = ["P1_soft.csv", "P1_hard.csv"]
    found_in(tmp_path, PLAIN, names)
    for name in ("Kopie von P1_hard.csv", "~$P1_hard.csv"):
        shutil.copy(tmp_path / "P1_hard.csv", tmp_path / name)
    found = look(tmp_path, recordings_in([tmp_path]), tmp_path, ReadingSettings(), None)
    assert not any("~$" in file for file in found.files)
    assert found.copies == ("Kopie von P1_hard.csv is P1_hard.csv byte by byte; take one of them out of the folder",)
    assert f"# FILL IN: {found.copies[0]}\n" in found.text("s", {})


def test_stiffness_of_a_specimen_that_no_pattern_names(tmp_path: Path) -> None:
    for number, name in enumerate(("ama hard.csv", "ama_soft_2.csv", "bob-x y z.csv")):
        write(tmp_path / name, PLAIN, number)
    assert main(["new", str(tmp_path), "--no-questions", "--stiffness", "hard=6"]) == 0
    assert load_study(tmp_path / "study.toml").stiffness_n_per_mm["hard"] == 6.0
