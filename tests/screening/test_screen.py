"""Recordings that are unlike their study are named, with what they do to b; clean studies raise no doubt."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.study_mishaps import CURVES_V, MISHAPS, cut, digits, filtered, fitted, gain, made, trials_of
from emg2vsa.screening import Screened, Screening, screened, screened_trials
from emg2vsa.screening.screen import screen, traits_by_recording
from emg2vsa.settings import PressJudgement

PEOPLE = 6
SPOILT = ("P0", "S2")


@pytest.fixture(scope="module")
def clean():
    """Trials of a study without a mishap."""
    return {(f"P{n}", s): trials_of(made(n, s, 77), f"P{n}", s) for n in range(PEOPLE) for s in CURVES_V}


def with_one(clean, raw, key=SPOILT):
    """What is found where one recording is another."""
    return screen(traits_by_recording((clean | {key: trials_of(raw, *key)}).values()))


def test_a_clean_study_raises_no_doubt(clean):
    assert screen(traits_by_recording(clean.values())) == Screening()


@pytest.mark.parametrize(
    ("name", "cause", "b_share"),
    [
        ("one recording × 2", "gain", 1.0),
        ("one recording × 0.5", "gain", -0.5),
        ("one recording × 1.3", "gain", 0.3),
        ("EDC of one recording × 10", "gain", None),
        ("low-passed at 60 Hz, one", "filters in the file", -0.38),
        ("high-passed at 60 Hz, one", "filters in the file", -0.4),
        ("notch 45 to 55 Hz, one", "filters in the file", -0.15),
        ("250 Hz interpolated to 1000 Hz, one", "filters in the file", None),
        ("envelope to 50 Hz, high-passed at 10 Hz, one", "filters in the file", None),
        ("time × 2, one", "time scale", None),
        ("time × 1.1, one", "time scale", None),
        ("time × 0.5, one", "time scale", None),
        ("ounces as N, one", "unit of force", None),
    ],
)
def test_a_mishap_is_named_in_its_recording_alone(clean, name, cause, b_share):
    (found,) = with_one(clean, MISHAPS[name][0](made(0, "S2", 77))).found
    assert (found.participant, found.specimen, found.cause, found.verdict) == (*SPOILT, cause, "doubtful")
    if b_share is not None:
        assert 1 + found.b_share == pytest.approx(1 + b_share, rel=0.2)


def test_exchanged_muscles_and_harmless_filters_are_told_only(clean):
    narrow = filtered((72.0, 84.0), "bandstop")
    for change in (MISHAPS["muscles exchanged, one"][0], MISHAPS["low-passed at 200 Hz, one"][0], narrow):
        (found,) = with_one(clean, change(made(0, "S2", 77))).found
        assert (found.verdict, abs(found.b_share) < 0.08) == ("told", True)


@pytest.mark.parametrize(("change", "b_share"), [(gain(2.0), 1.0), (gain(0.3, "EDC"), -0.45)])
def test_a_gain_of_a_whole_session_shows_in_its_noise(clean, change, b_share):
    spoilt = {("P0", s): trials_of(change(made(0, s, 77)), "P0", s) for s in CURVES_V}
    found = screen(traits_by_recording((clean | spoilt).values())).found
    assert {(each.participant, each.specimen) for each in found} == set(spoilt)
    assert [each.b_share for each in found] == pytest.approx([b_share] * 3, abs=0.15)


@pytest.mark.parametrize(
    "change",
    [
        lambda raw: raw, digits(1e-6), cut(1.0), cut(0.4003), gain(0.5),
        lambda raw: replace(raw, force_n=1.02 * raw.force_n), lambda raw: replace(raw, force_n=0.98 * raw.force_n),
    ],
)  # fmt: skip
def test_a_copy_makes_both_recordings_unreadable(clean, change):
    found = with_one(clean, change(made(3, "S1", 77))).found
    assert {(each.participant, each.specimen): each.text for each in found if each.verdict == "unreadable"} == {
        SPOILT: "the same recording as P3/S1", ("P3", "S1"): "the same recording as P0/S2"
    }  # fmt: skip


def test_two_recordings_say_nothing_of_what_is_normal(clean):
    spoilt = trials_of(gain(10.0)(made(0, "S2", 77)), *SPOILT)
    assert screen(traits_by_recording([clean["P0", "S1"], spoilt])) == Screening()


def test_recordings_of_other_muscles_are_not_compared(clean):
    other = clean["P1", "S1"]
    renamed = replace(other, traits=replace(other.traits, muscles=("ECR", "FCR")))
    spoilt = {SPOILT: trials_of(gain(10.0)(made(0, "S2", 77)), *SPOILT)}
    assert screen(traits_by_recording((clean | spoilt | {("P1", "S1"): renamed}).values())) == Screening()


def test_who_accepts_the_recording_overrules_and_one_press_does_not(clean):
    traits = traits_by_recording((clean | {SPOILT: trials_of(gain(3.0)(made(0, "S2", 77)), *SPOILT)}).values())
    whole = PressJudgement(*SPOILT, None, "the amplifier was set so", False)
    (found,) = screen(traits, [whole]).found
    assert (found.verdict, screen(traits, [whole]).of(*SPOILT)) == ("ok", None)
    (found,) = screen(traits, [replace(whole, repetition=1)]).found
    assert found.verdict == "doubtful"


def test_fits_and_trials_follow():
    both = {}
    fitted(made(0, "S1"), "P0", "S1", both)
    trials, fits = both["P0", "S1"]
    assert "ok" in fits.verdict

    def of(verdict):
        return Screening((Screened("P0", "S1", "gain", "its gain", 1.5, verdict),))

    doubtful = screened(fits, of("doubtful"))
    assert not np.any(doubtful.verdict == "ok")
    was_ok = fits.verdict == "ok"
    assert set(doubtful.verdict[was_ok]) == {"doubtful"}
    assert all(reason.startswith("its gain (b 2.5 times)") for reason in doubtful.reason[was_ok])
    assert set(screened(fits, of("unreadable")).verdict) == {"rejected"}
    for verdict in ("ok", "told"):
        assert screened(fits, of(verdict)).verdict.tolist() == fits.verdict.tolist()
    assert screened(fits, None).reason.tolist() == fits.reason.tolist()
    assert screened_trials(trials, of("unreadable")).fault == "its gain (b 2.5 times)"
    assert screened_trials(trials, of("told")).remarks[-1] == "its gain (b 2.5 times)"
    assert screened_trials(trials, of("doubtful")) is trials
    use = {
        v: [of(v).counts("P0", "S1", use) for use in ("ok", "ok+doubtful")] for v in ("told", "doubtful", "unreadable")
    }
    assert use == {"told": [True, True], "doubtful": [False, True], "unreadable": [False, False]}


def test_nothing_is_said_of_a_recording_without_presses(clean):
    raw = made(0, "S2", 77)
    silent = trials_of(replace(raw, force_n=np.full(raw.force_n.size, 0.2)), *SPOILT)
    assert silent.repetition.size == 0
    assert screen(traits_by_recording((clean | {SPOILT: silent}).values())) == Screening()


def test_a_person_whose_own_band_is_another_is_no_filter(clean):
    """Skin and muscles differ: all recordings of the person agree, and the noise at rest has no edge."""
    traits = traits_by_recording(clean.values())
    narrow = {
        key: replace(own, press_band_hz=own.press_band_hz * [1.0, 0.7, 0.6]) if key[0] == "P0" else own
        for key, own in traits.items()
    }
    assert not screen(narrow).found
    one = traits | {SPOILT: narrow[SPOILT]}
    assert [each.cause for each in screen(one).found] == ["filters in the file"]


def test_a_visit_that_lacks_a_specimen_is_doubtful_and_recordings_compare_within_visits(clean):
    at = dict.fromkeys(clean, ("1", "2")) | {SPOILT: ("1",)}
    spoilt = {key: trials_of(gain(2.0)(made(0, key[1], 77)), *key) for key in clean if key[0] == "P0" and key != SPOILT}
    traits = traits_by_recording((clean | spoilt).values())
    assert SPOILT in [(each.participant, each.specimen) for each in screen(traits).found]
    screening = screen(traits, (), at)
    assert SPOILT not in [(each.participant, each.specimen) for each in screening.found]
    assert screening.unequal == (("P0", "2", "S2"),)
    into = {}
    fitted(made(0, "S1", 77), "P0", "S1", into)
    ((_, fits),) = into.values()
    visit = np.where(fits.repetition > 2, "2", "1")
    found = screened(replace(fits, visit=visit), Screening(unequal=screening.unequal))
    assert found.verdict.tolist() == np.where(visit == "2", "doubtful", "ok").tolist()
    assert "visit 2 lacks S2" in found.reason[-1]
