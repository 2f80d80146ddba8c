"""Which steps a study has, what each depends on, and which stages a wanted stage needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from emg2vsa.pipeline.fingerprint import Fingerprints, as_json, digest, library_versions
from emg2vsa.pipeline.ledger import Parts
from emg2vsa.readers.bids_sidecars import side_file_paths
from emg2vsa.readers.formats import reader_module
from emg2vsa.study import RecordingEntry, Study

FAILED = "failed"
"""Stands for the key of an input that failed: the step runs without it, and again once it works."""


@dataclass(frozen=True)
class Stage:
    """A kind of step. ``roots`` are the modules whose code, with all they import, makes its result."""

    name: str
    needs: tuple[str, ...]
    per: str  # recording, participant or study
    roots: tuple[str, ...]
    libraries: tuple[str, ...]


STAGES = {
    stage.name: stage
    for stage in (
        Stage(
            "trials", (), "recording", ("emg2vsa.trials.extract", "emg2vsa.readers.roles"),
            ("numpy", "scipy", "edfio", "ezc3d", "pandas", "pymatreader"),
        ),
        Stage("fits", ("trials",), "recording", ("emg2vsa.fits", "emg2vsa.trials.session"), ("numpy", "scipy")),
        Stage("hypotheses", ("fits",), "study", ("emg2vsa.hypotheses",), ("numpy", "scipy", "statsmodels")),
        Stage("profiles", ("fits",), "study", ("emg2vsa.profiles",), ("numpy", "scipy")),
        Stage("schedules", ("profiles",), "study", ("emg2vsa.schedules",), ("numpy", "scipy")),
        Stage("pages", ("trials", "fits"), "participant", ("emg2vsa.report.session_page",), ("numpy",)),
        Stage(
            "report", ("trials", "fits", "hypotheses", "profiles", "schedules", "pages"), "study",
            ("emg2vsa.report.study_report", "emg2vsa.schedule_files", "emg2vsa.truth"), ("numpy", "matplotlib"),
        ),
    )
}  # fmt: skip


@dataclass(frozen=True)
class Step:
    """One stage for one recording, one participant or the whole study."""

    stage: str
    item: str
    parts: Parts

    @property
    def id(self) -> str:
        return step_id(self.stage, self.item)

    @cached_property
    def key(self) -> str:
        return digest(self.stage, self.item, repr(as_json(self.parts)))


def step_id(stage: str, item: str) -> str:
    return f"{stage}/{item}"


def stages_for(wanted: str | None) -> tuple[str, ...]:
    """The wanted stage and all it needs, in running order; every stage when nothing is named."""
    if wanted is None:
        return tuple(STAGES)
    needed = {wanted}
    for name in reversed(STAGES):
        if name in needed:
            needed.update(STAGES[name].needs)
    return tuple(name for name in STAGES if name in needed)


def items(study: Study, stage: str) -> tuple[str, ...]:
    """The items of a stage, in the study's order."""
    match STAGES[stage].per:
        case "recording":
            return tuple(entry.key for entry in study.recordings)
        case "participant":
            return tuple(dict.fromkeys(entry.participant for entry in study.recordings))
        case _:
            return ("study",)


def upstream(study: Study, stage: str, item: str) -> tuple[str, ...]:
    """Ids of the steps whose results this one takes."""
    if STAGES[stage].per == "recording" and not (stage == "fits" and study.cocontraction.needs_session):
        return tuple(step_id(need, item) for need in STAGES[stage].needs)
    prefix = "" if STAGES[stage].per == "study" else f"{item.partition('/')[0]}/"
    return tuple(
        step_id(need, other) for need in STAGES[stage].needs for other in items(study, need) if other.startswith(prefix)
    )


def truth_files(study: Study) -> tuple[Path, ...]:
    """The table of the simulated presses beside the recordings, where the study was simulated."""
    places = (study.data / "derivatives" / "truth" / "truth.tsv", study.data / "truth.tsv")
    return tuple(path for path in places if path.is_file())[:1]


def make_step(study: Study, stage: str, item: str, keys: Mapping[str, str], prints: Fingerprints) -> Step:
    """The step with everything it depends on; ``keys`` holds the keys of its inputs (or FAILED)."""
    entries = {entry.key: entry for entry in study.recordings} if STAGES[stage].per == "recording" else {}
    entry = entries.get(item)
    files: tuple[Path, ...] = ()
    roots = set(STAGES[stage].roots)
    if stage == "trials" and entry is not None:
        files = _files(entry)
        roots |= _reader_modules(entry)
    elif stage == "report":
        files = truth_files(study)
    parts = Parts(
        settings=_settings(study, stage, entry),
        files={_shown(path, study): prints.file(path) for path in files},
        inputs={name: keys[name] for name in upstream(study, stage, item)},
        code=prints.code(sorted(roots)),
        libraries=library_versions(STAGES[stage].libraries),
    )
    return Step(stage, item, parts)


def _settings(study: Study, stage: str, entry: RecordingEntry | None) -> dict[str, object]:
    used: dict[str, object] = {}
    if stage == "trials":
        assert entry is not None
        used = {
            "channels": entry.channels, "filters": entry.filters, "window": entry.window,
            "cocontraction": study.cocontraction,
        }  # fmt: skip
    elif stage == "fits":
        assert entry is not None
        used = {"fit": study.fit, "window.force_n": entry.window.force_n}
        if study.cocontraction.needs_session:
            used["cocontraction"] = study.cocontraction
    elif stage == "hypotheses":
        used = {"hypotheses": study.hypotheses}
    elif stage == "profiles":
        used = {
            "profile": study.profile, "specimens": study.stiffness_n_per_mm, "hypotheses.use": study.hypotheses.use,
            "window.force_n": study.window.force_n,
        }  # fmt: skip
    elif stage == "schedules":
        used = {"schedule": study.schedule, "study": study.name, "mode": study.mode}
    elif stage == "pages":
        used = {"title": study.title, "specimens": study.specimens, "reports": study.reports.name}
    elif stage == "report":
        used = {name: value for name, value in vars(study).items() if name not in _NOT_IN_REPORT}
        used["path"] = study.path.name
    return {name: as_json(value) for name, value in used.items()}


_NOT_IN_REPORT = {"path", "recordings", "results", "reports"}


def _files(entry: RecordingEntry) -> tuple[Path, ...]:
    own = (entry.emg_file, entry.force_file) if entry.force_file else (entry.emg_file,)
    return (*own, *(side for path in own for side in side_file_paths(path)))


def _reader_modules(entry: RecordingEntry) -> set[str]:
    modules = (reader_module(path) for path in (entry.emg_file, entry.force_file) if path)
    return {module for module in modules if module}


def _shown(path: Path, study: Study) -> str:
    try:
        return path.relative_to(study.path.parent).as_posix()
    except ValueError:
        return path.as_posix()
