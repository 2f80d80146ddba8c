from __future__ import annotations

import csv
import hashlib
import json
import os
import pickle
import re
import subprocess
import sys
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from jinja2 import UndefinedError
from scipy.stats import studentized_range
from scipy.stats import t as student

from emg2vsa import hypotheses
from emg2vsa.profiles import build_profiles
from emg2vsa.report import study_report
from emg2vsa.report.failures import Failure
from emg2vsa.report.inputs import StudyResults
from emg2vsa.report.section import rendered
from emg2vsa.report.sections.fits import FITS
from emg2vsa.report.sections.kappa import LAW_ERRORS
from emg2vsa.report.sections.provenance import TERMS
from emg2vsa.report.study_report import contents, numbers_and_tables, write_figure_pdfs, write_study_report
from emg2vsa.statistics.drift import Slope


@pytest.fixture(scope="module")
def written(results, tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("report")
    files = write_study_report(results, folder)
    assert not [path for path in files if path.suffix == ".pdf"]
    files += write_figure_pdfs(results, folder)
    assert set(files) == {path for path in folder.rglob("*") if path.is_file()}
    assert len(set(files)) == len(files)
    return folder


def digests(folder: Path) -> dict[str, str]:
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


def numbers(results: StudyResults, **people: object) -> dict:
    """The quantities, with other results of people."""
    return numbers_and_tables(with_people(results, **people)).quantities


def with_people(results: StudyResults, **changed: object) -> StudyResults:
    return replace(results, people=replace(results.recorded, **changed))


def with_profiles(results: StudyResults, **changed: object) -> StudyResults:
    return with_people(results, profiles=replace(results.recorded.profiles, **changed))


def test_everything_the_issue_names_is_there(written):
    names = set(digests(written))
    assert {"index.html", "results.json", "numbers.tex"} <= names
    figures = ("fig04_cocontraction", "fig05_schedules", "fig11_interpolation")
    assert {f"figures/{name}.{kind}" for name in figures for kind in ("svg", "pdf")} <= names
    tables = "anova_participants anova_specimens lsd_pairs normality profiles schedules leave_one_out"
    assert {f"tables/{name}.{kind}" for name in tables.split() for kind in ("csv", "tex")} <= names


def test_the_page_is_whole_self_contained_and_speaks(written, read_page):
    page = read_page(written / "index.html")
    assert page.tags.count("svg") == 6
    assert "These data are simulated." in page.text
    assert "EDC clipped <3 %>" in page.text
    assert [f"participants/P0{i}.html" for i in (1, 2, 3)] == [
        a for a in page.addresses if a.startswith("participants")
    ]
    assert "nan" not in re.split(r"\W+", page.text.lower())
    tables = [int(n) for n in re.findall(r"<b>Table (\d+)\.</b>", (written / "index.html").read_text())]
    assert tables == list(range(1, len(tables) + 1))


def test_numbers_on_the_page_are_those_of_results_json(written, read_page):
    found = json.loads((written / "results.json").read_text())
    text = read_page(written / "index.html").text
    between = (found[f"hypotheses.between_participants.{kind}"] for kind in ("significant", "tested"))
    assert "One-way ANOVA: {} of {} differ".format(*between) in text
    off = re.search(r"fitted slopes miss the true ones by (\S+) % on", text.replace("\N{NO-BREAK SPACE}", " "))
    assert float(off[1].replace("−", "-")) == float(f"{100 * found['recovery.mean_b_error']:.2g}")
    assert f"RMSE to the measured S2 is {found['profiles.S_new.rmse_v'] * 1e6:#.3g} µV" in text
    assert found["hypotheses.worst_pair"] in text


def test_fits_csv_holds_every_trial_exactly(written, results):
    with (written / "tables/fits.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["verdict"] for row in rows] == results.people.fits.verdict.tolist()
    assert np.array_equal([float(row["b_v"]) for row in rows], results.people.fits.b_v)
    assert [row["reason"] for row in rows if row["verdict"] == "rejected"] == ["EDC clipped <3 %>"]


def test_figures_keep_their_width_fonts_and_no_date(written):
    for name, width_mm in (("fig04_cocontraction", 181.0), ("fig05_schedules", 88.9), ("fig11_interpolation", 88.9)):
        svg = (written / f"figures/{name}.svg").read_text()
        pdf = (written / f"figures/{name}.pdf").read_bytes()
        width_pt = float(re.search(r'width="([0-9.]+)pt"', svg)[1])
        assert width_pt * 25.4 / 72 == pytest.approx(width_mm, abs=0.01)
        assert b"/FontFile2" in pdf  # TrueType, as IEEE asks: no Type 3
        assert b"/Type3" not in pdf
        assert b"CreationDate" not in pdf
        assert "dc:date" not in svg


def test_bytes_depend_on_the_results_alone(written, results, tmp_path):
    (tmp_path / "results.pickle").write_bytes(pickle.dumps(results))
    code = (
        "import pickle, sys; from pathlib import Path; from emg2vsa.report import study_report; "
        "results = pickle.load(open(sys.argv[1], 'rb')); "
        "study_report.write_study_report(results, Path(sys.argv[2])); "
        "study_report.write_figure_pdfs(results, Path(sys.argv[2]))"
    )
    environment = os.environ | {"PYTHONHASHSEED": "7", "TZ": "Asia/Tokyo", "SOURCE_DATE_EPOCH": "1"}
    again = tmp_path / "again"
    subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "results.pickle"), str(again)], check=True, env=environment
    )
    assert digests(again) == digests(written)


