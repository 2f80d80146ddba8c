"""A session as a program runs it: `emg2vsa.session.run`, `resume`, `finish` and `emulate`, without the command line."""

from __future__ import annotations

import asyncio
import json
import shutil
import subprocess
import sys
import threading
import urllib.request
from pathlib import Path

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa import session
from emg2vsa.errors import DataError, SettingError
from emg2vsa.session.journal import JOURNAL_FILE, Begun, Judged, PressBegun, read_journal
from emg2vsa.study_file import load_study

SEED = session.Virtual(seed=1)


@pytest.fixture
def study(tmp_path):
    text = small_study(
        participants=["P01", "P03"], specimens=["S1"], task="press", simulation="seed = 5\n",
        tables=f"[session]\n{SIMULATED_SESSION}pause_s = 1.0\nrepetitions = 2\n",
    )  # fmt: skip
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    return load_study(tmp_path / "study.toml")


def events(folder):
    return [line.event for line in read_journal(folder / JOURNAL_FILE)[0]]


def after_a_press(state):
    """Stop as Ctrl-C does, once a press was judged."""
    if any(press.verdict for press in state.presses):
        raise KeyboardInterrupt


def test_a_session_is_run_to_its_verdict_and_says_nothing(study, tmp_path, capsys):
    seen, ends = [], []
    truth = tmp_path / "truth.json"
    virtual = session.Virtual(seed=1, mistakes=("dips@1",), truth=truth)
    done = session.run(study, "P03", virtual=virtual, seen=seen.append, ended=ends.append)

    assert (done.how, done.why, done.good) == ("completed", "", True)
    assert ends == [session.SessionEnd("completed", "", done.folder)]
    assert seen[0].participant == "P03"
    assert seen[-1].ended == "completed"
    assert [e.verdict for e in events(done.folder) if isinstance(e, Judged)] == ["rejected", "ok", "ok"]
    assert [press["mistake"] for press in json.loads(truth.read_text())["presses"]] == ["dips", "", ""]
    judged = done.judged
    assert (judged.verdict, judged.left_out) == ("good", ())
    assert judged.verdicts[0].specimens[0].ok == 2
    assert all(path.is_file() for path in (*judged.recordings, judged.page))
    assert len(judged.recordings) == 1
    said = capsys.readouterr()
    assert (said.out, said.err) == ("", "")


def test_the_seed_is_that_of_the_study_unless_another_is_given(study, tmp_path):
    truth = []
    for number, seed in enumerate((None, 5, 1)):
        path = tmp_path / f"{number}.json"
        session.run(study, "P03", virtual=session.Virtual(seed=seed, truth=path), seen=after_a_press)
        truth.append(json.loads(path.read_text())["presses"][0]["b_v"])
        shutil.rmtree(study.data)
    assert truth[0] == truth[1] != truth[2]


def test_a_session_that_was_stopped_goes_on_with_its_order(study):
    stopped = session.run(study, "P03", virtual=SEED, seen=after_a_press)
    assert (stopped.how, stopped.why, stopped.judged, stopped.good) == ("ended", "Ctrl-C", None, False)
    with pytest.raises(DataError, match="--resume"):
        session.run(study, "P03", virtual=SEED)

    done = session.resume(study, "P03", virtual=SEED)
    assert done.how == "completed"
    told = events(done.folder)
    assert sum(isinstance(event, Begun) for event in told) == 2
    assert [(e.press, e.attempt) for e in told if isinstance(e, PressBegun)] == [(1, 1), (2, 1)]
    assert done.judged.verdicts[0].specimens[0].ok == 2


def test_what_there_is_of_a_session_is_finished(study):
    with pytest.raises(DataError, match="run the session first"):
        session.finish(study, "P03")
    session.run(study, "P03", virtual=SEED, seen=after_a_press)
    found = session.finish(study, "P03")
    assert found.verdicts[0].participant == "P03"
    assert found.verdicts[0].specimens[0].ok == 1
    assert found.folder == study.data / "sub-P03"
    assert session.finish(study, "P03") == found


@pytest.mark.parametrize(
    ("participant", "options", "said"),
    [
        ("P09", {"virtual": SEED}, "--participant P09: expected one of P01, P03"),
        ("P03", {}, "pages for a session with devices"),
        ("P03", {"pages": session.Pages(port=0)}, "expected a device"),
        ("P03", {"virtual": session.Virtual(mistakes=("sneeze@1",))}, "--mistake"),
        ("P03", {"virtual": SEED, "pages": session.Pages(port=0, bind="everywhere")}, "--bind"),
    ],
)
def test_what_cannot_be_run_is_refused_before_anything_is_written(study, participant, options, said):
    with pytest.raises(SettingError, match=said):
        session.run(study, participant, **options)
    assert not study.data.exists()


def test_there_is_nothing_to_resume_before_a_session(study):
    with pytest.raises(DataError, match="a session to resume"):
        session.resume(study, "P03", virtual=SEED)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"speed": 0.0}, "0.1 to 100"),
        ({"speed": 101.0}, "0.1 to 100"),
        ({"seed": -1}, "a whole number from 0"),
        ({"truth": Path("no/such/folder/truth.json")}, "no such folder"),
        ({"truth": Path(__file__).parent}, "expected a file, but found a folder"),
    ],
)
def test_a_virtual_participant_that_cannot_be_is_refused(options, said):
    with pytest.raises(SettingError, match=said):
        session.Virtual(**options)


@pytest.mark.parametrize("port", [99999, -1, "a"])
def test_a_port_that_cannot_be_is_refused(port):
    with pytest.raises(SettingError, match=r"port: expected a whole number from 0 to 65535"):
        session.Pages(port=port)


def test_pages_are_refused_where_an_event_loop_runs_and_nothing_is_begun(study):
    async def cell():
        session.run(study, "P01", virtual=SEED, pages=session.Pages(port=0))

    with pytest.raises(SettingError, match="expected a thread without a running event loop"):
        asyncio.run(cell())
    assert not study.data.exists()


def test_the_pages_answer_until_the_session_has_ended(study):
    answers = []

    def fetch(addresses):
        assert not addresses.on_network
        threading.Thread(target=lambda: answers.extend(map(answer, addresses[:2])), daemon=True).start()

    def answer(address):
        with urllib.request.urlopen(address, timeout=60) as page:
            return page.status

    def stop(state):
        if len(answers) == 2:
            raise KeyboardInterrupt

    done = session.run(
        study, "P03", virtual=session.Virtual(speed=20.0), pages=session.Pages(port=0), shown=fetch, seen=stop
    )
    assert answers == [200, 200]
    assert (done.how, done.why) == ("ended", "Ctrl-C")


def test_a_failing_callback_ends_the_session_and_is_raised(study):
    def fail(state):
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        session.run(study, "P03", virtual=SEED, seen=fail)
    assert session.resume(study, "P03", virtual=SEED, seen=after_a_press).why == "Ctrl-C"


def test_public_names_load_when_asked_for_and_modules_below_stay_reachable():
    program = (
        "import sys; from emg2vsa import session; import emg2vsa.session.plan; before = set(sys.modules);"
        "assert 'emg2vsa.lab.session_run' not in before and 'numpy' not in before, 'loaded too soon';"
        "assert session.plan.Plan and session.run.__module__ == 'emg2vsa.lab.session_run';"
        "assert all(getattr(session, name) for name in session.__all__);"
        "assert dir(session) == sorted(session.__all__)"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
