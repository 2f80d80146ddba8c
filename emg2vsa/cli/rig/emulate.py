"""``emg2vsa rig emulate``: the emulated rig behind real ports, for all other commands."""

from __future__ import annotations

import argparse
import gc
import signal
import sys
import threading
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from emg2vsa.cli.arguments import Commands, add_command
from emg2vsa.cli.rig.choice import add_rig

if TYPE_CHECKING:
    from emg2vsa.rig.emulated.bench import EmulatedRig
    from emg2vsa.rig.emulated.servers import EmulatedServers
    from emg2vsa.rig_file import RigFile

_SWITCH_S = 2e-4


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "emulate",
        run,
        "Put an emulated rig behind serial, UDP and HTTP ports in real time, until Ctrl-C.",
        "Give the file of --write to emg2vsa rig info, run and watch in another shell. Lines typed here put faults on "
        "and off; type help. Linux and macOS only.",
    )
    add_rig(parser)
    parser.add_argument("--specimen", metavar="NAME", help="on the bench (default: the first of the rig file)")
    parser.add_argument("--angle", type=float, default=0.0, metavar="DEG", help="of its surface (default: 0)")
    parser.add_argument("--rigid", action="store_true", help="under the rigid motor, for the condition high-stiffness")
    parser.add_argument("--write", type=Path, metavar="FILE", help="a copy of RIG that leads to the emulated devices")


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.errors import SettingError
    from emg2vsa.rig_file import load_rig

    if sys.platform == "win32":
        do = "Use emg2vsa rig run --virtual."
        raise SettingError("rig emulate", wanted="a system with virtual serial ports", found="Windows", do=do)
    file = load_rig(arguments.rig)
    with _served(file, arguments) as servers:
        _introduce(file, servers, arguments)
        try:
            _obey(servers.bench, sys.stdin)
            threading.Event().wait()  # nobody types: serve on
        except KeyboardInterrupt:
            print("\nend of the emulation", flush=True)
    return 0


@contextmanager
def _served(file: RigFile, arguments: argparse.Namespace) -> Iterator[EmulatedServers]:
    from emg2vsa.errors import SettingError
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.emulated.bench import EmulatedRig
    from emg2vsa.rig.emulated.servers import EmulatedServers

    if file.emulated is None:
        do = "Add it (docs/reference/rig-file.md)."
        raise SettingError(file.path, wanted="a table [emulated]", found="none", do=do)
    if not 0 <= arguments.angle < 90:
        raise SettingError(
            "--angle", wanted="0 to below 90 degrees", found=f"{arguments.angle:g}", do="Choose another."
        )
    specimen = arguments.specimen or file.experiment.specimens[0]
    bench = EmulatedRig(file.emulated, specimen, arguments.angle, arguments.rigid, WallClock(), rig=file.rig)
    # a thread that is to answer at once would else wait 5 ms for the one that draws a frame
    usual_s, before = sys.getswitchinterval(), signal.signal(signal.SIGTERM, signal.default_int_handler)
    sys.setswitchinterval(_SWITCH_S)
    gc.freeze()  # a search of all that is loaded for garbage takes 50 ms, in which no device would answer
    try:
        with EmulatedServers(bench) as servers:
            yield servers
    finally:
        sys.setswitchinterval(usual_s)
        signal.signal(signal.SIGTERM, before)


def _introduce(file: RigFile, servers: EmulatedServers, arguments: argparse.Namespace) -> None:
    from emg2vsa.atomic import write_text_atomic
    from emg2vsa.cli.rig.served_file import check_replaceable, served_file, served_tables, toml_lines

    specimen = arguments.specimen or file.experiment.specimens[0]
    under = "the rigid motor" if arguments.rigid else f"the qbmove ({servers.bench.model})"
    print(f"# {specimen} at {arguments.angle:g} degrees under {under}")
    print("\n".join(toml_lines(served_tables(servers))).strip())
    if arguments.write:
        check_replaceable(arguments.write)
        write_text_atomic(arguments.write, served_file(file, servers, arguments.write.absolute().parent))
        print(f"\n# written: {arguments.write}")
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
                print(help_text(), flush=True)
            case words:
                try:
                    print(put(bench, words), flush=True)
                except SettingError as error:
                    print(error, flush=True)
