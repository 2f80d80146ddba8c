from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.exemplary import Choice
from emg2vsa.fits import usable
from emg2vsa.multiverse import Paths
from emg2vsa.registration.deviations import Deviation, Registered
from emg2vsa.report.facts import OF_PEOPLE, OF_PLAN, OF_RIG, OF_SPECIMENS, stated, told_of_people
from emg2vsa.report.inputs import Runs
from emg2vsa.report.methods import methods
from emg2vsa.report.references import cited
from emg2vsa.report.sections.provenance import filters_as_run, methods_text
from emg2vsa.report.wording import scored_by
from emg2vsa.session_settings import EmgSettings, SessionForceSettings, SessionSettings
from emg2vsa.settings import (
    MEDOID,
    CalibrationSettings,
    ClaimSettings,
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    PressJudgement,
    ProfileSettings,
    RunSettings,
    ScheduleSettings,
    WindowSettings,
)

ALL_TO_ADD = "resolution of the converter; participants' age, sex and handedness"


VERSIONS = {"emg2vsa": "0.1.0", "numpy": "2.3", "digest of fits": "0123"}
SESSION = SessionSettings(
    emg=EmgSettings(kind="simulated"), force=SessionForceSettings(kind="simulated"), training_specimens=("T1", "T2"),
    ethics="no. 7 of the university",
)  # fmt: skip
EQUIPMENT = (
    "ElectrodeManufacturer: Delsys", "ElectrodeType: Ag bars", "InterelectrodeDistance: 10", "SkinPreparation: alcohol",
    "EMGPlacementSchemeDescription: over the bellies.", "EMGReference: bipolar", "EMGGround: elbow",
    "Manufacturer: Delsys", "ManufacturersModelName: Trigno",
)  # fmt: skip
SETUP = {
    "f_contact_n": (0.5,), "f_max_n": (7.0,), "ramp_mm_per_s": (5.0,), "travel_mm": (15.0,), "pause_s": (2.0,),
    "rate_hz": (200.0,), "frame_rate_hz": (20.0, 25.0), "pin_length_mm": (3.0,), "dome_radius_mm": (20.0,),
}  # fmt: skip
REGISTERED = Registered(
    "registration.json", "ab12", "2026-03-04T10:00:00+00:00", "No run was there.", "c0de", {},
    (Deviation("plan", "alpha", "0.05", "0.1", ()), Deviation("code", "numpy", "2.3", "2.4", ())),
)  # fmt: skip
ASKED_BY_REFEREES = {
    "presses of each specimen": r"asks each participant for 6 presses on each specimen; 72 presses were found\.",
    "order of the specimens, practice and rests": r"in random order, all presses of one in a row \(seed 1\), before "
    r"them for practice of 5 presses on each of T1 and T2, and for rests .* 2 s .* 30 s between specimens\.",
    "sampling rates": r"EMG was sampled at 2000 Hz and force at 1000 Hz\.",
    "type of the electrodes": r"state the electrodes: Delsys, Ag bars\.",
    "distance of the electrodes of a pair": r"electrodes of a pair were 10 mm apart\.",
    "placement of the electrodes": r"state the placement: over the bellies\.",
    "reference and ground": r"state the reference and the ground: bipolar, elbow\.",
    "preparation of the skin": r"state the preparation of the skin: alcohol\.",
    "maker and model of the amplifier": r"state the amplifier: Delsys, Trigno\.",
    "ethics approval": r"ethics approval is no\. 7 of the university\.",
    "stiffness of the specimens": r"stiffness κ of 7\.63 \(S1\), 5\.32 \(S2\), .* N/mm\.",
    "standard errors of that stiffness": r"standard errors of κ are 0\.05 \(S1\) N/mm\.",
    "registration of the plan": r"registered on 2026-03-04 \(SHA-256 ab12\)\. At that time no run was there\. The plan "
    r"amends an earlier one \(SHA-256 c0de\)\. The study deviates in 1 point from it: "
    r"alpha \(0\.05 when registered, 0\.1 now\)\.",
    "ramp": r"probe moved at 5 mm/s along a ramp of 15 mm\.",
    "forces of contact and turning back": r"Contact was a force of 0\.5 N; a press turned back at 7 N\.",
    "pause between presses": r"pause between presses was 2 s\.",
    "largest force of a press": r"largest force of a press was 7\.4 N\.",
    "presses and mountings": r"had 1 mounting at each angle under each condition, and each mounting had \d+ presses\.",
    "order of the runs": r"order of the runs was random, seed 0\.",
    "rate of the control loop": r"control loop ran at 200 Hz\.",
    "rate of the camera": r"camera took 20 or 25 frames a second\.",
    "size of the frames": r"frame had \d+ × \d+ px\.",
    "pins of the sensor": r"sensor had \d+ pins\.",
    "size of the sensor": r"pins were 3 mm long, under a dome with a radius of 20 mm\.",
}
"""Fact to how methods.txt states it. A referee has asked for each of them."""


