"""``emg2vsa rig scan``: which ports there are, who answers on those that are named, and sensor and camera."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, get_args

from casr.command_line import Commands, add_command, add_json, whole_number
from emg2vsa.rig.serial_speed import BAUD, Baud

if TYPE_CHECKING:
    from emg2vsa.rig.clock import Clock


def add_to(commands: Commands) -> None:
    parser = add_command(
        commands,
        "scan",
        run,
        "List the serial adapters of qbmoves, and ask the devices that --port or a rig file names.",
        "Each port takes about 3 s. The command changes nothing, and sends nothing to a port or address that you do "
        "not name. Exit status 0: adapters are present and every named device answers; 1: otherwise; 2: "
        "the rig file has problems, or another run or command is using the rig.",
    )
    parser.add_argument("rig", nargs="?", type=Path, metavar="RIG", help="rig file whose devices are asked")
    parser.add_argument(
        "--port", action="append", default=[], help="ask this port, even if it is not listed; may be repeated"
    )
    parser.add_argument(
        "--id", action="append", default=[], type=_device_id, help="ask only this device id; may be repeated"
    )
    parser.add_argument(
        "--baud", type=int, choices=get_args(Baud), default=BAUD, help=f"baud rate of --port (default {BAUD})"
    )
    parser.add_argument(
        "--wait-ms",
        type=whole_number,
        default=5,
        metavar="MS",
        help="time to wait for each answer in ms (default 5; 20 for slow lines)",
    )
    add_json(parser)


def run(arguments: argparse.Namespace) -> int:
    from contextlib import nullcontext

    from emg2vsa.cli.rig.rig_lock import rig_lock
    from emg2vsa.cli.rig.states import Telling, camera_lines, force_lines
    from emg2vsa.rig.clock import WallClock
    from emg2vsa.rig.qbmove.scan import qbmove_ports
    from emg2vsa.rig_file import load_rig

    clock, file = WallClock(), load_rig(arguments.rig) if arguments.rig else None
    boards = [board for board in (file.devices.actuator, file.devices.motor) if board] if file else []
    ports = {board.port: board.baud for board in boards if board.port} | dict.fromkeys(arguments.port, arguments.baud)
    adapters, ids, telling = qbmove_ports(), arguments.id or range(1, 256), Telling(arguments.json)
    for port in adapters:
        if port not in ports:
            telling.say(port, partial(iter, ["an adapter as qbmoves have; ask it with --port"]))
    with rig_lock(file.path) if file else nullcontext():
        for port, baud in ports.items():
            telling.say(port, partial(_answers, port, baud, ids, arguments.wait_ms / 1000, clock))
        if file:
            telling.say("[force]", partial(force_lines, file.devices.force, file.rig.guards, clock))
        if file and (camera := file.devices.camera):
            telling.say(f"[camera] {camera.source}", partial(camera_lines, camera, file.rig.guards, clock))
    if not adapters and not ports:
        telling.remark("no serial port with a qbmove's adapter; name another with --port")
    return telling.end(good=bool(adapters or ports))


def _answers(port: str, baud: int, ids: Sequence[int], wait_s: float, clock: Clock) -> Iterator[str]:
    from emg2vsa.errors import DeviceError
    from emg2vsa.rig.qbmove.scan import scan
    from emg2vsa.rig.qbmove.transport import SerialLine

    line = SerialLine(port, baud)
    try:
        found = scan(line, clock, ids, reply_s=wait_s)
    finally:
        line.close()
    if not found:
        do = "Check power, cable and --baud; a slow line may need --wait-ms 20."
        raise DeviceError(port, wanted="a qbmove that answers", found="none", do=do)
    for one in found:
        yield f"id {one.device_id}" + (f", serial number {one.serial_number}" if one.serial_number else "")


def _device_id(text: str) -> int:
    if not text.isdecimal() or not 1 <= int(text) <= 255:
        raise argparse.ArgumentTypeError(f"expected a device id of 1 to 255, but found {text!r}")
    return int(text)
