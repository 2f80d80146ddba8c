"""The recordings of a session in BIDS, its verdict, and the participant's page."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from emg2vsa.pipeline.judged_sessions import is_bad, judge, of_participants
from emg2vsa.pipeline.run_study import Progress, run_study
from emg2vsa.session.dataset import write_dataset
from emg2vsa.session.open_session import folder_of, settings_of
from emg2vsa.session_verdict import SessionVerdict
from emg2vsa.study import Study
from emg2vsa.study_file import load_study

SILENT = Progress(lambda stage, total: None, lambda step: None, lambda: None, lambda text: None)


@dataclass(frozen=True)
class FinishedSession:
    """What a session has become.

    folder : the participant's, in the data set. recordings : files in it. left_out : (stay, why) of those that could
    not be written. notes : to be read. verdicts : of the participant's recordings, as ``emg2vsa check`` judges them;
    empty where none was written. page : of the participant, HTML.
    """

    folder: Path
    recordings: tuple[Path, ...]
    left_out: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    verdicts: tuple[SessionVerdict, ...]
    page: Path

    @property
    def verdict(self) -> str:
        """One of `emg2vsa.session_verdict.VERDICTS`; "" where nothing was judged."""
        return self.verdicts[0].verdict if self.verdicts else ""

    @property
    def good(self) -> bool:
        """Every recording was written, and is good or usable."""
        return not self.left_out and not is_bad(self.verdict)


def finish(study: Study, participant: str, *, visit: str | None = None, progress: Progress = SILENT) -> FinishedSession:
    """Write the recordings of a session in BIDS, judge them, and make the participant's page.

    A session that reaches its last press does so by itself. For one that was interrupted and will not be resumed; or
    again, after the study file has changed: it is read again, for the recordings that are there then.

    visit : one of [recordings] visits, where the study has them; the verdict is on all visits until now.
    progress : is told of the steps of the study that are run for it.

    Raises
    ------
    SettingError : the study has no [session], no such participant or visit; the data set cannot be written to.
    DataError : there is no session, its journal is damaged, or a recording is there that no session wrote.

    Examples
    --------
    >>> from emg2vsa import session
    >>> session.finish(study, "P03").verdict  # doctest: +SKIP
    'good'
    """
    study = study.at_visit(visit)
    settings_of(study, participant)
    written = write_dataset(folder_of(study, participant), study)
    whole = load_study(study.path)  # whose recordings are there now
    own = of_participants(whole, [participant])
    verdicts = judge(own, whole, 1, progress, None)
    run_study(own, stages=("trials", "fits", "screening", "pages"), jobs=1, progress=progress)
    return FinishedSession(
        study.data / f"sub-{participant}",
        written.files,
        written.left_out,
        written.notes,
        tuple(verdicts),
        own.reports / "participants" / f"{participant}.html",
    )