SEEN_IN_PRESSES = {
    "presses and mountings", "largest force of a press", "size of the frames", "pins of the sensor"
}  # fmt: skip


def left_to_authors(text):
    return text.partition("in no file of the study: ")[2].partition(".\n")[0].split("; ")


def told_of(results, study, trials=(), *, simulated=False, runs=(), calibration=None, choice=None, exported=True):
    people = replace(
        results.people, trials=tuple(trials), choice=choice, truth={} if simulated else None,
        profiles=results.people.profiles if exported else None,
    )  # fmt: skip
    rig = Runs(tuple(runs), None, calibration) if runs else None
    return replace(results, study=study, people=people, runs=rig, provenance=VERSIONS)


@pytest.fixture
def written(results):
    """Of a study, and what else is to be told of."""

    def text(study=results.study, trials=(), **more):
        told = methods(told_of(results, study, trials, **more))
        assert all(text.endswith(".") for _, text in told)
        return "\n".join(f"{heading}: {cited(text)}" for heading, text in told)

    return text


def test_a_study_that_tells_all_states_every_fact_that_a_referee_asks_for(results, runs):
    first, *rest = results.study.specimens
    specimens = (replace(first, stiffness_se_n_per_mm=0.05), *rest)
    study = replace(results.study, specimens=specimens, session=SESSION)
    trials = [replace(t, rates_hz=(2000.0, 2000.0, 1000.0), equipment=EQUIPMENT) for t in results.people.trials]
    made = [replace(run, setup=SETUP, simulated=False, peak_n=0 * run.first_n + 7.4) for run in runs[:2]]
    told = replace(told_of(results, study, trials, runs=made), run_order="random, seed 0", registered=REGISTERED)
    text = methods_text(told)
    assert {name for name, said in ASKED_BY_REFEREES.items() if not re.search(said, text)} == set()
    assert set(left_to_authors(text)).isdisjoint(ASKED_BY_REFEREES)
    assert "resolution of the converter" in left_to_authors(text)

    bare = methods_text(told_of(results, replace(results.study, specimens=()), runs=[replace(made[0], setup={})]))
    assert {name for name, said in ASKED_BY_REFEREES.items() if re.search(said, bare)} == SEEN_IN_PRESSES
    assert set(ASKED_BY_REFEREES) - set(left_to_authors(bare)) == SEEN_IN_PRESSES


@pytest.mark.parametrize("name", ASKED_BY_REFEREES)
def test_a_fact_that_lacks_one_value_is_left_to_the_authors(name):
    facts = OF_PEOPLE | OF_SPECIMENS | OF_PLAN | OF_RIG
    assert set(facts) == set(ASKED_BY_REFEREES)
    needs = re.findall(r"{(\w+)}", facts[name])
    assert needs
    told = dict.fromkeys(needs, "7")
    assert stated({name: facts[name]}, told) == (facts[name].format_map(told), [])
    for need in needs:
        less = {key: value for key, value in told.items() if key != need}
        assert stated({name: facts[name]}, less) == ("", [name])


def test_recordings_at_several_rates_are_counted(results):
    rates = [(2000.0, 1000.0), (2000.0, 1000.0), (1925.926, 1000.0)]
    trials = [replace(t, rates_hz=of) for t, of in zip(results.people.trials, rates, strict=False)]
    told = told_of_people(results.study, trials)
    assert told["emg_hz"] == "2000 Hz (2 recordings) and 1925.93 Hz (1 recording)"
    assert told["force_hz"] == "1000 Hz"


