"""The table [actuator] of a Dynamixel: what is read, and what is said of each wrong key."""

from __future__ import annotations

import pytest

from emg2vsa import rig
from emg2vsa.devices.dynamixel import DynamixelSettings
from emg2vsa.errors import StudyError
from tests.rig.dynamixel.conftest import FULL, Files

KEYS = (
    'kind = "dynamixel"\nmodel = "xm430-w350"\nfull_gain = 800\nd_gain = 1500\n'
    f"full_stiffness_nm_per_rad = {FULL}\ngoal_current_a = 0.4\n"
)


def test_every_key_is_read(rig_file: Files) -> None:
    text = 'port = "/dev/ttyUSB0"\nid = 7\nbaud = 57600\nwatchdog_s = 0.3\nreply_s = 0.02\n'
    assert rig.load(rig_file((KEYS, KEYS + text))).devices.actuator == DynamixelSettings(
        kind="dynamixel", port="/dev/ttyUSB0", id=7, baud=57600, model="xm430-w350", full_gain=800, d_gain=1500,
        full_stiffness_nm_per_rad=FULL, goal_current_a=0.4, watchdog_s=0.3, reply_s=0.02,
    )  # fmt: skip


def test_the_full_preset_is_the_measured_stiffness(rig_file: Files) -> None:
    assert rig.load(rig_file()).rig.full_preset == FULL


@pytest.mark.parametrize(
    ("line", "told"),
    [
        ("id = 253", "actuator.id: expected a number <= 252, but found 253."),
        ("id = -1", "actuator.id: expected a number >= 0, but found -1."),
        ("id = 1.5", "actuator.id: expected a whole number, but found 1.5."),
        ("port = 3", "actuator.port: expected text in quotes, but found 3."),
        ("baud = 1000", "actuator.baud: expected 9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000 or 4500000, "
         "but found 1000."),
        ('model = "mx-28"', "actuator.model: expected 'xm430-w350', 'xm430-w210', 'xh430-w350', 'xh430-w210', "
         "'xm540-w150' or 'xm540-w270', but found \"mx-28\"."),
        ("full_gain = 0", "actuator.full_gain: expected a number >= 1, but found 0."),
        ("full_gain = 16384", "actuator.full_gain: expected a number <= 16383, but found 16384."),
        ('full_gain = "800"', 'actuator.full_gain: expected a whole number, but found "800". Write it without quotes.'),
        ("d_gain = -1", "actuator.d_gain: expected a number >= 0, but found -1."),
        ("d_gain = 16384", "actuator.d_gain: expected a number <= 16383, but found 16384."),
        ("full_stiffness_nm_per_rad = 0", "actuator.full_stiffness_nm_per_rad: expected a number > 0, but found 0."),
        ('full_stiffness_nm_per_rad = "stiff"',
         'actuator.full_stiffness_nm_per_rad: expected a number, but found "stiff".'),
        ("goal_current_a = 0", "actuator.goal_current_a: expected a number >= 0.02, but found 0."),
        ("goal_current = 0.4", "actuator.goal_current: expected a known key, but found 'goal_current'. "
         "Did you mean 'goal_current_a'?"),
        ("watchdog_s = 0.05", "actuator.watchdog_s: expected a number >= 0.06, but found 0.05."),
        ("watchdog_s = 3", "actuator.watchdog_s: expected a number <= 2.54, but found 3."),
        ("reply_s = 0", "actuator.reply_s: expected a number >= 0.001, but found 0."),
        ("reply_s = 0.17", "actuator.reply_s: expected at most 0.167, so that 3 attempts end before watchdog_s, "
         "but found 0.17."),
        ('generation = "v6"', "actuator.generation: expected keys of this kind only ('generation' is of 'qbmove'), "
         "but found 'generation' with kind = 'dynamixel'."),
        ('kind = "dynamixl"',
         "actuator.kind: expected 'qbmove' or 'dynamixel', but found \"dynamixl\". Did you mean 'dynamixel'?"),
    ],
)  # fmt: skip
def test_a_wrong_key_is_one_clear_error(line: str, told: str, rig_file: Files) -> None:
    name = line.partition(" = ")[0]
    kept = "".join(each + "\n" for each in KEYS.splitlines() if not each.startswith(f"{name} = "))
    with pytest.raises(StudyError) as error:
        rig.load(rig_file((KEYS, f"{line}\n{kept}")))
    assert str(error.value).endswith(f"rig.toml:7: {told}")
