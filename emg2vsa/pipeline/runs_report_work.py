"""The report step of a study of measured runs alone."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.pipeline.fingerprint import library_versions
from emg2vsa.pipeline.manifest import write_manifest
from emg2vsa.pipeline.study_work import Inputs
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.report.inputs import Failure, RunsResults
from emg2vsa.report.study_report import write_runs_report
from emg2vsa.study import Study


def report(study: Study, inputs: Inputs, failures: Sequence[tuple[str, str, str]], result: Path) -> list[Ended]:
    """Write section VI from the stored results; a stage that failed leaves its section saying why."""

    def write() -> None:
        provenance = library_versions(("numpy", "scipy", "matplotlib", "emg2vsa"))
        provenance |= {f"{stage} key": paths[0].stem for stage, paths in inputs.items() if len(paths) == 1}
        results = RunsResults(
            study=study,
            runs=tuple(artifacts.load(path) for path in inputs["runs"]),
            discrimination=next(map(artifacts.load, inputs["discrimination"]), None),
            calibration=next(map(artifacts.load, inputs["calibration"]), None),
            failures=tuple(Failure(*failure) for failure in failures),
            provenance=provenance,
        )
        write_manifest(result, write_runs_report(results, study.reports))

    return [guarded("report/study", write)]
