"""A study as it is now beside its registration: its plan, the code that would judge it, and the data that are there."""

from __future__ import annotations

import contextlib
import importlib
from collections.abc import Iterator
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import emg2vsa
from emg2vsa.errors import DataError, Emg2vsaError
from emg2vsa.pipeline.code import Code
from emg2vsa.pipeline.fingerprint import MISSING, Fingerprints, digest
from emg2vsa.registration import Registered, compared, plan_of, planned_claims, read_registration
from emg2vsa.registration.deviations import CODE
from emg2vsa.registration.plan import Plain, session_plan
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
    now = {
        "plan": plan_of(study, _tables(rig) if rig else {}),
        "claims": planned_claims(study, rig.experiment if rig else None),
        "code": _code(Code(prints)),
        "data": {"recordings": _recordings(study, prints), "runs": _runs(study, prints)},
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
    """Participant to what the plan of a recorded session says of [session]."""
    for participant in study.participants:
        path = session_folder(study.data, participant, study.task) / PLAN_FILE
        if path.is_file():
            with contextlib.suppress(DataError):  # of a damaged plan the session itself tells
                yield participant, session_plan(dict(read_plan(path).settings["session"]))


def _tables(rig: RigFile) -> dict[str, Any]:
    """Of a rig file all that is no address and no way to its devices."""
    camera, emulated = rig.devices.camera, rig.emulated
    return {
        "rig": asdict(rig.rig),
        "experiment": asdict(rig.experiment),
        "camera": {key: getattr(camera, key) for key in ("height", "width", "rate_hz", "delay_s")} if camera else {},
        "emulated": asdict(emulated) if emulated else {},
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
    """Those of which every file is there, with the digests of their files."""
    found = {entry.key: [prints.file(path) for path in (*entry.files, *entry.mvc_files)] for entry in study.recordings}
    return {key: digests for key, digests in found.items() if MISSING not in digests}


def _runs(study: Study, prints: Fingerprints) -> dict[str, list[str]]:
    """Measured runs by folder; those of an emulated rig follow from the plan."""
    source = study.runs_source
    if source is None or source.rig is not None or not source.root.is_dir():
        return {}
    folders = (path for path in sorted(source.root.iterdir()) if path.is_dir())
    files = {path.name: [each for each in sorted(path.rglob("*")) if each.is_file()] for path in folders}
    return {name: [digest(*map(prints.file, of))] for name, of in files.items() if of}
