"""The report step: everything that was found, in one folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from emg2vsa import artifacts
from emg2vsa.fits import concatenate
from emg2vsa.pipeline.fingerprint import library_versions
from emg2vsa.pipeline.manifest import write_manifest
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.report.inputs import Failure, StudyResults
from emg2vsa.report.study_report import write_study_report
from emg2vsa.schedule_files import write_schedule
from emg2vsa.study import Study
from emg2vsa.truth import read_truth


def report(
    study: Study,
    inputs: Mapping[str, Sequence[Path]],
    failures: Sequence[tuple[str, str, str]],
    truth: Path | None,
    result: Path,
) -> list[Ended]:
    """Write the report of a study from its stored results; a stage that failed leaves its section saying why."""

    def write() -> None:
        provenance = library_versions(("numpy", "scipy", "matplotlib", "emg2vsa"))
        provenance |= {f"{stage} key": paths[0].stem for stage, paths in inputs.items() if len(paths) == 1}
        fits = concatenate([artifacts.load(path) for path in inputs["fits"]])
        results = StudyResults(
            study=study,
            trials=tuple(artifacts.load(path) for path in inputs["trials"]),
            fits=fits,
            hypotheses=_only(inputs["hypotheses"]),
            profiles=_only(inputs["profiles"]),
            schedules=_only(inputs["schedules"]) or (),
            failures=tuple(Failure(*failure) for failure in failures),
            provenance=provenance,
            truth=read_truth(truth, fits) if truth else None,
            runs=tuple(artifacts.load(path) for path in inputs["runs"]),
            discrimination=_only(inputs["discrimination"]),
            calibration=_only(inputs["calibration"]),
        )
        files = write_study_report(results, study.reports)
        for schedule in results.schedules:
            files += write_schedule(study.reports / "schedules", schedule)
        write_manifest(result, files)

    return [guarded("report/study", write)]


def _only(paths: Sequence[Path]) -> Any:
    return artifacts.load(paths[0]) if paths else None
