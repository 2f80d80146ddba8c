"""A session that was recorded is rebuilt from its folder: pages byte by byte, and verdicts to the last bit."""

from __future__ import annotations

import json
import re
from dataclasses import asdict, replace

import pytest

from benchmarks.session_kill import sitting
from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.errors import DataError, SettingError
from emg2vsa.session import replay
from emg2vsa.session.journal import JOURNAL_FILE, Judged, PressEnded, line_bytes, read_journal
from emg2vsa.session.open_session import folder_of
from emg2vsa.session.plan import PLAN_FILE
from emg2vsa.session.views import Request, ScreenReport
from emg2vsa.study_file import load_study
from tests.session.conftest import write_study

FEW = "repetitions = 2"
WIDTH = 'repetitions = 2\nstop = "width"\nwidth = 0.001\nmost_presses = 3'


class Killed(Exception):
    """In place of the session's end."""


class Watched:
    """What both pages showed, as JSON: by the number of lines that the journal had, and at last."""

    def __init__(self):
        self.shown, self._seen = {}, None

    def __call__(self, desk, now_s):
        (number, state), participant = desk.operator(), desk.participant()
        if self._seen == (number, participant):
            return
        self._seen = number, participant
        self.last = as_json(state), as_json(participant)
        self.last_line = int(re.search(r": (\d+) events", state.saved)[1])
        self.shown.setdefault(self.last_line, self.last)


def as_json(view):
    return json.dumps(asdict(view))


def without_devices(page):
    return json.dumps(json.loads(page) | {"devices": []})


def both(*besides):
    def beside(desk, now_s):
        for one in besides:
            one(desk, now_s)

    return beside


def kill_at(from_s, command):
    def beside(desk, now_s):
        if now_s > from_s and desk.force().command == command:
            raise Killed

    return beside


def untouched(folder):
    return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}


def check(played, watched, presses):
    """The pages after the last turn, and every verdict; nothing in the folder has changed."""
    before = untouched(played.folder)
    replayed = replay(played.study, played.folder)
    assert [press.differences for press in replayed.presses] == [()] * presses
    assert replayed.same
    assert replayed.notes == ()
    assert (as_json(replayed.operator), as_json(replayed.participant)) == watched.last
    assert untouched(played.folder) == before
    return replayed


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mistakes", "session", "presses"),
    [
        ((), 'training_specimens = ["T1"]\ntraining_repetitions = 1', 7),
        (("dips@2", "early@4"), 'repetitions = 2\norder = "interleaved"\ncheck_each_press = true', 6),
        (("never-lifts@1", "sensor-offset@2", "electrode-off:FDS@3", "clipping@4", "mains@5", "aborted@6"), "", 11),
        ((), WIDTH, 6),
    ],
)  # fmt: skip
def test_every_page_and_every_verdict_of_a_session_is_rebuilt(play, mistakes, session, presses):
    watched = Watched()
    played = play(*mistakes, session=session, beside=watched)
    check(played, watched, presses)
    for number, (operator, participant) in list(watched.shown.items())[::9]:
        replayed = replay(played.study, played.folder, line=number)
        # the samples of the devices are those until the line, which may be some turns older than the page
        assert without_devices(as_json(replayed.operator)) == without_devices(operator), number
        assert as_json(replayed.participant) == participant, number


def test_a_session_that_was_killed_and_resumed_is_rebuilt(play):
    killed, watched = Watched(), Watched()
    with pytest.raises(Killed):
        play("dips@1", session=FEW, beside=both(killed, kill_at(38, "press")))
    resumed = play("dips@1", session=FEW, resume=True, beside=watched)
    replayed = check(resumed, watched, 5)
    assert {press.before.press for press in replayed.presses} == {1, 2, 3, 4}
    assert resumed.state.ended == "completed"
    shown = resumed.state.presses
    (broken,) = (press.number for press in shown if any("interrupted" in said for said, _ in press.problems))
    assert [press.verdict for press in shown if press.number == broken][-2:] == ["rejected", "ok"]
    assert all(fit.presses == 2 for fit in resumed.state.fits)
    before = replay(resumed.study, resumed.folder, line=killed.last_line)
    assert (without_devices(as_json(before.operator)), as_json(before.participant)) == (
        without_devices(killed.last[0]), killed.last[1],
    )  # fmt: skip


def test_a_killed_session_with_a_torn_line_is_rebuilt_up_to_it(play, study_file):
    with pytest.raises(Killed):
        play(session=FEW, beside=kill_at(30, "stop"))
    study = load_study(study_file(FEW))
    folder = folder_of(study, "P03")
    path = folder / JOURNAL_FILE
    whole = path.read_bytes()
    path.write_bytes(whole[:-40])
    replayed = replay(study, folder)
    assert replayed.line == len(whole.splitlines()) - 1
    assert replayed.same
    assert "bytes of the journal are no whole line" in replayed.notes[0]
    assert path.read_bytes() == whole[:-40]


