"""``emg2vsa rig emulate``: the emulated rig behind real ports, for all other commands."""

from __future__ import annotations

import argparse
import json
import os
import signal
import sys
import threading
import tomllib
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from casr.command_line import Commands, add_command, add_json
from emg2vsa.cli.rig.choice import add_rig

if TYPE_CHECKING:
    from emg2vsa.rig.emulated.bench import EmulatedRig
    from emg2vsa.rig.emulated.servers import EmulatedServers
    from emg2vsa.rig_file import RigFile
_HEAD = "# Written by emg2vsa rig emulate, good for as long as it runs."


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "emulate",
        run,
        "Run an emulated rig behind serial, UDP and HTTP ports in real time, until Ctrl-C.",
        "Use the file of --write with emg2vsa rig info, run and watch in another shell. Type lines here to switch "
        "faults on and off; type help for a list. Linux and macOS only.",
    )
    add_rig(parser)
    parser.add_argument("--specimen", metavar="NAME", help="specimen on the bench (default: the first of the rig file)")
    parser.add_argument(
        "--angle", type=float, default=0.0, metavar="DEG", help="angle of its surface in degrees (default: 0)"
    )
    parser.add_argument("--rigid", action="store_true", help="use the rigid motor of the condition high-stiffness")
    parser.add_argument(
        "--fault",
        action="append",
        default=[],
        metavar="LINE",
        help='fault that is on from the start, such as "ignore at 2 N for 1.5 s"; may be repeated',
    )
    parser.add_argument(
        "--write", type=Path, metavar="FILE", help="write a copy of RIG with the addresses of the emulated devices"
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.rig.emulated.fault_words import put
    from emg2vsa.rig_file import load_rig

    file = load_rig(arguments.rig)
    with _served(file, arguments) as servers:
        faults = [put(servers.bench, line) for line in arguments.fault]
        _introduce(file, servers, arguments, faults)
        try:
            _obey(servers.bench, sys.stdin)
            threading.Event().wait()  # nobody types: serve on
        except KeyboardInterrupt:
            print("\nend of the emulation", flush=True)
    return 0


@contextmanager
def _served(file: RigFile, arguments: argparse.Namespace) -> Iterator[EmulatedServers]:
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.clock import WallClock, undisturbed
    from emg2vsa.rig.emulated.bench import EmulatedRig
    from emg2vsa.rig.emulated.controls import ARTIFICIAL
    from emg2vsa.rig.emulated.servers import EmulatedServers

    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md)."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    if file.emulated.control in ARTIFICIAL:
        where, do = f"{file.path}, emulated.control", "Use rig run --virtual or emg2vsa run, which know the schedules."
        raise SettingError(where, wanted="a world that needs no schedule", found=file.emulated.control, do=do)
    if not 0 <= arguments.angle < 90:
        raise SettingError(
            "--angle", wanted="0 to below 90 degrees", found=f"{arguments.angle:g}", do="Choose an angle in this range."
        )
    specimen = arguments.specimen or file.experiment.specimens[0]
    bench = EmulatedRig(file.emulated, specimen, arguments.angle, arguments.rigid, WallClock(), rig=file.rig)
    before = signal.signal(signal.SIGTERM, signal.default_int_handler)
    try:
        # a busy computer keeps no real device waiting
        with undisturbed(), EmulatedServers(bench) as servers:
            yield servers
    finally:
        signal.signal(signal.SIGTERM, before)


def _introduce(file: RigFile, servers: EmulatedServers, arguments: argparse.Namespace, faults: Iterable[str]) -> None:
    from casr.atomic import write_text_atomic

    specimen = arguments.specimen or file.experiment.specimens[0]
    under = "the rigid motor" if arguments.rigid else f"the qbmove ({servers.bench.model})"
    if arguments.write:
        check_replaceable(arguments.write)
        write_text_atomic(arguments.write, served_file(file, servers, arguments.write.absolute().parent))
    if arguments.json:  # one line: what reads it need not wait for the end
        told = {"specimen": specimen, "angle_deg": arguments.angle, "devices": served_tables(servers)}
        print(json.dumps(told | {"faults": list(faults)}), flush=True)
        return
    print(f"# {specimen} at {arguments.angle:g} degrees under {under}")
    print("\n".join(toml_lines(served_tables(servers))).strip())
    if arguments.write:
        print(f"\n# written: {arguments.write}")
    for fault in faults:
        print(f"# {fault}")
    print("# help for faults, Ctrl-C to end", flush=True)


def _obey(bench: EmulatedRig, lines: Iterable[str]) -> None:
    """Put faults on and off, line by line, until the last one."""
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.emulated.fault_words import help_text, put

    for line in lines:
        match line.strip():
            case "":
                continue
            case "quit":
                raise KeyboardInterrupt
            case "help":
                print(
                    f"{help_text()}\n  {'where':<18}the probe and its force: a calliper for emg2vsa rig commission",
                    flush=True,
                )
            case "where":
                print("probe {:.2f} mm down, {:.2f} N".format(*bench.probe()), flush=True)
            case words:
                try:
                    print(put(bench, words), flush=True)
                except SettingError as error:
                    print(error, flush=True)


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
        "camera": {"source": servers.camera_url} | ({"delay_s": delay_s} if (delay_s := bench.camera.delay_s) else {}),
    }


def served_file(file: RigFile, servers: EmulatedServers, folder: Path) -> str:
    """Text of a rig file for ``folder``: as ``file``, with these devices, and another folder for the runs."""
    raw = tomllib.loads(file.path.read_text(encoding="utf-8"))
    places = {
        "schedules": os.path.relpath(file.schedules, folder),
        "runs": os.path.relpath(file.emulated_runs, folder),
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
