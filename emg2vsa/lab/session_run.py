"""A participant's session as one call: run, or gone on with, and then written in BIDS and judged."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple

from emg2vsa.devices.clock import Clock, VirtualClock, WallClock, undisturbed
from emg2vsa.errors import SettingError
from emg2vsa.lab.session_devices import Virtual, devices
from emg2vsa.lab.session_finish import SILENT, FinishedSession, finish
from emg2vsa.pipeline.registered import session_deviations
from emg2vsa.pipeline.run_study import Progress
from emg2vsa.session.desk import SessionDesk
from emg2vsa.session.form import Form, is_answered, read_form, store_answers
from emg2vsa.session.open_session import folder_of, missed_visits, open_session, settings_of
from emg2vsa.session.views import OperatorState
from emg2vsa.study import Study
from emg2vsa.worlds.people.pages import EmulatedOperator
from emg2vsa.worlds.people.participant import EmulatedParticipant

if TYPE_CHECKING:
    from emg2vsa.live.server import Listening

_SHOWN_S = 1.5
"""The pages stay so long after the end, to show it."""


@dataclass(frozen=True, kw_only=True)
class Pages:
    """The two pages of a session, for a browser on this computer. They need the extra ``web``.

    port : 0 for any that is free. bind : a further address of this computer, for a second screen or a tablet; what is
    sent over it is not encrypted.
    """

    port: int = 8421
    bind: str | None = None

    def __post_init__(self) -> None:
        if not (isinstance(self.port, int) and 0 <= self.port <= 65535):
            do = "Choose a port, or 0 for any that is free."
            raise SettingError("port", wanted="a whole number from 0 to 65535", found=repr(self.port), do=do)


class Addresses(NamedTuple):
    """Addresses of the two pages. on_network : other computers can reach them."""

    operator: str
    participant: str
    on_network: bool


@dataclass(frozen=True)
class SessionEnd:
    """How a session ended.

    how : "completed", "ended" (by the operator, or with Ctrl-C) or "failed"; why : in words, or "". folder : where the
    samples and the journal are. judged : recordings and verdict of a session that is complete; None for another.
    """

    how: Literal["completed", "ended", "failed"]
    why: str
    folder: Path
    judged: FinishedSession | None = None

    @property
    def good(self) -> bool:
        """It is complete, and good or usable."""
        return self.judged is not None and self.judged.good


def run(
    study: Study,
    participant: str,
    *,
    visit: str | None = None,
    form: Path | None = None,
    virtual: Virtual | None = None,
    pages: Pages | None = None,
    shown: Callable[[Addresses], None] | None = None,
    seen: Callable[[OperatorState], None] | None = None,
    ended: Callable[[SessionEnd], None] | None = None,
    progress: Progress = SILENT,
) -> SessionEnd:
    """Run a participant's session as [session] of the study says, to its last press, its recordings and its verdict.

    It returns when the session has ended. Samples and events are saved as they come, so that a session that ended
    early, or whose program was killed, goes on with `resume`.

    Parameters
    ----------
    participant : a code of the study's participants.
    visit : one of [recordings] visits, where the study has them.
    form : the participant's answers to [session.form], in TOML; they go into participants.tsv of the data set. Without
        them the answers must stand there, but for an emulated participant.
    virtual : an emulated participant behind emulated sensors; None for the devices that [session] names.
    pages : the operator's and the participant's page. Without them the operator is emulated as well, which needs
        ``virtual``. They are served by the calling thread, in which no event loop may run.
    shown : called with the addresses of the pages when they can be opened.
    seen : called with what the operator sees, whenever that changes. KeyboardInterrupt raised here ends the session
        as Ctrl-C does.
    ended : called when the session has ended, before its recordings are written.
    progress : is told of the steps of the study that are run for the verdict.

    Raises
    ------
    SettingError : the study has no [session], no such participant or visit; an option or the port cannot be used.
    DataError : the session has been begun already: `resume` goes on with it.
    DeviceError : a device does not answer when the session begins.

    Examples
    --------
    >>> from emg2vsa import session
    >>> from emg2vsa.study_file import load_study
    >>> study = load_study("study.toml")  # doctest: +SKIP
    >>> done = session.run(study, "P03", virtual=session.Virtual(seed=1))  # doctest: +SKIP
    >>> done.how, done.judged.verdict  # doctest: +SKIP
    ('completed', 'good')
    """
    return _Sitting(study.at_visit(visit), participant, False, form, virtual, pages, shown, seen, ended).judged(
        progress
    )


def resume(
    study: Study,
    participant: str,
    *,
    visit: str | None = None,
    form: Path | None = None,
    virtual: Virtual | None = None,
    pages: Pages | None = None,
    shown: Callable[[Addresses], None] | None = None,
    seen: Callable[[OperatorState], None] | None = None,
    ended: Callable[[SessionEnd], None] | None = None,
    progress: Progress = SILENT,
) -> SessionEnd:
    """Go on with a session that ended before its last press, in the order of presses that was drawn for it.

    Parameters and errors are those of `run`, but DataError says that there is no session to resume. A press that was
    under way is repeated. A session that is complete presses nothing, and its recordings are written and judged again.

    Examples
    --------
    >>> done = session.resume(study, "P03", virtual=session.Virtual(seed=1))  # doctest: +SKIP
    """
    return _Sitting(study.at_visit(visit), participant, True, form, virtual, pages, shown, seen, ended).judged(progress)


@dataclass(frozen=True)
class _Sitting:
    """What `run` and `resume` are given. again : it is resumed."""

    study: Study
    participant: str
    again: bool
    form: Path | None
    virtual: Virtual | None
    pages: Pages | None
    shown: Callable[[Addresses], None] | None
    seen: Callable[[OperatorState], None] | None
    ended: Callable[[SessionEnd], None] | None

    def judged(self, progress: Progress) -> SessionEnd:
        end = self._recorded()
        if end.how != "completed":
            return end
        return replace(
            end, judged=finish(self.study, self.participant, visit=self.study.visit or None, progress=progress)
        )

    def _recorded(self) -> SessionEnd:
        study, participant, virtual, pages = self.study, self.participant, self.virtual, self.pages
        settings = settings_of(study, participant)
        if pages is None and virtual is None:
            do = "Give pages, or virtual for an emulated participant and operator."
            raise SettingError("pages", wanted="pages for a session with devices", found="none", do=do)
        if pages is not None and _loop_runs():
            do = "Call it in a thread of its own: await asyncio.to_thread(session.run, ...)."
            raise SettingError("pages", wanted="a thread without a running event loop", found="one that runs", do=do)
        self._take_form(settings.form)
        clock = self._clock()
        person, makers = devices(study, settings, participant, clock, virtual)
        at_once = isinstance(clock, VirtualClock)
        with (
            _port_taken(pages) as at,
            open_session(
                study,
                participant,
                clock,
                makers,
                resume=self.again,
                at_once=at_once,
                deviations=(*session_deviations(study, participant), *missed_visits(study, participant)),
            ) as desk,
        ):
            if person is not None:
                person.watch(desk)
            beside = self._beside(desk, person)
            if at is None:
                with nullcontext() if at_once else undisturbed():
                    _turn(desk, clock, beside)
            else:
                self._with_pages(desk, clock, beside, at)
            over = desk.session.state.ended
        if person is not None and virtual is not None:
            virtual.keep_truth(person)
        assert over is not None
        end = SessionEnd(over.how, over.why, folder_of(study, participant))
        if self.ended is not None:
            self.ended(end)
        return end

    def _take_form(self, form: Form) -> None:
        study, participant = self.study, self.participant
        if self.form is not None:
            store_answers(study.data, participant, form, read_form(self.form, form, participant))
        elif self.virtual is None and not is_answered(study.data, participant, form):
            raise SettingError(
                "--form", wanted=f"answers of {participant} to [session.form] ({', '.join(form)})", found="none",
                do=f"Write them: emg2vsa session form {study.path} --participant {participant} > {participant}.toml",
            )  # fmt: skip

    def _clock(self) -> Clock:
        if self.virtual is None:
            return WallClock()
        return VirtualClock() if self.pages is None and self.virtual.speed is None else self.virtual.clock()

    def _beside(self, desk: SessionDesk, person: EmulatedParticipant | None) -> Callable[[float], None]:
        """What is done after each turn: by the emulated operator, or by whoever gives an emulated participant the
        specimen that the operator is asked to place."""
        operator = EmulatedOperator(desk, person.place) if self.pages is None and person is not None else None
        told = 0

        def beside(now_s: float) -> None:
            nonlocal told
            if operator is not None:
                operator.turn(now_s)
            number, state = desk.operator()
            if operator is None and person is not None and state.awaits == "specimen":
                person.place(state.specimen)
            if self.seen is not None and number != told:
                told = number
                self.seen(state)

        return beside

    def _with_pages(self, desk: SessionDesk, clock: Clock, beside: Callable[[float], None], at: Listening) -> None:
        """The session turns in a thread of its own beside the server of the pages."""
        from emg2vsa.live.server import HOST, serve
        from emg2vsa.live.session_routes import session_pages

        failures: list[BaseException] = []
        over, left = threading.Event(), threading.Event()

        def turn() -> None:
            try:
                with undisturbed():
                    _turn(desk, clock, beside)
                left.wait(_SHOWN_S)
            except BaseException as error:
                failures.append(error)
            finally:
                over.set()

        def ready(*pages: str) -> None:
            operator, participant = pages
            if self.shown is not None:
                self.shown(Addresses(operator, participant, at.host != HOST))

        turning = threading.Thread(target=turn, name="session")
        turning.start()
        try:
            serve(session_pages(desk, clock), at, ready, over)
            over.wait()
        except KeyboardInterrupt:
            pass
        finally:
            left.set()
            desk.session.end("ended", "Ctrl-C")
            turning.join()
        if failures:
            raise failures[0]


def _loop_runs() -> bool:
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return False
    return True


def _port_taken(pages: Pages | None) -> AbstractContextManager[Listening | None]:
    """Before the session begins, for it ends nothing that has begun."""
    if pages is None:
        return nullcontext()
    from emg2vsa.live.server import listening

    return listening(pages.port, pages.bind)


def _turn(desk: SessionDesk, clock: Clock, beside: Callable[[float], None]) -> None:
    try:
        desk.run(clock, beside)
    except KeyboardInterrupt:
        desk.session.end("ended", "Ctrl-C")
