"""The authors' package of a study that was run: complete, traceable, LaTeX that compiles, the same bytes every time."""

from __future__ import annotations

import csv
import hashlib
import json
import re
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from emg2vsa.cli import main

EXACT = ("--paper", "--jobs", "1", "--json")


def contents(folder: Path) -> dict[str, bytes]:
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.fixture(scope="module")
def package(packaged_once: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    root = tmp_path_factory.mktemp("package")
    shutil.copytree(packaged_once, root, dirs_exist_ok=True)
    return root / "reports" / "small" / "paper"


def test_every_number_table_and_figure_of_the_report_is_there(package: Path) -> None:
    found, report = contents(package), contents(package.parent)
    kept = {
        name for name in report
        if not name.startswith((".", "paper/", "participants/")) and not name.endswith((".html", ".svg"))
    }  # fmt: skip
    assert kept <= set(found)
    assert all(found[name] == report[name] for name in kept)
    numbers = found["numbers.tex"].decode()
    with (package / "results.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["key"] for row in rows] == list(json.loads(found["results.json"]))
    assert all(rf"\newcommand{{{row['macro']}}}" in numbers for row in rows)


def test_a_second_run_gives_identical_bytes(package: Path) -> None:
    before = contents(package)
    assert main(["report", str(package.parents[2] / "studies/small/study.toml"), *EXACT]) == 0
    assert contents(package) == before


def test_another_folder_and_two_processes_give_identical_bytes(
    package: Path, simulated: Path, ran_once: Path, tmp_path: Path
) -> None:
    study = tmp_path / "studies" / "small" / "study.toml"
    shutil.copytree(simulated, study.parent)
    assert main(["run", str(study), "--jobs", "2", "--json"]) == 0
    assert contents(tmp_path / "reports") == contents(ran_once / "reports")
    assert main(["report", str(study), "--out", str(tmp_path / "out"), *EXACT]) == 0
    assert contents(tmp_path / "out") == contents(package)


def test_every_number_leads_to_steps_and_on_to_the_recordings(package: Path) -> None:
    provenance = json.loads((package / "provenance.json").read_text())
    steps = provenance["steps"]
    assert set(provenance["numbers"]) == set(json.loads((package / "results.json").read_text()))

    def files_behind(step: str) -> set[str]:
        found = set(steps[step]["files"])
        for name, key in steps[step]["inputs"].items():
            assert steps[name]["result"] == key
            found |= files_behind(name)
        return found

    recordings = {name for step in steps.values() for name in step["files"]}
    assert len([name for name in recordings if name.endswith("_emg.bdf")]) == 6
    assert not [name for name in recordings if name.startswith("/")]
    for key, made_by in provenance["numbers"].items():
        assert made_by, key
        assert {name for step in made_by for name in files_behind(step)} <= recordings
    assert provenance["numbers"]["fit.S1.b_v.mean"] == ["fits/P01/S1", "fits/P02/S1"]
    assert provenance["numbers"]["hypotheses.worst_p"] == ["hypotheses/study"]
    assert files_behind("hypotheses/study") >= {name for name in recordings if name.endswith("_emg.bdf")}


def test_the_supplement_is_the_folder_as_a_research_object(package: Path) -> None:
    archive = zipfile.ZipFile(package / "supplement.zip")
    loose = {name: data for name, data in contents(package).items() if name != "supplement.zip"}
    assert {name: archive.read(name) for name in archive.namelist()} == loose
    crate = json.loads(loose["ro-crate-metadata.json"])
    entities = {entity["@id"]: entity for entity in crate["@graph"]}
    files = {e["name"]: e["sha256"] for e in crate["@graph"] if e["@type"] == "File"}
    assert files == {
        name: hashlib.sha256(data).hexdigest() for name, data in loose.items() if name != "ro-crate-metadata.json"
    }
    taken = [entities[link["@id"]] for link in entities["#run"]["object"]]
    base = package.parents[2] / "studies" / "small"
    for one in taken:
        assert one["sha256"] == hashlib.sha256((base / one["name"]).read_bytes()).hexdigest()
    assert len(taken) > 6
    assert "The recordings were simulated" in entities["./"]["description"]


def test_latex_is_closed_escaped_and_takes_only_the_packages_it_names(package: Path) -> None:
    for path in package.rglob("*.tex"):
        text = path.read_text()
        assert not re.findall(r"[^\x00-\x7F\xA0-\xFF\u2018\u2019]", text), path.name  # what pdflatex cannot set
        plain = re.sub(r"\\[{}%&_#$]", "", text)
        plain = "\n".join(line.partition("%")[0] for line in plain.splitlines())
        assert plain.count("{") == plain.count("}"), path.name
        opened = re.findall(r"\\(begin|end)\{(\w+\*?)\}", plain)
        stack: list[str] = []
        for kind, name in opened:
            if kind == "begin":
                stack.append(name)
            else:
                assert stack.pop() == name
        assert not stack, path.name
        takes = text.partition("\n")[0]
        for command, needed in (
            (r"\toprule", "booktabs"), (r"{tabularx}", "tabularx"), (r"{longtable}", "longtable"),
            (r"{landscape}", "lscape"), (r"\includegraphics", "graphicx"),
        ):  # fmt: skip
            assert command not in plain or needed in takes or path.name == "proof.tex", (path.name, needed)


def test_table_rows_have_as_many_cells_as_columns(package: Path) -> None:
    tables = list((package / "tables").glob("*.tex"))
    assert len(tables) >= 10
    for path in tables:
        text = re.sub(r">\{\\raggedright\\arraybackslash\}", "", path.read_text()).replace(r"\&", "")
        columns = len(re.search(r"\\begin\{(?:tabularx?|longtable)\}(?:\{\\linewidth\})?\{([lrX]+)\}", text)[1])
        rows = [line for line in text.splitlines() if " & " in line]
        assert {row.count(" & ") + 1 for row in rows} == {columns}, path.name


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="no pdflatex here")
def test_the_proof_compiles(package: Path, tmp_path: Path) -> None:
    done = subprocess.run(
        ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", f"-output-directory={tmp_path}", "proof.tex"],
        cwd=package, capture_output=True, text=True, errors="replace",
    )  # fmt: skip
    assert done.returncode == 0, done.stdout[-2000:]
    assert (tmp_path / "proof.pdf").stat().st_size > 10_000


def test_what_only_an_earlier_package_held_goes(package: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    study = str(package.parents[2] / "studies/small/study.toml")
    assert main(["report", study, "--out", str(out), *EXACT]) == 0
    crate = out / "ro-crate-metadata.json"
    text = crate.read_text().replace('"@id": "methods.txt"', '"@id": "figures/old.pdf"')
    crate.write_text(text.replace('"@id": "numbers.tex"', '"@id": "../outside.txt"'))
    (out / "figures" / "old.pdf").write_text("old")
    (tmp_path / "outside.txt").write_text("not ours")
    (out / "notes.txt").write_text("the author's own")
    assert main(["report", study, "--out", str(out), *EXACT]) == 0
    assert set(contents(out)) - set(contents(package)) == {"notes.txt"}
    assert (tmp_path / "outside.txt").exists()


def test_a_folder_with_other_files_is_left_alone(package: Path, tmp_path: Path, capsys: pytest.CaptureFixture) -> None:
    (tmp_path / "numbers.tex").write_text("mine")
    study = str(package.parents[2] / "studies/small/study.toml")
    assert main(["report", study, "--paper", "--out", str(tmp_path)]) == 2
    assert "expected an empty folder" in capsys.readouterr().err
    assert contents(tmp_path) == {"numbers.tex": b"mine"}


@pytest.mark.parametrize("option", [["--out", "x"], ["--published", "2026-01-31"], ["--licence", "CC0"]])
def test_options_of_the_package_alone_are_one_clear_line(option: list[str], capsys: pytest.CaptureFixture) -> None:
    assert main(["report", "absent.toml", *option]) == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_date_and_licence_are_the_authors_to_say(package: Path, tmp_path: Path) -> None:
    study = str(package.parents[2] / "studies/small/study.toml")
    said = ["--published", "2026-01-31", "--licence", "https://creativecommons.org/licenses/by/4.0/"]
    assert main(["report", study, "--out", str(tmp_path / "out"), *said, *EXACT]) == 0
    (root,) = (
        entity for entity in json.loads((tmp_path / "out/ro-crate-metadata.json").read_text())["@graph"]
        if entity["@id"] == "./"
    )  # fmt: skip
    assert root["datePublished"] == "2026-01-31"
    assert root["license"] == {"@id": "https://creativecommons.org/licenses/by/4.0/"}
    assert "Not published yet" not in root["description"]
    with pytest.raises(SystemExit):
        main(["report", study, "--paper", "--published", "31.1.2026"])