def test_a_failed_stage_says_why_in_its_place(broken, tmp_path, read_page):
    files = write_study_report(broken, tmp_path)
    page = read_page(tmp_path / "index.html")
    assert "Failed: no usable <trial>" in page.text
    assert "Failed: no profile of P01" in page.text
    assert "The study has no schedules." in page.text
    assert "channel 'Fz' is missing" in page.text
    assert "No sign of a simulation was found" in page.text
    assert page.tags.count("svg") == 1
    assert {path.stem for path in files if path.parent.name == "figures"} == {"figverdicts"}
    assert write_figure_pdfs(broken, tmp_path) == [tmp_path / "figures" / "figverdicts.pdf"]


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"participant": ""}, ("Co-contraction of all participants", "largest p of all participants")),
        ({"new": None, "new_measured": None, "new_error": None}, ("names no new specimen",)),
        ({"new_measured": None, "new_error": None}, ("nobody palpated a specimen of this stiffness",)),
    ],
)
def test_profiles_of_all_without_a_new_specimen_and_of_one_nobody_measured(results, changed, said, tmp_path, read_page):
    other = with_profiles(results, **changed)
    if "new" in changed:
        other = with_people(other, schedules=tuple(s for s in results.people.schedules if s.specimen != "S_new"))
    files = write_study_report(other, tmp_path)
    text = read_page(tmp_path / "index.html").text
    assert all(words in text for words in said)
    assert bool([path for path in files if "fig11" in path.name]) is ("new" not in changed)


def test_results_tell_how_likely_a_family_of_tests_rejects_anything_where_nothing_differs(written, results):
    found = json.loads((written / "results.json").read_text())
    anova = results.people.hypotheses.tests.between_groups.anova
    assert found["hypotheses.between_participants.chance_of_any"] == pytest.approx(1 - 0.95**4)
    chances = [  # the pairs of a participant share their means: the largest of them is the studentized range
        studentized_range.sf(np.sqrt(2) * student.isf(0.025, df2), df1 + 1, df2)
        for df1, df2 in zip(anova.df1.tolist(), anova.df2.tolist(), strict=True)
    ]
    assert found["hypotheses.pairs.chance_of_any"] == pytest.approx(1 - np.prod(1 - np.array(chances)))


