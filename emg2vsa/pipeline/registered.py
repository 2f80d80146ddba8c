"""A study as it is now beside its registration: its plan, the code that would judge it, and the data that are there."""

from __future__ import annotations

import contextlib
import importlib
import json
import re
from collections.abc import Iterator
from dataclasses import asdict, replace
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, Any

import emg2vsa
from emg2vsa.errors import DataError, Emg2vsaError
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import MISSING, Fingerprints, digest
from emg2vsa.readers.sample_files import sample_file_paths
from emg2vsa.registration import Registered, compared, plan_of, planned_claims, read_registration
from emg2vsa.registration.deviations import CODE
from emg2vsa.registration.plan import Plain, session_plan
from emg2vsa.rig.experiment import Run
from emg2vsa.rig.record.new_folder import PLAN_FILE as PLAN_OF_RUN
from emg2vsa.run_folders.find import find_runs
from emg2vsa.session.plan import PLAN_FILE, read_plan
from emg2vsa.session.record import session_folder
from emg2vsa.study import Study

if TYPE_CHECKING:
    from emg2vsa.rig_file import RigFile


def registered(study: Study, *, final: bool = False) -> Registered | None:
    """The registration of ``study`` and every deviation from it; None without one.

    final : as for ``compared``. DataError : the registration is not as it was written, or not of this study.
    """
    if study.registration is None:
        return None
    of = read_registration(study.registration, study.name)
    rig = _rig(study, study.path.parent / of["rig_file"] if of["rig_file"] else None)
    now = as_it_is(study, rig)
    return replace(
        compared(of, now, study.registration.name, final=final),
        from_amended=tuple(_from_amended(study.registration, of, now, final)),
    )


def _from_amended(path: Path, of: Plain, now: Plain, final: bool) -> Iterator[str]:
    """Deviations, but those of code, from the amended registrations that still lie beside the one of ``path``."""
    for other in sorted(path.parent.glob("*.json")) if of["amends"] else ():
        with contextlib.suppress(DataError):
            if (earlier := read_registration(other, None))["sha256"] == of["amends"]:
                yield from (f"{other.name}, {each}" for each in compared(earlier, now, other.name, final=final).of_plan)
                yield from _from_amended(other, earlier, now, final)


def _rig(study: Study, planned: Path | None) -> RigFile | None:
    """The rig file of the study, or the one that was registered; None where it is gone or has problems, which a run of
    the rig tells."""
    path = study.runs_source.rig if study.runs_source and study.runs_source.rig else planned
    with contextlib.suppress(Emg2vsaError):
        return importlib.import_module("emg2vsa.rig_file").load_rig(path) if path else None
    return None


def as_it_is(study: Study, rig: RigFile | None) -> dict[str, Any]:
    """``plan``, ``claims``, ``code``, ``data`` and ``sessions`` of a study."""
    prints = Fingerprints(study.results / "fingerprints.json")
    there = _runs(study, prints)
    runs = {run.name: run for run in rig.experiment.all_runs()} if rig else {name: there[name][0] for name in there}
    now = {
        "plan": plan_of(study, _tables(rig) if rig else {}, runs),
        "claims": planned_claims(study, rig.experiment if rig else None),
        "code": _code(Code(prints)),
        "data": {"recordings": _recordings(study, prints), "runs": {name: one[1] for name, one in there.items()}},
        "sessions": dict(_sessions(study)),
    }
    if study.results.is_dir():
        prints.save()
    return now


def session_deviations(study: Study, participant: str) -> tuple[str, ...]:
    """What a session of ``participant`` does otherwise than registered, in sentences; also why that cannot be told."""
    try:
        found = registered(study)
    except Emg2vsaError as error:
        return (f"The registered plan cannot be read: {error}",)
    of = [each for each in found.deviations if each.kind == "protocol"] if found else []
    others = ("session of ", *(f"participant {name}" for name in study.participants if name != participant))
    return tuple(f"Deviation from the registered plan: {each}" for each in of if not each.what.startswith(others))


def _sessions(study: Study) -> Iterator[tuple[str, dict[str, Any]]]:
    """Participant, or visit, to what the plan of a recorded session says of [session]."""
    for participant, visit in product(study.participants, study.visits or ("",)):
        path = session_folder(study.data, participant, study.task, visit) / PLAN_FILE
        if path.is_file():
            with contextlib.suppress(DataError):  # of a damaged plan the session itself tells
                who = f"{participant} at visit {visit}" if visit else participant
                yield who, session_plan(dict(read_plan(path).settings["session"]))


def _tables(rig: RigFile) -> dict[str, Any]:
    """Tables of a rig file without addresses and ways to its devices."""
    camera, emulated = rig.devices.camera, rig.emulated
    return {
        "rig": asdict(rig.rig),
        "experiment": asdict(rig.experiment),
        "camera": {key: getattr(camera, key) for key in ("height", "width", "rate_hz", "delay_s")} if camera else {},
        "emulated": asdict(emulated) if emulated else {},
        "plate": asdict(rig.plate),
    }


def _code(code: Code) -> dict[str, Any]:
    reached = {name: code.reached(f"{emg2vsa.__name__}.{module}") for name, (module, _) in CODE.items()}
    parts = {name: each.modules.digest for name, each in reached.items()}
    libraries = {name: version for each in reached.values() for name, version in each.libraries.value.items()}
    return {
        "emg2vsa": emg2vsa.__version__, "digest": digest(*parts.values()), "parts": parts,
        "libraries": dict(sorted(libraries.items())),
    }  # fmt: skip


def _recordings(study: Study, prints: Fingerprints) -> dict[str, list[str]]:
    """Those of which every file is there, with the digests of their files and of those that their samples are in."""
    named = {entry.key: (*entry.files, *entry.mvc_files) for entry in study.recordings}
    found = {
        key: [prints.file(file) for path in paths for file in (path, *sample_file_paths(path))]
        for key, paths in named.items()
    }
    return {key: digests for key, digests in found.items() if MISSING not in digests}


def _runs(study: Study, prints: Fingerprints) -> dict[str, tuple[Run, list[str]]]:
    """Measured runs by name, with the digests of their folders; those of an emulated rig follow from the plan.

    A copy, and a further folder of a run that the rig would have named otherwise, are runs of their own.
    """
    source, folders = study.runs_source, []
    with contextlib.suppress(DataError):  # of a run that makes no sense the pipeline tells
        for entry in find_runs(source.root, study.pressed_n_per_mm) if source and source.rig is None else ():
            for place, folder in enumerate(entry.folders, 1):
                run = Run(entry.specimen, entry.angle_deg, entry.condition, _mounting(folder, place))  # type: ignore[arg-type]
                of_rig = re.fullmatch(rf"{re.escape(run.name)}(-\d+)?", folder.name) is not None
                folders.append((not of_rig, run, folder))
    found: dict[str, tuple[Run, list[str]]] = {}
    for other, run, folder in sorted(folders):
        own = digest(*(prints.file(path) for path in sorted(folder.rglob("*")) if path.is_file()))
        again = (other and run.name in found) or any(own in digests for _, digests in found.values())
        found.setdefault(f"{run.name} in {folder.name}" if again else run.name, (run, []))[1].append(own)
    return found


def _mounting(folder: Path, place: int) -> int:
    """Mounting of a run, as its plan tells; else its place among the folders of its specimen, angle and condition."""
    with contextlib.suppress(OSError, ValueError, KeyError, TypeError):
        if isinstance(told := json.loads((folder / PLAN_OF_RUN).read_text("utf-8"))["plan"]["mounting"], int):
            return told
    return place
