"""A loss of power at any moment loses the running press at most; and the test would notice if it lost more."""

from __future__ import annotations

import random
from pathlib import Path

import pytest

from benchmarks.session_power_loss import RULES, after_power_loss, cut_at, record_session, resumed
from emg2vsa.errors import Emg2vsaError


@pytest.fixture(scope="module")
def session(tmp_path_factory):
    return record_session(tmp_path_factory.mktemp("power") / "session")


def outcomes(session, folder: Path, calls, rule: str, n: int):
    _, told, written = session
    rng = random.Random(f"5 {rule}")
    for i in range(n):
        some, done = cut_at(calls, rng)
        left = folder / str(i)
        left.mkdir()
        for name, content in after_power_loss(some, rule, rng).items():
            (left / name).write_bytes(content)
        try:
            yield resumed(left, done, told, written)
        except Emg2vsaError as error:
            yield error


@pytest.mark.parametrize("rule", RULES)
def test_at_most_the_running_press_is_lost(session, tmp_path, rule):
    for outcome in outcomes(session, tmp_path, session[0], rule, 40):
        assert not isinstance(outcome, Emg2vsaError), outcome
        assert outcome.fault == ""
        assert outcome.presses_lost <= 1


@pytest.mark.parametrize(("forgotten", "said"), [("sitting-1_emg.samples", "emg"), ("journal.jsonl", "")])
def test_a_forgotten_fsync_would_be_noticed(session, tmp_path, forgotten, said):
    """The same calls, but that one file is never brought to the disk itself."""
    calls = list(session[0])
    for i, call in enumerate(calls):
        if call.kind == "sync" and call.name == forgotten:
            calls[i] = call._replace(kind="open")
    found = list(outcomes(session, tmp_path, calls, "any", 40))
    faults = [own for own in found if isinstance(own, Emg2vsaError) or own.fault]
    assert faults
    assert any(said in str(own) for own in faults)