def test_a_study_whose_presses_are_all_rejected_has_a_report(results, tmp_path):
    fits = replace(results.people.fits, verdict=np.full(results.people.fits.verdict.size, "rejected"))
    study = results.study
    tested = hypotheses.test_hypotheses(fits, study.hypotheses, study.participants, study.palpated)
    write_study_report(with_people(results, fits=fits, hypotheses=tested, profiles=None, schedules=()), tmp_path)
    found = json.loads((tmp_path / "results.json").read_text())
    assert found["claims.specimens_differ.verdict"] == "not determined"
    assert found["hypotheses.order"] == "unknown"


def test_of_one_recording_a_session_no_drift_is_said(results, tmp_path, read_page):
    tested = results.people.hypotheses
    told = with_people(results, hypotheses=replace(tested, drift=replace(tested.drift, places=1)))
    write_study_report(told, tmp_path)
    text = " ".join(read_page(tmp_path / "index.html").text.split())
    assert "The data do not tell how much b changes over a session." in text


def test_order_and_drift_have_a_line_of_their_own(results, tmp_path, read_page):
    """Of people whose order nobody knows, and of others whose order differs."""
    tested = results.people.hypotheses
    known = replace(tested.drift, order="differs", by_order=Slope(1e-7, 2e-8, 3.0))
    for drift, order, by in (
        (tested.drift, "is not known", "the presses of recordings"),
        (known, "differs between people", "this order"),
    ):
        told = with_people(results, hypotheses=replace(tested, drift=drift))
        write_study_report(told, tmp_path)
        text = " ".join(read_page(tmp_path / "index.html").text.split())
        assert f"The order of specimens {order}." in text
        assert re.search(rf"Over a session, b changes by \S+.% \[\S+.%, \S+.%\], as {by} tells?\.", text)
        found = json.loads((tmp_path / "results.json").read_text())
        assert found["hypotheses.order"] == drift.order
        mean = np.mean(told.people.fits.b_v[told.used])
        within = 100 * drift.within.value * (drift.places - 1) / mean
        assert found["hypotheses.drift.within_recordings_percent"] == pytest.approx(within)


def test_a_participant_without_a_page_is_not_linked(results, tmp_path, read_page):
    write_study_report(replace(results, failures=(Failure("P02", "pages", "disk full"),)), tmp_path)
    page = read_page(tmp_path / "index.html")
    assert [a for a in page.addresses if a.startswith("participants")] == [f"participants/P0{i}.html" for i in (1, 3)]
    assert "disk full" in page.text


def test_normalised_activity_is_never_called_volts(results, tmp_path, read_page):
    fits = replace(
        results.people.fits, activity_unit="1", a_v=1e4 * results.people.fits.a_v, b_v=-1e4 * results.people.fits.b_v,
        v_max_v=1e4 * results.people.fits.v_max_v,
    )  # fmt: skip
    study = results.study
    profiles = build_profiles(fits, study.stiffness_n_per_mm, study.profile, study.window, study.hypotheses.use)
    write_study_report(with_people(results, fits=fits, profiles=profiles), tmp_path)
    names = json.loads((tmp_path / "results.json").read_text())
    assert {"fit.S1.b.mean", "profiles.S_new.rmse"} <= set(names)
    assert not [name for name in names if re.search(r"_v(\.|$)", name)]
    heads = [path.read_text().splitlines()[0] for path in (tmp_path / "tables").glob("*.csv")]
    assert not [head for head in heads if re.search(r"_v(,|$)", head)]
    text = read_page(tmp_path / "index.html").text.replace("0.0002 V (200 µV)", "")  # the paper's number
    assert "µV" not in text
    assert "Slope b (" not in (tmp_path / "figures/fig04_cocontraction.svg").read_text()


