"""A small study, made by hand up to the trials and by the real stages from there on."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest

from emg2vsa.extraction import Trials
from emg2vsa.fits import Fits, concatenate, fit_trials
from emg2vsa.hypotheses import test_hypotheses as run_hypotheses
from emg2vsa.profiles import build_profiles
from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import People, StudyResults
from emg2vsa.schedules.build import build_schedules
from emg2vsa.settings import (
    ChannelSettings,
    CocontractionSettings,
    EmgChannelSettings,
    FilterSettings,
    FitSettings,
    ForceChannelSettings,
    HypothesisSettings,
    ProfileSettings,
    ScheduleSettings,
    WindowSettings,
)
from emg2vsa.signals.bias import BiasBudget
from emg2vsa.signals.delays import DelayBudget
from emg2vsa.study import RecordingEntry, Specimen, Study
from tests.made_traits import unknown

PRESSES, SAMPLES, FS_HZ = 6, 200, 100.0
TRUE = {"S1": (42e-6, 20e-6), "S2": (36e-6, 17e-6), "S3": (28e-6, 13e-6), "S5": (16e-6, 7e-6)}
STIFFNESS = {"S1": 7.63, "S2": 5.32, "S3": 3.35, "S5": 1.11}


def make_study(participants: tuple[str, ...] = ("P01", "P02", "P03"), title: str = "A small study") -> Study:
    channels = ChannelSettings(
        emg={"EDC": EmgChannelSettings(name="EDC"), "FDS": EmgChannelSettings(name="FDS")},
        force=ForceChannelSettings(name="Fz"),
    )
    window = WindowSettings(expected_trials=PRESSES)
    recordings = tuple(
        RecordingEntry(p, s, Path(f"{p}_{s}.csv"), None, channels, FilterSettings(), window)
        for p in participants
        for s in TRUE
    )
    kept = ("S1", "S3", "S5")
    new = {"new_specimen": "S_new", "new_stiffness_n_per_mm": 5.32}
    return Study(
        name="small", title=title, mode="default", path=Path("study.toml"), participants=participants,
        specimens=tuple(Specimen(name, stiffness) for name, stiffness in STIFFNESS.items()), recordings=recordings,
        cocontraction=CocontractionSettings(), fit=FitSettings(), hypotheses=HypothesisSettings(kept_specimens=kept),
        profile=ProfileSettings(participant=participants[0], specimens=kept, **new), schedule=ScheduleSettings(),
        simulation=None, results=Path("results"), reports=Path("reports"), data=Path("data"), window=window,
    )  # fmt: skip


def make_trials(participant: str, specimen: str, seed: int) -> Trials:
    """Presses with known a and b plus noise; press 2 is warned, press 3 rejected, on one recording only."""
    rng = np.random.default_rng(seed)
    a, b = TRUE[specimen]
    force = np.tile(np.linspace(0.5, 7.0, SAMPLES), PRESSES)
    activity = a + b * np.log(force) + 0.1 * a * rng.standard_normal(force.size)
    start = 3.0 + 6.0 * np.arange(PRESSES)
    verdict, reasons = np.full(PRESSES, "ok", dtype="<U8"), [""] * PRESSES
    if (participant, specimen) == ("P01", "S3"):
        verdict[1:3] = "doubtful", "rejected"
        reasons[1:3] = "force falls on 4 % of its path", "EDC clipped <3 %>"
    time = np.arange(0.0, start[-1] + 5.0, 0.1)
    phase = (time[:, None] - start) / 2.0
    overview = np.where((phase > 0) & (phase < 1.2), np.clip(0.5 + 6.5 * phase, 0, 7.3), 0).sum(axis=1)
    return Trials(
        participant=participant, specimen=specimen, muscles=("EDC", "FDS"), repetition=np.arange(1, PRESSES + 1),
        start_s=start, stop_s=start + 2.0, duration_s=np.full(PRESSES, 2.0), peak_force_n=np.full(PRESSES, 7.3),
        falling_share=np.full(PRESSES, 0.01), snr_db=np.full(PRESSES, 20.0), verdict=verdict, reasons=tuple(reasons),
        fs_hz=FS_HZ, offsets=SAMPLES * np.arange(PRESSES + 1), force_n=force, activity=activity,
        envelopes_v=np.stack([0.4 * activity, 0.6 * activity]), activity_unit="V", rest_force_n=0.12,
        rest_envelope_v=np.array([1e-6, 1.5e-6]), mains_ratio=np.array([0.01, 0.02]), clip_share=np.zeros(2),
        overview_time_s=time, overview_force_n=overview, delay=DelayBudget((("EMG band-pass", 0.0),), 0.0, 0.0, 0.0),
        bias=BiasBudget.of((), PRESSES), traits=unknown(("EDC", "FDS"), PRESSES),
        notes=("EMG band-pass: true -3 dB at 12.4 Hz and 438 Hz", "tare: 0.12 N"),
    )  # fmt: skip


def own_fits(trials: list[Trials], study: Study) -> Fits:
    return concatenate([fit_trials(t, study.fit, study.window) for t in trials])


def make_results() -> StudyResults:
    study = make_study()
    trials = [make_trials(e.participant, e.specimen, seed) for seed, e in enumerate(study.recordings)]
    fits = own_fits(trials, study)
    profiles = build_profiles(fits, study.stiffness_n_per_mm, study.profile, study.window, study.hypotheses.use)
    rows = zip(fits.participant.tolist(), fits.specimen.tolist(), fits.repetition.tolist(), strict=True)
    people = People(
        fits=fits,
        trials=tuple(trials),
        hypotheses=run_hypotheses(fits, study.hypotheses),
        profiles=profiles,
        schedules=build_schedules(profiles, study.schedule, {"study": study.name}),
        truth={row: TRUE[row[1]] for row in rows},
    )
    return StudyResults(study, people, provenance={"emg2vsa": "0.1.0", "numpy": "2.3"})


@pytest.fixture(scope="session")
def fits_of() -> Callable[[list[Trials], Study], Fits]:
    return own_fits


@pytest.fixture(scope="session")
def results() -> StudyResults:
    return make_results()


@pytest.fixture(scope="session")
def broken(results: StudyResults) -> StudyResults:
    """The same study with the stages after the fits failed, on recorded data, and one recording unreadable."""
    failures = (
        Failure("P03/S5", "trials", "P03_S5.csv: channel 'Fz' is missing"),
        Failure("study", "hypotheses", "no usable <trial>"),
        Failure("study", "profiles", "no profile of P01"),
    )
    people = replace(results.recorded, hypotheses=None, profiles=None, schedules=(), truth=None)
    return replace(results, people=people, failures=failures)


class PageReader(HTMLParser):
    """What must hold of every page: balance of elements, ids and references, drawings and what they say."""

    VOID = frozenset({"meta", "br", "link", "img", "input"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.named_by: list[str] = []
        self.addresses: list[str] = []
        self.words: list[str] = []
        self.feed(text)
        assert not self.open

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        self.tags.append(tag)
        if tag not in self.VOID:
            self.open.append(tag)
        self.ids += [given["id"]] if "id" in given else []
        self.named_by += (given.get("aria-labelledby") or "").split()
        self.addresses += [given[name] for name in ("href", "src", "xlink:href") if given.get(name)]
        for value in given.values():
            self.addresses += [f"#{name}" for name in re.findall(r"url\(#([^)]+)\)", value or "")]

    def handle_startendtag(self, tag, attributes):
        self.handle_starttag(tag, attributes)
        if tag not in self.VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(data)

    @property
    def text(self) -> str:
        return " ".join("".join(self.words).split())

    def check(self) -> None:
        """Well-formed, self-contained, and every drawing has words."""
        assert len(set(self.ids)) == len(self.ids)
        own = {address[1:] for address in self.addresses if address.startswith("#")}
        assert own | set(self.named_by) <= set(self.ids)
        # a frame of the camera in a figure is carried by the page itself
        assert not [a for a in self.addresses if re.match(r"(https?:)?//(?!doi\.org/)|data:(?!image/png;base64,)", a)]
        assert not {"script", "link", "img", "iframe"} & set(self.tags)
        assert {"html", "header", "nav", "main", "footer", "h1"} <= set(self.tags)


@pytest.fixture(scope="session")
def read_page() -> Callable[[Path], PageReader]:
    def read(path: Path) -> PageReader:
        text = path.read_text()
        assert text.startswith('<!DOCTYPE html>\n<html lang="en">')
        assert text.count('role="img"') == text.count("<desc ")
        page = PageReader(text)
        page.check()
        return page

    return read
