"""The page of one participant."""

from __future__ import annotations

from pathlib import Path

from emg2vsa import artifacts
from emg2vsa.fits import concatenate
from emg2vsa.pipeline.manifest import write_manifest
from emg2vsa.pipeline.tasks import Ended, guarded
from emg2vsa.report.inputs import Failure
from emg2vsa.report.session_page import write_session_page
from emg2vsa.study import Study


def run(
    study: Study,
    participant: str,
    trials: tuple[Path, ...],
    fits: tuple[Path, ...],
    failures: tuple[tuple[str, str, str], ...],
    result: Path,
) -> list[Ended]:
    """Write the page and remember its files."""

    def write() -> None:
        files = write_session_page(
            study,
            participant,
            [artifacts.load(path) for path in trials],
            concatenate([artifacts.load(path) for path in fits]) if fits else None,
            tuple(Failure(*failure) for failure in failures),
            study.reports,
        )
        write_manifest(result, files)

    return [guarded(f"pages/{participant}", write)]
