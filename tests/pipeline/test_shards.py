"""Several processes write one store at once, each its share; the outcome is that of one run, byte for byte."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from emg2vsa.cli import main
from emg2vsa.pipeline.campaign import campaign
from emg2vsa.pipeline.fingerprint import Fingerprints, part_of
from emg2vsa.pipeline.ledger import Entry, Ledger, Parts
from emg2vsa.pipeline.shard import Shard, group_of, shared_stages
from emg2vsa.pipeline.stage_order import ORDER, items
from emg2vsa.study_file import load_study

RUN = [sys.executable, "-m", "emg2vsa.cli", "run", "--jobs", "1"]
STORE = "studies/small/.emg2vsa/small/store"


def outcome(study: Path) -> dict[str, bytes]:
    """Every stored result and every written file of a study; no locks, which tell of processes."""
    loaded = load_study(study)
    parts = (loaded.results / "store", loaded.reports, study.parent / "runs-virtual")
    files = (path for part in parts for path in part.rglob("*") if path.is_file() and not path.name.startswith("."))
    return {path.relative_to(study.parents[2]).as_posix(): path.read_bytes() for path in files}


def emptied(study: Path) -> dict[str, bytes]:
    """Nothing was run yet; the outcome of the run that was."""
    before = outcome(study)
    for part in (study.parent / ".emg2vsa", load_study(study).reports, study.parent / "runs-virtual"):
        shutil.rmtree(part)
    return before


def shard(study: Path, number: int, of: int, *more: str) -> subprocess.Popen[str]:
    command = [*RUN, *more, "--shard", f"{number}/{of}", str(study)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def killed_at_work(process: subprocess.Popen[str], study: Path) -> None:
    """Kill a shard with SIGKILL while it works at a step."""
    under_way = study.parent / ".emg2vsa" / "small" / "under-way"
    end = time.monotonic() + 60
    while not list(under_way.glob("*.json")) and time.monotonic() < end:
        assert process.poll() is None, process.communicate()
        time.sleep(0.002)
    process.kill()
    process.communicate()


def test_each_step_is_in_one_shard_together_with_what_it_goes_with(study: Path) -> None:
    found = campaign(load_study(study))
    for name in shared_stages(ORDER):
        if name in ("exemplary", "profiles", "schedules"):
            continue
        for item in items(found, name):
            owners = [number for number in (1, 2, 3) if Shard(number, 3).has(found, name, item)]
            assert len(owners) == 1
            assert Shard(owners[0], 3).has(found, "runs", group_of(found, name, item))
    assert group_of(found, "trials", "P02/S1") == group_of(found, "fits", "P02/S3") == group_of(found, "pages", "P02")
    assert group_of(found, "emulation", "S1_0_modular") == group_of(found, "runs", "S1_0_modular") == "S1_0_modular"


def test_one_shard_after_the_other_gives_what_one_run_gives(study: Path) -> None:
    before = emptied(study)
    for number in (1, 2):
        assert main(["run", str(study), "--only", "fits", "--jobs", "1", "--shard", f"{number}/2", "--json"]) == 0
    assert main(["run", str(study), "--only", "fits", "--jobs", "1", "--json"]) == 0
    after = outcome(study)
    assert len(after) == 6 + 6
    assert {path: before[path] for path in after} == after
    assert not list((study.parent / ".emg2vsa" / "small").glob("*shard*"))


@pytest.mark.slow
def test_two_at_once_one_of_them_killed_and_run_again_give_what_one_run_gives(study: Path) -> None:
    before = emptied(study)
    first = shard(study, 1, 2, "--human-only")
    killed_at_work(first, study)
    both = [shard(study, number, 2, "--human-only") for number in (1, 2)]
    told = [process.communicate() for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    assert all("This shard is done. When all shards are: emg2vsa run " in out for out, _ in told)
    results = study.parent / ".emg2vsa" / "small"
    assert sorted(path.name for path in results.glob("ledger*")) == [
        "ledger.shard-1-of-2.jsonl",
        "ledger.shard-2-of-2.jsonl",
    ]
    ended = {step for step in Ledger(results).steps() if step.startswith(("trials", "fits", "pages"))}
    assert len(ended) == 6 + 6 + 2
    assert main(["run", str(study), "--human-only", "--jobs", "1", "--json"]) == 0
    after = outcome(study)
    parts = ("trials", "fits", "pages", "hypotheses", "exemplary", "profiles", "schedules")
    wanted = {path for path in before if path.startswith(tuple(f"{STORE}/{part}/" for part in parts))}
    assert len(wanted) == 6 + 6 + 2 + 4
    assert {path: before[path] for path in wanted} == {path: after.get(path) for path in wanted}
    assert [path.name for path in results.glob("*shard*")] == []
    assert list((results / "under-way").iterdir()) == []


def test_runs_wait_for_schedules_and_a_run_of_the_whole_finds_shards_fresh(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.rmtree(study.parent / ".emg2vsa" / "small" / "store" / "schedules")
    capsys.readouterr()
    left = []
    for number in (1, 2):
        assert main(["run", str(study), "--jobs", "1", "--shard", f"{number}/2", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["ran"] == []
        assert told["needs"] == ["schedules"]
        left += told["left"]
    assert sorted(left) == sorted(
        f"{s}/{i}_0_modular" for s in ("emulation", "runs") for i in ("S1", "S3", "S5", "S_new")
    )
    assert main(["run", str(study), "--jobs", "1", "--shard", "1/2"]) == 0
    assert "--only schedules, then the shards again.\n" in capsys.readouterr().out
    assert main(["run", str(study), "--jobs", "1", "--only", "schedules", "--json"]) == 0
    capsys.readouterr()
    for number in (1, 2):
        assert main(["run", str(study), "--jobs", "1", "--shard", f"{number}/2", "--json"]) == 0
        told = json.loads(capsys.readouterr().out)
        assert told["ran"] == told["left"] == []


def test_a_shard_takes_no_schedules_of_other_settings(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = study.read_text()
    study.write_text(text + "[schedule]\nstep_n = 0.5\n")
    capsys.readouterr()
    assert main(["run", str(study), "--jobs", "1", "--shard", "1/1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["needs"] == ["schedules"]


def test_a_damaged_ledger_of_a_shard_costs_its_lines_and_no_more(
    study: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    results = study.parent / ".emg2vsa" / "small"
    shutil.rmtree(results)
    assert main(["run", str(study), "--only", "fits", "--jobs", "1", "--shard", "1/1", "--json"]) == 0
    path = results / "ledger.shard-1-of-1.jsonl"
    lines = path.read_bytes().split(b"\n")
    lines[-3] = lines[-3].replace(b"done", b"dome")
    path.write_bytes(b"\n".join(lines))
    (results / "fingerprints.shard-1-of-1.json").write_text("[1]")
    capsys.readouterr()
    assert main(["run", str(study), "--only", "fits", "--jobs", "1", "--json"]) == 0
    told = capsys.readouterr()
    assert f"{path} is damaged: 1 line left out." in told.err
    assert "fingerprints.shard-1-of-1.json is damaged" in told.err
    assert json.loads(told.out)["failures"] == []
    assert not list(results.glob("*shard*"))
    assert main(["run", str(study), "--only", "fits", "--jobs", "1", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["ran"] == []


def test_memories_of_shards_are_taken_in_and_a_shard_keeps_only_what_is_its_own(tmp_path: Path) -> None:
    for name in ("old", "new"):
        (tmp_path / name).write_text(name)
    whole, own = tmp_path / "whole.json", tmp_path / "own.json"
    prints = Fingerprints(whole)
    digests = [prints.file(tmp_path / "old")]
    prints.save()
    prints = Fingerprints(own, beside=[whole])
    digests.append(prints.file(tmp_path / "new"))
    prints.save()
    assert str(tmp_path / "old") not in own.read_text()
    prints = Fingerprints(whole, beside=[own])
    prints.take_in()
    assert not own.exists()
    assert [str(tmp_path / name) in whole.read_text() for name in ("old", "new")] == [True, True]
    assert [Fingerprints(whole).file(tmp_path / name) for name in ("old", "new")] == digests


@pytest.mark.parametrize("text", ["0/2", "3/2", "1", "1/0", "a/b", "1/2/3", "-1/2", ""])
def test_a_shard_that_is_none_is_refused(study: Path, text: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as error:
        main(["run", str(study), f"--shard={text}"])
    assert error.value.code == 2
    assert f"expected I/N with I from 1 to N, such as 3/16, but found {text!r}" in capsys.readouterr().err


def test_a_shard_is_no_cluster(study: Path, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        main(["run", str(study), "--shard", "1/2", "--cluster", "local"])
    assert "not allowed with argument" in capsys.readouterr().err


@pytest.mark.slow
def test_everything_in_shards_is_everything_in_one_run(study: Path) -> None:
    before = emptied(study)
    for command in (["--only", "schedules"], []):
        both = [shard(study, number, 2) for number in (1, 2)]
        told = [process.communicate() for process in both]
        assert [process.returncode for process in both] == [0, 0], told
        assert main(["run", str(study), *command, "--jobs", "1", "--json"]) == 0
    assert outcome(study) == before


def test_of_two_shards_of_other_numbers_the_newer_ledger_counts(tmp_path: Path) -> None:
    part = part_of({"a": "1"})
    parts = Parts(part, {}, {}, part, part)
    for age_s, shard, status in ((20, "shard-3-of-3", "failed"), (10, "shard-1-of-4", "done")):
        Ledger(tmp_path, shard=shard).record(Entry("trials/P/S", "k", status, "", False, "r", parts))
        moment = time.time() - age_s
        os.utime(tmp_path / f"ledger.{shard}.jsonl", (moment, moment))
    ledger = Ledger(tmp_path)
    entry = ledger.with_key("trials/P/S", "k")
    assert entry is not None
    assert entry.status == "done"
    ledger.compact()
    assert [path.name for path in tmp_path.iterdir()] == ["ledger.jsonl"]
    assert Ledger(tmp_path).with_key("trials/P/S", "k") is not None
