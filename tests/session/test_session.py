"""A whole session: what is judged, what is refused, what is asked, and what its recordings say afterwards."""

from __future__ import annotations

import numpy as np
import pytest

from emg2vsa import artifacts
from emg2vsa.cli import main
from emg2vsa.cli.progress import progress
from emg2vsa.pipeline.judged_sessions import of_participants
from emg2vsa.pipeline.run_study import run_study
from emg2vsa.session.dataset import write_dataset
from emg2vsa.session.journal import JOURNAL_FILE, Judged, read_journal
from emg2vsa.session.views import Request
from emg2vsa.study_file import load_study


def test_a_small_session_from_its_signals_to_its_verdict(play, capsys):
    played = play("dips@2", session='training_specimens = ["T1"]\ntraining_repetitions = 1')
    assert played.state.ended == "completed"
    first = next(press for press in played.state.presses if press.phase == "main")
    number = first.number + 1
    assert played.verdicts.pop((number, 1))[0] == "rejected"
    kept = [press for press in played.state.presses if (press.number, press.attempt) != (number, 1)]
    assert [press.verdict for press in kept] == ["ok"] * 7
    assert max(played.session.verdict_delays_s) < 1.0
    for view in played.state.signals:
        assert view.problems == ()
        assert view.snr_db > 30
    for fit in played.state.fits:
        truth = np.mean([p.b_v for p in played.person.presses if p.specimen == fit.specimen and not p.mistake])
        assert fit.presses == 3
        assert fit.low_v < fit.b_v < fit.high_v
        assert fit.b_v == pytest.approx(truth, rel=0.15)
    write_dataset(played.folder, played.study)
    assert main(["check", str(played.study_file), "P03", "--jobs", "1"]) == 0
    assert "S1 3/3, S3 3/3" in capsys.readouterr().out


def checked(played):
    """Of each specimen the presses that were judged, and the trials that `emg2vsa check` finds."""
    write_dataset(played.folder, played.study)
    own = of_participants(load_study(played.study_file), ["P03"])
    board = run_study(own, stages=("trials",), jobs=1, progress=progress(quiet=True))
    for entry in own.recordings:
        (path,) = board.done("trials", (entry.key,))
        pressed = [press for press in played.state.presses if press.specimen == entry.specimen and press.verdict]
        yield pressed, artifacts.load(path)


