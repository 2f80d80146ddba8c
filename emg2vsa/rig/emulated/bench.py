"""The whole emulated rig: one world, and the far ends of the wires that share it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from casr.synthetic import ContactState
from emg2vsa.actuator import SPRINGS
from emg2vsa.arrays import Floats
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.netft.config import parse_config
from emg2vsa.devices.netft.datagrams import LoopbackDatagrams
from emg2vsa.devices.netft.driver import NetFt
from emg2vsa.devices.protocols import Devices
from emg2vsa.devices.qbmove.driver import Qbmove
from emg2vsa.devices.qbmove.rigid_motor import RigidMotor
from emg2vsa.devices.qbmove.settings import Model
from emg2vsa.rig.emulated.camera.frames import EmulatedCamera
from emg2vsa.rig.emulated.controls import ArtificialEffect
from emg2vsa.rig.emulated.direct_drivers import DirectNetFt, DirectQbmove
from emg2vsa.rig.emulated.fault_plan import FaultPlan
from emg2vsa.rig.emulated.faults import FaultyWire, WireLine
from emg2vsa.rig.emulated.netft.box import BoxSettings, RdtBox, configuration_page
from emg2vsa.rig.emulated.netft.faults import BoxFaults
from emg2vsa.rig.emulated.press_draws import PressDraws
from emg2vsa.rig.emulated.probe import Touch
from emg2vsa.rig.emulated.qbmove.firmware import QbmoveFirmware
from emg2vsa.rig.emulated.qbmove.switches import ADVANCED, MAKER_PRO
from emg2vsa.rig.emulated.settings import EmulatedSettings
from emg2vsa.rig.emulated.truth import TrueLoading
from emg2vsa.rig.emulated.world import World
from emg2vsa.rig.rig_settings import RigSettings

MOTOR_SPEED_RAD_PER_S = 3.0
"""Of the gearbox's output at full PWM: a guess. The paper names the motor (Maxon DCX8, GPX8 35:1, 12 V) without it."""
MOTOR_TORQUE_NM, MOTOR_CURRENT_MA = 0.3, 1500.0
"""At which the rigid motor stalls, 26 N at the probe with the gear of the emulated rig: guesses. The catalogue's motor
could not press with 7 N through that gear, which is a guess too."""
MOTOR_BOARD = replace(
    MAKER_PRO,
    supply_mv=12000,
    motor_speed_rad_per_s=MOTOR_SPEED_RAD_PER_S,
    stall_torque_nm=MOTOR_TORQUE_NM,
    stall_current_ma=MOTOR_CURRENT_MA,
)


def motor_board(world: World, clock: Clock, home_ticks: int = 0, latency_s: float = 0.0) -> QbmoveFirmware:
    """The board of the rigid motor: a qbrobotics board with one motor and one AS5045 encoder (paper, section V.A).

    Which firmware it runs is not published; it is taken to be the qbmove's, with motor 1 connected and motor 2 not.
    It has id 1, and turns a world whose ``springs`` are None; at the start its motor reads ``home_ticks``."""
    memory = MOTOR_BOARD.factory((home_ticks, 0, home_ticks))
    return QbmoveFirmware(MOTOR_BOARD, world, clock, memory=memory, loads=world.loads_nm, latency_s=latency_s)


DEVICE_ID = 1
_AWAY_MM = 1e6
TORQUE_NOISE_NM_PER_N = 0.02
"Noise of the torque over that of the force (guess)."
# with the rate limit of the factory, 0, a saturated move never starts; the one at which motors do move is a guess
_ADVANCED = replace(ADVANCED, max_pwm_rate=10)