def test_schedules_are_printed_without_repeating_what_is_constant(written, results):
    steps = results.people.schedules[0].preset.size
    specimens = len({s.specimen for s in results.people.schedules})
    printed = (written / "tables/schedules.tex").read_text().count(" & constant-")
    assert printed == 3 * specimens
    assert len((written / "tables/schedules.csv").read_text().splitlines()) == 1 + 4 * specimens * steps


def test_a_study_without_usable_recordings_or_without_people_says_so(results, tmp_path, read_page):
    failures = (Failure("P01/S1", "trials", "no channel <Fz>"),)
    write_study_report(StudyResults(results.study, failures=failures), tmp_path)
    page = read_page(tmp_path / "index.html")
    assert "No recording of people could be used." in page.text
    assert "no channel <Fz>" in page.text
    assert "#participants" in page.addresses
    assert [path.name for path in sorted((tmp_path / "tables").glob("*.csv"))] == ["failures.csv", "specimens.csv"]
    study = replace(results.study, recordings=(), participants=())
    write_study_report(StudyResults(study, provenance={"numpy": "2.3", "digest of runs": "abc"}), tmp_path)
    page = read_page(tmp_path / "index.html")
    assert "The study has no recordings of people." in page.text
    assert "What failed" not in page.text
    assert (tmp_path / "methods.txt").read_text().endswith("\n\nSoftware\nThe analysis ran with numpy 2.3.\n")
    assert "study.participants" not in (tmp_path / "results.json").read_text()


@pytest.mark.parametrize(
    ("others", "ours", "verdict"),
    [
        ({}, np.nan, "not determined"),
        ({"S1": 0.9914, "S3": 0.9731}, 0.0269, "not determined"),  # S2 and S5 say nothing
        ({"S1": 0.9914, "S2": 0.95, "S3": 0.9731, "S5": 0.95}, 0.05, "holds"),
        ({"S3": 0.85}, 0.15, "refuted"),
    ],
)
def test_plate_indentations_are_judged_where_the_study_says_how_straight_they_are(results, others, ours, verdict):
    specimens = tuple(replace(s, plate_adjusted_r2=others.get(s.name)) for s in results.study.specimens)
    told = numbers(replace(results, study=replace(results.study, specimens=specimens)))
    assert told["claims.plate_r2.ours"] == pytest.approx(ours, nan_ok=True)
    assert told["claims.plate_r2.verdict"] == verdict


def test_every_claim_has_a_verdict_by_its_interval_and_a_link(written, read_page):
    page = read_page(written / "index.html")
    rows, on_data = [], 0
    for name in ("claims", "claims_on_settings"):
        on_data = len(rows)
        with (written / f"tables/{name}.csv").open(newline="") as file:
            rows += csv.DictReader(file)
    found = json.loads((written / "results.json").read_text())
    keys = [key.split(".")[1] for key in found if re.fullmatch(r"claims\..*\.verdict", key)]
    assert len(rows) == len(keys) >= 9
    for key in keys:
        low, high, margin = (found[f"claims.{key}.{part}"] for part in ("low", "high", "margin"))
        told = found[f"claims.{key}.verdict"]
        assert told in {"holds", "refuted", "not determined"}
        if told != "not determined":
            inside = low <= margin if told == "holds" else high < margin or low > margin
            assert inside or low > 0, key
    assert {"#participants", "#fits", "#hypotheses", "#profiles", "#schedules"} <= set(page.addresses)
    told = Counter(row["verdict"] for row in rows[:on_data])
    said = r"(\d+) holds?, (\d+) (?:is|are) refuted, (\d+) (?:is|are) not determined"
    counts = [int(n) for n in re.search(said, page.text).groups()]
    assert counts == [told[verdict] for verdict in ("holds", "refuted", "not determined")]


