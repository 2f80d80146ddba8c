"""Which of the reasons of a recording is told as the cause."""

from __future__ import annotations

import pytest

from emg2vsa.extraction.diagnosis import ranked
from emg2vsa.extraction.remedies import REMEDIES, known, remedy_of

DIFFERS = "the lag of force differs by 42 ms (standard deviation)"
NO_FIT = "its fit explains too little (adjusted R2 -0.05)"


def lead(remarks, presses):
    return ranked(remarks, presses)[0]


@pytest.mark.parametrize(
    ("remarks", "reasons", "cause"),
    [
        (["EDC fades to 50 % over the presses"], DIFFERS, "EDC fades"),
        (["force was sampled at about 5 Hz, and held or interpolated to 1000 Hz"], DIFFERS, "force was sampled"),
        ([], f"the zero of force moves by 0.21 N around this press; {DIFFERS}", "the zero of force"),
        ([], f"muscles are tense between presses, up to 4 times as much as when they rest most; {DIFFERS}", "muscles"),
        (["EDC is stored in steps of 20 uV, coarse beside its EMG"], "EDC holds one value for 15 ms", "EDC is stored"),
        (["EDC shows the heart at rest, 71 beats a minute"], f"{NO_FIT}; {DIFFERS}", "EDC shows the heart"),
        (["EDC fades to 50 % over the presses"], "the lag of force drifts by 9 ms a second; do the clocks differ?",
         "the lag of force drifts"),
        ([], DIFFERS, "the lag of force differs"),
    ],
)  # fmt: skip
def test_a_cause_stands_before_what_follows_from_it(remarks, reasons, cause):
    found = ranked(remarks, [("doubtful", reasons)] * 6 + [("ok", "")] * 2)
    assert found[0].text.startswith(cause)
    assert found[0].do == remedy_of(found[0].text) != ""
    assert found[0].explains == 6


def test_a_cause_explains_at_least_half_of_what_another_does():
    late = "force follows EMG by 98 ms, which lowers b by about 9 %"
    spiky = "EDC has spikes: 3 samples far from their neighbours"
    few = [("doubtful", f"{spiky}; {late}")] * 2 + [("doubtful", late)] * 6
    assert lead([], few).text == late
    many = [("doubtful", f"{spiky}; {late}")] * 5 + [("doubtful", late)] * 3
    assert lead([], many).text == spiky


def test_a_press_that_is_used_explains_nothing_where_others_are_lost():
    moves = "EDC moves for 0.2 s, which is left out, with which b would change by -12 %"
    presses = [("ok", moves)] * 7 + [("rejected", "lasted 0.42 s, shorter than 0.5 s")]
    assert lead([], presses).text == "lasted 0.42 s, shorter than 0.5 s"
    assert lead(["EMG at 200 Hz holds only what lies below 100 Hz"], [("ok", moves)] + [("ok", "")] * 7).text == (
        "EMG at 200 Hz holds only what lies below 100 Hz"
    )


def test_numbers_of_all_presses_and_none_of_another_wording():
    presses = [
        ("rejected", "reached 5.61 of 7 N"), ("rejected", "reached 6.2 of 7 N"),
        ("rejected", "EDC clips in 16 % of samples; reached 4 of 7 N"),
    ]  # fmt: skip
    assert lead([], presses) == ("reached 4 to 6.2 of 7 N", "ask for firmer presses; show the target force", 3)
    both = ["EDC fades to 50 % over the presses", "FDS grows to 130 % over the presses"]
    assert lead(both, []).text == both[0]


def test_without_a_known_reason_there_is_no_cause():
    assert ranked([], []) == ()
    assert ranked(["something new"], [("rejected", "excluded by hand: sneezed"), ("ok", "")]) == ()


def test_what_a_person_has_judged_is_no_cause():
    fault = "EDC is 35 V during a press; is its unit uV, or its gain 10^6?"
    assert ranked([], [("ok", f"accepted by hand: sneezed; {fault}")] * 3) == ()
    assert ranked([], [("rejected", "operator: repeat: too fast; reached 5.6 of 7 N"), ("ok", "")]) == ()
    presses = [("rejected", f"excluded by hand: sneezed; {NO_FIT}")] * 3 + [("rejected", "reached 5.6 of 7 N")]
    assert [cause.text for cause in ranked([], presses)] == ["reached 5.6 of 7 N"]


def test_every_example_is_known_by_its_own_remedy():
    for rank, remedy in enumerate(REMEDIES):
        assert known(remedy.example) == rank