class EmulatedRig:
    """One specimen on the bench at one angle, and the devices around it, on ``clock``.

    Parameters
    ----------
    emulated : the bench. specimen, angle_deg : what is on it. rigid : under the rigid motor, else under the qbmove.
    rig : as the drivers are told, and as the bench is built; both actuators begin retracted, at its ``home_ticks``.
    run : name of the run; other names, other draws. plate : a flat plate presses, in place of the dome.
    mounting : from 1; each has draws of its own. effect : artificial, of a control world.

    Attributes
    ----------
    world : what is pressed. firmware : of the actuator. idle : of the other one, whose probe is not over the specimen.
    wire, box, camera : the ends that fail on demand: `FaultyWire`, and ``faults`` of the two others.
    plan : of faults that begin or end later.
    model : of the qbmove.

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
    ) -> None:
        self.rigid, self.clock, self.rig = rigid, clock, rig or RigSettings()
        self.model: Model = "advanced" if emulated.springs == "qbmove-advanced" else "maker-pro"
        self._draws = PressDraws(emulated, specimen, angle_deg, rigid, self.rig, run, plate, mounting, effect, mounted)
        self._area_rng = np.random.default_rng(self._draws.sensor_seed)
        self._press = 0
        self._lock = threading.RLock()
        self.world = World(clock, self._draws.world(0), next_press=self._draws.world)
        away = World(
            clock, replace(self._draws.world(0), gap_mm=_AWAY_MM, springs=SPRINGS[emulated.springs] if rigid else None)
        )
        on_springs, on_motor = (away, self.world) if rigid else (self.world, away)
        switches, home_ticks = _ADVANCED if self.model == "advanced" else MAKER_PRO, self.rig.home_ticks
        memory = switches.factory((home_ticks,) * 3)
        latency_s = self._draws.preset_latency_s
        qbmove = QbmoveFirmware(
            switches, on_springs, clock, memory=memory, loads=on_springs.loads_nm, latency_s=latency_s
        )
        motor = motor_board(on_motor, clock, home_ticks, latency_s)
        self.firmware, self.idle = (motor, qbmove) if rigid else (qbmove, motor)
        self.plan = FaultPlan()
        self.wire = FaultyWire(self.firmware, clock, seed=self._draws.sensor_seed)
        noise = emulated.force_noise_n, emulated.force_noise_n * TORQUE_NOISE_NM_PER_N
        box = BoxSettings(rate_hz=emulated.force_rate_hz, noise=noise, seed=self._draws.sensor_seed)
        self._force_zero_n = 0.0
        self._mounting = _turned_to(self.rig.push_axis)
        self._rotation = self._mounting.tolist()
        self._upright = bool(np.array_equal(self._mounting, np.eye(3)))
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
            return [self._loading(*each) for each in enumerate(self.world.loadings) if each[1]]

    def _loading(self, press: int, kept: list[tuple[float, Touch]]) -> TrueLoading:
        seen = self._draws.seen(press)
        areas = [seen.area_mm2(touch) for _, touch in kept]
        return TrueLoading(np.array([force_n for force_n, _ in kept]), np.array(areas))

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
        model = "maker-pro" if self.rigid else self.model
        percent = self.rig.stiffness_percent
        board: Qbmove
        force: NetFt
        if exact:
            board = Qbmove(line, DEVICE_ID, model=model, clock=self.clock, stiffness_percent=percent)
            force = NetFt(box_line, page, self.clock)
        else:
            board = DirectQbmove(
                line, DEVICE_ID, model=model, clock=self.clock, stiffness_percent=percent, firmware=self.firmware
            )
            all_records = self.rig.record_full_rate_force
            force = DirectNetFt(box_line, page, self.clock, box=self.box, all_records=all_records)
        force.start()
        self.camera.start()
        return Devices(RigidMotor(board) if self.rigid else board, force, self.camera)

    def _advance(self) -> None:
        self.firmware.advance()
        self.plan.look(self.clock.now_s(), self.world.normal_force_n)

    def _wrenches(self, times_s: Sequence[float]) -> list[Sequence[float]]:
        """Force and torque on the sensor; its origin is on the line of the force."""
        with self._lock:
            self._advance()
            return [self._turned(force_n) for force_n in self.world.forces_n(times_s)]

    def _turned(self, force_n: Sequence[float]) -> Sequence[float]:
        # plain numbers: three at a time are too few for arrays to pay
        x, y, z = force_n
        z += self._force_zero_n
        if self._upright:
            return [x, y, z, 0.0, 0.0, 0.0]
        return [a * x + b * y + c * z for a, b, c in self._rotation] + [0.0, 0.0, 0.0]

    def _contact(self, time_s: float) -> ContactState:
        with self._lock:
            self._advance()
            if self.world.press != self._press:
                self._press, self._seen = self.world.press, self._draws.seen(self.world.press)
                self._show()
            return self._seen.in_frame(self.world.touch(time_s), self._area_rng)

    def _show(self) -> None:
        self.camera.scene, self.camera.latency_s = self._seen.scene, self._seen.latency_s
        self._force_zero_n = self._draws.force_zero_n(self._press)


def _turned_to(axis: tuple[float, float, float]) -> Floats:
    """(3, 3) rotation that takes z to ``axis`` (Rodrigues)."""
    x, y, z = (float(part) for part in np.array(axis) / np.linalg.norm(axis))
    if z < 0:  # by way of -axis, as 1 + z may be next to nothing
        return _turned_to((-x, -y, -z)) @ np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0, 0, x], [0, 0, y], [-x, -y, 0]])
    turned: Floats = np.eye(3) + cross + cross @ cross / (1 + z)
    return turned
