"""The registry of devices: light, whole, and the table of every kind is what its role asks for."""

from __future__ import annotations

import re
import subprocess
import sys
import tomllib
from dataclasses import fields
from pathlib import Path
from typing import Annotated, get_args, get_type_hints

import pytest

from emg2vsa.devices import registry
from emg2vsa.devices.lsl import LslEmgSettings, LslForceSettings
from emg2vsa.devices.ni_daq import NiEmgSettings
from emg2vsa.devices.registry import ROLES, Kind
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.simulated import SimulatedEmgSettings, SimulatedForceSettings
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.session.plan import planned
from emg2vsa.session_settings import EmgSettings, SessionForceSettings, SessionSettings
from emg2vsa.settings import Tagged
from emg2vsa.study_file.problems import checked

ROOT = Path(__file__).resolve().parents[2]

KINDS = [(role, name) for role in ROLES for name in ROLES[role].kinds]
MUSCLES = {"EDC": "1", "FDS": "2"}


def kind_of(role: str, name: str) -> Kind:
    kind = registry.kind_of(role, name)
    assert kind is not None
    return kind


def test_no_driver_is_loaded_before_it_is_opened() -> None:
    code = (
        "import sys; from emg2vsa.devices import registry\n"
        "for role in registry.ROLES: registry.kinds(role)\n"
        "print([name for name in ('numpy', 'scipy', 'cv2', 'serial') if name in sys.modules])"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "[]\n"


@pytest.mark.parametrize(("role", "name"), KINDS)
def test_every_kind_is_whole(role: str, name: str) -> None:
    kind = kind_of(role, name)
    assert kind.role == role
    assert fields(kind.settings)[0].name == "kind"
    assert get_args(get_type_hints(kind.settings)["kind"]) == (name,)
    assert issubclass(kind.settings, registry.loaded(ROLES[role].base))
    places = [registry._whole(each) for each in (kind.open, kind.about, kind.facts, kind.scan) if each]
    assert all(callable(registry.loaded(each)) for each in places)


@pytest.mark.parametrize("role", ROLES)
def test_a_table_without_a_kind_is_of_the_one_that_there_was_before(role: str) -> None:
    default = ROLES[role].default
    hint = dict.fromkeys(("actuator", "force", "camera"), "emg2vsa.rig_file.tables:RigTables").get(
        role, "emg2vsa.session_settings:SessionSettings"
    )
    table = get_type_hints(registry.loaded(hint), include_extras=True)["force" if role == "session-force" else role]
    made, problems = checked(table, {"source": 0} if role == "camera" else {}, ("table",))
    if default is None:
        assert [str(each) for each in problems] == ["table.kind: expected a key 'kind', but found nothing."]
    else:
        assert (made.kind, problems) == (default, [])


EMG = {"kind": "", "channels": {}, "gain": 1.0, "fs_hz": 1000.0, "range_v": 5.0, "host": "127.0.0.1",
       "command_port": 50040, "emg_port": 50043, "stream": None, "delay_s": 0.0}  # fmt: skip
FORCE = {"kind": "", "rig": None, "axis": (0.0, 0.0, -1.0), "stream": None, "channel": None, "delay_s": 0.0}
"""Keys and order of plan.json of 0.1.0 and 0.2.0."""
SIMULATED = SimulatedForceSettings()


@pytest.mark.parametrize(
    ("emg", "own"),
    [
        (NiEmgSettings(channels=MUSCLES, gain=1000.0, fs_hz=2000.0, delay_s=0.01),
         {"channels": MUSCLES, "gain": 1000.0, "fs_hz": 2000.0, "delay_s": 0.01}),
        (TrignoSettings(channels=MUSCLES, host="there", emg_port=1),
         {"channels": MUSCLES, "host": "there", "emg_port": 1}),
        (LslEmgSettings(channels=MUSCLES, stream="x"), {"channels": MUSCLES, "stream": "x"}),
        (SimulatedEmgSettings(), {}),
    ],
)  # fmt: skip
def test_the_plan_of_a_session_keeps_its_bytes_whatever_the_emg(emg: EmgSettings, own: dict[str, object]) -> None:
    said = planned(SessionSettings(emg=emg, force=SIMULATED))["emg"]
    assert list(said.items()) == list((EMG | {"kind": emg.kind} | own).items())


@pytest.mark.parametrize(
    ("force", "own"),
    [
        (RigForceSettings(rig="rig.toml", axis=(0.0, 0.0, 1.0)), {"rig": "rig.toml", "axis": (0.0, 0.0, 1.0)}),
        (LslForceSettings(stream="x", channel="Fz", delay_s=0.01), {"stream": "x", "channel": "Fz", "delay_s": 0.01}),
        (SIMULATED, {}),
    ],
)  # fmt: skip
def test_the_plan_of_a_session_keeps_its_bytes_whatever_the_force(
    force: SessionForceSettings, own: dict[str, object]
) -> None:
    said = planned(SessionSettings(emg=SimulatedEmgSettings(), force=force))
    assert list(said["force"].items()) == list((FORCE | {"kind": force.kind} | own).items())
    unplanned = {"form", "lsl_outlets", "trigger"}  # people's own data, and who else listens
    assert list(said) == [each.name for each in fields(SessionSettings) if each.name not in unplanned]


def tables_of_people() -> list[tuple[str, str, dict[str, object]]]:
    """Where, role and table, of every device in studies/ and in the pages of docs; those of the page on a laboratory's
    own devices are read in tests/plugins."""
    texts = {str(path.relative_to(ROOT)): path.read_text() for path in (ROOT / "studies").glob("*/*.toml")}
    for path in [*(ROOT / "docs").glob("*.md"), *(ROOT / "docs" / "how-to").glob("*.md")]:
        if path.name != "add-a-device.md":
            blocks = re.findall(r"^```toml\n(.*?)^```$", path.read_text(), flags=re.M | re.S)
            parts = [part for block in blocks for part in re.split(r"\n(?=\[)", "\n" + block)]
            texts |= {f"{path.name}, {n}": part for n, part in enumerate(parts) if "..." not in part}
    found = []
    for name, text in texts.items():
        raw = tomllib.loads(text)
        tables = raw | {f"session-{key}": raw.get("session", {}).get(key) for key in ("emg", "force")}
        names = {"actuator": "actuator", "force": "force", "camera": "camera", "session-emg": "emg"}
        for key, role in (names | {"session-force": "session-force"}).items():
            if tables.get(key):
                found.append((name, role, tables[key]))
    return found


@pytest.mark.parametrize(("where", "role", "given"), tables_of_people(), ids=str)
def test_tables_that_people_have_are_read_as_they_stand(where: str, role: str, given: dict[str, object]) -> None:
    if where.startswith("tactile.md"):
        pytest.skip("a camera file")
    made, problems = checked(Annotated[object, Tagged(role)], given, (role,))
    assert problems == []
    for key, value in given.items():
        assert getattr(made, key) == (tuple(value) if isinstance(value, list) else value)


def test_people_have_tables_of_every_role() -> None:
    assert {role for _, role, _ in tables_of_people()} == set(ROLES)
