"""What commands on recordings, studies and sessions refuse: one line that says which, what was wanted, and found."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from pathlib import Path

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa.cli import main
from tests.small import study_of_files

REFUSED = """
inspect none.csv                                | No such file or directory
inspect empty                                   | expected recordings, but found a folder without any
inspect raw/bob_soft.csv --fs -1                | --fs: expected a rate above 0 Hz
inspect raw/bob_soft.csv --max-seconds 0        | emg2vsa inspect: reading.max_seconds: expected a number >= 1
new none                                        | expected a folder of recordings, but found no folder
new empty                                       | found a folder without any
new texts                                       | found none that can be read
new raw --stiffness hard                        | --stiffness: expected NAME=NUMBER
new raw --stiffness foam=3                      | expected a specimen that the files name (hard, soft), but found 'foam'
new raw --fs 0                                  | --fs: expected a rate above 0 Hz
run absent.toml                                 | absent.toml: expected a study file
run study.toml --timeout 3                      | emg2vsa run --timeout: expected --scheduler or --cluster, but found neither.
run study.toml --timeout 3 --jobs 2             | emg2vsa run --timeout: expected --scheduler or --cluster, but found neither.
run study.toml --scheduler a:1 --jobs 2         | expected workers of the scheduler alone, but found --jobs.
check study.toml P99                            | P99
check study.toml --watch absent                 | a folder to watch
check study.toml --watch empty                  | a folder to which none of them belongs
tools power --rho 1                             | power, rho: expected a correlation from 0 to below 1
tools convert raw/bob_soft.csv --out b          | found no --emg, --force, --participant
tools convert study.toml --out b --task a_b -q  | --task: expected letters and digits only
tools convert study.toml --out b --electrode-distance 0 | --electrode-distance: expected millimetres above 0
tools convert study.toml --out b --about study.toml | expected a JSON object
tools convert study.toml --out b --about none.json  | expected a JSON object, but found No such file or directory
tools convert none.toml --out b                 | expected a study file
tools stiffness one.csv                         | one.csv: expected a header row that names depth and force, such as indentation_mm
tools stiffness depth.csv --depth Weg           | depth.csv: expected a header row that names Weg and force, but found
tools stiffness depth.csv --force depth_mm      | line 1, column 'depth_mm': expected a unit of force, such as N, but found 'mm'
tools stiffness depth.csv --from 3 --to 1       | range of force: expected 0 < F0 < F1, newtons, but found 3 to 1
tools stiffness depth.csv --mountings=-1        | --mountings: expected a standard deviation between 0 and 100, in percent of kappa, but
tools stiffness depth.csv --castings 100        | --castings: expected a standard deviation between 0 and 100, in percent of kappa, but
tools stiffness depth.csv --study sized.toml    | sized.toml, specimens[0].diameter_mm: expected a number > 0, but found -5
tools stiffness depth.csv --study t.csv         | t.csv
tools stiffness depth.csv --write session.toml  | session.toml, specimens: expected a specimen depth, but found
tools sample slopes --out study.toml            | expected a folder, but found a file
stats t.csv --value bb --group g                | Did you mean 'b'?
stats t.csv --value g --group who               | line 2, column 'g'
stats t.csv --value b --group b                 | different columns
stats t.csv --value b --group g --alpha 2       | --alpha
stats t.csv --value b --group g --margin -1     | --margin
stats absent.csv --value b --group g            | absent.csv
stats one.csv --value b --group g               | found one, 'x'
session session.toml --participant P09          | expected one of P03
session session.toml PERSON                         | expected a device
session session.toml PERSON --no-page               | --no-page: expected --virtual
session session.toml PERSON --speed 2               | --speed: expected --virtual
session session.toml PERSON --virtual --speed 1000  | 0.1 to 100
session session.toml PERSON --virtual --seed -1     | --seed
session session.toml PERSON --virtual --no-page --mistake sneeze@1 | --mistake
session session.toml PERSON --virtual --no-page --truth no/such/folder/truth.json | no such folder
session session.toml PERSON --virtual --no-page --resume | a session to resume
session session.toml PERSON --virtual --bind everywhere | --bind
session simulation.toml PERSON                      | a table [session]
session finish simulation.toml PERSON               | a table [session]
session finish session.toml PERSON                  | expected the folder of a session, but found none
session replay session.toml nowhere             | nowhere: expected the folder of a session, but found none
session replay session.toml empty --line 0      | plan.json: expected the plan of a session
"""  # noqa: E501
MISSPELT = """
run study.toml --scheduler=here       | expected an address such as tcp://10.0.0.1:8786, but found 'here'
run study.toml --scheduler=ftp://a:1  | expected an address such as
run study.toml --cluster=slurm        | expected local or local:N with N from 1, but found 'slurm'
run study.toml --cluster=local:0      | expected local or local:N
run study.toml --timeout=soon         | expected a number of seconds above 0, but found 'soon'
run study.toml --timeout=0            | expected a number of seconds above 0
run study.toml --profile=yes          | --profile
tools sample pres --out new           | but found 'pres'. Did you mean presses?
session rnu session.toml PERSON           | but found 'rnu'. Did you mean run?
session replay session.toml . --line last | --line
"""


@pytest.fixture
def lab(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder with studies, tables and recordings of every kind."""
    monkeypatch.chdir(tmp_path)
    simulation = small_study(participants=["P03"], specimens=["S1"])
    files = {
        "raw/ama_hard.csv": "time (s),EDC (V),Fz (N)\n0,0.1,0\n0.001,0.2,1\n0.002,0.1,0\n",
        "texts/a.txt": "not a\nrecording\n", "study.toml": study_of_files(), "simulation.toml": simulation,
        "session.toml": f"{simulation}[session]\n{SIMULATED_SESSION}", "depth.csv": "depth_mm,force_n\n0,0\n1,1\n",
        "sized.toml": '[[specimens]]\nname = "depth"\ndiameter_mm = -5\nheight_mm = 3\n',
        "t.csv": "who,g,b\nP1,x,1\nP1,y,2\nP2,x,3\nP2,y,5\n", "one.csv": "g,b\nx,1\nx,2\n",
    }  # fmt: skip
    for name, text in (files | {"raw/bob_soft.csv": files["raw/ama_hard.csv"]}).items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    (tmp_path / "empty").mkdir()
    return tmp_path


def cases(table: str) -> Iterator[object]:
    for row in table.strip().splitlines():
        words, _, said = row.replace("PERSON", "--participant P03").partition("|")
        yield pytest.param(shlex.split(words), said.strip(), id=words.strip())


@pytest.mark.parametrize(("words", "said"), [*cases(REFUSED)])
def test_bad_input_is_one_line(lab: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    assert main(words) == 2
    found = capsys.readouterr()
    assert said in found.err
    assert (found.out, found.err.replace("1 problem; nothing was run.\n", "").count("\n")) == ("", 1)
    assert {path.name for path in lab.iterdir()} - {".emg2vsa"} == {
        "raw", "texts", "empty", "study.toml", "session.toml", "simulation.toml", "depth.csv", "t.csv", "one.csv",
        "sized.toml",
    }  # fmt: skip


@pytest.mark.parametrize(("words", "said"), [*cases(MISSPELT)])
def test_what_is_misspelt_is_named(lab: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    with pytest.raises(SystemExit, match="2"):
        main(words)
    assert said in " ".join(capsys.readouterr().err.split())
