"""Motors off, whatever state the rig is in."""

from __future__ import annotations

from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

from emg2vsa.devices.clock import WallClock
from emg2vsa.devices.device_settings import ActuatorSettings
from emg2vsa.devices.protocols import Measurements
from emg2vsa.devices.qbmove.settings import MotorSettings
from emg2vsa.errors import DeviceError
from emg2vsa.lab.device_states import angles
from emg2vsa.lab.person import NOBODY, Person
from emg2vsa.lab.rig_lock import end_user, stop_unnamed_run
from emg2vsa.rig.open_rig import open_board
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.rig_file import load_rig


@dataclass(frozen=True)
class Off:
    """device : table of the rig file. problem : why its motors are not known to be off; "" where they are.
    at : angles of motors and shaft."""

    device: str
    problem: str
    at: Measurements | None


def off(rig_file: str | Path, person: Person = NOBODY) -> tuple[Off, ...]:
    """Switch the motors off in any state, and end the process that uses the rig: asked first, ended when silent.

    The lock needs no more of the rig file than its name: a file with problems keeps no run going. StudyError : the file
    cannot be read; DeviceError : somebody else's process uses the rig.
    """
    end_user(Path(rig_file), person.warn)
    file = load_rig(rig_file)
    stop_unnamed_run(file.runs, person.warn)
    boards = {"actuator": file.devices.actuator, "motor": file.devices.motor}
    return tuple(board_off(name, board, person) for name, board in boards.items() if board)


def board_off(name: str, settings: ActuatorSettings | MotorSettings, person: Person = NOBODY) -> Off:
    """Switch the motors of one device off, and ask it. SettingError where ``settings`` name no port."""
    try:
        with closing(open_board(settings, RigSettings(), WallClock())) as board:
            board.deactivate()
            at = board.measurements()
    except DeviceError as error:
        person.say(f"[{name}] NOT confirmed off: {error}")
        return Off(name, str(error), None)
    person.say(f"[{name}] motors off; {angles(at)}")
    return Off(name, "", at)
