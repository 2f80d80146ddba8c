"""The report step: everything that was found, in one folder."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from emg2vsa import artifacts
from emg2vsa.errors import DataError
from emg2vsa.fits import concatenate
from emg2vsa.pipeline.fingerprint import library_versions
from emg2vsa.pipeline.manifest import write_manifest
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.report.inputs import Failure, StudyResults
from emg2vsa.report.study_report import write_study_report
from emg2vsa.study import Study
from emg2vsa.truth import read_truth


def report(
    study: Study,
    inputs: Mapping[str, Sequence[Path]],
    failures: Sequence[tuple[str, str, str]],
    truth: Path | None,
    result: Path,
) -> list[Ended]:
    """Write the report of a study from its stored results."""

    def write() -> None:
        provenance = library_versions(("numpy", "scipy", "matplotlib", "emg2vsa"))
        provenance |= {f"{stage} key": _only(paths).stem for stage, paths in inputs.items() if len(paths) == 1}
        results = StudyResults(
            study=study,
            trials=tuple(artifacts.load(path) for path in inputs["trials"]),
            fits=concatenate([artifacts.load(path) for path in inputs["fits"]]),
            hypotheses=artifacts.load(_only(inputs["hypotheses"])),
            profiles=artifacts.load(_only(inputs["profiles"])),
            schedules=artifacts.load(_only(inputs["schedules"])),
            failures=tuple(Failure(*failure) for failure in failures),
            provenance=provenance,
            truth=read_truth(truth) if truth else None,
        )
        write_manifest(result, write_study_report(results, study.reports))

    return [guarded("report/study", write)]
