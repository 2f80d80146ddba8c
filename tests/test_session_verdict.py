"""The verdict on a session, and what to do about it."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from emg2vsa.session_verdict import VERDICTS, doubts_between, judge_session
from emg2vsa.settings import PressJudgement

SLOW = "lasted 21 s, longer than 20 s"
LEANT = "force rests at 0.30 N before contact"


def recording(specimen="S1", ok=0, doubtful=0, rejected=0, notes=(), fault=""):
    """What the verdict reads of trials."""
    verdict = np.array(["ok"] * ok + ["doubtful"] * doubtful + ["rejected"] * rejected, dtype="<U8")
    reasons = ("",) * ok + (LEANT,) * doubtful + (SLOW,) * rejected
    repetition = np.arange(1, verdict.size + 1)
    return SimpleNamespace(
        specimen=specimen, repetition=repetition, verdict=verdict, reasons=reasons, notes=notes, fault=fault, remarks=()
    )


def replaced(found, **values):
    """The recording with other values."""
    return SimpleNamespace(**(vars(found) | values))


def judge(*trials, wanted=10, failures=None):
    failures = failures or {}
    return judge_session(
        "P01", trials, {}, {t.specimen: wanted for t in trials} | dict.fromkeys(failures, 10), failures
    )


@pytest.mark.parametrize(
    ("counts", "wanted", "verdict"),
    [
        ({"ok": 10}, 10, "good"),
        ({"ok": 10}, None, "good"),
        ({"ok": 9, "doubtful": 1}, 10, "usable"),
        ({"ok": 9}, 10, "usable"),
        ({"ok": 11}, 10, "usable"),
        ({"ok": 8, "doubtful": 1, "rejected": 1}, 10, "usable"),
        ({"ok": 7, "doubtful": 3}, 10, "repeat"),
        ({"ok": 7, "rejected": 3}, 10, "repeat"),
        ({"ok": 7}, 10, "repeat"),
        ({"rejected": 1}, None, "repeat"),
        ({}, None, "repeat"),
    ],
)
def test_each_verdict(counts, wanted, verdict):
    judged = judge(recording(**counts), wanted=wanted)
    assert judged.verdict == verdict
    assert judged.specimens[0].verdict == verdict
    assert bool(judged.advice) == (verdict != "good")


def test_usable_lists_what_was_found_equal_reasons_once():
    judged = judge(recording(ok=8, doubtful=3), wanted=10)
    assert judged.advice == (
        (f"S1: presses 9-11 doubtful: {LEANT}", "ask to lift the finger between presses"),
        ("S1: 11 presses found, 10 wanted", ""),
    )


def test_repeat_says_why():
    assert judge(recording(ok=5, rejected=5)).advice == (
        ("S1: record again (5 usable presses of 10)", ""),
        (f"S1: presses 6-10 rejected: {SLOW}", "ask for a steady press"),
    )
    none = "presses: none; tared force goes from -0.02 to 3.1 N, the window is 0.5 to 7 N"
    told = [advice.text for advice in judge(recording(notes=("force: N as stored", none))).advice]
    assert told == ["S1: record again", f"S1: {none}", "S1: 0 presses found, 10 wanted"]


def test_what_is_mended_in_files_is_not_recorded_again():
    raw = "EDC lies below 61 Hz, unlike all others; is it an envelope? (b -57 %)"
    spoilt = replaced(recording(doubtful=8), reasons=(raw,) * 8)
    assert judge(spoilt, wanted=8).advice[:2] == (
        ("S1: mend it before it is recorded again (0 usable presses of 8)", ""),
        (f"S1: presses 1-8 doubtful: {raw}", "export the raw EMG, as for the other recordings"),
    )


def test_one_most_likely_cause_has_the_only_remedy():
    drying = replaced(
        recording(ok=2, doubtful=6), remarks=("EDC fades to 40 % over the presses",),
        reasons=("",) * 2 + ("b is expected to be 14 % too low: lag; the lag of force differs by 40 ms "
                             "(standard deviation)",) * 6,
    )  # fmt: skip
    remedy = "press the electrode on or renew it; longer rests; record again"
    told = judge(drying).advice
    assert [do for _, do in told if do] == [remedy]
    assert told[1] == ("S1: EDC fades to 40 % over the presses", remedy)


def test_a_cause_among_other_reasons_of_a_press_is_named_alone():
    late = "force follows EMG by 90 ms, which lowers b by about 9 %"
    found = replaced(recording(doubtful=8), reasons=(f"its slope is uncertain by 60 %; {late}",) * 8)
    told = judge(found, wanted=8).specimens[0].told
    assert told[0].text == f"most likely: {late}"
    assert told[0].do.startswith('set align = "lag"')
    assert [do for _, do in told[1:]] == [""]


def test_what_could_not_be_read_is_not_recorded_again():
    judged = judge(recording(ok=10), failures={"S2": "S2.csv: expected a force, but found no unit. State it."})
    assert judged.verdict == "unreadable"
    assert judged.advice == (("S2: cannot be used: S2.csv: expected a force, but found no unit. State it.", ""),)
    assert [s.verdict for s in judged.specimens] == ["good", "unreadable"]


def test_a_recording_that_nobody_tried_to_read():
    judged = judge_session("P01", [], {}, {"S1": 10}, {})
    assert (judged.verdict, judged.advice) == ("unreadable", (("S1: cannot be used: no recording", ""),))


def test_a_wrong_sign_is_mended_in_the_study_file():
    mend = "set sign = -1 (or remove it) at the force channel of the study file"
    doubt = "force rises while EMG is below its rest; is its sign -1?"
    judged = judge(recording(rejected=10, fault=doubt))
    assert (judged.verdict, judged.advice) == ("unreadable", ((f"S1: cannot be used: {doubt}", mend),))


def test_the_worst_recording_counts_and_is_said_first():
    parts = {"good": recording("A", ok=10), "usable": recording("B", ok=9), "repeat": recording("C", ok=1)}
    for worst in range(1, 4):
        chosen = [parts[name] for name in VERDICTS[:worst]]
        assert judge(*chosen).verdict == VERDICTS[worst - 1]
    judged = judge(*parts.values(), failures={"D": "D.csv: found an empty file."})
    assert judged.verdict == "unreadable"
    assert list(dict.fromkeys(advice.text[0] for advice in judged.advice)) == ["D", "C", "B"]
    assert [s.specimen for s in judged.specimens] == ["A", "B", "C", "D"]


def doubtful(participant, specimen, b_v, start=0.0, lag_s=0.0):
    """What a look across recordings reads of trials and fits."""
    n = 6
    rng = np.random.default_rng([*f"{participant}{specimen}".encode()])
    slopes = b_v * (1 + 0.03 * rng.standard_normal(n))
    trials = SimpleNamespace(
        participant=participant, specimen=specimen, start_s=start + np.arange(n) + rng.random(), lag_s=lag_s,
        lag_se_s=0.002, repetition=np.arange(1, n + 1),
    )  # fmt: skip
    fits = SimpleNamespace(b_v=slopes, v_max_v=3 * slopes, verdict=np.array(["ok"] * n))
    return trials, fits


def doubts(recordings, judgements=()):
    fits = {(t.participant, t.specimen): f for t, f in recordings}
    return doubts_between([t for t, _ in recordings], fits, judgements)


def study(swapped=""):
    made = []
    for person in ("P1", "P2", "P3", "P4", "P5"):
        slopes = {"S1": 20e-6, "S5": 8e-6}
        if person == swapped:
            slopes = {"S1": 8e-6, "S5": 20e-6}
        made += [doubtful(person, name, b_v) for name, b_v in slopes.items()]
    return made


def test_recordings_that_agree_raise_no_doubt():
    assert doubts(study()) == {}


def test_swapped_specimens_are_named():
    found = doubts(study(swapped="P3"))
    assert set(found) == {("P3", "S1"), ("P3", "S5")}
    assert found["P3", "S1"] == ["b of S1 is below that of S5, against all other participants; were S1 and S5 swapped?"]


def test_two_that_disagree_prove_nothing():
    assert doubts([each for each in study(swapped="P3") if each[0].participant in ("P1", "P2", "P3")]) == {}


def test_a_recording_whose_clock_is_apart_from_the_session():
    made = [
        doubtful("P1", name, 1e-5, lag_s=lag_s) for name, lag_s in zip("ABCD", (0.02, 0.025, 0.12, 0.02), strict=True)
    ]
    found = doubts(made)
    assert list(found) == [("P1", "C")]
    assert found["P1", "C"][0].startswith("lag of force is 98 ms from the 22 ms")


def test_a_judgement_of_a_press_that_is_not_there():
    judgements = (PressJudgement("P1", "S1", 12, "typo", True), PressJudgement("P1", "S5", 6, "fine", False))
    assert doubts(study(), judgements) == {("P1", "S1"): ["[[exclude]] names press 12, of 6 found"]}