def with_window(study, window):
    return replace(study, recordings=tuple(replace(entry, window=window) for entry in study.recordings))


def with_filters(study, filters):
    return replace(study, recordings=tuple(replace(entry, filters=filters) for entry in study.recordings))


def test_states_what_a_reporting_standard_asks_for(written, results):
    text = written(results.study, results.people.trials) + "; ".join(filters_as_run(results.people.trials))
    for said in (
        "3 participants pressed 4 specimens", "EDC and FDS", "Butterworth, order 2, 10 to 450 Hz", "order 50, 20 Hz",
        "run forward and backward", "true -3 dB at 12.4 Hz and 438 Hz", "not normalised", "0.5 to 7 N",
        "force bins of 0.3 N", "inverse variance", "at 95 %", "Kolmogorov-Smirnov", "Fisher's LSD",
        "participant P01", "emg2vsa 0.1.0 and numpy 2.3", ALL_TO_ADD,
    ):  # fmt: skip
        assert said in text
    assert "None" not in text


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (
            lambda s: replace(s, fit=FitSettings(points="samples", weights="none")),
            "ordinary least squares on the samples",
        ),
        (
            lambda s: replace(s, fit=FitSettings(robust=True)),
            ", with Huber's weights against outliers (Huber, 1964), on",
        ),
        (lambda s: with_filters(s, FilterSettings(envelope="rms", rms_window_s=0.05)), "root mean square over 50 ms"),
        (lambda s: with_filters(s, FilterSettings(envelope="rms")), "25 % more than a rectified mean"),
        (lambda s: with_filters(s, FilterSettings(align="lag")), "Force was moved by the lag"),
        (lambda s: with_filters(s, FilterSettings(force_filter=False)), "Force was not filtered"),
        (lambda s: with_filters(s, FilterSettings(phase="causal")), "their delays were left in"),
        (lambda s: replace(s, cocontraction=CocontractionSettings(index="rudolph", normalise="mvc")), "Rudolph"),
        (lambda s: replace(s, profile=ProfileSettings()), "all participants"),
        (lambda s: replace(s, window=WindowSettings(force_n=(1.0, 5.0))), "1 to 5 N"),
        (lambda s: replace(s, fit=FitSettings(min_adj_r2=0.4)), "adjusted R² on force bins was less than 0.4"),
        (lambda s: replace(s, fit=FitSettings(max_b_error_ratio=7.0)), "7 times the median of its recording"),
        (
            lambda s: replace(s, fit=FitSettings(max_b_error=3.0)),
            "3 times b and more than 0.2 of the mean fitted",
        ),
        (
            lambda s: replace(s, fit=FitSettings(min_adj_r2=-1.0, max_b_error_ratio=0.0)),
            "rejected if e was more than 4 times b",
        ),
        (lambda s: with_window(s, WindowSettings(max_missed_n=0.7)), "began more than 0.7 N above 0.5 N"),
        (
            lambda s: replace(s, judgements=(PressJudgement("P01", "S1", 2, "noisy [@me]", True),)),
            "By hand, whatever these rules say, were excluded: P01/S1, press 2 (noisy [me]).",
        ),
        (
            lambda s: replace(s, judgements=(PressJudgement("P01", "S1", None, "seen", False),)),
            "were accepted: P01/S1 (seen).",
        ),
        (lambda s: replace(s, schedule=ScheduleSettings(gear_mm_per_degree=0.3)), "by 0.3 mm for each degree of"),
        (lambda s: replace(s, claims=ClaimSettings(slope_percent=12.0)), "12 % of the mean for b between specimens"),
        (
            lambda s: replace(s, claims=ClaimSettings(false_verdict_percent=5.0)),
            "Intervals of 99.63 % give any false verdict among 27 claims a chance of 5 % at most",
        ),
    ],
)
def test_follows_the_settings(written, results, changed, said):
    assert said not in written(results.study)
    assert said in written(changed(results.study))


