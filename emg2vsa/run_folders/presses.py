"""The presses of a run from its folders; frames are decoded when they are scored."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from datetime import datetime
from functools import partial
from pathlib import Path

import numpy as np

from casr.camera import Camera
from casr.errors import CasrError
from casr.frame_files import find_presses, open_frames, read_camera
from casr.frame_files.folder import CAMERA_FILE, FORCE_FILE, folder_contents
from emg2vsa.arrays import Floats
from emg2vsa.errors import Emg2vsaError
from emg2vsa.rig.record.new_folder import EMULATED_FILE, PLAN_FILE
from emg2vsa.rig.record.press_counts import peak_forces_n, stopped_presses, verdicts
from emg2vsa.rig.record.run_log import GOING_IN, read_log
from emg2vsa.rig.rig_settings import axis_of
from emg2vsa.run_folders.documents import document
from emg2vsa.run_scores.press import Press

_LOG = "log.csv"
_PRESS = re.compile(r"press[-_ ]?\d", re.IGNORECASE)
_NONE: Floats = np.empty(0)


def is_simulated(folders: Sequence[Path]) -> bool:
    """Did an emulated rig make any of it?"""
    return any((folder / EMULATED_FILE).is_file() for folder in folders)


def run_notes(folders: Sequence[Path]) -> tuple[str, ...]:
    """What a reader of the scores should know of runs that were not completed, and of presses that lost something."""
    notes = []
    for folder in folders:
        ended = document(folder / "ended.json")
        if ended and ended.get("how") != "completed":
            cause = ended.get("cause") or ended.get("why") or "unknown"
            notes.append(f"{folder.name} ended early: {ended.get('how')}, {cause}")
        notes += [
            f"{folder.name}, press {number} is doubtful: {why}"
            for number, (verdict, why) in verdicts(folder).items()
            if verdict == "doubtful"
        ]
    return tuple(notes)


_SETUP = {
    PLAN_FILE: ("f_contact_n", "f_max_n", "ramp_mm_per_s", "travel_mm", "pause_s", "rate_hz"),
    CAMERA_FILE: ("frame_rate_hz", "pin_length_mm", "dome_radius_mm"),
}


def run_setup(folders: Sequence[Path], camera: Path | None = None) -> dict[str, tuple[float, ...]]:
    """How presses were made, as the plans and camera files of their folders tell; what none of them tells is absent.

    Each value stands once. camera : the file of folders that have none.
    """
    found: dict[str, list[float]] = {}
    for folder in folders:
        own = folder / CAMERA_FILE
        files = {PLAN_FILE: folder / PLAN_FILE, CAMERA_FILE: own if own.is_file() or camera is None else camera}
        for kind, path in files.items():
            tables = [table for table in document(path).values() if isinstance(table, dict)]
            for key in _SETUP[kind]:
                values = [table[key] for table in tables if isinstance(table.get(key), (int, float))]
                found.setdefault(key, []).extend(map(float, values[:1]))
    return {key: tuple(dict.fromkeys(values)) for key, values in found.items() if values}


def read_presses(folders: Sequence[Path], camera: Path | None = None, order: Sequence[float] = ()) -> Iterator[Press]:
    """Presses of the folders, numbered on from folder to folder.

    order : of the folders, in place of the times in their plans.
    camera : the camera file where neither the press nor its run has a camera.toml of its own.
    A press whose frames are missing or cannot be read raises nothing and comes with the reason; a log that is missing
    or foreign leaves out the force over indentation.
    """
    repetition = 0
    began_of = order or [_pressed_at(folder) for folder in folders]
    for mounting, folder, began in zip(_mountings(folders), folders, began_of, strict=True):
        travel, peaks_n = _travel(folder), peak_forces_n(folder)
        found, stopped = verdicts(folder), stopped_presses(folder)
        camera_file = folder / CAMERA_FILE if (folder / CAMERA_FILE).is_file() else camera
        seen_by, trouble = _camera(camera_file)
        for number, path in enumerate(_press_folders(folder), start=1):
            repetition += 1
            force_n, depth_mm, n_before = travel.get(_number(path, number), (_NONE, _NONE, 0))
            verdict, why = found.get(_number(path, number), ("ok", ""))
            peak_n = peaks_n.get(_number(path, number), math.nan)
            unit = "mm2" if camera_file or (path / CAMERA_FILE).is_file() else "px2"
            press = partial(
                Press, force_n=force_n, depth_mm=depth_mm, area_unit=unit, mounting=mounting, peak_n=peak_n,
                n_before=n_before, pressed_at=began,
            )  # fmt: skip
            if verdict == "rejected":
                reason = f"{folder.name}, press {_number(path, number)} was rejected by the rig: {why}"
            elif short := stopped.get(_number(path, number)):
                reason = f"{folder.name}, press {_number(path, number)} is no whole press: it was stopped {short}"
            else:
                reason = ""
            if reason:
                yield press(repetition, None, reason)
                continue
            try:
                if trouble:
                    raise trouble
                frames = open_frames(path)
                frames = frames if frames.camera or seen_by is None else replace(frames, camera=seen_by)
                frames.source.name = path.relative_to(folder.parent).as_posix()  # as errors name it
                yield press(repetition, frames, "")
            except CasrError as error:
                yield press(repetition, None, str(error))


def _mountings(folders: Sequence[Path]) -> list[int]:
    """Number of each folder's mounting, from 1: the rig continues a mounting in a further folder, as its plan tells."""
    plans = [document(folder / PLAN_FILE).get("plan") for folder in folders]
    told = [plan.get("mounting") if isinstance(plan, dict) else None for plan in plans]
    own = [m if isinstance(m, int) else folder for folder, m in zip(folders, told, strict=True)]
    return [list(dict.fromkeys(own)).index(one) + 1 for one in own]


