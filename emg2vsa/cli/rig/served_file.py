"""A rig file that leads to the emulated devices instead of its own."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from emg2vsa.rig.emulated.servers import EmulatedServers
    from emg2vsa.rig_file import RigFile

_HEAD = "# Written by emg2vsa rig emulate, good for as long as it runs."


def served_tables(servers: EmulatedServers) -> dict[str, dict[str, Any]]:
    """The tables [actuator], [motor], [force] and [camera] of the rig that ``servers`` put up."""
    from emg2vsa.rig.emulated.bench import DEVICE_ID

    bench, force = servers.bench, servers.force
    ports = servers.port, servers.idle_port
    motor_port, qbmove_port = ports if bench.rigid else reversed(ports)
    return {
        "actuator": {"port": qbmove_port, "id": DEVICE_ID, "generation": "v6", "model": bench.model},
        "motor": {"port": motor_port, "id": DEVICE_ID, "generation": "v6"},
        "force": {"kind": "net-ft", "host": force.host, "rdt_port": force.rdt_port, "http_port": force.http_port},
        "camera": {"source": servers.camera_url},
    }


def served_file(file: RigFile, servers: EmulatedServers, folder: Path) -> str:
    """Text of a rig file for ``folder``: as ``file``, with these devices, and another folder for the runs."""
    raw = tomllib.loads(file.path.read_text(encoding="utf-8"))
    places = {
        "schedules": os.path.relpath(file.schedules, folder),
        "runs": os.path.relpath(file.runs.with_name(f"{file.runs.name}-emulated"), folder),
    }
    tables = raw | served_tables(servers) | {"experiment": raw["experiment"] | places}
    tables |= {"emulated": raw.get("emulated", {}) | {"behind_ports": True}}
    return f"{_HEAD} From {file.path.name}.\n" + "\n".join(toml_lines(tables)) + "\n"


def check_replaceable(path: Path) -> None:
    """SettingError where there is a file that no emulation has written."""
    from emg2vsa.errors import SettingError

    if path.exists() and not path.read_text(encoding="utf-8", errors="replace").startswith(_HEAD):
        do = "Choose another name for --write."
        raise SettingError(path, wanted="a new file, or one of an earlier emulation", found="another file", do=do)


def toml_lines(tables: Mapping[str, Any], name: str = "") -> Iterator[str]:
    """TOML of nested tables of texts, numbers, booleans and lists."""
    if name:
        yield f"\n[{name}]"
    for key, value in tables.items():
        if not isinstance(value, Mapping):
            # a JSON text, number, boolean or list of these is TOML as well
            yield f"{_key(key)} = {json.dumps(value, ensure_ascii=False)}"
    for key, value in tables.items():
        if isinstance(value, Mapping):
            yield from toml_lines(value, f"{name}.{_key(key)}" if name else _key(key))


def _key(name: str) -> str:
    return name if name.replace("-", "_").isidentifier() and name.isascii() else json.dumps(name)
