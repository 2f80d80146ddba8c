from __future__ import annotations

from dataclasses import replace

import numpy as np
from emg2vsa.report.data_sections import participants

from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import origin, without_samples
from emg2vsa.settings import SimulationSettings


def test_trials_without_samples_keep_what_is_told_of_them(results):
    full = results.people.trials[0]
    light = without_samples(full)
    assert (light.notes, light.reasons, light.verdict.tolist()) == (full.notes, full.reasons, full.verdict.tolist())
    assert light.force_n.size == light.overview_force_n.size == 0
    assert light.envelopes_v.shape == (2, 0)
    assert not np.shares_memory(light.start_s, full.start_s)


def test_each_participant_gets_own_trials_and_failures(results):
    failures = (
        Failure("P01/S1", "trials", "cut"),
        Failure("study", "profiles", "none"),
        Failure("P02", "pages", "full"),
    )
    own = replace(results, failures=failures).by_participant()
    assert list(own) == ["P01", "P02", "P03"]
    assert [[t.participant for t in trials] for trials, _ in own.values()] == [[name] * 4 for name in own]
    assert [list(failed) for _, failed in own.values()] == [[failures[0]], [failures[2]], []]


def test_a_truth_makes_it_a_simulation(results):
    assert origin(results).strong == "These results come from a simulation."
    assert origin(replace(results, people=replace(results.people, truth={}))).source == "simulated data"


def test_without_a_truth_the_report_says_what_it_saw_and_claims_no_more(results):
    said = origin(replace(results, people=replace(results.people, truth=None)))
    assert said.strong.startswith("No table of simulated truth was found")
    assert "Nothing" not in said.text


def test_a_study_that_can_be_simulated_warns(results):
    study = replace(results.study, simulation=SimulationSettings())
    said = origin(replace(results, people=replace(results.people, truth=None, study=study)))
    assert said.strong == "These data may be simulated."


def test_the_table_of_participants_looks_through_all_recordings_a_fixed_number_of_times(results):
    class Counted(tuple):
        looks = 0

        def __iter__(self):
            Counted.looks += 1
            return super().__iter__()

    def looks(people: int) -> int:
        names = tuple(f"P{i:03}" for i in range(people))
        entries, trials = results.study.recordings[:4], results.people.trials[:4]
        study = replace(
            results.study, participants=names,
            recordings=Counted(replace(entry, participant=name) for name in names for entry in entries),
        )  # fmt: skip
        many = replace(
            results, study=study, trials=Counted(replace(t, participant=name) for name in names for t in trials),
            failures=Counted(Failure(f"{name}/S1", "fits", "cut") for name in names),
        )  # fmt: skip
        Counted.looks = 0
        assert participants(many).count('scope="row"') == people
        return Counted.looks

    assert looks(20) == looks(5) > 0
