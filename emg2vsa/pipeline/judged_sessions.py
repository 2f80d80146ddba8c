"""Participants' sessions judged from their recordings, whose presses and fits are brought up to date for it.

Also while they are recorded: which recordings somebody waits for, when they are complete, and their verdicts.
"""

from __future__ import annotations

import importlib
import os
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TextIO

from casr.terminal import Look, coloured
from emg2vsa import artifacts
from emg2vsa.companions.law_misfit import cell_misfits, compare_misfits
from emg2vsa.companions.person_slopes import person_slopes
from emg2vsa.errors import Emg2vsaError, SettingError
from emg2vsa.fits import Fits, by_recording, concatenate
from emg2vsa.pipeline.places import writable_or_temporary
from emg2vsa.pipeline.plan import StepPlan, survey
from emg2vsa.pipeline.run_study import Progress, run_study
from emg2vsa.process_pool import available_cores
from emg2vsa.screening import Screening, screened, screened_trials
from emg2vsa.screening.screen import screen, traits_by_recording, visits_of
from emg2vsa.session_verdict import Doubts, SessionVerdict, doubts_between, judge_session
from emg2vsa.study import RecordingEntry, Study

STAGES = ("trials", "fits")
LOOKS: dict[str, Look] = {"good": "good", "usable": "doubtful", "repeat": "bad", "unreadable": "bad"}
"""Looks of the words of verdicts on a terminal."""
POLL_S = 0.25
"""A file that has kept its size and time over two looks so far apart is complete."""


def of_participants(study: Study, participants: Sequence[str]) -> Study:
    """The study with the recordings of these participants; of all for none. SettingError for one it does not have."""
    unknown = [name for name in participants if name not in study.participants]
    if unknown:
        wanted = f"participants of the study ({', '.join(study.participants)})"
        raise SettingError(study.path, wanted=wanted, found=", ".join(unknown), do="Check the spelling.")
    chosen = participants or study.participants
    return replace(study, recordings=tuple(each for each in study.recordings if each.participant in chosen))


def judge(study: Study, whole: Study, jobs: int, shown: Progress, below: Path | None) -> list[SessionVerdict]:
    """The verdicts on the study's recordings, beside what is known of the ``whole`` study's others."""
    plan = run_study(study, stages=STAGES, jobs=jobs, progress=shown, below=below)
    doubts, screening, slopes = _beside(study, whole, plan, below)
    failures = {item: message for item, _, message in plan.failures()}
    return [
        replace(
            _verdict(plan, participant, failures, doubts, screening),
            b=tuple(row for row in slopes if row["participant"] == participant and row["presses"]),
        )
        for participant in plan.campaign.cells
    ]


def _beside(
    study: Study, whole: Study, plan: StepPlan, below: Path | None
) -> tuple[Doubts, Screening, list[dict[str, str | int | float | None]]]:
    """What is doubtful beside all recordings of the whole study whose results are there, and which are unlike them; b
    of all people."""
    if len(whole.recordings) > len(study.recordings):
        plan = survey(replace(study, recordings=whole.recordings), STAGES, lambda text: None, below=below)
    known = [key for key in plan.campaign.recordings if plan.done("trials", (key,)) and plan.done("fits", (key,))]
    own = [artifacts.load(path) for path in plan.done("fits", known)]
    trials = [artifacts.load(path) for path in plan.done("trials", known)]
    screening = screen(
        traits_by_recording(trials), whole.judgements, {(t.participant, t.specimen): visits_of(t) for t in trials}
    )
    fits = concatenate((screened(each, screening) for each in own), bins=False) if own else None
    doubts = doubts_between(trials, by_recording(fits) if fits else {}, whole.judgements)
    return doubts, screening, person_slopes(fits, whole.hypotheses.use).rows() if fits else []


