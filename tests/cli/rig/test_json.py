"""``--json``: one JSON object of what the words say, for every command of the rig."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from emg2vsa.devices.qbmove.ticks import DEG_PER_TICK

Rig = Callable[..., tuple[int, str, str]]


def test_motors_that_are_not_known_to_be_off(rig: Rig, rig_file: Callable[..., Path]) -> None:
    status, out, err = rig("off", rig_file(), "--json")
    assert (status, err) == (1, "")
    told = json.loads(out)["devices"]
    assert [(each["device"], each["at"]) for each in told] == [("actuator", None), ("motor", None)]
    assert told[0]["problem"].startswith("/dev/no-such-port: expected a serial port")


def test_the_address_of_a_page(rig: Rig, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("emg2vsa.lab.watch.serve", lambda routes, at, ready: ready("http://127.0.0.1:1/x"))
    status, out, _ = rig("watch", tmp_path, "--port", 0, "--json")
    assert (status, json.loads(out)) == (0, {"folder": str(tmp_path.resolve()), "address": "http://127.0.0.1:1/x"})


@pytest.mark.realtime
def test_moves_and_zeros_by_hand(rig: Rig, served: SimpleNamespace) -> None:
    status, out, err = rig("jog", served.path, "--mm", 1, "--json")
    assert status == 0, err
    moved = json.loads(out)
    assert moved["shaft_deg"] - moved["from_deg"] == pytest.approx(moved["moved_deg"], abs=1e-9)
    assert (moved["touched"], len(moved["force_n"])) == (False, 3)
    status, out, err = rig("zero", served.path, "--yes", "--json")
    assert status == 0, err
    after = json.loads(out)["after"]
    assert all(abs(angle_deg) <= 16 * DEG_PER_TICK for angle_deg in (*after["motors_deg"], after["shaft_deg"]))
    path = served.path
    path.write_text(path.read_text().replace("watchdog_s = 5", "watchdog_s = 0.5", 1))
    status, out, err = rig("prove-watchdog", path, "--yes", "--json")
    assert (status, json.loads(out)["verdict"]) == (0, "motors off"), err
