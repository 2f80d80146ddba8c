"""The state of a session is a fold over its journal, and the table says of every state what is legal in it."""

from __future__ import annotations

from itertools import product

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.durable.writer import DISK_TROUBLE
from emg2vsa.session import journal
from emg2vsa.session.journal import Line
from emg2vsa.session.legal import TABLE, Now, operator_state, participant_state, refusal, shown
from emg2vsa.session.plan import draw_presses
from emg2vsa.session.presses import Presses
from emg2vsa.session.screens import HIDDEN
from emg2vsa.session.state import DISK_BACK, NO_QUALITY, Rules, after, begun, goes_on
from emg2vsa.session.stay_judge import JUDGE_ENDED
from emg2vsa.session.views import REQUESTS, Request, ScreenReport
from emg2vsa.session_settings import SessionSettings

SETTINGS = SessionSettings(
    emg=SimulatedEmgSettings(), force=SimulatedForceSettings(), repetitions=2,
    training_specimens=("T1",), training_repetitions=1, stop="width", width=0.001, check_each_press=True,
)  # fmt: skip
RULES = Rules("a study", "P03", SETTINGS, ("EDC", "FDS"), 0.95)
PLANNED = draw_presses("a study", "P03", ("S1", "S3"), SETTINGS)
OPENED = {name: journal.StreamOpened(name, "a", name, ("EDC",), "V", 1000.0, None, 0.0) for name in ("emg", "force")}
WORDS = ("rest", "ready", "start", "press", "stop", "wait", "pause", "done")
numbers, attempts = st.integers(1, 6), st.integers(1, 2)
texts = st.sampled_from([NO_QUALITY, JUDGE_ENDED, goes_on("S1"), goes_on("S3"), "a cable", "S1: ", ""])
volts = st.sampled_from([None, 1e-5, 1.3e-5, 2e-5])
problems = st.sampled_from([(), (("EDC is flat", "attach it"),), (("no rest", "measure again"),) * 2])
EVENTS = st.one_of(
    st.just(journal.Begun("P03", "a study", "0", "here")),
    st.builds(journal.StreamOpened, st.sampled_from(["emg", "force"]), st.sampled_from(["a", "b"]), st.just("emg"),
              st.just(("EDC", "FDS")), st.just("V"), st.just(1000.0), st.none(), st.just(0.0)),
    st.builds(journal.Commanded, st.sampled_from(WORDS), st.integers(0, 6), st.integers(0, 2)),
    st.builds(lambda p, a: journal.PressBegun(p.number, a, p.specimen, p.phase, p.repetition, p.stay),
              st.sampled_from(PLANNED), attempts),
    st.builds(journal.PressEnded, numbers, attempts, st.just(1.0), st.just(2.0),
              st.sampled_from(["complete", "aborted"]), st.sampled_from([None, 7.3])),
    st.builds(lambda n, a, v, p, x: journal.Judged(n, a, v, p, {"a_v": x, "b_v": x}), numbers, attempts,
              st.sampled_from(["ok", "warned", "rejected"]), problems, volts),
    st.builds(journal.Decided, numbers, attempts, st.sampled_from(["accept", "repeat", "skip"])),
    st.builds(journal.Interrupted, numbers, attempts),
    st.builds(journal.PressAdded, st.integers(6, 7), st.just("main"), st.sampled_from(["S1", "S3"]), st.just(3),
              st.integers(2, 3), st.just("wide")),
    st.builds(journal.Noted, texts, st.integers(0, 6), attempts),
    st.builds(journal.Paused, st.sampled_from(["operator", journal.BETWEEN, "disk", "device"])),
    st.just(journal.Continued()),
    st.builds(journal.Checked, st.sampled_from([journal.PLACED, *SETTINGS.checklist, "shoes"])),
    st.builds(journal.Unchecked, st.sampled_from([*SETTINGS.checklist, "shoes"])),
    st.builds(journal.Measuring, st.sampled_from(["rest", "contraction"])),
    st.builds(journal.QualityMeasured, st.sampled_from(["rest", "contraction"]),
              st.sampled_from([{}, {"EDC": 2e-6, "FDS": 3e-6}]), problems),
    st.builds(journal.Told, texts),
    st.builds(journal.Ended, st.sampled_from(["completed", "ended", "failed"])),
)  # fmt: skip
MOMENTS = st.tuples(
    st.floats(0, 60), st.sampled_from([0.0, 0.5]), st.sampled_from([None, True, False]),
    st.sampled_from([0.0, 90.0]), st.booleans(), st.booleans(),
)  # fmt: skip


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(st.lists(st.tuples(EVENTS, MOMENTS), max_size=40))
def test_any_lines_make_a_state_in_which_every_request_has_an_answer_and_the_pages_a_view(steps):
    """Also lines that no session writes in this order, as a journal with a gap in it has them."""
    state = begun(RULES, Presses(PLANNED))
    for number, (event, moment) in enumerate(steps, 1):
        state = after(state, Line(number, 1, float(number), "", event))
        now = Now(state, *moment)
        answers = {name: refusal(now, Request(name, item="shoes", text="a note")) for name in REQUESTS}
        assert all(said == "" or said.endswith(".") for said in answers.values()), answers
        page = operator_state(now)
        assert page.awaits == shown(now).awaits
        assert set(page.commands) <= {*REQUESTS} if state.ended is None else page.commands == ()
        assert participant_state(now).command == state.command
        if state.ended is not None:
            assert set(answers.values()) == {"The session has ended."}


