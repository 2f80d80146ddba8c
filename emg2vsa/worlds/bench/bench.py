"""The whole emulated rig: one world, the far ends of the wires that share it, and ports that lead to them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from typing import Any, Self

import numpy as np

from emg2vsa.arrays import Floats
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.netft.box import parse_config
from emg2vsa.devices.netft.datagrams import LoopbackDatagrams
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.protocols import Devices
from emg2vsa.errors import SettingError
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.worlds.bench.controls import ArtificialEffect
from emg2vsa.worlds.bench.press_draws import PressDraws
from emg2vsa.worlds.bench.probe import Force
from emg2vsa.worlds.bench.settings import EmulatedSettings
from emg2vsa.worlds.bench.truth import TrueLoading
from emg2vsa.worlds.bench.world import World
from emg2vsa.worlds.far_ends.actuator_end import FarEnd, Place
from emg2vsa.worlds.far_ends.camera import CameraServer, EmulatedCamera
from emg2vsa.worlds.far_ends.dynamixel.far_end import DYNAMIXEL
from emg2vsa.worlds.far_ends.faults import FaultPlan, FaultyWire, WireLine
from emg2vsa.worlds.far_ends.netft_box import NO_LOAD, BoxSettings, RdtBox, configuration_page
from emg2vsa.worlds.far_ends.netft_faults import BoxFaults
from emg2vsa.worlds.far_ends.netft_server import DirectNetFt, RdtServer
from emg2vsa.worlds.far_ends.ports import VirtualSerialPort
from emg2vsa.worlds.far_ends.qbmove.far_end import QBMOVE, RIGID_MOTOR
from emg2vsa.worlds.tactile import ContactState

ACTUATORS = {"qbmove": QBMOVE, "dynamixel": DYNAMIXEL}
"By kind."
_TABLES, _DIGITS = ("actuator", "motor"), 10
_AWAY_MM = 1e6
TORQUE_NOISE_NM_PER_N = 0.02
"Noise of the torque over that of the force (guess)."


class EmulatedRig:
    """One specimen on the bench at one angle, and the devices around it, on ``clock``.

    Parameters
    ----------
    emulated : the bench. specimen, angle_deg : what is on it. rigid : under the rigid motor, else under the actuator.
    actuator : its settings; a qbmove where none are given. numbers : serial numbers by table of the rig file.
    rig : as the drivers are told, and as the bench is built; both actuators begin retracted, at its ``home_deg``.
    run : name of the run; other names, other draws. plate : a flat plate presses, in place of the dome.
    mounting : from 1; each has draws of its own. effect : artificial, of a control world.

    Attributes
    ----------
    world : what is pressed. firmware : of the actuator. idle : of the other one, whose probe is not over the specimen.
    end, idle_end : kinds of both. wire, box, camera : the ends that fail on demand: `FaultyWire`, and ``faults`` of the
    two others.
    plan : of faults that begin or end later. numbers : those that its devices tell: a box, and qbmoves of digits.

    Raises
    ------
    SettingError : the specimen is not known, or the contact would leave the image.
    """

    def __init__(
        self,
        emulated: EmulatedSettings,
        specimen: str,
        angle_deg: float,
        rigid: bool,
        clock: Clock,
        *,
        rig: RigSettings | None = None,
        run: str = "",
        plate: bool = False,
        mounting: int = 1,
        effect: ArtificialEffect | None = None,
        mounted: str = "",
        actuator: Any = None,
        numbers: Mapping[str, str] | None = None,
    ) -> None:
        self.rigid, self.clock, self.rig = rigid, clock, rig or RigSettings()
        ends = RIGID_MOTOR, _far_end_of("qbmove" if actuator is None else actuator.kind)
        self.end, self.idle_end = ends if rigid else reversed(ends)
        springs, idle_springs = (end.springs(emulated.springs) for end in (self.end, self.idle_end))
        self._draws = PressDraws(
            emulated, specimen, angle_deg, springs, self.rig, run, plate, mounting, effect, mounted
        )
        self._area_rng = np.random.default_rng(self._draws.sensor_seed)
        self._press = 0
        self._true: dict[int, TrueLoading] = {}
        "Of presses that are over: their scene is at hand only while they last."
        self._lock = threading.RLock()
        self.world = World(clock, self._draws.world(0), next_press=self._draws.world)
        away = World(clock, replace(self._draws.world(0), gap_mm=_AWAY_MM, springs=idle_springs))
        latency_s = self._draws.preset_latency_s
        self.numbers = {table: each for table, each in (numbers or {}).items() if _tells(table, each, actuator)}
        number, idle_number = (self.numbers.get(each, "") for each in _TABLES[:: -1 if rigid else 1])
        self.place = Place(actuator, emulated.springs, self.rig, self.world, clock, latency_s, number)
        self.idle_place = self.place._replace(world=away, serial_number=idle_number)
        self.firmware, self.idle = self.end.device(self.place), self.idle_end.device(self.idle_place)
        self.plan = FaultPlan()
        self.wire = FaultyWire(self.firmware, self.end.frames, clock, seed=self._draws.sensor_seed)
        noise = emulated.force_noise_n, emulated.force_noise_n * TORQUE_NOISE_NM_PER_N
        box = BoxSettings(rate_hz=emulated.force_rate_hz, noise=noise, seed=self._draws.sensor_seed)
        box = replace(box, serial=self.numbers.get("force", box.serial))
        self._force_zero_n = 0.0
        self._mounting = _turned_to(self.rig.push_axis)
        self._rotation = self._mounting.tolist()
        self._felt: tuple[Force, float] | None = None
        self._of_felt: Sequence[float] = NO_LOAD
        self.box = RdtBox(self._wrenches, box)
        self.box.faults = BoxFaults(seed=self._draws.sensor_seed)
        self._seen = self._draws.seen(0)
        self.camera = EmulatedCamera(self._seen.scene, self._contact, clock, timing=self._draws.frame_timing)
        self._show()

    def answer(self, data: bytes) -> bytes:
        """What comes back over the actuator's wire; from any thread."""
        with self._lock:
            self._advance()
            return self.wire(data)

    def probe(self) -> tuple[float, float]:
        """The probe's way down from where the shaft is at 0, mm, and its true force, N; from any thread."""
        with self._lock:
            self.firmware.advance()
            now_s = self.clock.now_s()
            return self.world.probe_mm(now_s), float(np.linalg.norm(self.world.force_n(now_s)))

    def loadings(self) -> list[TrueLoading]:
        """What is true of each press so far."""
        with self._lock:
            every = [self._true.get(press) or self._loading(press) for press in range(len(self.world.loadings))]
        return [loading for loading in every if loading is not None]

    def _loading(self, press: int) -> TrueLoading | None:
        """None where it has not begun."""
        if not (kept := self.world.loadings[press]):
            return None
        forces_n, touches = zip(*kept, strict=True)
        seen = self._seen if press == self._press else self._draws.seen(press)
        return TrueLoading(np.array(forces_n), np.array(list(map(seen.area_mm2, touches))))

    def interrupt(self, action: Callable[[], None]) -> None:
        """Carry out ``action`` at the clock's time, while no device speaks; from any thread."""
        with self._lock:
            self.firmware.advance()
            action()

    def reset_actuator(self) -> None:
        """Its power off and on; from any thread."""
        with self._lock:
            self.wire.reset()

    def devices(self, *, exact: bool = True) -> Devices:
        """The real drivers on lines within this process, force sensor and camera started.

        exact : every turn of the loop is a conversation byte for byte, of which faults of the wire and of the box are
        part. Else the drivers ask actuator and box themselves.
        """
        line = WireLine("emulated bus", self.answer, lambda: self.wire.due_s, self.clock)
        box_line = LoopbackDatagrams("emulated box", self.box, self.clock)
        page = parse_config(configuration_page(self.box))
        board = self.end.driver(line, self.firmware, self.place, exact)
        force: NetFt
        if exact:
            force = NetFt(box_line, page, self.clock)
        else:
            all_records = self.rig.record_full_rate_force
            force = DirectNetFt(box_line, page, self.clock, box=self.box, all_records=all_records)
        force.start()
        self.camera.start()
        return Devices(board.pressing(), force, self.camera)

    def _advance(self) -> None:
        self.firmware.advance()
        self.plan.look(self.clock.now_s(), self.world.normal_force_n)

    def _wrenches(self, times_s: Sequence[float]) -> list[Sequence[float]]:
        """Force and torque on the sensor; its origin is on the line of the force."""
        with self._lock:
            self._advance()
            forces_n, zero_n = self.world.forces_n(times_s), self._force_zero_n
        return [self._wrench(force_n, zero_n) for force_n in forces_n]

    def _wrench(self, force_n: Force, zero_n: float) -> Sequence[float]:
        """The same as before while the force stays."""
        if (force_n, zero_n) != self._felt:
            self._felt, (x, y, z) = (force_n, zero_n), force_n
            # plain numbers: three at a time are too few for arrays to pay
            self._of_felt = (*[a * x + b * y + c * (z + zero_n) for a, b, c in self._rotation], 0.0, 0.0, 0.0)
        return self._of_felt

    def _contact(self, time_s: float) -> ContactState:
        with self._lock:
            self._advance()
            if self.world.press != self._press:
                if (over := self._loading(self._press)) is not None:
                    self._true[self._press] = over
                self._press, self._seen = self.world.press, self._draws.seen(self.world.press)
                self._show()
            return self._seen.in_frame(self.world.touch(time_s), self._area_rng)

    def _show(self) -> None:
        self.camera.scene, self.camera.latency_s = self._seen.scene, self._seen.latency_s
        self._force_zero_n = self._draws.force_zero_n(self._press)