@pytest.mark.slow
def test_a_page_that_was_hidden_and_a_device_that_was_lost_are_rebuilt(play):
    from tests.session.test_run_troubles import Failing

    failing, back_s = [], []

    def lost(emg, force):
        failing.append(Failing(emg))
        return failing[0], force

    def trouble(desk, now_s):
        running = desk.session.state.running
        desk.screen(ScreenReport(60.0, 10.0, 20.0 + now_s, 17.0, running is not None and running.key == (1, 1)))
        if not back_s and desk.force().command == "press" and running.key == (2, 1):
            back_s.append(now_s + 7.0)
            failing[0].lost = True
        elif back_s and now_s > back_s[0]:
            failing[0].lost = False

    watched = Watched()
    played = play(session=FEW, source=lost, beside=both(trouble, watched))
    assert played.verdicts[1, 1] == ("rejected", ["the participant's page was hidden"])
    assert any("ms late" in said for _, problems in played.verdicts.values() for said in problems)
    check(played, watched, 5)


def older(folder):
    """Take out of a journal what an earlier version did not write."""
    path = folder / JOURNAL_FILE
    content = []
    for line in read_journal(path)[0]:
        if isinstance(line.event, PressEnded):
            line = replace(line, event=replace(line.event, zero_n=None))
        elif isinstance(line.event, Judged):
            line = replace(line, event=replace(line.event, samples={}))
        document = json.loads(line_bytes(line))
        if document["kind"] not in ("measuring", "unchecked"):
            content.append(line_bytes(replace(line, number=len(content) + 1)))
    path.write_bytes(b"".join(content))


def test_what_was_judged_is_known_without_its_numbers_too_from_the_times_of_the_samples(play):
    played = play("dips@2", session=FEW)
    older(played.folder)
    replayed = replay(played.study, played.folder)
    assert [press.differences for press in replayed.presses] == [()] * 5
    assert "earlier version" in replayed.notes[0]
    assert [view.snr_db for view in replayed.operator.signals] == [view.snr_db for view in played.state.signals]
    assert replayed.operator.presses == played.state.presses


def test_a_verdict_that_is_not_that_of_its_samples_is_told(played):
    path = played.folder / JOURNAL_FILE
    lines = read_journal(path)[0]
    false = {"a_v": 1e-5, "peak_n": 7.0}
    altered = [
        replace(
            line, event=replace(line.event, verdict="warned", problems=(("odd", ""),), values=line.event.values | false)
        )
        if isinstance(line.event, Judged)
        else line
        for line in lines
    ]
    path.write_bytes(b"".join(map(line_bytes, altered)))
    (press,) = replay(played.study, played.folder).presses
    found = "; ".join(press.differences)
    assert "verdict: was warned, is ok; problems: was odd, is none; peak_n: was 7.0, is 7." in found
    assert "a_v: was 1e-05, is " in found
    assert "b_v" not in found


def test_a_study_file_that_has_changed_is_told(played):
    study = load_study(write_study(played.study_file.parent, FEW + "\nrest_s = 3.0"))
    assert replay(study, played.folder).notes == (
        "The study file has changed since: session.rest_s was 2.0 and is 3.0.",
    )  # fmt: skip


