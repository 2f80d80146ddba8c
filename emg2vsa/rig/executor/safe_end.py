"""The way out of every run: probe away from the specimen, motors off."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from emg2vsa.devices.clock import Clock
from emg2vsa.devices.protocols import Actuator, ForceSample, Measurements, gives_way
from emg2vsa.errors import DeviceError
from emg2vsa.rig.executor.witnesses import mean_size
from emg2vsa.rig.rig_settings import RigSettings

_OFF_ATTEMPTS = 3
_SEND_ATTEMPTS = 3
_HEALS_S = 5.0
"""How long an actuator that takes no commands is asked whether it answers again; it has been told to go off."""
_THERE_MM = 0.2
"""Motors so close to the retracted position have reached it."""
_RISE_N = 1.0
"""Force that grows by so much on the way out is not taken away by it."""
_HOLD_S = 0.15
_STEADY_N, _STEADY_S, _LAG_S = 0.1, 0.2, 1.0
"""A force that changes by less in that time has come to rest; a sensor that lags may need so long for it."""
_LAG_MM = 1.0
"""Motors so close to their command, or coming nearer, obey it."""
_BEYOND_MM, _UNFELT_MM, _PIECE_MM = 5.0, 1.0, 0.25
"""How far the probe may go behind a retracted position that is not free, how far of that without any fall of force,
which friction may hide, and in what pieces."""
_FALL_N, _RISEN_N = 0.1, 0.3
_UNMOVED_MM = 1.0
"""A free motor that gives way itself and does not go so far has a frozen encoder, and pulls away without an end."""
_STUCK_S = 2.5
"""How much longer motors that have not obeyed while the probe presses are told to; then they go off where they are."""
_NEARER_MM = 0.02
"""In a rest, by which free motors are still on their way."""
_REST_S, _PACE_S = 0.05, 0.02
"""A short rest; and between commands at rest, each of which keeps the watchdog of the motors from running out."""
_SPREAD = 0.4
"""Share of the full preset by which motors may stand off the last one that was commanded."""
_JUMP_MM, _FASTEST = 0.5, 1.5
"""Beyond the largest speed of the rig times that, by which motors have not gone but their encoder has jumped."""

Log = Callable[[float, float, list[str]], ForceSample | None]


@dataclass(frozen=True)
class SafeEnd:
    """What was reached, and what went wrong on the way. last_force_n : of all three axes; None without a sensor."""

    retracted: bool
    deactivated: bool
    last_force_n: float | None
    notes: tuple[str, ...]


@dataclass(frozen=True)
class Start:
    """Where the way out begins.

    depth_mm, preset : of the motors. softest : preset that bears the least. contact_n : force of contact.
    home_is_free : a press had begun, so that the retracted position was free of contact.
    """

    depth_mm: float
    preset: float
    softest: float
    contact_n: float
    home_is_free: bool


def make_safe(actuator: Actuator, rig: RigSettings, clock: Clock, start: Start | None, log: Log) -> SafeEnd:
    """Retract, wait until the motors have followed, switch them off.

    The probe only moves away, and only while that does not make the force grow: else it is held and made as soft as it
    can be, until the force has come to rest. If a piece of the way makes it grow once more, or the motors do not obey,
    they go off there. A retracted position that was never free of
    contact is left behind as long as the force falls. All of that is limited in time.

    Nothing keeps it from trying, not even twenty times Ctrl-C. None as ``start``: nothing is known to have moved, so
    only motors off. Retracted is what the encoders say, for motors that have gone off by themselves obey no command,
    and what the force sensor says, unless that has gone. ``log`` is told every position and preset, and tells the
    force.
    """
    escape = _Escape(actuator, rig, clock, log)
    retracted = start is not None and escape.retract(start)
    deactivated = any(escape.tried(actuator.deactivate) for _ in range(_OFF_ATTEMPTS))
    return SafeEnd(retracted, deactivated, escape.felt_n, tuple(dict.fromkeys(escape.notes)))


class _Pressing(Exception):
    """The way out presses harder, or leads nowhere."""


class _Jumped(Exception):
    """An encoder of the motors reads another place than they can have gone to."""


class _Escape:
    def __init__(self, actuator: Actuator, rig: RigSettings, clock: Clock, log: Log) -> None:
        self._actuator, self._rig, self._clock, self._log = actuator, rig, clock, log
        self.notes: list[str] = []
        self.felt_n: float | None = None
        self._depth_mm, self._preset, self._lowest_n = 0.0, 0.0, math.inf
        self._held = self._tried = self._woken = False
        self._failures, self._off_mm = 0, math.inf
        self._seen: tuple[float, float] | None = None
        self._jumped = False
        self._shaft_deg, self._shaft_from_mm, self._contact_n = math.nan, 0.0, math.inf
        self._vectors: deque[tuple[float, ...]] = deque(maxlen=max(1, round(2 * _REST_S * rig.rate_hz)))

    def retract(self, start: Start) -> bool:
        """Whether encoders and force say that it is retracted."""
        self._preset, self._softest, self._contact_n = start.preset, start.softest, start.contact_n
        # the last steps of the encoders behind the retracted position are not worth a motion
        self._depth_mm = max(start.depth_mm, 0.0) if start.depth_mm > -_THERE_MM else start.depth_mm
        self._goal_mm = min(self._depth_mm, 0.0)
        end_s = self._clock.now_s() + _HEALS_S
        while True:
            try:
                self._take_away(start)
                break
            except _Pressing as why:
                if self._failures and self._answers_again(end_s):
                    continue
                self.notes.append(f"the probe was not taken away further: {why}")
                break
            except _Jumped as why:
                self.notes.append(str(why))
                self.tried(self._actuator.deactivate)
                if self._jumped:  # one that goes on jumping leads nowhere
                    break
                self._jumped, self._woken = True, False
                self._goal_mm = min(self._depth_mm, 0.0)
        return self.tried(lambda: self._check(start.contact_n))

    def _take_away(self, start: Start) -> None:
        """Take the probe away from where it is. _Pressing : it presses harder, or leads nowhere."""
        low_deg, high_deg = self._rig.position_deg
        if not low_deg <= self._rig.position_at(self._depth_mm) <= high_deg:
            # the device would take no command, and go by that encoder with all its force
            raise _Pressing(f"the encoder reads {self._depth_mm:.1f} mm, where position_deg does not reach")
        if not self._held:  # else the motors are on their way to the softest preset
            self._check_spread()
        self._wake()
        self._ramp(self._goal_mm)
        before_mm = self._from_home_mm()
        self._rest(self._rig.settle_s)
        if not self._there() and self._wake():  # gone off on the way
            self._ramp(self._goal_mm)
            self._rest(self._rig.settle_s)
        if self._there() and self._touches(start.contact_n):
            self._come_to_rest()
        end_s = self._clock.now_s() + _STUCK_S
        while not self._there() and self._clock.now_s() < end_s:
            at_mm = self._from_home_mm()
            if not (self._touches(start.contact_n) or at_mm < before_mm - _NEARER_MM):
                break
            before_mm = at_mm
            self._rest(_REST_S)
            if self._wake():
                self._ramp(self._goal_mm)
            if not self._touches(start.contact_n):
                self._rest(self._rig.settle_s)
        pressed_there = self._there() and self._touches(start.contact_n)
        if not start.home_is_free or self._goal_mm < 0 or pressed_there:
            self._leave()

    def _check_spread(self) -> None:
        """_Pressing where the two motors of springs are further apart, or nearer, than any command has sent them: one
        encoder has jumped, and no command for both takes the probe away."""
        joint, at = self._actuator.joint, list[Measurements]()
        if joint is None or gives_way(joint) or not self.tried(lambda: at.append(self._actuator.measurements())):
            return
        if abs((spread := joint.preset_at(at[0])) - self._preset) > _SPREAD:
            raise _Pressing(f"the motors stand as for a preset of {100 * spread:.0f} %: an encoder has jumped")

    def _answers_again(self, end_s: float) -> bool:
        """After commands that failed: whether the actuator answers before ``end_s``. Meanwhile it is told to go to the
        end of the way, and then off, for it may hear without answering."""
        self.tried(lambda: self._actuator.command(self._rig.position_at(self._goal_mm), self._preset))
        self._wait(self._rig.settle_s)
        self.tried(self._actuator.deactivate)
        while self._clock.now_s() < end_s:
            if self.tried(self._actuator.is_active):
                self._failures, self._woken = 0, False
                return True
            self.tried(lambda: self._feel(self._rig.position_at(self._depth_mm)))
            self._wait(_REST_S)
        return False

    def _wake(self) -> bool:
        """Whether motors that had gone off by themselves, and answer, are on again where they stand: once. A reset or a
        watchdog that has run out leaves the probe pressed, and takes no command."""
        said: list[bool] = []
        if self._woken or not self.tried(lambda: said.append(self._actuator.is_active())) or said[0]:
            return False
        self._woken = True
        self.notes.append("the motors had gone off; they were switched on where they stood, to take the probe away")
        return self._on_where_they_stand()

    def tried(self, action: Callable[[], object]) -> bool:
        """Whether ``action`` came to its end; what kept it from that is noted."""
        try:
            action()
        except BaseException as error:
            self.notes.append(f"{type(error).__name__}: {error}".removesuffix(": "))
            return False
        return True

    def _ramp(self, to_mm: float) -> None:
        while True:
            step_mm = self._rig.escape_mm_per_s * self._rig.period_s
            self._step(max(to_mm, self._depth_mm - step_mm))
            if self._depth_mm <= to_mm:
                return
            self._wait(self._rig.period_s)

    def _rest(self, duration_s: float) -> None:
        told_s = self._clock.now_s()
        end_s = told_s + duration_s
        while (left_s := end_s - self._clock.now_s()) > 0:
            self._wait(min(left_s, self._rig.period_s))
            # few commands: on a line that loses bytes each may become another one; yet enough to see a jump
            if (now_s := self._clock.now_s()) - told_s >= _PACE_S - 1e-6 or now_s >= end_s:
                self._step(self._depth_mm)
                told_s = now_s
            else:
                self.tried(lambda: self._feel(self._rig.position_at(self._depth_mm)))

    def _leave(self) -> None:
        end_mm, unfelt_mm, fallen_n = self._depth_mm - _BEYOND_MM, 0.0, self._mean_n() or 0.0
        away = (self._mean_n() or 0.0) < _FALL_N
        while not away and self._depth_mm > end_mm:
            left_n = self._mean_n() or 0.0
            away = left_n < _FALL_N  # one piece more takes the last of it away
            if unfelt_mm >= _UNFELT_MM:
                raise _Pressing(f"{left_n:.2f} N do not fall on the way")
            low_deg, high_deg = self._rig.position_deg
            if not low_deg <= self._rig.position_at(self._depth_mm - _PIECE_MM) <= high_deg:
                raise _Pressing("position_deg ends there")
            self._step(self._depth_mm - _PIECE_MM)
            self._rest(2 * _REST_S)
            unfelt_mm += _PIECE_MM
            if (self._mean_n() or 0.0) > left_n + _RISEN_N:
                raise _Pressing(f"the force grew to {self._mean_n() or 0.0:.2f} N")
            if (now_n := self._mean_n()) is not None and now_n < fallen_n - _FALL_N:
                unfelt_mm, fallen_n = 0.0, now_n

    def _step(self, depth_mm: float) -> None:
        """Command a depth, and feel. _Pressing when the force has grown for the second time, or nobody obeys."""
        position_deg = self._rig.position_at(depth_mm)
        if self.tried(lambda: self._actuator.command(position_deg, self._preset)):
            self._depth_mm, self._failures = depth_mm, 0
        elif self.notes[-1] != KeyboardInterrupt.__name__:
            self._failures += 1
            if self._failures == _SEND_ATTEMPTS:
                raise _Pressing("the actuator takes no commands")
        self.tried(lambda: self._feel(position_deg))
        self._see_jump()
        self._judge_motor(position_deg)
        if self.felt_n is not None and self.felt_n > self._lowest_n + _RISE_N:
            if self._held and (self._tried or not self._obeys()):
                raise _Pressing(f"the force grew to {self.felt_n:.2f} N")
            self._lowest_n = self.felt_n
            if not self._held:
                self._hold()

    def _see_jump(self) -> None:
        """_Jumped where the motors read further from where they were than they can have gone: the device goes by that
        reading, with all its force. They are to go off, and on again where they read to be."""
        at_mm: list[float] = []
        if not self.tried(lambda: at_mm.append(self._rig.depth_at(self._actuator.position_deg()))):
            self._seen = None
            return
        before, now_s = self._seen, self._clock.now_s()
        self._seen = at_mm[0], now_s
        if before is None:
            return
        most_mm = _JUMP_MM + _FASTEST * self._rig.max_mm_per_s * (now_s - before[1])
        if abs(at_mm[0] - before[0]) > most_mm:
            self._depth_mm = at_mm[0]
            raise _Jumped(f"the encoder jumped by {at_mm[0] - before[0]:.1f} mm on the way out")

    def _hold(self) -> None:
        """Stop, and find out with one piece of the way whether the force really grows: a sensor that lags tells of the
        way in for some time yet. Motors that do not obey meanwhile, as with an encoder that has jumped, go off."""
        self._held = True
        if self._preset != self._softest:
            self._preset = self._softest
            self._rest(_HOLD_S)
        self._come_to_rest()
        before_n = self._mean_n()
        self._step(max(self._depth_mm - _PIECE_MM, self._goal_mm - _THERE_MM / 2))
        self._come_to_rest()
        self._tried, after_n = True, self._mean_n()
        if after_n is not None and before_n is not None and after_n > before_n + _RISEN_N:
            raise _Pressing(f"the force grew to {after_n:.2f} N")
        self._lowest_n = math.inf if after_n is None else after_n

    def _come_to_rest(self) -> None:
        """Motors off until the force has come to rest, so that no encoder that errs drives them on meanwhile; then on
        again where they stand."""
        end_s, level_n = self._clock.now_s() + _LAG_S, self._mean_n()
        if level_n is None or not self.tried(self._actuator.deactivate):
            return
        while level_n is not None and self._clock.now_s() < end_s:
            until_s = self._clock.now_s() + _STEADY_S
            while self._clock.now_s() < until_s:
                self._wait(self._rig.period_s)
                self.tried(lambda: self._feel(self._rig.position_at(self._depth_mm)))
            before_n, level_n = level_n, self._mean_n()
            if level_n is not None and abs(level_n - before_n) < _STEADY_N:
                break
        self._on_where_they_stand()

    def _on_where_they_stand(self) -> bool:
        """Whether they go on."""
        at_mm: list[float] = []
        if not self.tried(self._actuator.activate):
            return False
        if self.tried(lambda: at_mm.append(self._rig.depth_at(self._actuator.position_deg()))):
            self._depth_mm, self._seen = at_mm[0], None
            if at_mm[0] < self._goal_mm - _THERE_MM:  # no way leads back towards the specimen
                self._goal_mm = at_mm[0]
        return True

    def _obeys(self) -> bool:
        depths_mm: list[float] = []
        self.tried(lambda: depths_mm.append(self._rig.depth_at(self._actuator.position_deg())))
        if not depths_mm:
            return False
        before_mm, self._off_mm = self._off_mm, abs(depths_mm[0] - self._depth_mm)
        return self._off_mm <= self._there_mm() or self._off_mm < min(before_mm, _LAG_MM)

    def _feel(self, position_deg: float) -> None:
        sample = self._log(position_deg, self._preset, self.notes)
        felt_n = math.nan if sample is None else sample.size_n
        self.felt_n = felt_n if math.isfinite(felt_n) else None
        if sample is not None and self.felt_n is not None:
            self._vectors.append(sample.loads[:3])
        else:
            self._vectors.clear()
        self._lowest_n = min(self._lowest_n, math.inf if self.felt_n is None else felt_n)

    def _mean_n(self) -> float | None:
        """Mean of the last samples: the noise of one sample is no force."""
        return mean_size(self._vectors) if self._vectors else None

    def _wait(self, duration_s: float) -> None:
        self.tried(lambda: self._clock.sleep_until(self._clock.now_s() + duration_s))

    def _touches(self, contact_n: float) -> bool:
        return self.felt_n is not None and self.felt_n >= contact_n

    def _there(self) -> bool:
        return self._from_home_mm() <= self._there_mm()

    def _from_home_mm(self) -> float:
        """Distance from home by the motors' encoders; infinite where they do not tell."""
        depths_mm: list[float] = []
        self.tried(lambda: depths_mm.append(self._rig.depth_at(self._actuator.position_deg())))
        return abs(depths_mm[0]) if depths_mm else math.inf

    def _there_mm(self) -> float:
        """So close to the retracted position is there; friction holds a motor that gives way itself further off."""
        joint = self._actuator.joint
        if joint is None or not gives_way(joint) or self._preset == 0:
            return _THERE_MM
        held_nm = self._rig.guards.spring_rest_n * self._rig.lever_m
        held_rad = held_nm / float(joint.stiffness_nm_per_rad(self._preset))
        return _THERE_MM + math.degrees(held_rad) * self._rig.gear_mm_per_degree

    def _judge_motor(self, position_deg: float) -> None:
        """_Pressing when a motor that gives way itself has a wrong encoder, and drives on with all it has: only torque
        off ends that. By its encoder it presses on, or it pulls away and does not move though the probe is free."""
        joint, at = self._actuator.joint, list[Measurements]()
        if joint is None or not gives_way(joint):
            return
        if not self.tried(lambda: at.append(self._actuator.measurements())):
            return
        pressing_n = -self._rig.push_sign * joint.torque_nm(at[0], position_deg, self._preset) / self._rig.lever_m
        if pressing_n > self._rig.guards.spring_n:
            raise _Pressing(f"the motor presses with {pressing_n:.1f} N by its encoder")
        if at[0].shaft_deg != self._shaft_deg:
            self._shaft_deg, self._shaft_from_mm = at[0].shaft_deg, self._depth_mm
        unmoved = self._shaft_from_mm - self._depth_mm > _UNMOVED_MM and not self._touches(self._contact_n)
        # without a force sensor nobody knows whether it is the specimen that holds it
        most_n = self._rig.guards.spring_rest_n * (1 if self.felt_n is not None else 2)
        if unmoved and -pressing_n > most_n:
            raise _Pressing(f"the motor pulls away with {-pressing_n:.1f} N by its encoder, which does not move")

    def _check(self, contact_n: float) -> None:
        depth_mm = self._rig.depth_at(self._actuator.position_deg())
        pulled = depth_mm < 0 and self._touches(contact_n)  # as far as the force would have fallen
        if abs(depth_mm) > self._there_mm() and not pulled:
            do = "Take it away from the specimen by hand, or by the next run."
            found = f"{depth_mm:.1f} mm from it"
            raise DeviceError("probe", wanted="motors at the retracted position", found=found, do=do)
        if self._touches(contact_n):
            do = "See what touches the probe; check home_deg and the zero of the force sensor."
            wanted = f"less than {contact_n:g} N at the retracted position"
            raise DeviceError("probe", wanted=wanted, found=f"{self.felt_n:.2f} N", do=do)
