"""``emg2vsa rig scan``: which ports there are, who answers on them, and whether sensor and camera are there."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from casr.command_line import Commands, add_command, whole_number

if TYPE_CHECKING:
    from emg2vsa.rig.clock import Clock


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "scan",
        run,
        "List serial ports and the qbmoves that answer on them; with a rig file, also its force sensor and camera.",
        "About 3 s for each port. Nothing is switched or changed. Exit status 0: a qbmove has answered, and all that "
        "the rig file names is there; 1: not so.",
    )
    parser.add_argument("rig", nargs="?", type=Path, metavar="RIG", help="rig file, to look for its devices too")
    parser.add_argument("--port", action="append", default=[], help="this port as well, listed or not; repeat")
    parser.add_argument("--id", action="append", default=[], type=_device_id, help="ask only this id; repeat")
    parser.add_argument(
        "--wait-ms", type=whole_number, default=5, metavar="MS", help="wait for each answer (default 5; slow lines: 20)"
    )


def run(arguments: argparse.Namespace) -> int:
    from emg2vsa.cli.rig.states import camera_lines, force_lines, said
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.qbmove.scan import qbmove_ports
    from emg2vsa.rig_file import load_rig

    clock, file = WallClock(), load_rig(arguments.rig) if arguments.rig else None
    boards = [board for board in (file.devices.actuator, file.devices.motor) if board] if file else []
    ports = qbmove_ports(also=(*arguments.port, *(board.port for board in boards)))
    ids = arguments.id or range(1, 256)
    good = [said(port, partial(_answers, port, ids, arguments.wait_ms / 1000, clock)) for port in ports]
    if not ports:
        print("no serial port with a qbmove's adapter; name another with --port")
    if file:
        good.append(said("[force]", partial(force_lines, file.devices.force, file.rig.guards, clock)))
    if file and (camera := file.devices.camera):
        good.append(said(f"[camera] {camera.source}", partial(camera_lines, camera, file.rig.guards, clock)))
    return int(not ports or not all(good))


def _answers(port: str, ids: Sequence[int], wait_s: float, clock: Clock) -> Iterator[str]:
    from emg2vsa.errors import DeviceError
    from emg2vsa.rig.qbmove.driver import BAUD
    from emg2vsa.rig.qbmove.scan import scan
    from emg2vsa.rig.qbmove.transport import SerialLine

    line = SerialLine(port, BAUD)
    try:
        found = scan(line, clock, ids, reply_s=wait_s)
    finally:
        line.close()
    if not found:
        do = "Check power and cable; a slow line may need --wait-ms 20."
        raise DeviceError(port, wanted="a qbmove that answers", found="none", do=do)
    for one in found:
        yield f"id {one.device_id}" + (f", serial number {one.serial_number}" if one.serial_number else "")


def _device_id(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 255:
        raise argparse.ArgumentTypeError(f"wanted a device id of 1 to 255; found {text!r}")
    return int(text)
