"""What a session does when a device is lost, the disk is full, the page is hidden, or the program is ended."""

from __future__ import annotations

import errno
from contextlib import nullcontext

import numpy as np
import pytest

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.durable.system import OperatingSystem
from emg2vsa.errors import DeviceError
from emg2vsa.session import replay
from emg2vsa.session.journal import (
    JOURNAL_FILE,
    Commanded,
    Interrupted,
    Judged,
    Paused,
    PressBegun,
    Told,
    read_journal,
)
from emg2vsa.session.open_session import open_session
from emg2vsa.session.views import Request, ScreenReport
from emg2vsa.study_file import load_study
from emg2vsa.worlds.people.sensors import simulate

pytestmark = pytest.mark.slow
FEW = "repetitions = 2"


class Failing:
    """A source that is lost while its ``lost`` is true, and cannot be opened meanwhile."""

    lost = False

    def __init__(self, source):
        self._source = source

    def __getattr__(self, name):
        return getattr(self._source, name)

    def start(self):
        self._check()
        self._source.start()

    def read(self):
        self._check()
        return self._source.read()

    def _check(self):
        if self.lost:
            raise DeviceError("EMG", wanted="samples", found="none", do="Switch it on.")


def test_a_lost_device_interrupts_the_press_and_the_session_goes_on_when_it_is_back(play):
    failing = []

    def lost(emg, force):
        failing.append(Failing(emg))
        return failing[0], force

    back_s, warned = [], []

    def switch(desk, now_s):
        if not back_s and desk.force().command == "press":
            back_s.append(now_s + 7.0)
            failing[0].lost = True
        elif back_s and now_s > back_s[0]:
            failing[0].lost = False
        warned.append(any(text.startswith("EMG: ") for text in desk.operator()[1].warnings))
        if desk.operator()[1].message == "The lost device is back. Go on.":
            assert desk.operator()[1].awaits == ""
            warned.append(None)

    played = play(source=lost, session=FEW, beside=switch)
    assert played.state.ended == "completed"
    assert (True in warned, None in warned, warned[-1]) == (True, True, False)
    assert played.verdicts[1, 1] == ("rejected", ["interrupted: EMG lost"])
    assert sum(press.verdict in ("ok", "warned") for press in played.state.presses) == 4
    lines, _ = read_journal(played.folder / JOURNAL_FILE)
    assert Paused("device") in [line.event for line in lines]
    assert len(list(played.folder.glob("*_emg*.samples"))) == 2


def test_a_changed_study_file_is_told_on_resume_and_the_order_stays(play):
    play(session=FEW, most_presses=1)
    resumed = play(session=FEW + "\nrest_s = 3.0", resume=True)
    assert any("session.rest_s was 2.0 and is 3.0" in said for said in resumed.state.warnings)
    assert len([press for press in resumed.state.presses if press.verdict]) == 4


def test_a_hidden_page_rejects_the_press_under_way(play):
    def hide(desk, now_s):
        running = desk.session.state.running
        hidden = running is not None and (running.press.number, running.attempt) == (1, 1)
        desk.screen(ScreenReport(60.0, 10.0, 20.0, 17.0, hidden))

    played = play(session=FEW, beside=hide)
    assert played.verdicts[1, 1] == ("rejected", ["the participant's page was hidden"])
    assert played.verdicts[1, 2][0] == "ok"


def test_a_full_disk_pauses_the_session_until_there_is_room(play, monkeypatch):
    write = OperatingSystem.write
    full = {"now": False, "seen": False}

    def refuse(self, handle, offset, piece):
        if full["now"]:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, handle, offset, piece)

    monkeypatch.setattr(OperatingSystem, "write", refuse)

    def fill(desk, now_s):
        full["now"] = 25.0 < now_s < 28.0
        full["seen"] |= "No space left" in desk.operator()[1].saved

    played = play(session=FEW, beside=fill)
    assert full["seen"]
    assert played.state.ended == "completed"
    assert not [text for text in played.state.warnings if "disk" in text]
    events = [line.event for line in read_journal(played.folder / JOURNAL_FILE)[0]]
    assert Paused("disk") in events
    assert sum(isinstance(event, PressBegun) for event in events) >= 4
    assert sum(press.verdict in ("ok", "warned") for press in played.state.presses) == 4


