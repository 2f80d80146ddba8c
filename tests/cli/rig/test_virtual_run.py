"""``emg2vsa rig run --virtual``: all runs of the file on the emulated rig, those done before left out.

``emg2vsa rig run --all``: the whole experiment in its order, stopped and taken up again.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.rig.fault_case import read_log
from emg2vsa.errors import SettingError
from emg2vsa.lab import pressing
from emg2vsa.lab.pressed import Pressed
from emg2vsa.lab.pressing import Pressing
from emg2vsa.rig.plan import RunPlan
from emg2vsa.rig.record.ended import Ended
from emg2vsa.rig.record.new_folder import good_presses, how_ended
from emg2vsa.run_folders.presses import read_presses
from emg2vsa.schedule_files import write_schedule
from emg2vsa.worlds.bench.virtual_run import run_virtual
from tests.cli.rig.conftest import make_schedules

Rig = Callable[..., tuple[int, str, str]]
RigFile = Callable[..., Path]


def ends(err: str) -> list[str]:
    """What is said of each run, without the guards that are laxer than usual."""
    return [line for line in err.splitlines() if "rig.guards." not in line]


def test_all_runs_are_done_once(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    path, runs = rig_file(), tmp_path / "elsewhere"
    options = ("--virtual", "--out", runs, "--repetitions", 1, "--specimen", "S3")
    status, out, err = rig("run", path, *options, "--condition", "modular", "--jobs", 2)
    assert status == 0, err
    names = ["S3_0_modular", "S3_30_modular"]
    assert sorted(folder.name for folder in runs.iterdir()) == names
    assert [how_ended(runs / name) for name in names] == ["completed"] * 2
    assert sorted(line.split()[1] for line in err.splitlines()) == [f"{name}:" for name in names]
    assert err.splitlines()[1].startswith("2/2 ")
    assert out.startswith("guard: rig.guards.force_n = 50 protects less than 10, the default\n")
    table = [line for line in out.splitlines() if not line.startswith("guard: ")]
    assert table[:3] == [
        "presses done                         S3",
        "modular, 0 degrees                    1",
        "modular, 30 degrees                   1",
    ]
    assert sorted(line.split()[:3] for line in table[4:6]) == [[name, "1", "S3"] for name in names]
    assert table[4].endswith("ok: presses like S3")
    assert table[6].startswith("runs done: 2, ")
    logs = [(runs / name / "log.csv").read_bytes() for name in names]

    status, out, err = rig("run", path, *options, "--jobs", 1)
    assert status == 0
    assert len(ends(err)) == 1
    assert ends(err)[0].startswith("3/3 S3_0_high-stiffness: completed: 1 of 1 presses, ")
    assert [line for line in out.splitlines() if not line.startswith("guard: ")][1:4] == [
        "high-stiffness, 0 degrees             1",
        "modular, 0 degrees          done before",
        "modular, 30 degrees         done before",
    ]
    assert [(runs / name / "log.csv").read_bytes() for name in names] == logs
    assert read_log(runs / "S3_0_high-stiffness" / "log.csv")[-1].preset == 0


def test_every_mounting_has_a_folder_of_its_own(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    path, runs = rig_file(("repetitions = 2", "repetitions = 1\nmountings = 2")), tmp_path / "runs-virtual"
    options = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "high-stiffness")
    status, out, err = rig("run", path, *options)
    assert status == 0, err
    names = ["S3_0_high-stiffness", "S3_0_high-stiffness_mounting-2"]
    assert sorted(folder.name for folder in runs.iterdir()) == names
    assert ("high-stiffness, 0 degrees (2)", "1") in [tuple(row.rsplit(maxsplit=1)) for row in out.splitlines()]
    assert [press.mounting for press in read_presses([runs / name for name in names])] == [1, 2]
    status, _, err = rig("run", path, *options, "--mounting", 3)
    assert (status, "mounting: expected 1, 2, but found 3" in err) == (2, True)


def test_a_run_that_ends_early_is_told_and_done_again(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    options = ("--virtual", "--specimen", "S1", "--angle", 0, "--condition", "high-stiffness", "--repetitions", 1)
    far = rig_file(("gap_mm = 2", "gap_mm = 14.8"))
    far.write_text(far.read_text().replace("force_n = 50", "force_n = 50\ncontact_mm = 20"))
    status, out, err = rig("run", far, *options)
    assert status == 1
    assert "1/1 S1_0_high-stiffness: guard: travel in approach of press 1 (" in err
    assert "high-stiffness, 0 degrees     0, travel\n" in out
    assert rig("run", rig_file(), *options)[0] == 0
    assert how_ended(tmp_path / "runs-virtual" / "S1_0_high-stiffness-2") == "completed"
    status, out, _ = rig("run", rig_file(), *options, "--json")
    (press,) = json.loads(out)["presses"]  # the first run told no kappa
    assert (press["folder"], press["press"], press["verdict"]) == ("S1_0_high-stiffness-2", 1, "ok")
    assert press["low_n_per_mm"] < press["stated_n_per_mm"] == 7.63 < press["high_n_per_mm"]


def test_measured_runs_are_none_of_its_own(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    options = ("--specimen", "S1", "--angle", 0, "--condition", "high-stiffness", "--repetitions", 1)
    measured = tmp_path / "runs" / "S1_0_high-stiffness"
    measured.mkdir(parents=True)
    (measured / "ended.json").write_text('{"how": "completed", "repetitions_done": 2}')
    assert rig("run", rig_file(), "--virtual", *options)[0] == 0
    assert [path.name for path in (tmp_path / "runs").iterdir()] == [measured.name]
    assert rig("run", rig_file(), "--virtual", "--out", tmp_path / "runs", *options)[0] == 0
    assert sorted(path.name for path in (tmp_path / "runs").iterdir()) == [measured.name, f"{measured.name}-2"]


@pytest.mark.parametrize("how", ["interrupted", "full"])
def test_what_stops_one_run(how: str, rig: Rig, rig_file: RigFile, monkeypatch: pytest.MonkeyPatch) -> None:
    ran: list[Path] = []

    def run_virtual(plan: Any, rig: Any, emulated: Any, folder: Path, **other: Any) -> Ended:
        ran.append(folder)
        if how == "full":
            raise SettingError(folder, wanted="room", found="none", do="Free some.")
        return Ended("interrupted", "Ctrl-C", "", "load", 1, 1.0, "")

    monkeypatch.setattr(pressing, "run_virtual", run_virtual)
    status, out, err = rig("run", rig_file(), "--virtual", "--specimen", "S1", "--jobs", 1)
    if how == "interrupted":
        assert (status, len(ran)) == (130, 1)
    else:
        assert (status, len(ran)) == (1, 3)
        assert "not run. " in err
        assert out.count("not run") == 3


ALL = ("--all", "--virtual", "--jobs", 1)
LISTED = ("--all", "--order", "listed")
RUNS = ["S1_0_high-stiffness", "S3_0_high-stiffness", "S1_0_modular", "S3_0_modular", "S1_30_modular", "S3_30_modular"]


RANDOM = [
    "S3_30_modular",
    "S3_0_modular",
    "S1_0_high-stiffness",
    "S1_0_modular",
    "S1_30_modular",
    "S3_0_high-stiffness",
]
"""Of seed 0, for ever."""


def order_of(runs: Path) -> list[str]:
    kept = json.loads((runs / "order.json").read_text())
    return ["{specimen}_{angle_deg:g}_{condition}".format(**run) for run in kept["runs"]]


def places(runs: Path) -> dict[str, int]:
    return {path.parent.name: json.loads(path.read_text())["plan"]["order"] for path in runs.glob("*/plan.json")}


def test_a_random_order_is_kept_and_a_stopped_sequence_goes_on(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path, runs = rig_file(("repetitions = 2", "repetitions = 1")), tmp_path / "runs-virtual"
    done: list[str] = []

    def stopped(*arguments: Any, **options: Any) -> Any:
        if len(done) == 2:
            raise KeyboardInterrupt
        done.append(options["run"])
        return run_virtual(*arguments, **options)

    monkeypatch.setattr(pressing, "run_virtual", stopped)
    status, _, err = rig("run", path, *ALL, "--order", "random", "--seed", 3)
    assert status == 130, err
    order = order_of(runs)
    assert sorted(order) == sorted(RUNS)
    assert order != RUNS
    assert done == order[:2]

    monkeypatch.setattr(pressing, "run_virtual", run_virtual)
    status, out, err = rig("run", path, *ALL)
    assert status == 0, err
    said = [line for line in err.splitlines() if "rig.guards." not in line]
    assert [line.split()[1].rstrip(":") for line in said] == order[2:]
    assert places(runs) == {name: number for number, name in enumerate(order, start=1)}
    assert out.count("done before") == 2
    assert rig("run", path, *ALL)[0] == 0
    assert order_of(runs) == order


def test_runs_are_in_random_order_unless_the_rig_file_lists_them(
    rig: Rig, rig_file: Callable[..., Path], tmp_path: Path
) -> None:
    drawn = rig("dry-run", rig_file())[1].split("order of the runs: ")[1]
    assert drawn.startswith("random with seed 0\n")
    assert [line.split()[0] for line in drawn.splitlines() if "_0_" in line or "_30_" in line] == RANDOM
    other = rig("dry-run", rig_file(("[experiment]", "[experiment]\nseed = 1")), "--json")[1]
    assert json.loads(other)["seed"] == 1
    assert sorted(json.loads(other)["runs"]) == sorted(RUNS)
    assert json.loads(other)["sequence"] != RANDOM
    path = rig_file(("repetitions = 2", 'repetitions = 1\norder = "listed"'))
    assert json.loads(rig("dry-run", path, "--json")[1])["sequence"] == RUNS
    assert rig("run", path, *ALL)[0] == 0
    assert order_of(tmp_path / "runs-virtual") == RUNS


def test_a_run_that_goes_on_makes_other_presses(rig: Rig, rig_file: Callable[..., Path], tmp_path: Path) -> None:
    path, runs = rig_file(), tmp_path / "runs-virtual"
    one = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "modular")
    assert rig("run", path, *one, "--repetitions", 1)[0] == 0
    assert rig("run", path, *one)[0] == 0
    first, second = runs / "S3_0_modular", runs / "S3_0_modular-2"
    assert (good_presses(first), good_presses(second)) == (1, 1)
    assert (first / "log.csv").read_bytes() != (second / "log.csv").read_bytes()


@pytest.mark.parametrize(
    ("kept", "said"),
    [
        ("{", "expected an order as emg2vsa rig run writes it, but found "),
        ('{"order": "file", "seed": null, "runs": []}', "expected the 6 runs of the rig file, but found 0, not the"),
        ('{"order": "up", "seed": 1, "runs": []}', "found order 'up'."),
        (RUNS, "order.json: expected order random with seed 4, but found listed, begun."),
    ],
)  # fmt: skip
def test_another_order_than_the_one_that_is_kept_is_refused(
    kept: str | list[str], said: str, rig: Rig, rig_file: RigFile, tmp_path: Path
) -> None:
    (tmp_path / "runs-virtual").mkdir()
    asked = ("--order", "random", "--seed", 4) if isinstance(kept, list) else ()
    if isinstance(kept, list):
        runs = [dict(zip(("specimen", "angle_deg", "condition"), name.split("_"), strict=True)) for name in kept]
        kept = json.dumps({"order": "file", "seed": None, "runs": runs})
    (tmp_path / "runs-virtual" / "order.json").write_text(kept)
    status, _, err = rig("run", rig_file(), *ALL, *asked)
    assert status == 2
    assert said in err


class Rigged:
    """Ends of runs as they are told, and folders that say so."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, *ends: tuple[Any, ...]) -> None:
        self.ends, self.asked, self.pressed = list(ends), list[str](), list[tuple[str, int, int | None]]()
        monkeypatch.setattr(Pressing, "press", lambda pressing, *press: self.press(*press))
        monkeypatch.setattr("emg2vsa.cli.rig.choice._asked", self.answer)
        self.answers: list[str] = []

    def answer(self, question: str) -> str:
        self.asked.append(question)
        return self.answers.pop(0) if self.answers else ""

    def press(self, plan: RunPlan, folder: Path, kappa: None) -> Pressed:
        how, good, *away = self.ends.pop(0) if self.ends else ("completed", plan.repetitions)
        folder.mkdir(parents=True)
        (folder / "ended.json").write_text(json.dumps({"how": how, "repetitions_done": good}))
        self.pressed.append((folder.name, plan.repetitions, plan.order))
        retracted, deactivated = away or (True, True)
        left = {"retracted": retracted, "deactivated": deactivated}
        return Pressed(folder, Ended(how, "", "", "done", 1, 1.0, "", **left))


