"""Tables solved case by case on several processes; one that lies in the folder already is not solved again."""

from __future__ import annotations

import glob
import io
import json
import multiprocessing
import os
import threading
import zipfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from casr.atomic import write_bytes_atomic
from casr.dome.solver.bodies import Stopped
from casr.dome.solver.press import LONGEST_MM, Pressed, press
from casr.dome.solver.sensor_file import Case
from casr.dome.tables import HEIGHT, LEAST_FORCE_N, SOLVER, digest
from casr.dome.view import INNER_RADIUS_MM, OUTER_RADIUS_MM
from casr.errors import SettingError
from casr.one_thread import one_thread

AREA_AT_N = (0.5, 1.0, 2.0, 4.0)
_LENGTHS = ("depth_mm", "contact_radius_mm", "s_mm", "u_r_mm", "u_z_mm")


@dataclass(frozen=True)
class Solved:
    """A case with what its file says of the solution; stopped : why there is no file."""

    case: Case
    said: dict[str, Any]
    stopped: str = ""
    before: bool = False


def solve(cases: Sequence[Case], folder: Path, jobs: int) -> Iterator[Solved]:
    """Each case as it ends, those that are there already first. OSError : the folder cannot be written.
    SettingError : it holds tables of another dome by the same name."""
    folder.mkdir(parents=True, exist_ok=True)
    _check_names(folder, cases[0])
    left = []
    for case in cases:
        said = said_of(folder / f"{case.name}.npz")
        if said.get("digest") == case.digest:
            yield Solved(case, said, before=True)
        else:
            left.append(case)
    if jobs == 1 or len(left) < 2:
        yield from (_solve(case, folder) for case in left)
        return
    with ProcessPoolExecutor(min(jobs, len(left)), multiprocessing.get_context("spawn"), _begin) as pool:
        calls = [pool.submit(_solve, case, folder) for case in left]
        try:
            yield from (call.result() for call in as_completed(calls))
        finally:
            pool.shutdown(cancel_futures=True)


def _begin() -> None:
    """In a process of its own: one thread, and an end with the process that started it, even one that was killed."""
    one_thread()
    parent = multiprocessing.parent_process()
    assert parent is not None

    def end() -> None:
        parent.join()
        os._exit(1)

    threading.Thread(target=end, daemon=True).start()


def _check_names(folder: Path, case: Case) -> None:
    name, dome = case.name.partition("_")[0], asdict(case.pressing.dome)
    for path in sorted(folder.glob(f"{glob.escape(name)}_k*.npz")):
        other = said_of(path).get("pressing", {}).get("dome", dome)
        if other != dome:
            key = next(key for key in dome if other.get(key) != dome[key])
            raise SettingError(
                str(path), wanted=f"tables of one dome by the name {name}", found=f"another, {key} {other[key]}",
                do="Give this dome another name or folder, or remove the tables that are there.",
            )  # fmt: skip


def said_of(path: Path) -> dict[str, Any]:
    """The metadata of a table of this solver; nothing where there is none, or its arrays were changed."""
    try:
        with np.load(path, allow_pickle=False) as kept:
            said = dict(json.loads(str(kept["metadata"])))
            return said if said.get("arrays") == digest(dict(kept)) else {}
    except (OSError, EOFError, KeyError, TypeError, ValueError, zipfile.BadZipFile):
        return {}


def _solve(case: Case, folder: Path) -> Solved:
    try:
        fine = press(case.pressing)
        others = {
            "mesh_and_steps": replace(case.pressing, mesh_mm=2 * case.pressing.mesh_mm, step_mm=2 * LONGEST_MM),
            "penalty": replace(case.pressing, penalty=0.5),
        }
        errors = {name: area_error(press(other), fine) for name, other in others.items()}
    except Stopped as error:
        least = error.reached_n < LEAST_FORCE_N
        do = "Check the units, mm and MPa" if least else f"Set [solve] force_n to {0.95 * error.reached_n:.2g} or less"
        return Solved(case, {}, stopped=f"{error}. {do}")
    said = _metadata(case, fine, errors)
    write_bytes_atomic(folder / f"{case.name}.npz", table_file(case, fine, said))
    return Solved(case, said)


def areas_mm2(found: Pressed, at_n: Sequence[float]) -> list[float]:
    """Area of contact seen along the axis at forces, mm^2; NaN beyond the last."""
    touched = found.contact_radius_mm > 0
    log_n, log_mm = (np.log(each[touched]) for each in (found.force_n, found.contact_radius_mm))
    return list(map(float, np.pi * np.exp(2 * np.interp(np.log(at_n), log_n, log_mm, right=np.nan))))


def dome_radius_mm(case: Case) -> float:
    """What camera.toml calls the sensor's radius when it is scored by these tables.

    Who reads tables takes pins to stand on a sphere of 19 mm in a dome of 20. Tables are written in the millimetres in
    which that is so; with a skin of another thickness this is not the radius outside.
    """
    dome = case.pressing.dome
    return OUTER_RADIUS_MM / INNER_RADIUS_MM * (dome.radius_mm - dome.skin_mm)


def area_error(other: Pressed, fine: Pressed) -> float:
    """Largest change of the area, a share of it, in a coarser solution: errors fall in proportion to the size of
    elements and steps and to 1 / penalty, or faster, so that no more is left in the fine one."""
    areas, others = (np.array(areas_mm2(each, AREA_AT_N)) for each in (fine, other))
    return float(np.max(np.abs(others / areas - 1), initial=0.0, where=np.isfinite(others)))


def _metadata(case: Case, fine: Pressed, errors: dict[str, float]) -> dict[str, Any]:
    areas = areas_mm2(fine, AREA_AT_N)
    pressing = asdict(case.pressing) | {"friction": case.name.rpartition("_")[2]}
    return {
        "digest": case.digest, "case": case.name, "solver": SOLVER, "pressing": pressing,
        "stiffness_n_per_mm": case.stiffness_n_per_mm if case.stiffness_n_per_mm < np.inf else None,
        "stiffness_by": case.stiffness_by,
        "dome_radius_mm": dome_radius_mm(case),
        "area_mm2": dict(zip(map(str, AREA_AT_N), areas, strict=True)),
        "area_error": sum(errors.values()), "area_error_of": errors,
        "force_unbalance": fine.unbalance, "work_not_stored": fine.unstored,
    }  # fmt: skip


def table_file(case: Case, found: Pressed, said: dict[str, Any]) -> bytes:
    """The file of a table (casr.dome.tables), in millimetres of a dome of 20 mm."""
    arrays: dict[str, Any] = {name: getattr(found, name) for name in ("force_n", "tilt_rad", *_LENGTHS)}
    for name in _LENGTHS:
        arrays[name] = arrays[name] * (OUTER_RADIUS_MM / dome_radius_mm(case))
    arrays["edge_arc_mm"] = found.edge_arc_mm * (OUTER_RADIUS_MM / case.pressing.dome.radius_mm)  # keeps the angle
    arrays[HEIGHT] = np.array(case.pressing.specimen.height_mm * (OUTER_RADIUS_MM / dome_radius_mm(case)))
    file = io.BytesIO()
    whole = json.dumps(said | {"arrays": digest(arrays)}, sort_keys=True)
    np.savez_compressed(file, metadata=np.array(whole), **arrays)
    return file.getvalue()