def test_a_press_is_repeated_no_more_often_than_the_study_allows(play):
    def repeat(desk, now_s):
        last = [press for press in desk.operator()[1].presses if press.verdict]
        if last and last[-1].number == 1 and not last[-1].decision and desk.force().command == "rest":
            answers.add(desk.ask(Request("repeat", press=1, text="the participant sneezed")))

    answers = set()
    played = play(session=FEW + "\nmost_repeats = 1", beside=repeat)
    assert [press.attempt for press in played.state.presses if press.number == 1] == [1, 2]
    assert any("1 presses on this specimen were repeated" in answer for answer in answers)


def test_a_good_press_is_not_repeated_without_a_reason(play):
    def repeat(desk, now_s):
        last = [press for press in desk.operator()[1].presses if press.verdict]
        if len(last) == 1:
            answers.add(desk.ask(Request("repeat", press=1)))

    answers = set()
    play(session=FEW, beside=repeat)
    assert any("give the reason as a note" in answer for answer in answers)


def test_a_further_press_is_suggested_by_width_and_written_as_such(play):
    played = play(session='repetitions = 2\nstop = "width"\nwidth = 0.001\nmost_presses = 3')
    added = [press for press in played.state.presses if press.repetition == 3]
    assert {press.specimen for press in added} == {"S1", "S3"}
    assert all(press.verdict for press in added)
    numbers = [press.number for press in played.state.presses]
    assert numbers != sorted(numbers)  # each comes within the stay of its specimen
    lines, _ = read_journal(played.folder / JOURNAL_FILE)
    assert not any(isinstance(line.event, Interrupted) for line in lines)
    assert Commanded("done") in [line.event for line in lines]


class Altered(Failing):
    """A source whose samples are changed by ``change`` while it is set."""

    change = staticmethod(lambda samples: samples)

    def read(self):
        return [block._replace(samples=self.change(block.samples)) for block in self._source.read()]


def test_a_tap_while_the_last_press_is_judged_begins_no_attempt(play):
    force = []

    def altered(emg, own):
        force.append(Altered(own))
        return emg, force[0]

    def tap(desk, now_s):
        tapped = desk.session.state.judging and desk.force().command == "rest"
        force[0].change = (lambda samples: samples + 3.0) if tapped else Altered.change

    played = play(source=altered, session=FEW, beside=tap)
    assert played.state.ended == "completed"
    attempts = played.session.state.presses.tried
    assert [own.attempt for own in attempts] == [1] * 4
    told = [line.event.text for line in read_journal(played.folder / JOURNAL_FILE)[0] if isinstance(line.event, Told)]
    assert sum("pressed between presses" in text for text in told) == 4


def test_a_force_of_the_wrong_sign_is_told_with_its_remedy(play):
    force = []

    def turned(emg, own):
        force.append(Altered(own))
        force[0].change = lambda samples: -samples
        return emg, force[0]

    def end(desk, now_s):
        if any("session.force.axis" in text for text in desk.session.state.warnings):
            desk.ask(Request("abort"))
            desk.ask(Request("end"))

    played = play(source=turned, session=FEW, beside=end)
    assert any("its sign is wrong" in text for text in played.state.warnings)


def test_the_page_of_the_participant_cannot_flood_the_journal(play):
    def toggle(desk, now_s):
        desk.screen(ScreenReport(60.0, 10.0, 20.0, 17.0, round(now_s * 200) % 2 == 0))
        if now_s > 5:
            desk.ask(Request("end"))

    played = play(session=FEW, operator=False, beside=toggle)
    lines, _ = read_journal(played.folder / JOURNAL_FILE)
    assert 4 <= sum(isinstance(line.event, ScreenReport) for line in lines) <= 6


def test_practice_goes_on_while_the_disk_is_full_and_the_presses_that_count_wait(play, monkeypatch):
    write, told = OperatingSystem.write, []
    full = {"now": False, "tries": 0}

    def refuse(self, handle, offset, piece):
        if full["now"]:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, handle, offset, piece)

    monkeypatch.setattr(OperatingSystem, "write", refuse)

    def fill(desk, now_s):
        own = desk.session.state
        full["now"] = now_s > 8.0 and full["tries"] < 600
        if full["now"] and own.paused == "disk":
            full["tries"] += 1
            told.append((desk.operator()[1], desk.session.record.safe_lines))

    played = play(session=f'{FEW}\ntraining_specimens = ["T1"]\ntraining_repetitions = 2', beside=fill)
    assert played.state.ended == "completed"
    shown, safe = told[-1]
    assert shown.message == "The disk is full."
    assert any(text.startswith("The disk does not take the recording: No space") for text in shown.warnings)
    practice = [press for press in shown.presses if press.phase == "training"]
    assert [press.verdict for press in practice] == ["ok", "ok"]
    lines, _ = read_journal(played.folder / JOURNAL_FILE)
    judged = [line for line in lines if isinstance(line.event, Judged)]
    assert len(judged) == 6
    assert safe < judged[0].number  # nothing of the practice was on the disk
    assert replay(played.study, played.folder).same


