"""``emg2vsa check``: is this participant's session good, now?"""

from __future__ import annotations

import argparse
import dataclasses
import os
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING, TextIO

from casr.command_line import Commands, add_command, add_json, print_json
from casr.terminal import Look, coloured, note
from emg2vsa.cli.arguments import add_jobs, add_study, add_work, jobs_of, study_of

if TYPE_CHECKING:
    from emg2vsa.pipeline.plan import StepPlan
    from emg2vsa.pipeline.run_study import Progress
    from emg2vsa.session_verdict import Doubts, SessionVerdict
    from emg2vsa.study import RecordingEntry, Study

STAGES = ("trials", "fits")
LOOKS: dict[str, Look] = {"good": "good", "usable": "doubtful", "repeat": "bad", "unreadable": "bad"}
"""Of the words of verdicts on a terminal."""
POLL_S = 0.25
"""A file that has kept its size and time over two looks so far apart is complete."""


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "check",
        run,
        "Check the study file, then judge each participant's session: good, usable, repeat or unreadable.",
        "Good: every press is as it should be. Usable: you can go on, but read the remarks. Repeat: a recording has "
        "fewer than 80 % "
        "usable presses. Unreadable: a recording cannot be used until its file or the study file is corrected. Exit "
        "status 0: all good or usable; 1: some repeat or unreadable; 2: the study file has problems.",
    )
    add_study(parser)
    parser.add_argument("participants", nargs="*", metavar="PARTICIPANT", help="sessions to judge (default: all)")
    parser.add_argument(
        "--watch",
        type=Path,
        metavar="FOLDER",
        help="judge each recording when it appears in FOLDER, until you press Ctrl-C",
    )
    add_work(parser)
    add_jobs(parser)
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.pipeline.places import writable_or_temporary

    whole, below = study_of(arguments)
    chosen = of_participants(whole, arguments.participants)
    with writable_or_temporary(chosen, below, now=True) as (study, below):
        if arguments.watch is not None:
            return _watch(arguments, study, whole, below)
        shown = progress(quiet=arguments.json)
        verdicts = judge(study, whole, jobs_of(arguments), shown, below)
    if arguments.json:
        print_json({verdict.participant: as_json(verdict) for verdict in verdicts})
    else:
        for line in told(verdicts, sys.stdout):
            print(line)
    return int(any(verdict.verdict in ("repeat", "unreadable") for verdict in verdicts))


def as_json(verdict: SessionVerdict) -> dict[str, object]:
    """A verdict for programs; of each advice its text and what to do."""
    advice = [each._asdict() for each in verdict.advice]
    return dataclasses.asdict(verdict) | {"advice": advice}


def of_participants(study: Study, participants: list[str]) -> Study:
    """The study with the recordings of these participants."""
    from emg2vsa.errors import SettingError

    unknown = [name for name in participants if name not in study.participants]
    if unknown:
        raise SettingError(
            study.path, wanted=f"participants of the study ({', '.join(study.participants)})",
            found=", ".join(unknown), do="Check the spelling.",
        )  # fmt: skip
    chosen = participants or study.participants
    return dataclasses.replace(study, recordings=tuple(e for e in study.recordings if e.participant in chosen))


def judge(study: Study, whole: Study, jobs: int, shown: Progress, below: Path | None) -> list[SessionVerdict]:
    """The verdicts on the study's recordings, beside what is known of the ``whole`` study's others."""
    from emg2vsa.pipeline.run_study import run_study

    plan = run_study(study, stages=STAGES, jobs=jobs, progress=shown, below=below)
    doubts = _doubts(study, whole, plan, below)
    failures = {item: message for item, _, message in plan.failures()}
    return [_verdict(plan, participant, failures, doubts) for participant in plan.campaign.cells]


def _doubts(study: Study, whole: Study, plan: StepPlan, below: Path | None) -> Doubts:
    """What is doubtful beside all recordings of the whole study whose results are there."""
    from emg2vsa import artifacts
    from emg2vsa.fits import by_recording, concatenate
    from emg2vsa.pipeline.plan import survey
    from emg2vsa.session_verdict import doubts_between

    if len(whole.recordings) > len(study.recordings):
        everything = dataclasses.replace(study, recordings=whole.recordings)
        plan = survey(everything, STAGES, lambda text: None, below=below)
    known = [key for key in plan.campaign.recordings if plan.done("trials", (key,)) and plan.done("fits", (key,))]
    fits = [artifacts.load(path) for path in plan.done("fits", known)]
    return doubts_between(
        [artifacts.load(path) for path in plan.done("trials", known)],
        by_recording(concatenate(fits)) if fits else {},
        whole.judgements,
    )


