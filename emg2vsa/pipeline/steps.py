"""Which steps a study has, what each depends on, and which stages a wanted stage needs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.pipeline.fingerprint import Fingerprints, as_json, digest, library_versions
from emg2vsa.pipeline.ledger import Parts
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
            "trials", (), "recording", ("emg2vsa.trials", "emg2vsa.readers.roles"),
            ("numpy", "scipy", "edfio", "ezc3d", "pandas", "pymatreader"),
        ),
        Stage("fits", ("trials",), "recording", ("emg2vsa.fits",), ("numpy", "scipy")),
        Stage("hypotheses", ("fits",), "study", ("emg2vsa.hypotheses",), ("numpy", "scipy")),
        Stage("profiles", ("fits",), "study", ("emg2vsa.profiles",), ("numpy",)),
        Stage("schedules", ("profiles",), "study", ("emg2vsa.schedules", "emg2vsa.schedule_files"), ("numpy",)),
        Stage("pages", ("trials", "fits"), "participant", ("emg2vsa.report.session_page",), ("numpy",)),
        Stage(
            "report", ("trials", "fits", "hypotheses", "profiles", "schedules", "pages"), "study",
            ("emg2vsa.report.study_report",), ("numpy", "matplotlib"),
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

    @property
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
    found: list[str] = []
    for need in STAGES[stage].needs:
        for other in items(study, need):
            if STAGES[stage].per == "study" or other == item or other.startswith(f"{item}/"):
                found.append(step_id(need, other))
    return tuple(found)


def make_step(study: Study, stage: str, item: str, keys: Mapping[str, str], prints: Fingerprints) -> Step:
    """The step with everything it depends on; ``keys`` holds the keys of its inputs (or FAILED)."""
    entry = next((e for e in study.recordings if e.key == item), None)
    parts = Parts(
        settings=_settings(study, stage, item, entry),
        files={_shown(path, study): prints.file(path) for path in _files(stage, entry)},
        inputs={name: keys[name] for name in upstream(study, stage, item)},
        code=prints.code((*STAGES[stage].roots, *_reader_module(stage, entry))),
        libraries=library_versions(STAGES[stage].libraries),
    )
    return Step(stage, item, parts)


def _settings(study: Study, stage: str, item: str, entry: RecordingEntry | None) -> dict[str, object]:
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
    elif stage == "hypotheses":
        used = {"hypotheses": study.hypotheses}
    elif stage == "profiles":
        used = {
            "profile": study.profile, "specimens": study.stiffness_n_per_mm, "hypotheses.use": study.hypotheses.use,
            "window": study.window,
        }  # fmt: skip
    elif stage == "schedules":
        used = {"schedule": study.schedule, "study": study.name}
    elif stage == "pages":
        used = {"title": study.title, "specimens": study.specimens, "reports": study.reports.name}
    elif stage == "report":
        used = {name: value for name, value in vars(study).items() if name not in _NOT_IN_REPORT}
        used["path"] = study.path.name
    return {name: as_json(value) for name, value in used.items()}


_NOT_IN_REPORT = {"path", "recordings", "results", "reports"}


def _files(stage: str, entry: RecordingEntry | None) -> Iterable[Path]:
    if stage != "trials" or entry is None:
        return ()
    from emg2vsa.readers import side_files

    own = [entry.emg_file] + ([entry.force_file] if entry.force_file else [])
    return [*own, *(side for path in own for side in side_files(path))]


def _shown(path: Path, study: Study) -> str:
    try:
        return path.relative_to(study.path.parent).as_posix()
    except ValueError:
        return path.as_posix()