@pytest.mark.parametrize("full", [False, True])
def test_a_session_ends_within_a_second_also_on_a_full_disk(study_file, monkeypatch, full):
    write = OperatingSystem.write
    disk = {"full": False}

    def refuse(self, handle, offset, piece):
        if disk["full"]:
            raise OSError(errno.ENOSPC, "No space left on device")
        write(self, handle, offset, piece)

    monkeypatch.setattr(OperatingSystem, "write", refuse)
    study = load_study(study_file(FEW))
    clock = WallClock()
    _, emg, force = simulate(study, study.session, "P03", clock)
    begun_s = 0.0
    told = pytest.raises(DeviceError, match="--resume") if full else nullcontext()
    with told, open_session(study, "P03", clock, (lambda: emg, lambda: force)) as desk:
        for _ in range(100):
            desk.turn(clock.now_s())
            disk["full"] = full
            clock.sleep_until(clock.now_s() + 0.005)
        assert bool(desk.session.record.trouble) == full
        begun_s = clock.now_s()
        desk.session.end("ended", "Ctrl-C")
    assert clock.now_s() - begun_s < 1.0


@pytest.mark.realtime
def test_a_server_that_drops_at_press_7_pauses_the_session_and_the_press_is_repeated(study_file):
    from emg2vsa.devices.clock import FastClock
    from emg2vsa.devices.trigno.driver import TrignoSource
    from emg2vsa.session.journal import PressEnded
    from emg2vsa.session.open_session import folder_of
    from emg2vsa.session.raw_files import SampleFile
    from emg2vsa.worlds.far_ends.trigno_server import TrignoServer
    from emg2vsa.worlds.people.pages import EmulatedOperator

    study = load_study(study_file("repetitions = 4"))
    clock = FastClock(4.0)
    person, _, force = simulate(study, study.session, "P03", clock)
    seen = {"dropped": 0, "told": 0}
    with TrignoServer(person, {1: "EDC", 5: "FDS"}, clock, start_delay_s=0.3) as server:
        ports = {"command_port": server.ports.command, "emg_port": server.ports.emg}
        settings = TrignoSettings(channels={"EDC": "1", "FDS": "5"}, **ports)
        sources = (lambda: TrignoSource(settings, clock), lambda: force)
        with open_session(study, "P03", clock, sources) as desk:
            person.watch(desk)
            operator = EmulatedOperator(desk, person.place)
            desk.ask(Request("continue"))

            def beside(now_s):
                operator.turn(now_s)
                running = desk.session.state.running
                if not seen["dropped"] and running and running.press.number == 7 and desk.force().command == "press":
                    seen["dropped"] = 1
                    server.disconnect()
                seen["told"] |= desk.operator()[1].message == "A device is lost."
                assert now_s < 400.0, desk.operator()[1].message

            desk.run(clock, beside)
        state = desk.operator()[1]
    assert seen == {"dropped": 1, "told": 1}
    assert state.ended == "completed"
    folder = folder_of(study, "P03")
    events = [line.event for line in read_journal(folder / JOURNAL_FILE)[0]]
    assert Paused("device") in events
    ended = {(each.press, each.attempt): each.how for each in events if isinstance(each, PressEnded)}
    judged = {(each.press, each.attempt): each for each in events if isinstance(each, Judged)}
    assert ended[7, 1] == "aborted"
    assert judged[7, 1].problems[0][0] == "interrupted: EMG lost"
    assert ended[7, 2] == "complete"
    assert {each.press for each in judged.values() if each.verdict != "rejected"} == set(range(1, 9))
    files = [SampleFile(path) for path in sorted(folder.glob("*_emg*.samples"))]
    assert len(files) == 2
    assert all(file.passed_over == 0 and np.isfinite(file.read(0, file.stop)).all() for file in files)
    replayed = replay(study, folder)
    assert replayed.same, [press.differences for press in replayed.presses]
    assert len(replayed.presses) == 8