def test_says_nothing_of_rules_that_reject_nothing(written, results):
    none = FitSettings(min_adj_r2=-1.0, max_b_error_ratio=0.0, max_b_error=0.0)
    assert "A fitted trial was rejected if" in written(results.study)
    assert "A fitted trial was rejected" not in written(replace(results.study, fit=none))
    assert "a signal cannot be right" in written(results.study)
    assert "a signal cannot be right" not in written(with_window(results.study, WindowSettings(implausible="warn")))


def test_conditions_margins_and_presses_that_were_tested_are_said(written, results, runs):
    text = written(results.study, runs=runs)
    for run in runs:
        assert f"Under {run.condition}, " in text
    assert "2 % of CASR" in text
    assert "CASR" not in written(results.study)
    tested = int(np.count_nonzero(usable(results.people.fits, results.study.hypotheses.use)))
    assert f"({tested} of {results.people.fits.verdict.size}, of " in text


def test_paths_and_recordings_that_could_not_be_read_are_said_where_there_are_some(results, runs):
    paths = Paths(
        ("a",), ("A",), np.array(["holds"]), np.array(["index", "force bins"]), np.array(["x", "y"]),
        np.array([["holds", "refuted"]]), *np.ones((3, 1, 2)),
    )  # fmt: skip
    trials = results.people.trials
    window = replace(results.study.recordings[0].window, expected_trials=6)
    study = with_window(results.study, window)
    told = replace(told_of(results, study, trials[1:], runs=runs[:1]), paths=paths)
    text = methods_text(told)
    assert "again along 2 other paths of analysis, which differ from this one in index and force bins." in text
    assert f"presses were found in the {len(trials) - 1} of {len(trials)} recordings that could be read." in text
    text = methods_text(told_of(results, study, trials))
    assert "other paths" not in text
    assert "could be read" not in text


def test_says_what_was_taken_out_of_the_emg_and_nothing_else(written, results):
    hum, rest = "Mains hum and its harmonics, fitted at rest, were subtracted", "subtracted in power"
    kept = written(with_filters(results.study, FilterSettings(mains="keep", rest_level="keep")))
    for said in (hum, rest):
        assert said in written(results.study)
        assert said not in kept


def test_recordings_with_other_settings_are_all_stated(written, results):
    first, *rest = results.study.recordings
    window = replace(first.window, min_duration_s=0.3)
    other = replace(first, filters=FilterSettings(fir_cutoff_hz=6.0), window=window)
    text = written(replace(results.study, recordings=(other, *rest)))
    for said in ("order 50, 6 Hz", "order 50, 20 Hz", "less than 0.3 s", "less than 0.5 s"):
        assert said in text
    assert f"In {first.key}: EMG was" in text
    assert f"In {len(rest)} of {len(rest) + 1} recordings: EMG was" in text


def test_nothing_is_claimed_that_did_not_happen(written, results):
    text = written(results.study, results.people.trials, simulated=True)
    assert "were simulated" in text
    assert ALL_TO_ADD not in text
    assert "compared participants" not in written(replace(results.study, participants=("P01",)))
    assert "; ".join(filters_as_run(results.people.trials)).count("true -3 dB at 12.4 Hz") == 1


@pytest.mark.parametrize("phase", ["zero-phase", "compensated", "causal"])
@pytest.mark.parametrize("envelope", ["fir", "rms"])
@pytest.mark.parametrize("points", ["bins", "samples"])
@pytest.mark.parametrize("weights", ["inverse-variance", "none"])
def test_every_choice_reads_as_sentences(written, results, phase, envelope, points, weights):
    study = replace(
        with_filters(results.study, FilterSettings(phase=phase, envelope=envelope)),
        fit=FitSettings(points=points, weights=weights),
    )
    text = written(study)
    assert not re.search(r"  | [,.;]|,,|;\.|\{|\}|by weighted by", text)


