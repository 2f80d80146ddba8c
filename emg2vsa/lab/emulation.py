"""The emulated rig behind real ports, for every command and program that opens devices."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from casr.atomic import write_text_atomic
from emg2vsa.devices.clock import WallClock, undisturbed
from emg2vsa.errors import SettingError
from emg2vsa.rig_file import RigFile
from emg2vsa.worlds.bench.bench import EmulatedRig, EmulatedServers
from emg2vsa.worlds.bench.controls import ARTIFICIAL
from emg2vsa.worlds.bench.faults import help_text, put

_HEAD = "# Written by emg2vsa rig emulate, good for as long as it runs."


@dataclass(frozen=True)
class Emulation:
    """An emulated rig that is served. faults : that are on from the start, in words."""

    specimen: str
    angle_deg: float
    servers: EmulatedServers
    devices: dict[str, dict[str, Any]]
    "The tables [actuator], [motor], [force] and [camera] that lead to it."
    faults: tuple[str, ...]

    @property
    def actuator(self) -> str:
        """What presses, in words."""
        table = self.devices["actuator"]
        return "rigid motor" if self.servers.bench.rigid else f"{table.get('kind', 'qbmove')} ({table['model']})"

    def obey(self, line: str) -> str:
        """Put a fault on or off; what is to be said of it. Also ``help`` and ``where``."""
        bench = self.servers.bench
        match line.strip():
            case "help":
                return (
                    f"{help_text(bench)}\n  {'where':<18}the probe and its force: a calliper for emg2vsa rig commission"
                )
            case "where":
                return "probe {:.2f} mm down, {:.2f} N".format(*bench.probe())
            case words:
                try:
                    return put(bench, words)
                except SettingError as error:
                    return str(error)


@contextmanager
def emulation(
    file: RigFile, *, specimen: str | None = None, angle_deg: float = 0.0, rigid: bool = False,
    faults: Sequence[str] = (), write: Path | None = None,
) -> Iterator[Emulation]:  # fmt: skip
    """An emulated rig behind serial, UDP and HTTP ports in real time, within a with statement. Linux and macOS only.

    specimen : on the bench; None: the first of the rig file. angle_deg : of its surface. rigid : under the rigid motor.
    faults : that are on from the start, as "ignore at 2 N for 1.5 s". write : a copy of the rig file that leads to it.
    SettingError : the rig file has no emulated rig, or none without schedules; no such specimen, angle or fault; a
    file of somebody else at ``write``; Windows.
    """
    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md)."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    if file.emulated.control in ARTIFICIAL:
        where, do = f"{file.path}, emulated.control", "Use rig run --virtual or emg2vsa run, which know the schedules."
        raise SettingError(where, wanted="a world that needs no schedule", found=file.emulated.control, do=do)
    if not 0 <= angle_deg < 90:
        do = "Choose an angle in this range."
        raise SettingError("--angle", wanted="0 to below 90 degrees", found=f"{angle_deg:g}", do=do)
    specimen = specimen or file.experiment.specimens[0]
    tables = {name: getattr(file.devices, name) for name in ("actuator", "motor", "force")}
    bench = EmulatedRig(
        file.emulated, specimen, angle_deg, rigid, WallClock(), rig=file.rig, actuator=file.devices.actuator,
        numbers={name: each.serial_number for name, each in tables.items() if each and each.serial_number},
    )  # fmt: skip
    # a busy computer keeps no real device waiting
    with undisturbed(), EmulatedServers(bench) as servers:
        put_on = tuple(put(bench, line) for line in faults)
        if write:
            check_replaceable(write)
            write_text_atomic(write, served_file(file, servers, write.absolute().parent))
        yield Emulation(specimen, angle_deg, servers, served_tables(servers), put_on)


def served_tables(servers: EmulatedServers) -> dict[str, dict[str, Any]]:
    """The tables [actuator], [motor], [force] and [camera] of the rig that ``servers`` put up."""
    bench, force = servers.bench, servers.force
    ports = servers.port, servers.idle_port
    ends = (bench.end, bench.place), (bench.idle_end, bench.idle_place)
    tables = [{"port": port} | end.table(place) for port, (end, place) in zip(ports, ends, strict=True)]
    motor, actuator = tables if bench.rigid else reversed(tables)
    served = {
        "actuator": actuator,
        "motor": motor,
        "force": {"kind": "net-ft", "host": force.host, "rdt_port": force.rdt_port, "http_port": force.http_port},
        "camera": {"source": servers.camera_url} | ({"delay_s": delay_s} if (delay_s := bench.camera.delay_s) else {}),
    }
    return {name: each | _number(bench.numbers.get(name)) for name, each in served.items()}


def _number(told: str | None) -> dict[str, Any]:
    return {"serial_number": told} if told else {}


def served_file(file: RigFile, servers: EmulatedServers, folder: Path) -> str:
    """Text of a rig file for ``folder``: as ``file``, with these devices, and another folder for the runs."""
    raw = tomllib.loads(file.path.read_text(encoding="utf-8"))
    places = {
        "schedules": os.path.relpath(file.schedules, folder),
        "runs": os.path.relpath(file.emulated_runs, folder),
    }
    tables = raw | served_tables(servers) | {"experiment": raw["experiment"] | places}
    domes = file.emulated and file.emulated.domes
    tables |= {"emulated": raw.get("emulated", {}) | {"behind_ports": True} | ({"domes": domes} if domes else {})}
    return f"{_HEAD} From {file.path.name}.\n" + "\n".join(toml_lines(tables)) + "\n"


def check_replaceable(path: Path) -> None:
    """SettingError where there is a file that no emulation has written."""
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
