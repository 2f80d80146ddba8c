from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

from emg2vsa.calibration.runs_calibration import calibrate_runs
from emg2vsa.exemplary import Choice
from emg2vsa.report.methods import methods
from emg2vsa.report.references import cited
from emg2vsa.report.sections.provenance import filters_as_run
from emg2vsa.report.wording import scored_by
from emg2vsa.settings import (
    MEDOID,
    CalibrationSettings,
    CocontractionSettings,
    FilterSettings,
    FitSettings,
    ProfileSettings,
    RunSettings,
    WindowSettings,
)

ALL_TO_ADD = "resolution of the converter; participants' age, sex and handedness; ethics approval."


def written(study, trials=(), **more):
    told = methods(study, trials, {"emg2vsa": "0.1.0", "numpy": "2.3"}, **more)
    assert all(each.text.endswith(".") for each in told)
    return "\n".join(f"{each.heading}: {cited(each.text)}" for each in told)


def with_filters(study, filters):
    return replace(study, recordings=tuple(replace(entry, filters=filters) for entry in study.recordings))


def test_states_what_a_reporting_standard_asks_for(results):
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
        (lambda s: with_filters(s, FilterSettings(force_filter=False)), "force was not filtered"),
        (lambda s: with_filters(s, FilterSettings(phase="causal")), "their delays were left in"),
        (lambda s: replace(s, cocontraction=CocontractionSettings(index="rudolph", normalise="mvc")), "Rudolph"),
        (lambda s: replace(s, profile=ProfileSettings()), "all participants"),
        (lambda s: replace(s, window=WindowSettings(force_n=(1.0, 5.0))), "1 to 5 N"),
    ],
)
def test_follows_the_settings(results, changed, said):
    assert said not in written(results.study)
    assert said in written(changed(results.study))


def test_says_what_was_taken_out_of_the_emg_and_nothing_else(results):
    hum, rest = "Mains hum and its harmonics, fitted at rest, were subtracted", "subtracted in power"
    kept = written(with_filters(results.study, FilterSettings(mains="keep", rest_level="keep")))
    for said in (hum, rest):
        assert said in written(results.study)
        assert said not in kept


def test_recordings_with_other_settings_are_all_stated(results):
    first, *rest = results.study.recordings
    window = replace(first.window, min_duration_s=0.3)
    other = replace(first, filters=FilterSettings(fir_cutoff_hz=6.0), window=window)
    text = written(replace(results.study, recordings=(other, *rest)))
    for said in ("order 50, 6 Hz", "order 50, 20 Hz", "less than 0.3 s", "less than 0.5 s"):
        assert said in text
    assert f"In {first.key}: EMG was" in text
    assert f"In {len(rest)} of {len(rest) + 1} recordings: EMG was" in text


def test_nothing_is_claimed_that_did_not_happen(results):
    text = written(results.study, results.people.trials, simulated=True)
    assert "were simulated" in text
    assert ALL_TO_ADD not in text
    assert "between participants" not in written(replace(results.study, participants=("P01",)))
    assert "; ".join(filters_as_run(results.people.trials)).count("true -3 dB at 12.4 Hz") == 1


@pytest.mark.parametrize("phase", ["zero-phase", "compensated", "causal"])
@pytest.mark.parametrize("envelope", ["fir", "rms"])
@pytest.mark.parametrize("points", ["bins", "samples"])
@pytest.mark.parametrize("weights", ["inverse-variance", "none"])
def test_every_choice_reads_as_sentences(results, phase, envelope, points, weights):
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
def test_every_step_of_scoring_is_named(results, runs, settings, said, unsaid):
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


def test_the_medoid_is_named_with_its_ties_and_one_participant_is_no_medoid(results):
    def choice(*to_others):
        names = ("P01", "P02", "P03")[: len(to_others)]
        return Choice(names, np.array(to_others), np.zeros(3), np.zeros(3), ())

    study = replace(results.study, profile=ProfileSettings(participant=MEDOID))
    assert "from those of the others (P02)." in written(study, choice=choice(0.3, 0.1, 0.2))
    assert "(P01, the first of 2 equally near)" in written(study, choice=choice(0.1, 0.1, 0.2))
    alone = replace(study, participants=("P01",))
    assert "the mean of the fits of the one participant, P01." in written(alone)
    assert "Stiffness schedules" not in written(study, exported=False)


def test_the_scatter_of_mountings_is_said_to_be_found_where_it_was(results, runs, stiffness_n_per_mm):
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