def test_the_table_answers_every_request_in_every_state():
    names = [row.name for row in TABLE]
    assert len(names) == len(set(names))
    for row, request in product(TABLE, REQUESTS):
        said = row.refuses.get(request, "")
        assert said == "" or said.endswith(".")
    for row in TABLE:
        assert set(row.refuses) <= set(REQUESTS), row.name
        assert not row.awaits or row.message, row.name
    assert TABLE[0].refuses.keys() == set(REQUESTS)


def folded(*events, sitting=1):
    state = begun(RULES, Presses(PLANNED))
    for number, event in enumerate(events, 1):
        state = after(state, Line(number, sitting, float(number), "", event))
    return state


PLACED = journal.Checked(journal.PLACED, "T1")
ALL = [journal.Checked(item) for item in SETTINGS.checklist]
BEGUN = journal.PressBegun(1, 1, "T1", "training", 1, 1)
ENDED = journal.PressEnded(1, 1, 5.0, 7.0, "complete", 7.2)
READY = (journal.Told(NO_QUALITY), PLACED, *ALL, journal.Commanded("ready"))
NOW = (30.0, 0.0, True)


@pytest.mark.parametrize(
    ("events", "moment", "state", "legal"),
    [
        ((), NOW, "quality", {"measure-rest", "continue", "pause", "end"}),
        ((journal.Measuring("rest"),), (2.0, 0.0, True), "measuring", {"pause", "end"}),
        ((journal.QualityMeasured("rest", {"EDC": 1e-6}),), NOW, "contraction",
         {"measure-rest", "measure-contraction", "continue", "pause", "end"}),
        (READY[:1], NOW, "placing", {"measure-rest", "placed", "pause", "end"}),
        (READY[:2], NOW, "checklist", {"placed", "skip", "pause", "end"}),
        (READY, NOW, "start", {"placed", "start", "skip", "pause", "end"}),
        (READY, (30.0, 0.4, False), "start", {"skip", "pause", "end"}),
        (READY, (30.0, 0.0, True, 31.0), "start", {"placed", "skip", "pause", "end"}),
        ((*READY, BEGUN), NOW, "pressing", {"abort"}),
        ((*READY, BEGUN, ENDED), NOW, "judging", {"skip", "pause", "end"}),
        ((*READY, BEGUN, ENDED), (30.0, 0.0, True, 0.0, False, True), "writing", {"skip", "pause", "end"}),
        ((*READY, BEGUN, ENDED, journal.Judged(1, 1, "rejected")), NOW, "verdict",
         {"placed", "accept", "repeat", "skip", "pause", "end"}),
        ((*READY, journal.Paused("operator")), NOW, "operator", {"placed", "skip", "continue", "end"}),
        ((*READY, journal.Paused("disk")), NOW, "disk", {"placed", "skip", "end"}),
        ((*READY, journal.Paused("device")), NOW, "device", {"placed", "skip", "continue", "end"}),
        ((*READY, journal.Paused("device")), (30.0, 0.0, None, 0.0, True), "lost", {"skip", "end"}),
        ((journal.Ended("ended"),), NOW, "ended", set()),
    ],
)  # fmt: skip
def test_what_is_legal_in_each_state(events, moment, state, legal):
    now = Now(folded(*events), *moment)
    assert shown(now).name == state
    always = {"check", "note"}
    found = {name for name in REQUESTS if name not in always and not refusal(now, Request(name))}
    assert found == legal


