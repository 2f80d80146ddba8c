"""A session from its devices to its desk, and whatever ends it: what was recorded stays, and can be resumed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import asdict, replace
from datetime import datetime
from functools import partial
from pathlib import Path
from typing import Any

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.device_settings import ForceSettings
from emg2vsa.devices.registry import Around, known
from emg2vsa.devices.streams import Source
from emg2vsa.devices.trigger import TriggerOut
from emg2vsa.errors import SettingError
from emg2vsa.session.dataset import refuse_foreign
from emg2vsa.session.desk import SessionDesk
from emg2vsa.session.plan import PLAN_FILE, Plan, changes, draw_presses, order_of, planned, read_plan
from emg2vsa.session.plugs import Outlets, Plugs
from emg2vsa.session.record import new_session, resume_session, session_folder
from emg2vsa.session.recorded_stream import RecordedStream
from emg2vsa.session.session import Session, check_muscles
from emg2vsa.session.stay_judge import JudgeAtOnce, JudgeBeside
from emg2vsa.session_settings import SessionSettings
from emg2vsa.study import Study

LOST_S = 1.0
"A force sensor of which nothing comes for so long is lost; nobody is hurt by a bar that stands still for less."

Maker = Callable[[], Source]
"""Opens a device anew, not started: when the session begins, and whenever the device was lost."""
Makers = tuple[Maker, Maker]
"""Makers of the source of the EMG and of that of the force."""


def source_makers(
    settings: SessionSettings, muscles: Sequence[str], clock: Clock, *, rig_force: ForceSettings | None = None
) -> Makers:
    """Makers of the sources of EMG and force. They raise SettingError and DeviceError as the kinds of the devices do.

    Parameters
    ----------
    muscles : roles of the study; the EMG has them in this order.
    rig_force : table [force] of the rig file that session.force.rig names.
    """
    emg = settings.emg
    if channels := getattr(emg, "channels", None):  # of whatever kind
        emg = replace(emg, channels={role: channels[role] for role in muscles if role in channels})  # type: ignore[call-arg]
    others = {"emg": emg, "session-force": settings.force} | ({"force": rig_force} if rig_force else {})
    around = Around(clock, LOST_S, others=others)
    force = settings.force
    return partial(known("emg", emg).opened, emg, around), partial(known("session-force", force).opened, force, around)


def settings_of(study: Study, participant: str) -> SessionSettings:
    """The table [session]. SettingError where there is none, the study does not know the participant, or it has visits
    and is at none of them."""
    if study.session is None:
        do = "Add it: docs/reference/study-file.md lists its keys."
        raise SettingError(study.path, wanted="a table [session]", found="none", do=do)
    if participant not in study.participants:
        raise SettingError(
            f"--participant {participant}", wanted=f"one of {', '.join(study.participants)}", found="another code",
            do=f"Check the code, or add it to [participants] of {study.path}.",
        )  # fmt: skip
    study.at_visit(study.visit or None)
    return study.session


def folder_of(study: Study, participant: str) -> Path:
    """Where the samples and the journal of a participant's session are."""
    return session_folder(study.data, participant, study.task, study.visit)


def missed_visits(study: Study, participant: str) -> tuple[str, ...]:
    """A sentence where a visit before this one has not begun: the wrong one may have been named."""
    earlier = study.visits[: study.visits.index(study.visit)] if study.visit else ()
    missed = [one for one in earlier if not (folder_of(study.at_visit(one), participant) / PLAN_FILE).is_file()]
    told = (
        f"{participant} is at visit {study.visit}, but visit {', '.join(missed)} has not begun. Is this the right one?"
    )
    return ((told,) if missed else ()) + tuple(_other_orders(study, participant))


def _other_orders(study: Study, participant: str) -> Iterator[str]:
    """A sentence for each visit whose kind of order was another one."""
    now = study.session.order if study.session else ""
    for visit in study.visits:
        path = folder_of(study.at_visit(visit), participant) / PLAN_FILE
        before = read_plan(path).settings.get("session", {}).get("order", now) if path.is_file() else now
        if visit != study.visit and before != now:
            yield f"The order of {participant} was {before!r} at visit {visit}, and the study file now says {now!r}."