@pytest.mark.parametrize(
    ("settings", "said", "unsaid"),
    [
        (RunSettings(), ("contact front in every frame", "at their exposure", "power law"), ("dense", "equation")),
        (
            RunSettings(algorithm="paper"),
            (
                "the mean of the forces logged while each was the last", "Algorithm 1, pins matched one to one",
                "dense optical flow (Horn and Schunck, 1981)", "divergence over the contact", "equation (1) as printed",
                "equation (2) as printed",
            ),
            ("exposure", "power law"),
        ),
        (
            RunSettings(algorithm="edge", engine="dis", region="image", rate="slope"),
            ("fold of the pins", "(Kroeger et al., 2016)", "mean divergence over the whole image", "slope of the line"),
            ("Schunck", "equation"),
        ),
    ],
)  # fmt: skip
def test_every_step_of_scoring_is_named(written, results, runs, settings, said, unsaid):
    text = written(replace(results.study, scoring=settings), runs=runs)
    paragraph = next(line for line in text.splitlines() if line.startswith("Contact area spread rate"))
    for words in said:
        assert words in paragraph
    for words in unsaid:
        assert words not in paragraph


def test_captions_name_the_steps():
    assert scored_by(RunSettings()) == "algorithm front: force at exposure, CASR by a power law"
    assert scored_by(RunSettings(algorithm="paper", region="image")) == (
        "algorithm paper: initial area by rule paper, dense Horn–Schunck flow over the whole image, mean force per "
        "frame, area by equation (1) as printed, CASR by equation (2) as printed"
    )


def test_the_medoid_is_named_with_its_ties_and_one_participant_is_no_medoid(written, results):
    def choice(*to_others):
        names = ("P01", "P02", "P03")[: len(to_others)]
        return Choice(names, np.array(to_others), np.zeros(3), np.zeros(3), ())

    study = replace(results.study, profile=ProfileSettings(participant=MEDOID))
    assert "from those of the others (P02)." in written(study, choice=choice(0.3, 0.1, 0.2))
    assert "(P01, the first of 2 equally near)" in written(study, choice=choice(0.1, 0.1, 0.2))
    alone = replace(study, participants=("P01",))
    assert "the mean of the fits of the one participant, P01." in written(alone)
    assert "Stiffness schedules" not in written(study, exported=False)


def test_the_scatter_of_mountings_is_said_to_be_found_where_it_was(written, results, runs, stiffness_n_per_mm):
    own = [run for run in runs if run.angle_deg == 0 and run.condition in ("modular", "high-stiffness")]
    found = calibrate_runs(own, stiffness_n_per_mm, "S_new", CalibrationSettings(resamples=20))
    study = replace(results.study, profile=ProfileSettings(new_specimen="S_new"))

    def measured(*designs):
        def changed(i, each):
            law = replace(each.algorithms["front"].chosen, mounting_sd=0.01 * (i + 2), mounting_freedom=6.0)
            of = replace(each.algorithms["front"], chosen=law)
            return replace(each, algorithms=each.algorithms | {"front": of}) if i in designs else each

        return replace(found, conditions=tuple(changed(i, each) for i, each in enumerate(found.conditions)))

    assumed = "an assumed SD of 4.3 % of the score"
    assert assumed in written(study, runs=own, calibration=found)
    both = written(study, runs=own, calibration=measured(0, 1))
    assert "the SD of the score between mountings that those of all designs show (2 to 3 %)" in both
    assert "assumed" not in both
    one = written(study, runs=own, calibration=measured(1))
    assert "that those of all designs show (3 % in 1 of 2 designs), in the others an assumed SD" in one
    assert assumed in one


def test_what_users_wrote_is_said_as_it_stands(results):
    trials = [replace(t, equipment=("ElectrodeType: {wet} [@home] <b>.",)) for t in results.people.trials]
    told = told_of(results, replace(results.study, session=replace(SESSION, ethics="no. 7.")), trials)
    text = methods_text(told)
    assert "state the electrodes: {wet} [home] <b>." in text
    assert "approval is no. 7." in text


def test_the_curve_of_schedules_and_the_test_of_laws_are_said(written, results):
    splines = replace(results.study, profile=replace(results.study.profile, curve="spline"))
    assert "follow monotone cubic splines (Ramsay, 1988) in ln F" in " ".join(written(splines).split())
    assert "monotone cubic splines" not in written()
    assert "root mean square distance lies above 1 % of the level." in " ".join(written().split())