def _verdict(
    plan: StepPlan, participant: str, failures: dict[str, str], doubts: Doubts, screening: Screening
) -> SessionVerdict:
    cells = plan.campaign.cells[participant]
    entries = [plan.campaign.recordings[cell] for cell in cells]
    fits = {
        e.specimen: screened(artifacts.load(path), screening) for e in entries for path in plan.done("fits", (e.key,))
    }
    session = judge_session(
        participant,
        [screened_trials(artifacts.load(path), screening) for path in plan.done("trials", cells)],
        fits,
        {entry.specimen: entry.wanted_presses for entry in entries},
        {entry.specimen: failures[entry.key] for entry in entries if entry.key in failures},
        {specimen: said for (who, specimen), said in doubts.items() if who == participant},
    )
    if not fits:
        return session
    law = compare_misfits(cell for each in fits.values() for cell in cell_misfits(each, "ok"))
    said = law.said(next(iter(fits.values())).activity_unit)
    return replace(session, law=said, law_fits=not law.together[0].told)


def fits_of(study: Study, shown: Progress) -> dict[str, Fits]:
    """Key of each recording that could be fitted to its fits, brought up to date, with the judgements of people."""
    with writable_or_temporary(study, None, now=True) as (placed, below):
        plan = run_study(placed, stages=STAGES, jobs=available_cores(), progress=shown, below=below)
        return {key: artifacts.load(path) for key in plan.campaign.recordings for path in plan.done("fits", (key,))}


def as_json(verdict: SessionVerdict) -> dict[str, object]:
    """A verdict for programs; of each advice its text and what to do."""
    return asdict(verdict) | {"advice": [each._asdict() for each in verdict.advice]}


def is_bad(word: str) -> bool:
    """Whether a verdict asks somebody to do something before the session can be used."""
    return word in ("repeat", "unreadable")


def told(verdicts: Iterable[SessionVerdict], stream: TextIO) -> Iterator[str]:
    """One line a session, its remarks with their remedies beneath, and at the end how many sessions are how good.

    Of several sessions only those say it whose presses the logarithm does not fit.
    """
    verdicts = list(verdicts)
    counts: Counter[str] = Counter()
    for verdict in verdicts:
        counts[verdict.verdict] += 1
        presses = ", ".join(f"{s.specimen} {s.ok}/{s.wanted or s.found}" for s in verdict.specimens)
        word = coloured(f"{verdict.verdict.upper():<10}", LOOKS[verdict.verdict], stream)
        yield f"{verdict.participant:<6} {word}  {presses}"
        for advice in verdict.advice:
            yield f"    {advice.text}"
            if advice.do:
                yield f"      -> {advice.do}"
        if verdict.law and (len(verdicts) == 1 or not verdict.law_fits):
            yield f"    {verdict.law}"
    if counts.total() > 1:
        yield counted(counts)
        if fits := [verdict.law_fits for verdict in verdicts if verdict.law]:
            yield f"The presses of {fits.count(False)} of {len(fits)} people contradict the logarithm v = a + b ln F."


def counted(verdicts: Counter[str]) -> str:
    """How many sessions are how good. verdicts : their words."""
    unreadable = f", {verdicts['unreadable']} unreadable" if verdicts["unreadable"] else ""
    return f"{verdicts['good']} good, {verdicts['usable']} usable, {verdicts['repeat']} to repeat{unreadable}"