def place_of(study: Study, participant: str) -> int:
    """Place of the participant in a design, from 0: among those planned, unless an earlier visit has taken another
    one.
    """
    places = {visit: study.participants.index(participant) + i for i, visit in enumerate(study.visits or ("",))}
    for visit, path in ((visit, folder_of(study.at_visit(visit or None), participant) / PLAN_FILE) for visit in places):
        if path.is_file() and (taken := read_plan(path).order.get("place")):
            return int(taken) - 1 + places[study.visit] - places[visit]
    return places[study.visit]


def kept_settings(study: Study) -> dict[str, Any]:
    """What a session depends on of the study file, which its plan keeps."""
    return {"session": None if study.session is None else planned(study.session),
            "specimens": [each.name for each in study.specimens], "window": asdict(study.window)}  # fmt: skip


def _plugs(study: Study, settings: SessionSettings, clock: Clock, sources: Sequence[Source]) -> Plugs:
    """Open, before anything is recorded: what they lack is told at once."""
    emg, force = (source.info for source in sources)
    muscles = tuple(study.recordings[0].channels.emg)
    outlets = Outlets(study.name, muscles, emg, force, clock) if settings.lsl_outlets else None
    return Plugs(outlets, TriggerOut(settings.trigger, clock) if settings.trigger else None)


@contextmanager
def open_session(
    study: Study,
    participant: str,
    clock: Clock,
    makers: Makers,
    *,
    resume: bool = False,
    at_once: bool = False,
    deviations: Sequence[str] = (),
) -> Iterator[SessionDesk]:
    """Devices started, folder and order made or found again, ready for `SessionDesk.run`.

    at_once : judge and write within the turn, for a clock that stands still meanwhile. When the block is left before
    the session has ended, the session ends as interrupted. deviations : from a registered plan, or of visits; the
    session tells them.
    SettingError, DataError, DeviceError : as `settings_of`, `new_session`, `resume_session`, and the devices.
    """
    settings = settings_of(study, participant)
    folder = folder_of(study, participant)
    now = kept_settings(study)
    refuse_foreign(folder, study, participant)
    with ExitStack() as stack:
        sources = []
        for make in makers:
            sources.append(source := make())
            stack.callback(source.close)
        for source in sources:
            source.start()
        check_muscles(study, sources[0].info.channels)
        fs_hz, band_hz = sources[0].info.fs_hz, settings.about.band_hz
        if band_hz and band_hz[1] > fs_hz / 2:
            raise SettingError(
                f"{study.path}, session.about.band_hz", wanted=f"at most half the rate of the EMG, {fs_hz / 2:g} Hz",
                found=f"{band_hz[1]:g}", do="Correct the band, or the rate of the device.",
            )  # fmt: skip
        plugs = stack.enter_context(closing(_plugs(study, settings, clock, sources)))
        if resume:
            record = resume_session(folder, clock.now_s, background=not at_once)
        else:
            place, specimens = place_of(study, participant), now["specimens"]
            presses = draw_presses(study.name, participant, specimens, settings, place, study.visit)
            order = order_of(specimens, settings, place)
            drawn_at = datetime.now().astimezone().isoformat("T", "seconds")
            plan = Plan(study.name, participant, settings.seed, drawn_at, presses, now, study.visit, order)
            record = new_session(folder, plan, clock.now_s, background=not at_once)
        stack.callback(record.close)
        emg, force = (
            RecordedStream(name, source, make, record, clock.now_s(), not at_once)
            for name, source, make in zip(("emg", "force"), sources, makers, strict=True)
        )
        judge = JudgeAtOnce() if at_once else JudgeBeside()
        changed = changes(record.plan.settings, now) if resume else ()
        session = Session(study, settings, record, (emg, force), judge, clock.now_s(), changed, deviations, plugs)
        stack.callback(session.end, "failed", "the program ended")
        yield SessionDesk(session)
