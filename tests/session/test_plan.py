"""The order of presses: pinned, for it must be the same for ever; and balanced as it says."""

from __future__ import annotations

import itertools
import json
from collections import Counter
from dataclasses import replace

import pytest

from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.session.plan import Plan, changes, design, draw_presses, order_of, plan_bytes, read_plan
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


@pytest.mark.parametrize("n", [1, 2, 3, 4, 5, 6, 7])
def test_designs_are_balanced(n):
    """Each specimen at each place equally often; in a Williams design each after each other one, too."""
    latin, williams = design("latin-square", n), design("williams", n)
    assert (len(latin), len(williams)) == (n, 2 * n if n % 2 else n)
    for rows in (latin, williams):
        for place in range(n):
            assert Counter(row[place] for row in rows) == dict.fromkeys(range(n), len(rows) // n)
    follows = Counter(pair for row in williams for pair in itertools.pairwise(row))
    assert follows == dict.fromkeys(itertools.permutations(range(n), 2), len(williams) // n)


@pytest.mark.parametrize(("how", "rows"), [("latin-square", 5), ("williams", 10)])
def test_participants_take_the_rows_of_a_design_in_turn(how, rows):
    settings = replace(SETTINGS, order=how, repetitions=1)

    def at(place: int) -> tuple[str, ...]:
        presses = draw_presses("palpation", f"P{place:02}", FIVE, settings, place)
        return tuple(press.specimen for press in presses if press.phase == "main")

    taken = [at(place) for place in range(2 * rows)]
    assert taken[:rows] == taken[rows:]
    assert len(set(taken)) == rows
    assert taken[0] == at(0) != FIVE, "letters are drawn by seed and study"
    assert order_of(FIVE, settings, rows + 2) == {"kind": how, "place": rows + 3, "row": 3, "rows": rows}


def test_listed_may_differ_from_person_to_person():
    orders = {"P01": FIVE[::-1], "P02": FIVE}
    assert order("P01", "listed", orders=orders)[::3] == list(FIVE[::-1])
    assert order("P02", "listed", orders=orders)[::3] == list(FIVE)


def test_a_visit_has_a_draw_of_its_own():
    drawn = [draw_presses("palpation", "P03", FIVE, SETTINGS, visit=visit) for visit in ("", "1", "2")]
    assert len(set(drawn)) == 3


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
    visit = replace(plan, visit="2", order={"kind": "williams", "place": 3, "row": 3, "rows": 10})
    (tmp_path / "plan.json").write_bytes(plan_bytes(visit))
    assert read_plan(tmp_path / "plan.json") == visit


def test_a_plan_of_an_earlier_version_has_no_visit(tmp_path):
    plan = Plan("palpation", "P03", 1, "2026-11-23", draw_presses("palpation", "P03", FIVE, SETTINGS))
    content = json.loads(plan_bytes(plan))
    del content["visit"], content["order"]
    (tmp_path / "plan.json").write_text(json.dumps(content))
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