def test_a_sitting_begins_with_nothing_but_the_presses():
    judged = journal.Judged(1, 1, "ok", (), {"a_v": 1e-5, "b_v": 2e-6})
    resumed = journal.Begun("P03", "a study", "0", "here", resumed=True)
    state = folded(*READY, journal.Told("a cable"), BEGUN, ENDED, judged, resumed)
    assert state == begun(RULES, state.presses)
    assert state.presses.done == {1}
    assert state.wanted == PLANNED[1]


def test_a_further_press_that_is_declined_is_not_suggested_again():
    own = [press for press in PLANNED if press.specimen == PLANNED[1].specimen]
    lines = [journal.Told(NO_QUALITY), journal.Decided(1, 1, "skip")]
    pressed = []
    for press, b_v in zip(own, (1e-5, 3e-5), strict=True):
        pressed += [
            journal.PressBegun(press.number, 1, press.specimen, "main", press.repetition, press.stay),
            journal.PressEnded(press.number, 1, 5.0, 7.0, "complete", 7.2),
            journal.Judged(press.number, 1, "ok", (), {"a_v": 2e-5, "b_v": b_v}),
        ]
    skipped = journal.PressBegun(1, 1, "T1", "training", 1, 1), journal.PressEnded(1, 1, 1.0, 1.0, "aborted")
    lines = [lines[0], *skipped, lines[1], journal.Checked(journal.PLACED, own[0].specimen), *pressed]
    state = folded(*lines)
    assert state.suggested is not None
    assert (state.suggested.number, state.suggested.repetition, state.placed) == (6, 3, True)
    told = f"{own[0].specimen}: {state.fits[own[0].specimen].suggestion}"
    assert folded(*lines, journal.Told(told)).warnings == ()
    declined = folded(*lines, journal.Told(told), journal.Told(goes_on(own[0].specimen)))
    assert (declined.suggested, declined.warnings, declined.placed) == (None, (), False)
    again = folded(*lines, journal.Told(goes_on(own[0].specimen)), journal.Decided(own[1].number, 1, "accept"))
    assert again.suggested is None


@pytest.mark.parametrize(
    ("told", "over"),
    [
        ("EMG: the server is gone", OPENED["emg"]),
        ("Force: no samples for 2 s", OPENED["force"]),
        (f"{DISK_TROUBLE}: No space left on device.", journal.Told(DISK_BACK)),
        (HIDDEN, ScreenReport(60.0, 1.0, 2.0, 17.0, False)),
    ],
)
def test_a_warning_of_what_has_come_back_is_over_and_no_other(told, over):
    state = begun(RULES, Presses(PLANNED))
    for number, text in enumerate(("Chair was moved.", told), 1):
        state = after(state, Line(number, 1, float(number), "", journal.Told(text)))
    others = [event for event in (*OPENED.values(), journal.Told(DISK_BACK), journal.Continued()) if event != over]
    for event in others:
        state = after(state, Line(3, 1, 3.0, "", event))
    assert state.warnings == ("Chair was moved.", told)
    assert after(state, Line(4, 1, 4.0, "", over)).warnings == ("Chair was moved.",)
