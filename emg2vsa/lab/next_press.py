"""What the presses of an unknown specimen have told so far, and which press would narrow its stiffness most."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from emg2vsa.calibration.next_press import COUNTS, Choice, Done, belief, next_press, options
from emg2vsa.calibration.online import OnlineCalibration
from emg2vsa.calibration_file import open_calibration, sha256_of
from emg2vsa.errors import DataError
from emg2vsa.rig.kappa.live_kappa import KAPPA_FILE
from emg2vsa.rig.record.new_folder import KAPPA_ABOUT_FILE, PLAN_FILE


@dataclass(frozen=True)
class Believed:
    """Of kappa, N/mm: its median, and the interval that it lies in by the confidence of the calibrations."""

    kappa_n_per_mm: float
    low_n_per_mm: float
    high_n_per_mm: float

    def __str__(self) -> str:
        return f"{self.kappa_n_per_mm:.3g} N/mm, from {self.low_n_per_mm:.3g} to {self.high_n_per_mm:.3g}"


@dataclass(frozen=True)
class NextPresses:
    """What to press next. options : the most informative first. chosen : None where no further press is worthwhile.

    The ``calibration`` of a choice is its index in ``calibrations``, which are names of files.
    """

    calibrations: tuple[str, ...]
    belief: Believed
    options: tuple[Choice, ...]
    chosen: Choice | None


def next_presses(
    calibrations: Sequence[str | Path],
    done: Sequence[str | Path] = (),
    presses: Sequence[int] = (),
    stop_at: float = 0.0,
) -> NextPresses:
    """Calibrations (stiffness preset and angle), numbers of presses and new mountings, by what they promise to tell.

    calibrations : files of emg2vsa run. done : folders of runs whose presses were judged; one folder is one mounting.
    presses : numbers to weigh; none: 1, 2, 3, 5 and 10. stop_at : half width of the interval, as a share of kappa, at
    which no further press is needed.

    DataError : a file that cannot be used; a run that fits no calibration, was not judged, or would count twice.
    """
    paths = [Path(path) for path in calibrations]
    opened = [open_calibration(path) for path in paths]
    before = _done([Path(folder) for folder in done], opened, paths)
    listed = options(opened, before, tuple(sorted(set(presses))) or COUNTS)
    chosen = next_press(opened, before, stop_at)
    return NextPresses(tuple(path.name for path in paths), believed(opened, before), listed, chosen)


def believed(calibrations: Sequence[OnlineCalibration], done: Mapping[int, Done]) -> Believed:
    """Of kappa, from what the calibrations (by index) have said so far."""
    found = belief(calibrations, done)
    return Believed(found.middle, *found.interval(calibrations[0].settings.confidence))


def _done(folders: Sequence[Path], calibrations: Sequence[OnlineCalibration], paths: Sequence[Path]) -> dict[int, Done]:
    """Presses so far, by calibration. DataError where a run fits none, was not judged, or would count twice."""
    places = [(each.angle_deg, each.condition) for each in calibrations]
    for i, (angle_deg, condition) in enumerate(places):
        if (angle_deg, condition) in places[:i]:
            found_there = f"{paths[places.index(places[i])]} too is of {angle_deg:g}°, {condition}"
            do = "Give one of the two."
            raise DataError(paths[i], wanted="one calibration for each angle and condition", found=found_there, do=do)
    found: dict[int, Done] = {}
    pressed: dict[str, Path] = {}
    seen: set[Path] = set()
    for folder in folders:
        if folder.resolve() in seen:
            raise DataError(folder, wanted="every run once", found="it twice", do="Name it once with --done.")
        seen.add(folder.resolve())
        plan, rows = _plan(folder / PLAN_FILE), last_estimates(folder / KAPPA_FILE)
        place = plan["angle_deg"], plan["condition"]
        if place not in places:
            there = ", ".join(path.name for path in paths)
            do = "Give the calibration of this angle and condition too."
            raise DataError(
                folder, wanted=f"one of the calibrations {there}", found=f"{place[0]:g}°, {place[1]}", do=do
            )
        pressed.setdefault(plan["specimen"], folder)
        if len(pressed) > 1:
            (one, first), (other, _) = pressed.items()
            do = "Name runs of one specimen only."
            raise DataError(folder, wanted=f"a run of {one}, as {first.name} is", found=f"one of {other}", do=do)
        if not rows:
            do = "Press with rig run --calibration."
            raise DataError(folder / KAPPA_FILE, wanted="presses that were judged", found="none", do=do)
        index = places.index(place)
        check_judged_by(folder, calibrations[index], paths[index].name)
        found[index] = with_run(found.get(index, Done()), rows, len(rows), new_mounting=True)
    return found


def check_judged_by(folder: Path, calibration: OnlineCalibration, name: str) -> None:
    """DataError where kappa.json names another calibration than the file ``name``; earlier versions do not tell."""
    about = folder / KAPPA_ABOUT_FILE
    try:
        told = json.loads(about.read_text(encoding="utf-8")).get("sha256")
    except FileNotFoundError:
        return
    except (OSError, ValueError, AttributeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(about, wanted="by which calibration presses were judged", found=_why(error), do=do) from error
    if told is not None and told != (own := sha256_of(calibration)):
        do = "Give the calibration that the run was judged by, or press again."
        raise DataError(f"{about}, sha256", wanted=f"that of {name}, {own[:12]}", found=str(told)[:12], do=do)


def with_run(before: Done, rows: Sequence[tuple[float, float, str]], presses: int, *, new_mounting: bool) -> Done:
    """What a further run adds: its presses, and the estimate of its last row where that is the narrower one.

    rows : as ``last_estimates`` has them.
    """
    kappa, low, cues = before.kappa, before.low, before.cues
    if rows and not (before.low > 0 and before.low / before.kappa > rows[-1][1] / rows[-1][0]):
        kappa, low, cues = rows[-1]
    return replace(
        before, presses=before.presses + presses, mountings=before.mountings + new_mounting, kappa=kappa, low=low,
        cues=cues,
    )  # fmt: skip


def last_estimates(path: Path) -> list[tuple[float, float, str]]:
    """kappa, the lower end of its interval and the cues of the last row of each press that tells them."""
    last: dict[str, tuple[float, float, str]] = {}
    try:
        with path.open(encoding="utf-8", newline="") as file:
            for row in csv.DictReader(file):
                if row["kappa_n_per_mm"] and row["low_n_per_mm"]:
                    told = float(row["kappa_n_per_mm"]), float(row["low_n_per_mm"]), row["cues"]
                    last[row["repetition"]] = told
    except (OSError, ValueError, KeyError, TypeError):
        return []
    return list(last.values())


def _why(error: Exception) -> str:
    """Without the path, which the message names already."""
    return str((isinstance(error, OSError) and error.strerror) or error)


def _plan(path: Path) -> dict[str, Any]:
    try:
        plan = json.loads(path.read_text(encoding="utf-8"))["plan"]
        return {
            "specimen": str(plan["specimen"]),
            "angle_deg": float(plan["angle_deg"]),
            "condition": str(plan["condition"]),
        }
    except (OSError, ValueError, KeyError, TypeError) as error:
        do = "Name the folder of a run that rig run made."
        raise DataError(path, wanted="the plan of a run", found=_why(error), do=do) from error
