"""A session from its devices to its desk, and whatever ends it: what was recorded stays, and can be resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import asdict, replace
from datetime import datetime
from pathlib import Path

from emg2vsa.errors import SettingError
from emg2vsa.rig.clock import Clock
from emg2vsa.rig.device_settings import ForceSettings
from emg2vsa.session.desk import SessionDesk
from emg2vsa.session.open_sources import open_sources
from emg2vsa.session.plan import Plan, changes, draw_presses
from emg2vsa.session.record import new_session, resume_session, session_folder
from emg2vsa.session.recorded_stream import RecordedStream
from emg2vsa.session.run import Session, check_muscles
from emg2vsa.session.stay_judge import JudgeAtOnce, JudgeBeside
from emg2vsa.session.streams import Source
from emg2vsa.session_settings import EmgSourceSettings, ForceSourceSettings, SessionSettings
from emg2vsa.study import Study

_NOBODY = (ForceSourceSettings(kind="simulated"), EmgSourceSettings(kind="simulated"))
"""In the place of the other device, while one is opened alone."""

Makers = tuple[Callable[[], Source], Callable[[], Source]]
"""Open the source of the EMG, and that of the force, without starting it."""


def settings_of(study: Study, participant: str) -> SessionSettings:
    """The table [session]. SettingError where there is none, or the study does not know the participant."""
    if study.session is None:
        do = "Add it: docs/reference/study-file.md lists its keys."
        raise SettingError(study.path, wanted="a table [session]", found="none", do=do)
    if participant not in study.participants:
        raise SettingError(
            f"--participant {participant}", wanted=f"one of {', '.join(study.participants)}", found="another code",
            do=f"Check the code, or add it to [participants] of {study.path}.",
        )  # fmt: skip
    return study.session


def folder_of(study: Study, participant: str) -> Path:
    """Where the samples and the journal of a participant's session are."""
    return session_folder(study.data, participant, study.task)


@contextmanager
def open_session(
    study: Study, participant: str, clock: Clock, makers: Makers, *, resume: bool = False, at_once: bool = False
) -> Iterator[SessionDesk]:
    """Devices started, folder and order made or found again, ready for `SessionDesk.run`.

    at_once : judge and write within the turn, for a clock that stands still meanwhile. When the block is left before
    the session has ended, the session ends as interrupted.
    SettingError, DataError, DeviceError : as `settings_of`, `new_session`, `resume_session`, and the devices.
    """
    settings = settings_of(study, participant)
    folder = folder_of(study, participant)
    now = {"session": asdict(settings), "specimens": [each.name for each in study.specimens],
           "window": asdict(study.window)}  # fmt: skip
    with ExitStack() as stack:
        sources = []
        for make in makers:
            sources.append(source := make())
            stack.callback(source.close)
            source.start()
        check_muscles(study, sources[0].info.channels)
        if resume:
            record = resume_session(folder, clock.now_s, background=not at_once)
        else:
            presses = draw_presses(study.name, participant, now["specimens"], settings)  # type: ignore[arg-type]
            drawn_at = datetime.now().astimezone().isoformat("T", "seconds")
            plan = Plan(study.name, participant, settings.seed, drawn_at, presses, now)
            record = new_session(folder, plan, clock.now_s, background=not at_once)
        stack.callback(record.close)
        emg, force = (
            RecordedStream(name, source, make, record, clock.now_s(), not at_once)
            for name, source, make in zip(("emg", "force"), sources, makers, strict=True)
        )
        judge = JudgeAtOnce() if at_once else JudgeBeside()
        changed = changes(record.plan.settings, now) if resume else ()
        session = Session(study, settings, record, (emg, force), judge, clock.now_s(), changed)
        stack.callback(session.end, "failed", "the program ended")
        yield SessionDesk(session)


def device_makers(study: Study, clock: Clock, rig_force: ForceSettings | None) -> Makers:
    """The devices that [session] names. rig_force : table [force] of the rig file, where the force comes from a rig.

    The first time both are opened together, for they may share a card; a lost one is opened alone.
    """
    assert study.session is not None
    settings, muscles = study.session, tuple(study.recordings[0].channels.emg)
    first: list[Source] = []

    def make(at: int) -> Source:
        if not first:
            first.extend(open_sources(settings, muscles, clock, rig_force=rig_force))
        if first[at] not in handed:
            handed.append(first[at])
            return first[at]
        nobody = replace(settings, force=_NOBODY[0]) if at == 0 else replace(settings, emg=_NOBODY[1])
        pair = open_sources(nobody, muscles, clock, rig_force=rig_force, simulated=(first[0], first[1]))
        return pair[at]

    handed: list[Source] = []
    return (lambda: make(0), lambda: make(1))
