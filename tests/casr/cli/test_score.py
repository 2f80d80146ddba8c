"""``casr score``: one press, many presses, what comes out and with which exit status."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
import tifffile

from casr.cli import main
from emg2vsa.worlds.tactile import ContactWorld, PressSettings, TimelineSettings, simulate_press, write_press

Captured = pytest.CaptureFixture[str]


def test_one_press_for_people(presses: Path, capsys: Captured) -> None:
    assert main(["score", str(presses / "S5_00deg_01")]) == 0
    out = capsys.readouterr().out
    for word in ("S5_00deg_01", "A_c0, front", "growth", "CASR, skin", "skin/front", "mm2/N", "left out", "pin-affine"):
        assert word in out
    lines = out.splitlines()
    assert lines[1].startswith("  CASR, front")
    forces = r"over 0.5 to 7 N, frames from 0.\d\d to [67].\d\d N, front determined from 0.\d\d"
    assert re.search(rf"mm2/N, 95 %: [\d.]+ to [\d.]+; {forces}", lines[1])


def test_the_quantity_asked_for_is_the_result(presses: Path, capsys: Captured) -> None:
    rates = {}
    for quantity in ("front", "skin"):
        assert main(["score", str(presses / "S5_00deg_01"), "--quantity", quantity, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        rates[quantity] = found["rate"]["value"]
        assert found["settings"]["quantity"] == quantity
        assert found["interval"]["low"] < found["rate"]["value"] < found["interval"]["high"]
        assert found["skin"]["rate"]["value"] != found["front_spread"]["rate"]["value"]
    assert rates["front"] == found["front_spread"]["rate"]["value"]
    assert rates["skin"] == found["skin"]["rate"]["value"]
    assert main(["score", str(presses / "S5_00deg_01"), "--quantity", "skin"]) == 0
    assert capsys.readouterr().out.splitlines()[1].startswith("  CASR, skin")


def test_a_front_that_is_not_determined_heads_the_press(tmp_path: Path, capsys: Captured) -> None:
    timeline = TimelineSettings(peak_n=0.62, start_n=0.45)
    hard = PressSettings(stiffness_n_per_mm=7.63, timeline=timeline)
    folder = write_press(simulate_press(hard), tmp_path / "run" / "small", overwrite=False)
    assert main(["score", str(folder), "--start-n", "0.4"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[1].startswith("  Not determined: the contact is too small")
    assert "--quantity skin" in lines[1]
    assert not any(line.startswith("  A_c0, front") for line in lines)
    assert main(["score", str(folder), "--start-n", "0.4", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["rate"] is None
    assert set(found["area"]) == {None}
    assert main(["score", str(tmp_path / "run"), "--start-n", "0.4"]) == 0
    assert "not determined" in capsys.readouterr().out.splitlines()[1]


def test_a_press_unlike_the_others_is_named(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    run = tmp_path / "run"
    for name in ("S1_00deg_01", "S5_00deg_01", "S5_00deg_02"):
        shutil.copytree(presses / name, run / name)
    odd = PressSettings(stiffness_n_per_mm=3.35, world=ContactWorld(stick_force_n=0.5))
    write_press(simulate_press(odd), run / "odd", overwrite=False)
    page = tmp_path / "pages.html"
    assert main(["score", str(run), "--page", str(page)]) == 0
    said = [line for line in capsys.readouterr().out.splitlines() if line.startswith("check this press:")]
    assert len(said) == 1
    assert said[0].startswith("check this press: odd: skin grew")
    assert "Check odd: skin grew" in page.read_text(encoding="utf-8")
    assert "Check this press:" in (tmp_path / "pages_pages" / "odd.html").read_text(encoding="utf-8")
    assert "Check this press:" not in (tmp_path / "pages_pages" / "S1_00deg_01.html").read_text(encoding="utf-8")
    assert main(["score", str(run), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)["presses"]
    assert [name for name, press in found.items() if press["doubts"]] == ["odd"]


def test_tables_of_pins_and_frames(presses: Path, tmp_path: Path) -> None:
    words = ["--pins", str(tmp_path / "new" / "pins.csv"), "--frames", str(tmp_path / "frames.csv")]
    assert main(["score", str(presses / "S5_00deg_01"), *words]) == 0
    assert (tmp_path / "new" / "pins.csv").read_text().startswith("frame,pin,x_px,y_px,inside\n")
    assert (tmp_path / "frames.csv").read_text().startswith("frame,force_n,front_area_mm2,")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["frames.csv", "new"]


def test_the_whole_image_as_region(presses: Path, capsys: Captured) -> None:
    words = ["--engine", "dis", "--region", "image", "--quantity", "skin"]
    assert main(["score", str(presses / "S5_00deg_01"), *words, "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["settings"]["region"] == "image"
    assert found["log_growth"] == found["divergence"]


def test_domes_of_a_lab_are_taken(
    presses: Path, tmp_path: Path, shared_data: Callable[[str], Path], capsys: Captured
) -> None:
    for table in sorted(shared_data("contact_fem").glob("A_*.npz")):
        shutil.copy(table, tmp_path)
    assert main(["score", str(presses / "S5_00deg_01"), "--domes", str(tmp_path), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["front"]["dome"] == "A"


def test_a_specimen_of_a_height_without_tables_is_refused(presses: Path, capsys: Captured) -> None:
    assert main(["score", str(presses / "S5_00deg_01"), "--specimen-height-mm", "10"]) == 2
    said = capsys.readouterr().err
    assert "specimen_height_mm: expected tables of one dome, stiffness and friction on both sides of 10 mm" in said


def test_the_papers_force_of_a_frame_is_that_of_half_a_frame_later(presses: Path, capsys: Captured) -> None:
    first = {}
    for rule in ("exposure", "mean"):
        assert main(["score", str(presses / "S5_00deg_01"), "--force-rule", rule, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        first[rule] = dict(zip(found["frames"], found["force_n"], strict=True))
    later = [first["mean"][frame] - force for frame, force in first["exposure"].items()]
    assert sum(later[5:-5]) / len(later[5:-5]) == pytest.approx(6.5 / 3 * 0.025, rel=0.1)


def test_the_mean_rate_ends_at_the_forces_asked_for(presses: Path, capsys: Captured) -> None:
    assert main(["score", str(presses / "S5_00deg_01"), "--start-n", "1", "--stop-n", "5", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["rate"]["window_n"] == [1.0, 5.0]


def late(presses: Path, tmp_path: Path, offset_n: float, lag_s: float) -> Path:
    """A press whose force is off and whose frames are stamped too late."""
    folder = tmp_path / "late"
    shutil.copytree(presses / "S5_00deg_01", folder)
    head, *rows = (folder / "force.csv").read_text().splitlines()
    cells = [row.split(",") for row in rows]
    first_s = {index: float(time) for time, _, index in reversed(cells)}
    stamps = [f"{first_s[index] - 0.0025 + lag_s:.4f}" if index != "-1" else "" for _, _, index in cells]
    lines = [f"{t},{float(f) + offset_n:.6f},{i},{s}" for (t, f, i), s in zip(cells, stamps, strict=True)]
    (folder / "force.csv").write_text("\n".join([f"{head},frame_time_s", *lines]) + "\n")
    return folder


def test_zero_and_lag_are_said_and_taken_off(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    assert main(["score", str(presses / "S5_00deg_01"), "--json"]) == 0
    wanted = json.loads(capsys.readouterr().out)
    folder = late(presses, tmp_path, 0.4, 0.045)
    assert main(["score", str(folder), "--camera-lag", "0.045"]) == 0
    captured = capsys.readouterr()
    assert "force zero  +0.40" in captured.out
    assert "camera lag" in captured.out
    assert "+45 ms taken off" in captured.out
    assert "note: the force rests at 0.40" in captured.err
    for options in (["--camera-lag", "0.045"], ["--correct-lag"]):
        assert main(["score", str(folder), *options, "--json"]) == 0
        found = json.loads(capsys.readouterr().out)
        assert found["rate"]["value"] == pytest.approx(wanted["rate"]["value"], rel=0.02)
        assert found["force_zero"]["level_n"] == pytest.approx(0.4, abs=0.01)
    assert main(["score", str(folder), "--no-tare", "--json"]) == 0
    assert abs(json.loads(capsys.readouterr().out)["rate"]["value"] / wanted["rate"]["value"] - 1) > 0.02


def test_a_press_to_check_says_so_first(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    folder = tmp_path / "both" / "backwards"
    shutil.copytree(presses / "S5_00deg_01", folder)
    frames = tifffile.imread(folder / "frames.tif")
    tifffile.imwrite(folder / "frames.tif", frames[::-1], photometric="minisblack")
    page = tmp_path / "page.html"
    assert main(["score", str(folder), "--page", str(page)]) == 0
    said = capsys.readouterr().out.splitlines()[1:4]
    assert any(line.startswith("  Check this press: the pins go back") for line in said)
    assert "the pins go back" in page.read_text(encoding="utf-8")
    shutil.copytree(presses / "S5_00deg_02", tmp_path / "both" / "good")
    assert main(["score", str(tmp_path / "both")]) == 0
    captured = capsys.readouterr()
    assert [line.split()[0] for line in captured.out.splitlines() if line.endswith("check this press")] == ["backwards"]
    assert "note: backwards: check this press: the pins go back" in captured.err


def test_a_bad_press_does_not_stop_the_others(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    folder = tmp_path / "some"
    shutil.copytree(presses / "S5_00deg_01", folder / "good")
    (folder / "bad").mkdir()
    (folder / "bad" / "frames.tif").write_bytes(b"II*\0 cut off")
    page = tmp_path / "index.html"
    assert main(["score", str(folder), "--page", str(page)]) == 1
    captured = capsys.readouterr()
    assert captured.out.count("mm2/N") == 1
    assert len(captured.err.splitlines()) == 1
    assert captured.err.startswith("not scored: bad")
    assert "Not scored: bad" in page.read_text(encoding="utf-8")
    assert [path.name for path in (tmp_path / "index_pages").iterdir()] == ["good.html"]


def without_camera(presses: Path, run: Path) -> Path:
    """Two presses below ``run``; neither has a camera file."""
    for name in ("S5_00deg_01", "S5_00deg_02"):
        shutil.copytree(presses / name, run / name, ignore=shutil.ignore_patterns("camera.toml"))
    return run


def test_a_camera_file_serves_all_presses_below_its_folder(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    run = without_camera(presses, tmp_path / "run")
    shutil.copy(presses / "S5_00deg_01" / "camera.toml", run / "camera.toml")
    assert main(["score", str(run)]) == 0
    both = capsys.readouterr()
    assert both.out.count("mm2/N") == 2
    assert "px²" not in both.out + both.err
    assert main(["area", str(run / "S5_00deg_01")]) == 0
    assert "px²" not in capsys.readouterr().err


def test_without_a_camera_the_headline_says_px2(presses: Path, tmp_path: Path, capsys: Captured) -> None:
    run, page = without_camera(presses, tmp_path / "run"), tmp_path / "pages.html"
    assert main(["score", str(run), "--page", str(page)]) == 0
    both = capsys.readouterr()
    assert both.out.count("px2/N") == 2
    note = "areas are in px², not mm²: no camera.toml in the folder of the press or the folder above it, and none given"
    assert both.err.count(note) == 2
    assert "No camera file for 2: their areas are in px², not mm²." in page.read_text(encoding="utf-8")
    assert "No camera file: areas are in px²" in (tmp_path / "pages_pages" / "S5_00deg_01.html").read_text(
        encoding="utf-8"
    )
    assert main(["score", str(run / "S5_00deg_01")]) == 0
    assert capsys.readouterr().out.startswith("S5_00deg_01, areas in px², not mm²\n")
    assert main(["area", str(run / "S5_00deg_01")]) == 0
    assert note in capsys.readouterr().err
    assert main(["score", str(run), "--camera", str(presses / "S1_00deg_01" / "camera.toml"), "--json"]) == 0
    given = json.loads(capsys.readouterr().out)["presses"]
    assert {press["area_unit"] for press in given.values()} == {"mm2"}


def test_pictures_and_page_of_one_press(presses: Path, tmp_path: Path) -> None:
    words = ["--page", str(tmp_path / "a" / "one.html"), "--figures", str(tmp_path / "pictures")]
    assert main(["score", str(presses / "S5_00deg_02"), *words]) == 0
    page = (tmp_path / "a" / "one.html").read_text(encoding="utf-8")
    assert page.count("<svg style=") == 6
    assert "http" not in page.replace("http://www.w3.org", "")
    names = {path.name for path in (tmp_path / "pictures").iterdir()}
    assert names == {f"{name}.svg" for name in ("area_curve", "edges", "growth", "pins", "area", "spreading")}
