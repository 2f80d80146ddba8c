"""How late the frames of the camera are, from runs that are recorded."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.rig.record.new_folder import PLAN_FILE
from emg2vsa.rig_file import load_rig
from emg2vsa.run_folders.camera_delay import CameraDelay, measure_delay


def camera_delay(paths: Sequence[str | Path]) -> CameraDelay:
    """The delay by the presses of ``paths``: folders of runs, or rig files for all their runs. It moves nothing.

    SettingError : a path is neither, or has no runs. RecordingError : as `measure_delay`.
    """
    if not paths:
        raise SettingError("paths", wanted="folders of runs, or rig files", found="none", do="Name one.")
    return measure_delay([folder for path in paths for folder in _folders(Path(path))])


def _folders(path: Path) -> list[Path]:
    if path.is_dir():
        return [path]
    if not path.exists():
        raise SettingError(path, wanted="the folder of a run, or a rig file", found="neither", do="Check the path.")
    runs = load_rig(path).runs
    if not (folders := sorted(plan.parent for plan in runs.glob(f"*/{PLAN_FILE}"))):
        do = "Press first: emg2vsa rig run."
        raise SettingError(path, wanted=f"runs in {runs}", found="none", do=do)
    return folders