def test_lost_recordings_confirm_nothing(results, fits_of):
    """All presses of P01 on S3 and of P03 are lost: they may still come, and the claims on people are on two people."""
    trials = [
        t for t in results.people.trials if t.participant != "P03" and (t.participant, t.specimen) != ("P01", "S3")
    ]
    fits, study = fits_of(trials, results.study), results.study
    lost = hypotheses.test_hypotheses(fits, study.hypotheses, study.participants, study.palpated)
    assert set(lost.missing_cells) == {"P01 S3", "P03 S1", "P03 S2", "P03 S3", "P03 S5"}
    expected = {"P01 S1-S3", "P01 S3-S5", "P03 S1-S3", "P03 S1-S5", "P03 S3-S5"}
    assert set(lost.missing_pairs) == expected
    q = numbers_and_tables(with_people(results, fits=fits, hypotheses=lost)).quantities
    assert q["claims.curves.verdict"] == "not determined"
    assert q["claims.specimens_differ.verdict"] == "not determined"


def test_two_sections_may_not_give_the_same_name(results, monkeypatch):
    monkeypatch.setattr(study_report, "SECTIONS", (*study_report.SECTIONS, FITS))
    with pytest.raises(ValueError, match=r"section fits gives what another one gives: .*fit\.used"):
        contents(results)


def test_a_text_may_ask_for_what_there_is_alone_and_is_escaped(results):
    broken, content = replace(FITS, text="{{ q['fit.usedd'] | number }}"), contents(results)
    with pytest.raises(UndefinedError, match=r"fit\.usedd"):
        rendered(broken, results, content)
    made = rendered(replace(FITS, words=lambda r, q: {"name": "<S1>"}, text="{{ name }}"), results, content)
    assert "&lt;S1&gt;" in made
    assert "<S1>" not in made


def test_a_new_statistic_is_one_quantity_and_one_line_of_its_section(results, tmp_path, read_page, monkeypatch):
    """What a section's file must say, beside the stage's: the value, and where the text shows it."""

    def quantities(shown):
        yield from FITS.quantities(shown)
        yield "fit.a_not_positive", int(np.count_nonzero(shown.people.fits.a_v[shown.used] <= 0))

    text = FITS.text + "<p>Trials whose a is not positive: {{ q['fit.a_not_positive'] }}.</p>"
    more = replace(FITS, quantities=quantities, text=text)
    sections = tuple(more if section is FITS else section for section in study_report.SECTIONS)
    monkeypatch.setattr(study_report, "SECTIONS", sections)
    write_study_report(results, tmp_path)
    assert json.loads((tmp_path / "results.json").read_text())["fit.a_not_positive"] == 0
    assert r"\emgFitANotPositive}{0}" in (tmp_path / "numbers.tex").read_text()
    assert "Trials whose a is not positive: 0." in read_page(tmp_path / "index.html").text


def test_works_are_listed_where_the_methods_cite_them(written):
    text, bib = (written / "methods.txt").read_text(), (written / "references.bib").read_text()
    assert "(Kruskal and Wallis, 1952)" in text
    assert "@article{kruskal," in bib
    assert "doi = {10.1080/01621459.1952.10483441}" in bib
    assert "hertz" not in bib  # a study without runs cites no contact mechanics
    assert text.count("doi") + text.count("10.") >= bib.count("doi = ")


def test_terms_of_the_page_stand_in_the_glossary_in_the_same_words():
    glossary = (Path(__file__).parents[2] / "docs" / "glossary.md").read_text().splitlines()
    assert [row for term, meaning in TERMS if (row := f"| {term} | {meaning} |") not in glossary] == []


def test_errors_in_other_worlds_are_those_of_the_benchmark():
    told = json.loads((Path(__file__).parents[2] / "benchmarks" / "results" / "press_worlds.json").read_text())
    table = "\n".join(told["blocks"]).partition("Stiffness by world")[2].partition("\nkappa of S2")[0]
    rows = {line.split()[0]: line.split()[2:] for line in table.splitlines()[2:] if "->" not in line}
    exact = [float(row[0]) for row in rows.values()]
    assert [min(exact), max(exact)] == pytest.approx([100 * error for error in LAW_ERRORS])