def test_what_cannot_be_rebuilt_is_told_in_one_sentence(played, tmp_path):
    study, folder = played.study, played.folder
    path, plan = folder / JOURNAL_FILE, folder / PLAN_FILE
    whole, planned = path.read_bytes(), plan.read_text()

    def refused(match, error=DataError, line=None, where=folder):
        with pytest.raises(error, match=match):
            replay(study, where, line=line)

    refused(r"nowhere: expected the folder of a session, but found none\. Check", where=tmp_path / "nowhere")
    refused("plan.json: expected the plan of a session.*Put the file back", where=tmp_path)
    refused("--line: expected a line of .*journal.jsonl, 1 to .*but found 999", SettingError, 999)
    refused("--line: expected a line", SettingError, 0)
    path.write_bytes(whole.replace(b'"kind": "commanded"', b'"kind": "commandet"', 1))
    refused(r"journal.jsonl, line \d+: expected a line of the journal that matches its checksum.*copy")
    path.write_bytes(b"")
    refused("expected the journal of a session, but found no whole line. Put the file back")
    path.unlink()
    refused("expected the journal of a session, but found No such file")
    path.write_bytes(whole)
    plan.write_text(planned.replace('"participant": "P03"', '"participant": "P09"'))
    refused("--participant P09: expected one of P01, P03", SettingError)
    plan.write_text(planned.replace('"study": "small"', '"study": "large"'))
    refused("expected a session of the study small, but found one of large")
    plan.write_text(planned)
    samples = folder / "sitting-1_emg.samples"
    recorded = samples.read_bytes()
    samples.write_bytes(recorded[: len(recorded) // 2])
    refused(r"emg.samples: expected the samples \d+ to \d+ of press 1, but found samples to \d+\. Put the file back")
    samples.unlink()
    refused("emg.samples: expected a file of samples of a session, but found No such file")


def test_a_journal_that_lacks_a_line_is_never_the_same_and_never_a_traceback(played):
    path = played.folder / JOURNAL_FILE
    lines = path.read_bytes().splitlines(keepends=True)
    for left_out in range(1, len(lines)):
        path.write_bytes(b"".join(lines[: left_out - 1] + lines[left_out:]))
        try:
            replayed = replay(played.study, played.folder)
        except DataError as error:
            assert left_out <= 2, error  # noqa: PT017
            assert f"{JOURNAL_FILE}: expected a line that opens {('emg', 'force')[left_out - 1]}" in str(error)  # noqa: PT017
            continue
        assert not replayed.same
        assert f"no line between {left_out - 1} and {left_out + 1}" in replayed.notes[0]
        with pytest.raises(SettingError, match=f"but found {left_out}"):
            replay(played.study, played.folder, line=left_out)


EMG, FORCE = "sitting-1_emg.samples", "sitting-1_force.samples"


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (lambda emg, force: (force, emg), f"{EMG}: expected emg of EDC, FDS in V at .*{JOURNAL_FILE} says, but f"),
        (lambda emg, force: (force, force), f"{EMG}: expected emg of .* but found force of force in N at"),
        (lambda emg, force: (emg, emg), f"{FORCE}: expected force of .* but found emg of"),
        (lambda emg, force: (emg[:10], force), f"{EMG}: .* but found a head that is cut short"),
        (lambda emg, force: (emg, force[:90]), f"{FORCE}: .* but found a head that is cut short"),
    ],
)  # fmt: skip
def test_samples_that_are_not_those_of_the_journal_are_refused(played, change, match):
    paths = [played.folder / name for name in (EMG, FORCE)]
    for path, content in zip(paths, change(*(path.read_bytes() for path in paths)), strict=True):
        path.write_bytes(content)
    with pytest.raises(DataError, match=match):
        replay(played.study, played.folder)


def with_presses(change):
    return lambda plan: plan | {"presses": change(plan["presses"])}


@pytest.mark.parametrize(
    ("change", "match"),
    [
        (with_presses(lambda own: []), r"press 1 \(main, .*, as line \d+ of journal.jsonl says, but found no"),
        (with_presses(lambda own: own[::-1]), "expected press 1 at place 1, .* but found press"),
        (with_presses(lambda own: own[1:]), "expected press 1 at place 1, .* but found press 2"),
        (with_presses(lambda own: [each | {"specimen": "S9"} for each in own]), r"1 \(main, S3, .* press 1 \(main, S9"),
        (with_presses(lambda own: [each | {"stay": "1"} for each in own]), "found a press whose number"),
        (lambda plan: plan | {"participant": "P01"}, r"participant P03, as line 3 of .* found participant P01"),
        (lambda plan: [plan], "expected the plan of a session, but found no table"),
        (lambda plan: {}, "expected the plan of a session, but found no key 'presses'"),
    ],
)  # fmt: skip
def test_a_plan_that_is_not_that_of_the_journal_is_refused(played, change, match):
    path = played.folder / PLAN_FILE
    path.write_text(json.dumps(change(json.loads(path.read_text()))))
    for line in (None, 4):
        with pytest.raises(DataError, match=f"{PLAN_FILE}: .*{match}"):
            replay(played.study, played.folder, line=line)


def test_a_session_is_rebuilt_while_it_runs(play):
    found = []

    def look(desk, now_s):
        if now_s > 30 and not found:
            found.append(replay(desk.session.study, desk.session.record.folder))
            found.append(as_json(desk.participant()))
            desk.ask(Request("abort"))
            desk.ask(Request("end"))

    play(session=FEW, beside=look)
    assert found[0].same
    assert len(found[0].presses) == 1
    assert as_json(found[0].participant) == found[1]


@pytest.mark.slow
@pytest.mark.realtime
def test_sittings_that_were_killed_with_a_judge_of_their_own_are_rebuilt(tmp_path):
    path = tmp_path / "study.toml"
    table = f"[session]\n{SIMULATED_SESSION}repetitions = 3\npause_s = 1.0\n"
    path.write_text(small_study(participants=["P01"], specimens=["S1", "S3"], task="press", tables=table))
    study = load_study(path)
    folder = folder_of(study, "P01")
    resume, judged = False, []
    for state, after_s in (("press", 0.1), ("judging", 0.02), ("pause", 0.05), ("", 0.0)):
        _, killed = sitting(path, "P01", resume, state, 1, after_s)
        assert killed == bool(state)
        resume = True
        replayed = replay(study, folder)
        assert replayed.same, [press.differences for press in replayed.presses]
        judged.append(len(replayed.presses))
    assert judged == sorted(judged)
    assert judged[-1] >= 6
    assert replayed.operator.ended == "completed"
