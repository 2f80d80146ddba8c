from __future__ import annotations

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.report.failures import Failure
from emg2vsa.report.session_page import write_session_page
from emg2vsa.signals.bias import BiasBudget

LIGHT_PAGE_BYTES = 100_000


@pytest.fixture
def write(results, fits_of, tmp_path):
    def page_of(participant="P01", trials=None, failures=(), study=results.study) -> Path:
        own = [t for t in results.people.trials if t.participant == participant] if trials is None else trials
        fits = fits_of(own, study) if own else None
        (path,) = write_session_page(study, participant, own, fits, failures, tmp_path)
        assert path == tmp_path / "participants" / f"{participant}.html"
        return path

    return page_of


def test_one_verdict_and_every_press_in_the_same_bytes_again(write, read_page):
    path = write("P02")
    page, first = read_page(path), path.read_bytes()
    assert "Good. Every press can be used." in page.text
    assert page.text.count("Presses on") == 4
    assert len(first) < LIGHT_PAGE_BYTES
    assert "../index.html" in page.addresses
    assert write("P02").read_bytes() == first


def test_doubtful_and_rejected_presses_are_told_apart_without_colour(write, read_page):
    path = write("P01")
    page = read_page(path)
    text = path.read_text()
    assert "Repeat." in page.text
    assert "EDC clipped <3 %>" in page.text
    assert "force falls on 4 % of its path" in page.text
    assert 'fill="url(#rejected)"' in text
    assert ">3×</text>" in text
    assert ">2!</text>" in text
    assert "6 presses: 4 ok, 1 doubtful, 1 rejected" in page.text


@pytest.mark.parametrize("failed", [("S5",), ("S1", "S2", "S3", "S5")])
def test_recordings_that_failed_are_named_with_their_reason(write, results, read_page, failed):
    trials = [t for t in results.people.trials if t.participant == "P02" and t.specimen not in failed]
    failures = [Failure(f"P02/{name}", "trials", f"P02_{name}.csv: no channel 'Fz' & no <force>") for name in failed]
    page = read_page(write("P02", trials, failures))
    assert "Unreadable." in page.text
    assert all(failure.message in page.text for failure in failures)


def test_a_recording_without_presses_is_not_an_exception(write, results, read_page):
    full = next(t for t in results.people.trials if t.participant == "P02" and t.specimen == "S1")
    none = np.empty(0)
    empty = replace(
        full, repetition=none.astype(int), start_s=none, stop_s=none, duration_s=none, peak_force_n=none,
        falling_share=none, snr_db=none, verdict=none.astype("<U8"), reasons=(), offsets=np.zeros(1, dtype=int),
        force_n=none, activity=none, envelopes_v=np.empty((2, 0)), bias=BiasBudget.of((), 0),
    )  # fmt: skip
    trials = [empty, *(t for t in results.people.trials if t.participant == "P02" and t.specimen != "S1")]
    page = read_page(write("P02", trials))
    assert "no curve can be drawn" in page.text
    assert "0 presses: 0 ok" in page.text


def test_a_long_recording_stays_light(write, results):
    trials = [t for t in results.people.trials if t.participant == "P02"]
    hour = np.arange(0, 3600, 0.1)
    noise = np.random.default_rng(1).standard_normal(hour.size)
    long = [replace(t, overview_time_s=hour, overview_force_n=noise) for t in trials]
    assert write("P02", long).stat().st_size < LIGHT_PAGE_BYTES


def test_names_cannot_break_the_page(write, results, read_page):
    page = read_page(write(study=replace(results.study, title="<b>&'\"")))
    assert "<b>&'\"" in page.text


def test_pages_load_neither_matplotlib_nor_tests_nor_optimizers():
    unwanted = "matplotlib", "pandas", "scipy.optimize", "scipy.stats", "emg2vsa.discrimination", "emg2vsa.calibration"
    code = f"import sys, emg2vsa.report.session_page; sys.exit(not sys.modules.keys().isdisjoint({unwanted}))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0


def test_a_page_takes_nothing_of_other_participants(write, results):
    """The study that a page is handed may be reduced, and failures of P020 are none of P02."""
    study, failures = results.study, [Failure("P020", "pages", "of another"), Failure("P02", "fits", "own")]
    whole = write("P02", failures=failures).read_bytes()
    own = tuple(entry for entry in study.recordings if entry.participant == "P02")
    reduced = replace(study, recordings=own, participants=("P02",))
    assert write("P02", failures=failures[1:], study=reduced).read_bytes() == whole
    assert b"of another" not in whole