def _pressed_at(folder: Path) -> float:
    """See ``RunScores``. All runs of an emulated rig begin at the same date."""
    told = document(folder / PLAN_FILE)
    try:
        if is_simulated([folder]):
            return float(told["plan"]["order"])
        return datetime.fromisoformat(told["clock"]["zero_utc"]).timestamp()
    except (KeyError, TypeError, ValueError):
        return math.nan


def _press_folders(folder: Path) -> list[Path]:
    """Where presses are, and where only their frames are missing."""
    if _with_frames(folder) == [folder]:
        return [folder]
    try:
        contents = folder_contents(folder)
    except CasrError:
        return []
    below = [path for path in contents.folders if not path.is_symlink()]
    return [*contents.stacks, *(press for path in below for press in _with_frames(path) or [path] * _is_press(path))]


def _with_frames(folder: Path) -> list[Path]:
    try:
        return find_presses(folder)
    except CasrError:
        return []


def _is_press(path: Path) -> bool:
    return bool(_PRESS.match(path.name)) or (path / FORCE_FILE).is_file()


def _number(path: Path, number: int) -> int:
    """Repetition of a press as the log counts it."""
    _, dash, digits = path.name.rpartition("-")
    return int(digits) if dash and digits.isdecimal() else number


def _camera(path: Path | None) -> tuple[Camera | None, CasrError | None]:
    if path is None:
        return None, None
    try:
        return read_camera(path), None
    except CasrError as error:
        return None, error


def _travel(folder: Path) -> dict[int, tuple[Floats, Floats, int]]:
    """Repetition to force, N, and depth of the shaft, mm, on its way in, and how many of these rows come before the
    loading phase; empty without the rig's own log."""
    plan = document(folder / PLAN_FILE)
    try:
        log = read_log(folder / _LOG, ["repetition", "phase", "force_n"])
        axis = axis_of(plan["rig"])
    except (OSError, ValueError, KeyError, TypeError, Emg2vsaError):
        return {}
    way_in = log[log["phase"].isin(GOING_IN)].dropna()
    depth_mm = axis.depth_at(way_in["shaft_deg"].to_numpy(dtype=np.float64))  # type: ignore[arg-type]
    force_n, number = way_in["force_n"].to_numpy(dtype=np.float64), way_in["repetition"].to_numpy(dtype=np.int64)
    depth, before = np.asarray(depth_mm, dtype=np.float64), (way_in["phase"] != "load").to_numpy()
    return {
        int(r): (force_n[own], depth[own], int(np.count_nonzero(before[own])))
        for r in np.unique(number[~before])
        for own in [number == r]
    }
