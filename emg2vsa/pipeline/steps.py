"""Which steps a study has, what each depends on, and which stages a wanted stage needs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

from emg2vsa.pipeline.campaign import Campaign
from emg2vsa.pipeline.fingerprint import Fingerprints, as_json, digest, library_versions
from emg2vsa.pipeline.ledger import Parts
from emg2vsa.readers.bids_sidecars import side_file_paths
from emg2vsa.readers.formats import reader_module
from emg2vsa.settings import RIGID
from emg2vsa.study import RecordingEntry, RunEntry, Study

FAILED = "failed"
"""Stands for the key of an input that failed: the step runs without it, and again once it works."""


@dataclass(frozen=True)
class Stage:
    """A kind of step. ``roots`` are the modules whose code, with all they import, makes its result."""

    name: str
    needs: tuple[str, ...]
    per: str  # recording, run, participant or study
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
        Stage("runs", ("schedules",), "run", ("emg2vsa.runs.score_run",), ("numpy", "opencv-contrib-python-headless")),
        Stage("discrimination", ("runs",), "study", ("emg2vsa.discrimination",), ("numpy", "scipy")),
        Stage("calibration", ("runs",), "study", ("emg2vsa.calibration",), ("numpy", "scipy")),
        Stage("pages", ("trials", "fits"), "participant", ("emg2vsa.report.session_page",), ("numpy",)),
        Stage(
            "report",
            ("trials", "fits", "hypotheses", "profiles", "schedules", "runs", "discrimination", "calibration", "pages"),
            "study",
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


OF_RUNS = frozenset({"runs", "discrimination", "calibration"})
"""The stages of the rig's runs."""
OF_PEOPLE = frozenset(STAGES) - OF_RUNS - {"report"}
"""The stages of the recordings."""

HUMAN_STAGES = tuple(name for name in STAGES if name not in OF_RUNS)
"""Everything about people, and its report."""
CASR_STAGES = tuple(name for name in STAGES if name not in ("hypotheses", "pages"))
"""The rig's runs with what they need, and their report."""


def items(study: Study, stage: str) -> tuple[str, ...]:
    """The items of a stage, in the study's order."""
    if (stage in OF_RUNS and not study.runs) or (stage in OF_PEOPLE and not study.recordings):
        return ()
    match STAGES[stage].per:
        case "recording":
            return tuple(entry.key for entry in study.recordings)
        case "run":
            return tuple(entry.key for entry in study.runs)
        case "participant":
            return tuple(dict.fromkeys(entry.participant for entry in study.recordings))
        case _:
            return ("study",)


def upstream(study: Study, stage: str, item: str) -> tuple[str, ...]:
    """Ids of the steps whose results this one takes."""
    if STAGES[stage].per == "run":
        condition = _run_entry(study, item).condition
        return (step_id("schedules", "study"),) if _is_emulated(study) and condition != RIGID else ()
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


def _run_entry(study: Study, item: str) -> RunEntry:
    return next(entry for entry in study.runs if entry.key == item)


def _is_emulated(study: Study) -> bool:
    return study.runs_source is not None and study.runs_source.rig is not None


def make_step(campaign: Campaign, stage: str, item: str, keys: Mapping[str, str], prints: Fingerprints) -> Step:
    """The step with everything it depends on; ``keys`` holds the keys of its inputs (or FAILED)."""
    study = campaign.study
    entries = {entry.key: entry for entry in study.recordings} if STAGES[stage].per == "recording" else {}
    entry = entries.get(item)
    files: tuple[Path, ...] = ()
    roots = set(STAGES[stage].roots)
    if stage == "trials" and entry is not None:
        files = _files(entry)
        roots |= _reader_modules(entry)
    elif stage == "runs":
        files = _run_files(study, _run_entry(study, item))
        roots.add(_MADE if _is_emulated(study) else _READ)
    elif stage == "report":
        files = truth_files(study)
    parts = Parts(
        settings=_settings(campaign, stage, item, entry),
        files={_shown(path, study): prints.file(path) for path in files},
        inputs=dict(keys),
        code=prints.code(sorted(roots)),
        libraries=library_versions(STAGES[stage].libraries),
    )
    return Step(stage, item, parts)


_MADE, _READ = "emg2vsa.rig.emulated.virtual_run", "emg2vsa.run_folders.presses"


def _settings(campaign: Campaign, stage: str, item: str, entry: RecordingEntry | None) -> dict[str, object]:
    study = campaign.study
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
    elif stage == "runs":
        used = {"runs": study.scoring}
        if campaign.rig is not None:
            # which other runs there are changes nothing in this one
            used |= {"experiment": replace(campaign.rig.experiment, specimens=(item,), angles_deg={})}
            used |= {"rig": campaign.rig.rig, "emulated": campaign.rig.emulated}
    elif stage == "discrimination":
        used = {"discrimination": study.discrimination, "specimens": study.pressed_n_per_mm}
        used["new_specimen"] = study.profile.new_specimen
    elif stage == "calibration":
        used = {"calibration": study.calibration, "specimens": study.pressed_n_per_mm}
        used["standard errors"] = study.pressed_se_n_per_mm
        used["new_specimen"] = study.profile.new_specimen
    elif stage == "pages":
        used = {"title": study.title, "specimens": study.specimens, "reports": study.reports.name}
    elif stage == "report":
        used = {name: value for name, value in vars(study).items() if name not in _NOT_IN_REPORT}
        used["path"] = study.path.name
    return {name: as_json(value) for name, value in used.items()}


_NOT_IN_REPORT = {"path", "recordings", "results", "reports", "data", "runs", "runs_source"}
"""Where things lie changes nothing in a report: a project that was moved is as fresh as it was."""


def _run_files(study: Study, entry: RunEntry) -> tuple[Path, ...]:
    """What a measured run consists of."""
    camera = study.runs_source.camera if study.runs_source else None
    inside = (path for folder in entry.folders for path in sorted(folder.rglob("*")) if path.is_file())
    return (*([camera] if camera else []), *inside)


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