CHARACTERS = [
    ("too-fast@1", "warned", "faster than"),
    ("too-slow@1", "warned", "slower than"),
    ("dips@1", "rejected", "force falls"),
    ("aborted@1", "rejected", "reached"),
    ("overshoot@1", "rejected", "after STOP"),
    ("never-lifts@1", "rejected", "not lifted"),
    ("early@1", "rejected", "before START"),
    ("electrode-off:FDS@1", "rejected", "electrode of FDS is off"),
    ("mains@1", "warned", "mains is"),
    ("clipping@1", "rejected", "clips"),
    ("sensor-offset@1", "rejected", "before START"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("mistake", "verdict", "said"), CHARACTERS)
def test_each_character_has_its_verdict_and_check_agrees(play, mistake, verdict, said):
    played = play(mistake)
    own = played.verdicts[(1, 1)]
    assert own[0] == verdict, own
    assert any(said in found for found in own[1]), own
    others = {key: value for key, value in played.verdicts.items() if key != (1, 1)}
    assert {value[0] for value in others.values()} <= {"ok", "warned"}, others
    assert ((1, 2) in others) == (verdict == "rejected")
    assert played.state.ended == "completed"
    for own, trials in checked(played):
        # an early press ends at once, so far below the upper force that no trial is found in it
        own = [press for press in own if not any("finds no press" in found for found, _ in press.problems)]
        live = ["rejected" if press.decision == "repeat" else press.verdict for press in own]
        pairs = zip(trials.verdict.tolist(), live, strict=True)
        for found, judged in pairs:
            assert (found == "rejected") == (judged == "rejected"), trials.reasons
            assert found == "ok" or judged != "ok", trials.reasons


def asked(requests):
    """Ask at a time, once; what was said."""
    said = []
    waiting = list(requests)

    def beside(desk, now_s):
        while waiting and now_s >= waiting[0][0]:
            said.append(desk.ask(waiting.pop(0)[1]))
        if not waiting and desk.session.state.ended is None:
            desk.ask(Request("abort"))
            desk.ask(Request("end"))

    return beside, said


REFUSED = [
    (Request("start"), "Place specimen"),
    (Request("placed"), "Measure the signals"),
    (Request("measure-contraction"), "Measure the rest first"),
    (Request("abort"), "No press is under way"),
    (Request("accept"), "no finished press"),
    (Request("repeat", press=3), "Press 3 has not begun"),
    (Request("skip", press=3), "Press 3 has not begun"),
    (Request("accept", press=30), "Press 30 has not begun"),
    (Request("note", press=3, text="late"), "Press 3 has not begun"),
    (Request("note", text="a\x07"), "cannot be written"),
    (Request("note", text="\ud83d"), "cannot be written"),
    (Request("check", item="shoes"), "has no 'shoes'"),
    (Request("note", text="  "), "empty"),
    (Request("dance"), "no command"),
]


def test_what_is_not_possible_is_refused_in_a_sentence(play):
    beside, answers = asked([(0.2, request) for request, _ in REFUSED])
    play(operator=False, beside=beside)
    for answer, (request, said) in zip(answers, REFUSED, strict=True):
        assert said in answer, request
        assert answer.endswith(".")


def test_start_needs_signals_specimen_checklist_and_rest(play):
    items = ("arm on its support", "electrodes and cables in place", "chair and posture as before")
    beside, said = asked(
        [
            (1.0, Request("continue")),
            (1.1, Request("placed")),
            (1.2, Request("start")),
            *((1.3, Request("check", item=item)) for item in items),
            (1.4, Request("start")),
            (3.2, Request("pause")),
            (3.3, Request("start")),
            (3.4, Request("continue")),
            (6.0, Request("start")),
            (6.1, Request("start")),
            (6.2, Request("end")),
        ]
    )
    played = play(operator=False, beside=beside)
    assert said[0] == said[1] == ""
    assert "Confirm first: arm on its support" in said[2]
    assert "rest lasts" in said[6]
    assert "paused" in said[8]
    assert said[7] == said[9] == said[10] == ""
    assert "'start'" in said[11]
    assert "abort it first" in said[12]
    assert played.state.ended == "ended"


@pytest.mark.slow
@pytest.mark.parametrize("mistake", ["electrode-off:FDS@2", "electrode-off:EDC@2", "clipping@3", "mains@3"])
def test_a_good_press_stays_good_whatever_comes_later_in_its_stay(play, mistake):
    seen: dict[tuple[int, int], list[str]] = {}

    def look(desk, now_s):
        for press in desk.operator()[1].presses:
            own = seen.setdefault((press.number, press.attempt), [])
            if press.verdict and own[-1:] != [press.verdict]:
                own.append(press.verdict)

    played = play(mistake, beside=look)
    assert all(len(verdicts) == 1 for verdicts in seen.values()), seen
    events = [line.event for line in read_journal(played.folder / JOURNAL_FILE)[0]]
    judged = [(event.press, event.attempt) for event in events if isinstance(event, Judged)]
    assert len(judged) == len(set(judged)) == len(seen)
    number = int(mistake[-1])
    good = {key: value for key, value in played.verdicts.items() if key != (number, 1)}
    assert {verdict for verdict, _ in good.values()} == {"ok"}, good
    assert not any("lag" in found for _, problems in good.values() for found in problems)
    for own, trials in checked(played):
        for press, verdict in zip(own, trials.verdict.tolist(), strict=True):
            assert (verdict == "rejected") == (press.decision == "repeat"), (press.number, trials.reasons)