def test_rejected_presses_are_repeated_and_a_guard_ends_the_sequence(
    rig: Rig, rig_file: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    path = rig_file()
    bench = Rigged(monkeypatch, ("completed", 2), ("rejected", 1), ("completed", 1), ("guard", 1))
    status, out, err = rig("run", path, *LISTED)
    assert status == 1
    assert bench.pressed == [
        ("S1_0_high-stiffness", 2, 1), ("S3_0_high-stiffness", 2, 2), ("S3_0_high-stiffness-2", 1, 2),
        ("S1_0_modular", 2, 3),
    ]  # fmt: skip
    assert bench.asked[0].startswith("1/6: put S1 at 0 degrees under the rigid motor, 2 presses. Enter: press it; ")
    assert len(bench.asked) == 3  # not again for the press that was rejected
    assert out.endswith("2 of 6 runs are done; folder {}\n".format(path.parent / "runs"))
    assert "The sequence ends here; the same command takes it up again." in err

    bench.pressed.clear()
    bench.asked.clear()
    bench.answers = ["what", "", "s", "q"]
    assert rig("run", path, *LISTED)[0] == 1
    assert bench.pressed == [("S1_0_modular-2", 1, 3)]
    assert len(bench.asked) == 4
    assert bench.asked[0].startswith("3/6: put S1 at 0 degrees under the qbmove (modular), 1 presses. ")

    assert rig("run", path, *LISTED, "--yes", "--json")[0] == 0
    assert how_ended(path.parent / "runs" / "S3_30_modular") == "completed"


@pytest.mark.parametrize("left", [(False, True), (True, False)])
def test_a_probe_that_was_left_on_the_specimen_ends_the_sequence(
    left: tuple[bool, bool], rig: Rig, rig_file: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Though all its presses are whole."""
    path = rig_file()
    bench = Rigged(monkeypatch, ("completed", 2), ("rejected", 2, *left))
    status, _, err = rig("run", path, *LISTED, "--yes")
    assert status == 1
    assert [name for name, *_ in bench.pressed] == ["S1_0_high-stiffness", "S3_0_high-stiffness"]
    assert "was left with the probe NOT retracted, or motors NOT confirmed off. " in err
    assert f"Switch off with emg2vsa rig off {path}" in err


def test_a_session_with_a_rejected_press_says_so_by_its_status(
    rig: Rig, rig_file: Callable[..., Path], monkeypatch: pytest.MonkeyPatch
) -> None:
    bench = Rigged(monkeypatch, ("rejected", 1))
    status, out, _ = rig("run", rig_file(), *LISTED, "--yes")
    assert (status, len(bench.pressed)) == (1, 7)
    assert out.startswith("6 of 6 runs are done")


def test_presses_made_in_another_way_are_not_mixed(rig: Rig, rig_file: RigFile) -> None:
    path = rig_file()
    one = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "modular")
    assert rig("run", path, *one, "--repetitions", 1)[0] == 0
    plan, text = path.parent / "runs-virtual" / "S3_0_modular" / "plan.json", path.read_text()
    for change, said in (
        (("f_max_n = 5", "f_max_n = 4"), "f_max_n = 4.0, as the rig file and its schedules say now, but found 5.0."),
        (("[rig.guards]", "[rig]\nfilter_samples = 3\n[rig.guards]"), "filter_samples = 3, as the rig file"),
    ):
        path.write_text(text.replace(*change))
        status, _, err = rig("run", path, *one)
        assert (status, f"{plan}: expected {said}" in err) == (2, True)
    path.write_text(text)
    document = json.loads(plan.read_text())
    document["plan"]["schedule"]["steps"][0]["preset_ticks"] += 10
    plan.write_text(json.dumps(document))
    status, _, err = rig("run", path, *one)
    assert (status, "plan.json: expected preset_ticks of the schedule = [" in err) == (2, True)


def test_presses_go_on_after_the_interval_of_their_schedule_has_changed(rig: Rig, rig_file: RigFile) -> None:
    path = rig_file()
    one = ("--virtual", "--specimen", "S3", "--angle", 0, "--condition", "modular", "--repetitions")
    (schedule,) = (s for s in make_schedules() if s.specimen == "S3")
    low, high = np.min(schedule.stiffness_percent), np.max(schedule.stiffness_percent)
    for repetitions in (1, 2):
        ends = schedule.stiffness_percent + np.array([[-0.1], [0.1]]) * repetitions
        write_schedule(path.parent / "schedules", replace(schedule, interval_percent=np.clip(ends, low, high)))
        status, _, err = rig("run", path, *one, repetitions)
        assert status == 0, err
