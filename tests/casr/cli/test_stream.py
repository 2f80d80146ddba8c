"""``casr stream``: frame by frame, also while the press is recorded; the end is that of ``casr score``."""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import threading
import time
from pathlib import Path
from typing import Any

import cv2
import pytest

from casr.cli import main
from casr.frame_files import open_frames
from emg2vsa.worlds.tactile import PressSettings, TabulatedWorld, TimelineSettings, simulate_press, write_press

Captured = pytest.CaptureFixture[str]


@pytest.fixture(scope="module")
def press(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """To 3 N, in some 30 frames."""
    made = simulate_press(
        PressSettings(stiffness_n_per_mm=3.35, world=TabulatedWorld(), timeline=TimelineSettings(peak_n=3.0))
    )
    return write_press(made, tmp_path_factory.mktemp("stream") / "press", overwrite=False)


@pytest.fixture(scope="module")
def recorded(press: Path) -> dict[str, Any]:
    """What ``casr score`` says of it."""
    with contextlib.redirect_stdout(io.StringIO()) as out:
        assert main(["score", str(press), "--json"]) == 0
    return dict(json.loads(out.getvalue()))


def lines_of(out: str) -> list[dict[str, object]]:
    return [json.loads(line) for line in out.splitlines()]


def test_the_last_line_is_the_score_of_the_recording(press: Path, recorded: dict[str, Any], capsys: Captured) -> None:
    assert main(["stream", str(press), "--json"]) == 0
    *frames, last = lines_of(capsys.readouterr().out)
    score = last["score"]
    assert isinstance(score, dict)
    assert score["rate"]["value"] == pytest.approx(recorded["rate"]["value"], rel=1e-9)
    areas, same = ([area or 0 for area in each["area"]] for each in (score, recorded))
    assert areas == pytest.approx(same, rel=1e-9)
    assert [frame["frame"] for frame in frames] == list(range(len(open_frames(press))))
    told = [frame for frame in frames if frame["casr"] is not None]
    assert len(told) > 15
    # before the press turns back, the last answer is nearly the score
    at_peak = max(told, key=lambda frame: frame["force_n"])  # type: ignore[arg-type, return-value]
    assert at_peak["casr"] == pytest.approx(recorded["rate"]["value"], rel=5e-3)


def test_for_people(press: Path, capsys: Captured) -> None:
    assert main(["stream", str(press)]) == 0
    said = capsys.readouterr()
    frames = [line for line in said.out.splitlines() if line.startswith("frame ")]
    assert "rest" in frames[0]
    assert any("mm2  CASR" in line and "mm2/N" in line for line in frames)
    assert "  CASR, front" in said.out
    assert "note: " in said.err


@pytest.mark.parametrize("pages", [True, pytest.param(False, marks=pytest.mark.slow)], ids=["images", "one file"])
def test_a_press_that_is_being_recorded_is_followed_to_its_end(
    press: Path, recorded: dict[str, Any], tmp_path: Path, capsys: Captured, pages: bool
) -> None:
    folder = tmp_path / "growing"

    def record() -> None:
        time.sleep(0.1)
        (folder / "frames").mkdir(parents=True)
        shutil.copy(press / "camera.toml", folder)
        frames, rows = open_frames(press), (press / "force.csv").read_bytes().splitlines(keepends=True)
        if not pages:
            shutil.copy(press / "frames.tif", folder / "half")
            (folder / "half").rename(folder / "frames.tif")
            (folder / "frames").rmdir()
        index_at = rows[0].decode().strip().split(",").index("frame_index")
        saved = -1
        with (folder / "force.csv").open("wb", buffering=0) as log:
            for number, row in enumerate(rows):
                index = int(row.decode().split(",")[index_at]) if number else -1
                while pages and saved < index:
                    saved += 1
                    cv2.imwrite(str(folder / "frames" / f"{saved}.png"), frames[saved].astype("uint8"))
                log.write(row[:-3])  # half a line, for a moment
                log.write(row[-3:])
                time.sleep(5e-4)

    thread = threading.Thread(target=record)
    thread.start()
    assert main(["stream", str(folder), "--follow", "--idle", "4", "--json"]) == 0
    thread.join()
    *frames, last = lines_of(capsys.readouterr().out)
    score = last["score"]
    assert isinstance(score, dict)
    assert score["rate"]["value"] == pytest.approx(recorded["rate"]["value"], rel=1e-6)
    assert [frame["frame"] for frame in frames] == list(range(len(frames)))


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["none"], "none/force.csv: expected the force log of the press, but found no such file"),
        (["press/frames.tif", "--follow"], "--follow: expected a folder that is recorded into, but found a file"),
        (["press", "--stop-n", "0.1"], "--stop-n: expected more than --start-n, 0.5 N"),
        (["press", "--camera", "none.toml"], "none.toml"),
        (["empty"], "empty: expected images"),
        (["words"], "line 3: expected a number in force_n, but found 'x'"),
        (["few"], "few: expected frame 1, which force.csv names, but found 1 frames"),
    ],
)
def test_bad_input_is_one_line(
    press: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: Captured, options: list[str], said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    shutil.copytree(press, "press")
    for name, rows in {"empty": "1,0\n2,0\n", "words": "1,0\nx,1\n", "few": "1,0\n2,1\n3,2\n"}.items():
        Path(name).mkdir()
        (Path(name) / "force.csv").write_text("force_n,frame_index\n" + rows)
    cv2.imwrite("few/0.png", open_frames(press)[0].astype("uint8"))
    assert main(["stream", *options]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert len(error.strip().splitlines()) == 1


def test_frames_later_than_their_forces_are_waited_for(press: Path, tmp_path: Path, capsys: Captured) -> None:
    folder, late_s = tmp_path / "late", 1.3
    (folder / "frames").mkdir(parents=True)
    rows = (press / "force.csv").read_text().splitlines(keepends=True)
    index_at = rows[0].strip().split(",").index("frame_index")
    few = [row for row in rows[1:] if int(row.split(",")[index_at]) < 4]
    (folder / "force.csv").write_text("".join([rows[0], *few]))
    frames = open_frames(press)

    def record() -> None:
        time.sleep(late_s)
        for index in range(4):
            cv2.imwrite(str(folder / "half.png"), frames[index].astype("uint8"))
            (folder / "half.png").rename(folder / "frames" / f"{index}.png")

    thread = threading.Thread(target=record)
    thread.start()
    main(["stream", str(folder), "--follow", "--idle", "6"])
    thread.join()
    said = capsys.readouterr()
    assert said.err.startswith(f"waiting for frames and forces in {folder}\n")
    assert said.err.count("waiting") == 1
    assert "frame    3" in said.out


def test_frames_that_never_come_are_named_after_the_quiet_time(press: Path, tmp_path: Path, capsys: Captured) -> None:
    folder = tmp_path / "never"
    folder.mkdir()
    shutil.copy(press / "force.csv", folder)
    assert main(["stream", str(folder), "--follow", "--idle", "0.2"]) == 2
    assert "never: expected" in capsys.readouterr().err
