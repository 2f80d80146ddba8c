from __future__ import annotations

from dataclasses import replace

from emg2vsa.report.origin import origin
from emg2vsa.settings import SimulationSettings


def test_a_truth_makes_it_a_simulation(results):
    assert origin(results).strong == "These results come from a simulation."
    assert origin(replace(results, truth={})).source == "simulated data"


def test_without_a_truth_the_report_says_what_it_saw_and_claims_no_more(results):
    said = origin(replace(results, truth=None))
    assert said.strong.startswith("No table of simulated truth was found")
    assert "Nothing" not in said.text


def test_a_study_that_can_be_simulated_warns(results):
    study = replace(results.study, simulation=SimulationSettings())
    said = origin(replace(results, truth=None, study=study))
    assert said.strong == "These data may be simulated."
