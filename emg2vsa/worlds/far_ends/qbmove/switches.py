"""In what the Maker Pro and the Advanced differ, as their sources of generation 6 do."""

from __future__ import annotations

from dataclasses import dataclass

from emg2vsa.worlds.far_ends.qbmove.memory import INTERNAL_PER_TICK, Memory, fixed


@dataclass(frozen=True)
class Switches:
    """One model."""

    version: str
    counts_backwards: bool
    "Encoders count against the wire: offsets and references are negated on the way in, GET_INPUTS not on the way out."
    parameters: int
    parameter_bytes: int
    "The list without command and checksum."
    watchdog_counts: int
    "At the factory, and after each start."
    position_gains: tuple[float, float, float]
    current_gains: tuple[float, float, float]
    pwm_limit: int
    supply_mv: int
    motor_speed_rad_per_s: float
    stall_torque_nm: float
    "Load at which a motor stops."
    stall_current_ma: float
    "What it draws there at full PWM."
    has_counters: bool
    max_pwm_rate: int
    both_motors_or_none: bool
    "ACTIVATE with any bit switches both on."

    def factory(self, zeros_ticks: tuple[int, int, int] = (0, 0, 0)) -> Memory:
        """Settings after INIT_MEM; ``zeros_ticks``: what motor 1, motor 2 and shaft read where they begin."""
        return Memory(
            offsets=[ticks * INTERNAL_PER_TICK for ticks in zeros_ticks],
            position_pid=fixed(*self.position_gains),
            current_pid=fixed(*self.current_gains),
            watchdog_counts=self.watchdog_counts,
            max_pwm_rate=self.max_pwm_rate,
        )


MAKER_PRO = Switches(
    version="QBMMP v6.1.0",
    counts_backwards=False,
    parameters=13,
    parameter_bytes=1199,
    watchdog_counts=0,
    position_gains=(0.1, 0.0, 0.8),
    current_gains=(5.0, 0.0, 0.0),
    pwm_limit=43,  # the firmware's table at 24 V, for a motor of 8 V
    supply_mv=24000,
    motor_speed_rad_per_s=3.75,  # nickparnenzini/qbmove_plugin, qbmove_project.pdf
    # of the same source: 8 V over 2.3 ohm, 0.8 N m/A, less 0.8 N m of friction
    stall_torque_nm=2.0,
    stall_current_ma=3480.0,
    has_counters=False,
    max_pwm_rate=0,
    both_motors_or_none=False,
)
ADVANCED = Switches(
    version="QBADV v6.1.6",
    counts_backwards=True,
    parameters=14,
    parameter_bytes=1199,
    watchdog_counts=122,  # 5 s: the factory setting is the longest; which period runs before the first SET is unknown
    position_gains=(-0.1, 0.0, -0.8),
    current_gains=(3.0, 0.0, 0.0),
    pwm_limit=100,
    supply_mv=24000,
    motor_speed_rad_per_s=6.0,  # default of the Gazebo plugin of NMMI, a simulation's number
    stall_torque_nm=6.0,  # of the same
    stall_current_ma=7500.0,  # 0.8 N m/A as in the Maker Pro: a guess
    has_counters=True,
    max_pwm_rate=0,
    both_motors_or_none=True,
)