class EmulatedServers:
    """Serves ``bench``, which must be on a wall clock, within a with statement, at addresses that any program can open.

    port : name of the serial port of the actuator that presses; idle_port : of the other one. force : host and ports of
    the force sensor's box. camera_url : where the camera's pictures are.
    """

    def __init__(self, bench: EmulatedRig) -> None:
        self.bench = bench
        serial = VirtualSerialPort(bench.answer, lambda: bench.wire.due_s - bench.clock.now_s())
        self.force = RdtServer(bench.box, bench.clock)
        camera, idle = CameraServer(bench.camera), VirtualSerialPort(bench.idle)
        self.port, self.idle_port, self.camera_url = serial.name, idle.name, camera.url
        self._servers, self._open = (serial, idle, self.force, camera), ExitStack()

    def __enter__(self) -> Self:
        for server in self._servers:
            self._open.enter_context(server)
        return self

    def __exit__(self, *error: object) -> None:
        self._open.close()


def _tells(table: str, number: str, actuator: Any) -> bool:
    """Whether a device of this table can tell such a number: that of an adapter it cannot."""
    qbmove = table == "motor" or (table == "actuator" and (actuator is None or actuator.kind == "qbmove"))
    return table == "force" or (qbmove and len(number) == _DIGITS and number.isdecimal() and int(number) < 2**32)


def _far_end_of(kind: str) -> FarEnd:
    if kind not in ACTUATORS:
        do = "Run it on the device itself, or name another kind under [actuator]."
        wanted = f"one that can be emulated: {', '.join(ACTUATORS)}"
        raise SettingError("actuator.kind", wanted=wanted, found=kind, do=do)
    return ACTUATORS[kind]


def _turned_to(axis: tuple[float, float, float]) -> Floats:
    """(3, 3) rotation that takes z to ``axis`` (Rodrigues)."""
    x, y, z = (float(part) for part in np.array(axis) / np.linalg.norm(axis))
    if z < 0:  # by way of -axis, as 1 + z may be next to nothing
        return _turned_to((-x, -y, -z)) @ np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0, 0, x], [0, 0, y], [-x, -y, 0]])
    turned: Floats = np.eye(3) + cross + cross @ cross / (1 + z)
    return turned
