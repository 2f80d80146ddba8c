"""The order of presses: pinned, for it must be the same for ever; and balanced as it says."""

from __future__ import annotations

import itertools
from collections import Counter
from dataclasses import replace

import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.session.plan import Plan, changes, draw_presses, plan_bytes, read_plan
from emg2vsa.session_settings import SessionSettings

FIVE = ("S1", "S2", "S3", "S4", "S5")
SETTINGS = SessionSettings(
    emg=SimulatedEmgSettings(), force=SimulatedForceSettings(),
    training_specimens=("T2", "T1"), training_repetitions=2, repetitions=3,
)  # fmt: skip


def order(participant: str, how: str = "blocked", **given: object) -> list[str]:
    presses = draw_presses("palpation", participant, FIVE, replace(SETTINGS, order=how, **given))
    return [press.specimen for press in presses if press.phase == "main"]


def test_the_order_is_the_same_for_ever():
    """Drawn once more by a program of its own, from what the head of ``plan.py`` says."""
    assert order("P03")[::3] == ["S5", "S2", "S3", "S4", "S1"]
    assert "".join(name[1] for name in order("P03", "interleaved")) == "523412415353124"
    assert order("P03") != order("P04")
    assert order("P03") != order("P03", seed=2)


def test_training_comes_first_as_listed():
    presses = draw_presses("palpation", "P03", FIVE, SETTINGS)
    assert [(p.specimen, p.repetition, p.stay) for p in presses[:4]] == [
        ("T2", 1, 1), ("T2", 2, 1), ("T1", 1, 2), ("T1", 2, 2)
    ]  # fmt: skip
    assert {p.phase for p in presses[:4]} == {"training"}
    assert [p.number for p in presses] == list(range(1, 20))


def test_presses_on_one_specimen_in_a_row_are_one_stay():
    for how in ("blocked", "interleaved", "listed"):
        presses = draw_presses("palpation", "P07", FIVE, replace(SETTINGS, order=how))
        for before, after in itertools.pairwise(presses):
            assert (after.stay == before.stay) == ((before.phase, before.specimen) == (after.phase, after.specimen))
            assert after.stay - before.stay in (0, 1)


def test_interleaved_presses_every_specimen_as_often_as_every_other_at_any_moment():
    found = order("P05", "interleaved", repetitions=20)
    for n in range(len(found)):
        counts = Counter(found[:n])
        assert max(counts.values(), default=0) - min(counts[name] for name in FIVE) <= 1
    rounds = {tuple(found[i : i + 5]) for i in range(0, 100, 5)}
    assert len(rounds) > 10


def test_listed_is_as_listed():
    assert order("P05", "listed")[::3] == list(FIVE)


def test_all_orders_are_equally_likely():
    """Of 6000 people each of the 6 orders of three specimens has 1000, give or take 4 standard deviations."""
    drawn = Counter(
        tuple(press.specimen for press in draw_presses("s", f"P{i}", FIVE[:3], replace(SETTINGS, repetitions=1)))
        for i in range(6000)
    )
    assert len(drawn) == 6
    assert all(abs(count - 1000) < 4 * (6000 * 5 / 36) ** 0.5 for count in drawn.values())


def test_a_plan_reads_back_as_it_was_written(tmp_path):
    presses = draw_presses("palpation", "P03", FIVE, SETTINGS)
    plan = Plan("palpation", "P03", 1, "2026-11-23", presses, {"session": {"rest_s": 2.0}})
    (tmp_path / "plan.json").write_bytes(plan_bytes(plan))
    assert read_plan(tmp_path / "plan.json") == plan


@pytest.mark.parametrize(
    ("before", "now", "told"),
    [
        ({"a": {"b": 1}}, {"a": {"b": 1}}, ()),
        ({"a": {"b": (1, 2)}}, {"a": {"b": [1, 2]}}, ()),
        ({"a": {"b": 1}}, {"a": {"b": 2}}, ("a.b was 1 and is 2",)),
        ({"a": {"b": 1}}, {"a": {}}, ("a.b was 1 and is not set",)),
        ({"a": {}}, {"a": {"c": "x"}}, ('a.c was not set and is "x"',)),
        ({"a": {"b": None}}, {"a": {}}, ()),
    ],
)
def test_what_changed_in_the_study_file_is_told(before, now, told):
    assert changes(before, now) == told