class Awaited:
    """The recordings of a study that are written into a folder, with the files that they have now.

    Parameters
    ----------
    study : those that are judged. whole : beside all of these. folder : that is watched. again : both studies, read
        again. below : results that may be read. say : is told why they cannot be read again, and of files that belong
        to no recording.

    SettingError : no such folder, or none of the recordings belongs into it.
    """

    def __init__(
        self, study: Study, whole: Study, folder: Path, again: Callable[[], tuple[Study, Study]], below: Path | None,
        say: Callable[[str], None],
    ) -> None:  # fmt: skip
        self.folder = folder = Path(os.path.abspath(folder))
        self._study, self._whole, self._again, self._below, self._say = study, whole, again, below, say
        if not folder.is_dir():
            do = "Make this folder, or correct the path."
            raise SettingError(folder, wanted="a folder to watch", found="none", do=do)
        if not self._entries():
            raise SettingError(
                folder, wanted="the folder into which recordings of the study are written",
                found="a folder to which none of them belongs", do=f"The study's recordings lie in {study.data}.",
            )  # fmt: skip
        self._listed = _listing(folder)

    def _entries(self) -> list[RecordingEntry]:
        return [each for each in self._study.recordings if any(self.folder in path.parents for path in each.files)]

    def now(self) -> list[RecordingEntry]:
        """What is awaited; a pattern with * or {repetition} finds other files once files have come or gone."""
        if (present := _listing(self.folder)) != self._listed:
            new, self._listed = present - self._listed, present
            try:
                chosen, found = self._again()
                self._whole = replace(self._whole, recordings=found.recordings)
                self._study = replace(self._study, recordings=chosen.recordings)
            except Emg2vsaError as error:  # the study file was edited meanwhile
                self._say(str(error))
            self._tell_of_strangers(new)
        return self._entries()

    def _tell_of_strangers(self, new: Iterable[str]) -> None:
        """Files that have come and belong to no recording of the whole study: misnamed, perhaps."""
        known = {os.path.abspath(path) for entry in self._whole.recordings for path in entry.files}
        beside = {os.path.splitext(path)[0] for path in known}
        for path in sorted(new):
            # what a reader wants beside a recording bears its name, and what is being written has a name of its own
            if path in known or os.path.splitext(path)[0] in beside or os.path.basename(path).startswith((".", "~")):
                continue
            awaited = sorted(os.path.relpath(path, self.folder) for path in known if not os.path.exists(path))
            wanted = f" Awaited: {', '.join(awaited[:3])}{' ...' if len(awaited) > 3 else ''}." if awaited else ""
            self._say(f"{os.path.relpath(path, self.folder)} belongs to no recording of the study.{wanted}")

    def verdicts(self, shown: Progress) -> Iterator[tuple[str, SessionVerdict]]:
        """Key and verdict of each recording that lands, without end."""
        for entry in landings(self.now, time.sleep):
            (verdict,) = judge(replace(self._study, recordings=(entry,)), self._whole, 1, shown, self._below)
            yield entry.key, verdict

    def warm_up(self) -> None:
        """Load and look up beforehand what would delay the first verdict."""
        for name in ("readers.roles", "readers.plain_csv", "extraction.extract", "fits"):
            importlib.import_module(f"emg2vsa.{name}")
        survey(self._study, STAGES, lambda text: None, below=self._below)


def _listing(folder: Path) -> frozenset[str]:
    """The files below the folder, but for hidden folders."""
    found: set[str] = set()
    for inside, folders, files in os.walk(folder):
        folders[:] = [name for name in folders if not name.startswith(".")]
        found.update(os.path.join(inside, name) for name in files)
    return frozenset(found)


def landings(now: Callable[[], Iterable[RecordingEntry]], wait: Callable[[float], None]) -> Iterator[RecordingEntry]:
    """Each recording whenever its files are complete: there, and unchanged over two looks; again when they change.

    now : the recordings with the files that they have at a look. Those that are complete at the first look are not
    told: they were there before.
    """
    before = {entry.key: _state(entry) for entry in now()}
    done = dict(before)
    while True:
        wait(POLL_S)
        for entry in now():
            state = _state(entry)
            if state is not None and state == before.get(entry.key) != done.get(entry.key):
                done[entry.key] = state
                yield entry
            before[entry.key] = state


_State = tuple[tuple[Path, int, int], ...]


def _state(entry: RecordingEntry) -> _State | None:
    """Each file of a recording with its size and time; None while one is absent or empty."""
    found = []
    for path in entry.files:
        try:
            status = path.stat()
        except OSError:
            return None
        if status.st_size == 0:
            return None
        found.append((path, status.st_size, status.st_mtime_ns))
    return tuple(found)
