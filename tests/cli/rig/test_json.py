"""``--json``: one JSON object of what the words say, for every command of the rig."""

from __future__ import annotations

import json
from collections.abc import Callable
from importlib import import_module
from pathlib import Path

import pytest

Rig = Callable[..., tuple[int, str, str]]


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
