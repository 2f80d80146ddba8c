"""``emg2vsa rig dry-run``: limits and legs of each run, and what is said where there is none.

``--json``: one JSON object of what the words say, for every command of the rig.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

from emg2vsa.schedule_files import read_json

RigFile = Callable[..., Path]
Rig = Callable[..., tuple[int, str, str]]


def test_limits_legs_and_times(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    status, out, _ = rig("dry-run", rig_file(), "--specimen", "S1", "--details")
    assert status == 0
    assert out.startswith(
        "positions: -131.836 to 131.836 degrees\npresets: 20 to 80 % of the full one\n"
        "travel: 15 mm, +75 degrees from home\nforce: 50 N, 3000 N/s\n"
    )
    assert "\nS1_0_high-stiffness: 2 presses, at most 7.8 s\n" in out
    assert "\n  approach             0 to 75              0       0 to 0.5        1.88\n" in out
    preset = 100 * read_json(tmp_path / "schedules" / "S1_modular.json").preset[15]  # from 5.0 N on
    assert f"\n  retract              75 to 0{preset:>15.4g}                       1.88\n" in out
    assert out.endswith("\n3 runs, at most 0.4 min; nothing was sent\n")


def test_one_line_a_run(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    status, out, _ = rig("dry-run", rig_file(), "--specimen", "S1")
    assert status == 0
    presets = 100 * read_json(tmp_path / "schedules" / "S1_modular.json").preset[:16]  # up to 5.0 N
    lines = out.splitlines()
    lax = [line for line in lines if "protects less than" in line]
    assert "rig.guards.force_n = 50 protects less than 10, the default" in lax
    lines = [line for line in lines if line not in lax]
    assert lines[6].split()[:3] == ["run", "presses", "position,"]
    rows = {line.split()[0]: line.split() for line in lines[7:10]}
    rigid, modular = rows["S1_0_high-stiffness"], rows["S1_0_modular"]
    # to expect, with motors that may be following_s = 0.2 s behind, and a bus 0.02 s
    assert 5.0 < float(rigid.pop(-2)) < 10.5
    assert 5.0 < float(modular.pop(-2)) < 10.5
    assert rigid == ["S1_0_high-stiffness", "2", *["0", "to", "75", "0", "to", "0", "0", "to", "5", "7.8"]]
    assert modular == [
        "S1_0_modular", "2",
        *["0", "to", "75", f"{presets.min():.4g}", "to", f"{presets.max():.4g}", "0", "to", "5", "7.8"],
    ]  # fmt: skip
    assert len(lines) == 12


def test_as_json(rig: Rig, rig_file: RigFile) -> None:
    status, out, _ = rig("dry-run", rig_file(), "--json")
    assert status == 0
    runs = json.loads(out)["runs"]
    assert sorted(runs) == [
        "S1_0_high-stiffness", "S1_0_modular", "S1_30_modular", "S3_0_high-stiffness", "S3_0_modular", "S3_30_modular",
    ]  # fmt: skip
    legs = runs["S1_30_modular"]["legs"]
    assert [leg["force_n"] for leg in legs if leg["phase"] == "load"][-1] == [4.7, 5.0]
    assert runs["S1_30_modular"]["at_most_s"] == pytest.approx(2 * (1.875 + 1.875 + 0.05 + 0.1))


def test_a_run_that_breaks_a_limit_is_told_beside_the_others(rig: Rig, rig_file: RigFile) -> None:
    path = rig_file(("[rig.guards]", "[rig]\nmax_preset_ticks = 2800\n[rig.guards]"))
    status, out, _ = rig("dry-run", path, "--specimen", "S1")
    assert status == 1
    assert (
        "S1_0_modular: not possible. schedule of S1, modular, stiffness preset: expected 20 to 80 % of the device's "
        "maximum, but found 85.7143 %." in out
    )
    assert "S1_0_high-stiffness " in out


def test_schedules_that_are_absent_are_named(rig: Rig, rig_file: RigFile, tmp_path: Path) -> None:
    path = rig_file()
    (tmp_path / "schedules" / "S3_modular.json").unlink()
    status, _, err = rig("dry-run", path)
    assert status == 2
    assert err.endswith(
        "schedules: expected a schedule for every specimen and condition, 2 files, but found no S3_modular.json. "
        "Export them with emg2vsa schedule STUDY, or correct [experiment].\n"
    )
    assert rig("dry-run", path, "--specimen", "S1")[0] == 0
    assert rig("dry-run", path, "--condition", "high-stiffness")[0] == 0


def test_a_bad_rig_file_is_told_line_by_line(rig: Rig, rig_file: RigFile) -> None:
    status, out, err = rig("dry-run", rig_file(("f_max_n = 5", "f_max = 5\ncontact_s = -1")))
    assert (status, out) == (2, "")
    assert [line.partition("rig.toml:")[2] for line in err.splitlines()[:-1]] == [
        "33: experiment.f_max: expected a known key, but found 'f_max'. Did you mean 'f_max_n'?",
        "34: experiment.contact_s: expected a number >= 0, but found -1.",
    ]
    assert err.endswith("2 problems; nothing was run.\n")


def test_motors_that_are_not_known_to_be_off(rig: Rig, rig_file: Callable[..., Path]) -> None:
    status, out, err = rig("off", rig_file(), "--json")
    assert (status, err) == (1, "")
    told = json.loads(out)["devices"]
    assert [(each["device"], each["at"]) for each in told] == [("actuator", None), ("motor", None)]
    assert told[0]["problem"].startswith("/dev/no-such-port: expected a serial port")


def test_the_address_of_a_page(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pages = import_module("emg2vsa.live.watch_routes")
    monkeypatch.setattr(pages, "serve", lambda routes, at, ready: ready("http://127.0.0.1:1/x"))
    status, out, _ = rig("watch", tmp_path, "--port", 0, "--json")
    assert (status, json.loads(out)) == (0, {"folder": str(tmp_path.resolve()), "address": "http://127.0.0.1:1/x"})