def _verdict(plan: StepPlan, participant: str, failures: dict[str, str], doubts: Doubts) -> SessionVerdict:
    from emg2vsa import artifacts
    from emg2vsa.session_verdict import judge_session

    cells = plan.campaign.cells[participant]
    entries = [plan.campaign.recordings[cell] for cell in cells]
    fits = {e.specimen: artifacts.load(path) for e in entries for path in plan.done("fits", (e.key,))}
    return judge_session(
        participant,
        [artifacts.load(path) for path in plan.done("trials", cells)],
        fits,
        {entry.specimen: entry.window.expected_trials for entry in entries},
        {entry.specimen: failures[entry.key] for entry in entries if entry.key in failures},
        {specimen: said for (who, specimen), said in doubts.items() if who == participant},
    )


def told(verdicts: Iterable[SessionVerdict], stream: TextIO) -> Iterator[str]:
    """One line a session, its remarks with their remedies beneath, and at the end how many sessions are how good."""
    counts: Counter[str] = Counter()
    for verdict in verdicts:
        counts[verdict.verdict] += 1
        presses = ", ".join(f"{s.specimen} {s.usable}/{s.wanted or s.found}" for s in verdict.specimens)
        yield f"{verdict.participant:<6} {_coloured(verdict.verdict, stream)}  {presses}"
        for advice in verdict.advice:
            yield f"    {advice.text}"
            if advice.do:
                yield f"      -> {advice.do}"
    if counts.total() > 1:
        yield _counted(counts)


def _counted(verdicts: Counter[str]) -> str:
    unreadable = f", {verdicts['unreadable']} unreadable" if verdicts["unreadable"] else ""
    return f"{verdicts['good']} good, {verdicts['usable']} usable, {verdicts['repeat']} to repeat{unreadable}"


def _coloured(word: str, stream: TextIO) -> str:
    """The word of a verdict in capitals, in its colour on a terminal."""
    return coloured(f"{word.upper():<10}", LOOKS[word], stream)


def _watch(arguments: argparse.Namespace, study: Study, whole: Study, below: Path | None) -> int:
    from emg2vsa.cli.progress import progress
    from emg2vsa.errors import Emg2vsaError, SettingError

    folder = Path(os.path.abspath(arguments.watch))
    if not folder.is_dir():
        raise SettingError(
            folder, wanted="a folder to watch", found="none", do="Make this folder, or correct the path."
        )

    def awaited() -> list[RecordingEntry]:
        return [entry for entry in study.recordings if any(folder in path.parents for path in entry.files)]

    if not awaited():
        raise SettingError(
            folder, wanted="the folder into which recordings of the study are written", found="a folder to which "
                    "none of them belongs",
            do=f"The study's recordings lie in {study.data}.",
        )  # fmt: skip
    listed = _listing(folder)

    def now() -> list[RecordingEntry]:
        """What is awaited; a pattern with * or {repetition} finds other files once files have come or gone."""
        nonlocal study, whole, listed
        if (present := _listing(folder)) != listed:
            listed = present
            try:
                found, _ = study_of(arguments)
                chosen = of_participants(found, arguments.participants)
                whole = dataclasses.replace(whole, recordings=found.recordings)
                study = dataclasses.replace(study, recordings=chosen.recordings)
            except Emg2vsaError as error:  # the study file was edited meanwhile
                print(f"emg2vsa: {error}", file=sys.stderr)
        return awaited()

    _warm_up(study, below)
    verdicts: dict[str, str] = {}
    note(f"Watching {folder}; Ctrl-C ends.")
    try:
        for entry in landings(now, time.sleep):
            one = dataclasses.replace(study, recordings=(entry,))
            (verdict,) = judge(one, whole, 1, progress(quiet=True), below)
            verdicts[entry.key] = verdict.verdict
            if arguments.json:
                print_json({entry.key: as_json(verdict)})
            else:
                bell = "\a" if sys.stdout.isatty() and verdict.verdict in ("repeat", "unreadable") else ""
                for line in told([verdict], sys.stdout):
                    print(f"{bell}{line}", flush=True)
                    bell = ""
    except KeyboardInterrupt:
        counts = Counter(verdicts.values())
        print(f"\n{_counted(counts)}", file=sys.stderr)
    return int(any(verdict in ("repeat", "unreadable") for verdict in verdicts.values()))


def _warm_up(study: Study, below: Path | None) -> None:
    """Load and look up beforehand what would delay the first verdict."""
    import importlib

    from emg2vsa.pipeline.plan import survey

    for name in ("emg2vsa.readers.roles", "emg2vsa.readers.plain_csv", "emg2vsa.extraction.extract", "emg2vsa.fits"):
        importlib.import_module(name)
    survey(study, STAGES, lambda text: None, below=below)


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
