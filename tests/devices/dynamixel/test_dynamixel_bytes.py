"""The driver against a script of bytes. Packets in hexadecimal are those of the e-Manual, "DYNAMIXEL Protocol 2.0"."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable

import pytest

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.dynamixel import REPLY_S, DynamixelSettings
from emg2vsa.devices.dynamixel.conversation import Conversation, Status, answers
from emg2vsa.devices.dynamixel.driver import Dynamixel
from emg2vsa.devices.protocols import Measurements, Parameter, Usable
from emg2vsa.devices.serial_line import LoopbackLine
from emg2vsa.errors import DeviceError
from tests.devices.dynamixel.script import (
    OFF,
    PING,
    PING_ONE,
    PONG,
    Pair,
    activation,
    asked,
    info,
    number,
    packet,
    read,
    scripted,
    status,
    write,
    written,
)

PRESENT = asked(126, 10)


def reading(current: int, velocity: int, position: int, error: int = 0) -> Pair:
    return PRESENT, status(number(current, 2) + number(velocity, 4) + number(position, 4), error)


def published(sent: str, answer: str) -> LoopbackLine:
    """A line of one pair, that of the manual."""

    def device(data: bytes) -> bytes:
        assert data.hex(" ") == sent
        return bytes.fromhex(answer)

    return LoopbackLine("manual", device, VirtualClock())


def test_the_ping_of_the_manual() -> None:
    line = published("ff ff fd 00 01 03 00 01 19 4e", "ff ff fd 00 01 07 00 55 00 06 04 26 65 5d")
    assert list(answers(line, VirtualClock(), [1], REPLY_S)) == ["id 1, xm430-w210, firmware 38"]


@pytest.mark.parametrize(
    ("sent", "answer", "ask", "data"),
    [
        ("ff ff fd 00 01 07 00 02 84 00 04 00 1d 15", "ff ff fd 00 01 08 00 55 00 a6 00 00 00 8c c0",
         lambda talk: talk.read(1, 132, 4), b"\xa6\0\0\0"),
        ("ff ff fd 00 01 09 00 03 74 00 00 02 00 00 ca 89", "ff ff fd 00 01 04 00 55 00 a1 0c",
         lambda talk: talk.write(1, 116, b"\0\2\0\0"), b""),
    ],
    ids=["read", "write"],
)  # fmt: skip
def test_the_read_and_the_write_of_the_manual(
    sent: str, answer: str, ask: Callable[[Conversation], Status], data: bytes
) -> None:
    assert ask(Conversation(published(sent, answer), VirtualClock(), REPLY_S)) == (0, False, data)


def test_the_script_catches_what_is_left_over() -> None:
    with pytest.raises(AssertionError, match="left over"), scripted(read(64, 1, 0)):
        pass


def test_a_turn_reads_once_for_position_and_current() -> None:
    with scripted(reading(-100, -3, 2048 + 512)) as motor:
        assert motor.measurements() == Measurements((45.0,), 45.0)
        assert motor.currents_a() == pytest.approx((-0.269,))


def test_a_current_is_never_told_twice() -> None:
    with scripted(reading(100, 0, 2048), reading(1, 0, 2048), reading(2, 0, 2048)) as motor:
        assert motor.currents_a() == pytest.approx((0.269,))
        motor.measurements()
        assert motor.currents_a() == pytest.approx((0.00269,))
        assert motor.currents_a() == pytest.approx((0.00538,))


@pytest.mark.parametrize(("pulses", "degrees"), [(2048, 0), (0, -180), (-1, -180.087890625), (4095, 179.912109375)])
def test_positions_are_two_s_complement(pulses: int, degrees: float) -> None:
    with scripted(reading(0, 0, pulses)) as motor:
        assert motor.position_deg() == degrees


def test_what_is_stuffed_in_a_reply_is_taken_out() -> None:
    data = bytes.fromhex("ffff fdff ffff 00080000")  # the current -1, the speed -3 and the position 2048
    stuffed = packet(1, 0x55, 0, *data[:3], 0xFD, *data[3:])
    with scripted((PRESENT, stuffed)) as motor:
        assert motor.measurements().shaft_deg == 0
        assert motor.currents_a() == pytest.approx((-0.00269,))


def test_activation_and_end() -> None:
    with scripted(*activation(2000, pwm_limit=700), *OFF) as motor, motor:
        motor.activate()
        assert motor.current_limit_a() == pytest.approx(185 * 0.00269)


def test_a_gain_is_written_only_when_it_changes() -> None:
    goal = write(116, 4, 2048 + 114)
    with scripted(*activation(), goal, write(84, 2, 400), goal, goal, write(84, 2, 0), goal) as motor:
        motor.activate()
        for preset in (1.0, 0.5, 0.5003, 0.0):
            motor.command(10.0, preset)


def test_a_gain_that_was_not_confirmed_is_written_again() -> None:
    silent = (write(84, 2, 400)[0], b"")
    with scripted(*activation(), silent, silent, silent, write(84, 2, 800), write(116, 4, 2048)) as motor:
        motor.activate()
        with pytest.raises(DeviceError, match=r"a reply to Position P Gain \(84\), but found none in 3 attempts"):
            motor.command(0, 0.5)
        motor.command(0, 1)  # the gain of before, and perhaps no longer the motor's


def test_before_its_stiffness_is_measured_the_gain_supposes_one() -> None:
    with scripted(*activation(), write(116, 4, 2048 + 57), full_stiffness_nm_per_rad=None) as motor:
        motor.activate()
        motor.command(5, 1)
        assert motor.joint.full_preset == pytest.approx(4.1 / 2.3 * 2.69e-3 * 800 / 128 * 4096 / (2 * math.pi))
        assert motor.settings.unmeasured == "full_stiffness_nm_per_rad"


NOT_SET_UP = [
    ({(0, 2): 1030}, r"model number: expected 1020, the xm430-w350, but found 1030. Correct \[actuator\] model"),
    ({(6, 1): 45, (7, 1): 3}, "id: expected 1, but found 3. It answers to a Secondary ID"),
    ({(13, 1): 1}, "protocol type: expected 2, but found 1"),
    ({(11, 1): 3}, "operating mode: expected 5, current-based position control, but found 3.*--set 11=5"),
    ({(10, 1): 1}, "drive mode: expected 0: not reversed.*but found 1.*--set 10=0"),
    ({(10, 1): 4}, "drive mode: expected 0.*no time-based profile.*but found 4"),
    ({(10, 1): 8}, "drive mode: expected 0.*no torque by a goal, but found 8"),
    ({(20, 4): -2049}, "homing offset: expected -2048 to 2048 pulses, half a turn, but found -2049. Run emg2vsa"),
    ({(52, 4): 3000, (48, 4): 3000}, "position limits: expected two pulses of 0 to 4095.*but found 3000 and 3000"),
    ({(52, 4): 0, (48, 4): 4096}, "position limits: expected two pulses of 0 to 4095.*but found 0 and 4096"),
    ({(38, 2): 185}, "current limit: expected at least goal_current_a, 0.5 A, but found 0.498 A"),
    ({(63, 1): 20}, "shutdown: expected overload among the errors.*0x20, but found 0x14.*--set 63=52"),
    ({(60, 1): 1}, "startup configuration: expected 0: torque off.*but found 1.*--set 60=0"),
    ({(68, 1): 1}, "status return level: expected 2, an answer to everything, but found 1. Reboot it"),
    ({(70, 1): 0x24}, "hardware error: expected none, but found overheating, overload. Let it cool.*Take.*Then reboot"),
    ({(70, 1): 0x11}, "hardware error: expected none, but found input voltage, electrical shock. Check the supply"),
    ({(70, 1): 0x08}, "hardware error: expected none, but found motor encoder. Have the motor repaired. Then reboot"),
]  # fmt: skip


def limited(*ask: Pair) -> list[Pair]:
    return [*activation(limits=(1821, 2389)), *ask]


def until(*last: Pair) -> list[Pair]:
    """An activation, with the first of these as the answer to the last question like it, and those after it."""
    pairs = activation()
    at = max(place for place, (sent, _) in enumerate(pairs) if sent == last[0][0])
    return [*pairs[:at], *last]


def activate(motor: Dynamixel) -> None:
    motor.activate()


def then(act: Callable[[Dynamixel], object]) -> Callable[[Dynamixel], None]:
    """What is refused after an activation."""

    def both(motor: Dynamixel) -> None:
        motor.activate()
        act(motor)

    return both


def setting(number_of: int, *values: float) -> Callable[[Dynamixel], object]:
    return lambda motor: motor.set_parameter(number_of, values)


STILL_ON = [OFF[0], OFF[1], read(64, 1, 1), read(98, 1, 0)]
LOADED = read(70, 1, 0x20, error=0x80)
AFTER_THE_FIRST = "expected a position of -19.95 to 29.97 degrees"
TROUBLES = [
    *((info(changed), activate, told) for changed, told in NOT_SET_UP),
    ([pair for pair in info({(6, 1): 44}) if pair[0] not in (asked(10, 1), asked(60, 1))], activate,
     "firmware: expected 45 or newer, but found 44. Update it with DYNAMIXEL Wizard"),
    # another series, before its other table is read
    ([read(0, 2, 1060), read(6, 1, 46)], activate, "expected one of xm430-w350, .*, but found model number 1060"),
    ([*info({(52, 4): 1024, (48, 4): 3072}), read(132, 4, 3152)], activate,
     "expected a shaft at -90.00 to 90.00 degrees, but found 97.03. Turn it there by hand"),
    (until(read(98, 1, 0), read(70, 1, 0)), activate, r"expected 25 in Bus Watchdog \(98\), but found 0"),
    (until(read(64, 1, 0, error=0x80), read(70, 1, 0x10, error=0x80)), activate, "found electrical shock. Check"),
    *((limited(), then(lambda motor, deg=deg: motor.command(deg, 0.5)), AFTER_THE_FIRST)
      for deg in (-19.96, 29.98, math.nan, math.inf)),
    *((limited(), then(lambda motor, deg=deg: motor.move_motors((deg,))), AFTER_THE_FIRST) for deg in (-19.96, 29.98)),
    *((activation(), then(lambda motor, preset=preset: motor.command(0, preset)), "expected a preset of 0 to 1")
      for preset in (-0.001, 1.001, math.nan)),
    ([], lambda motor: motor.command(0, 1), "Call activate first"),
    ([], lambda motor: motor.current_limit_a(), "Call activate first"),
    ([*activation(), write(116, 4, 2048, error=4), read(98, 1, 25)], then(lambda motor: motor.command(0, 1)),
     r"Goal Position \(116\) done, but found the motor says a value outside its range"),
    ([*activation(), reading(0, 0, 2048, error=0x80), LOADED], then(lambda motor: motor.measurements()),
     "hardware error: expected none, but found overload"),
    ([*activation(), write(116, 4, 2048, error=0x80), LOADED], then(lambda motor: motor.command(0, 1)),
     "hardware error: expected none, but found overload"),
    (STILL_ON * 10, lambda motor: motor.deactivate(), r"torque off.*no confirmation.*power off"),
    ([], setting(7, 2.0), "expected another parameter than 7, ID, but found the motor would no longer answer"),
    ([], setting(8, 3.0), "expected another parameter than 8, Baud Rate, but found the motor would no longer answer"),
    ([], setting(13, 1.0), "expected another parameter than 13, Protocol Type"),
    ([], setting(116, 1.0), "expected a parameter of the motor, but found 116"),
    ([], setting(9, 255.0), "one whole number of 0 to 254 for parameter 9, Return Delay Time, but found 255"),
    *(([], setting(9, *values), f"but found {found}") for values, found in
      (((1.5,), "1.5"), ((1.0, 2.0), "1, 2"), ((math.nan,), "nan"), ((math.inf,), "inf"))),
    ([], setting(20, -131073.0), "one whole number of -2048 to 2048 for parameter 20, Homing Offset"),
    ([read(64, 1, 1)], setting(11, 5.0), "torque off while Operating Mode is set, but found"),
    ([read(64, 1, 0), write(11, 1, 2), read(11, 1, 3), read(70, 1, 0)], setting(11, 2.0),
     r"expected 2 in Operating Mode \(11\), but found 3"),
    ([read(64, 1, 0), write(11, 1, 2, error=6)], setting(11, 2.0), "the motor says a value outside its limits"),
    # the offset of before is set again
    ([read(64, 1, 0), read(20, 4, 10), read(132, 4, 2500), *written(20, 4, -442), reading(0, 0, 2060),
      *written(20, 4, 10)], lambda motor: motor.set_zeros(), r"a shaft at 0 degrees, but found 1.05. Hold"),
    ([read(64, 1, 0), read(20, 4, 0), read(132, 4, -6000)], lambda motor: motor.set_zeros(),
     r"within a turn of its encoder, but found -1.5 turns"),
]  # fmt: skip


@pytest.mark.parametrize(("pairs", "act", "told"), TROUBLES)
def test_what_is_refused_is_told_and_nothing_more_is_sent(
    pairs: list[Pair], act: Callable[[Dynamixel], object], told: str
) -> None:
    with scripted(*pairs) as motor, pytest.raises(DeviceError, match=told):
        act(motor)


@pytest.mark.parametrize("pulses", [-12, -11, 11, 12])
def test_a_goal_may_follow_a_shaft_that_creeps_by_a_degree(pulses: int) -> None:
    if abs(pulses) <= 11:
        crept = (read(116, 4, 2048 + pulses) if pair == read(116, 4, 2048) else pair for pair in activation())
        with scripted(*crept) as motor:
            motor.activate()
        return
    script = scripted(*until(read(116, 4, 2048 + pulses), read(70, 1, 0)))
    with script as motor, pytest.raises(DeviceError, match=r"expected 2048 in Goal Position \(116\), but found"):
        motor.activate()


@pytest.mark.parametrize(
    ("torque", "alert", "watchdog", "active"),
    [(1, 0, 25, True), (0, 0, 25, False), (1, 0x80, 25, False), (1, 0, 255, False), (1, 0, 0, True)],
)
def test_active(torque: int, alert: int, watchdog: int, active: bool) -> None:
    pairs = read(64, 1, torque, error=alert), read(98, 1, watchdog, error=alert)
    with scripted(*pairs, *pairs) as motor:
        assert motor.is_active() is motor.ask_active() is active


def test_a_goal_after_the_watchdog_is_told_as_such() -> None:
    refused, expired = write(116, 4, 2048, error=4), read(98, 1, 255)
    told = "expected a packet at least every 0.5 s, but found a watchdog that has run out. The motor has stopped"
    with scripted(*activation(), refused, expired, refused, expired) as motor:
        motor.activate()
        with pytest.raises(DeviceError, match=told):
            motor.command(0, 1)
        motor.move_motors((0.0,))
        assert motor.watchdog_ran_out()


def test_deactivation_insists() -> None:
    deaf = [(OFF[0][0], b""), OFF[1], read(64, 1, 0), read(98, 1, 255)]
    mute = [(sent, b"") for sent, _ in OFF]
    with scripted(*STILL_ON, *deaf, *mute, *OFF) as motor:
        motor.deactivate()


def test_deactivation_heeds_no_alert() -> None:
    with scripted(*(read(64, 1, 0, 0x80) if sent == asked(64, 1) else (sent, answer) for sent, answer in OFF)) as motor:
        motor.deactivate()


def test_the_context_ends_with_torque_off_and_keeps_the_first_error() -> None:
    with pytest.raises(KeyboardInterrupt), scripted(*OFF) as motor, motor:
        raise KeyboardInterrupt
    with pytest.raises(ZeroDivisionError) as told, scripted(*STILL_ON * 10) as motor, motor:
        raise ZeroDivisionError
    assert "Switch the power off" in told.value.__notes__[0]
    with pytest.raises(DeviceError, match="Switch the power off"), scripted(*STILL_ON * 10) as motor, motor:
        pass


def test_a_mute_motor_takes_three_attempts_of_the_clock_s_time() -> None:
    clock = VirtualClock()
    with scripted(*[(PRESENT, b"")] * 3, clock=clock, pong=b"") as motor:
        with pytest.raises(DeviceError, match=r"expected a reply to Present Current.*none in 3 attempts of 0.016 s"):
            motor.measurements()
        assert clock.now_s() == pytest.approx(3 * REPLY_S)
        assert (motor.counts.requests, motor.counts.lost, motor.counts.corrupt) == (5, 5, 0)


GOOD = reading(7, 0, 2048)[1]


@pytest.mark.parametrize("at", range(len(GOOD)))
def test_any_byte_lost_costs_one_attempt(at: int) -> None:
    with scripted((PRESENT, GOOD[:at] + GOOD[at + 1 :]), (PRESENT, GOOD)) as motor:
        assert motor.measurements().shaft_deg == 0
        assert (motor.counts.requests, motor.counts.lost) == (3, 1)


@pytest.mark.parametrize("at", range(len(GOOD)))
@pytest.mark.parametrize("mask", [0x01, 0x80, 0xFF])
def test_any_byte_changed_costs_one_attempt(at: int, mask: int) -> None:
    changed = bytes((*GOOD[:at], GOOD[at] ^ mask, *GOOD[at + 1 :]))
    with scripted((PRESENT, changed), (PRESENT, GOOD)) as motor:
        assert motor.measurements().shaft_deg == 0
        assert (motor.counts.requests, motor.counts.lost) == (3, 1)


def test_a_reply_after_its_time_is_no_answer_to_the_next_question() -> None:
    replies = iter((b"", status(bytes([5])) + PONG, status(bytes([0]))))
    sent: list[bytes] = []

    def device(data: bytes) -> bytes:
        sent.append(data)
        return next(replies)

    clock = VirtualClock()
    talk = Conversation(LoopbackLine("late", device, clock), clock, REPLY_S)
    assert talk.read(1, 64, 1, attempts=1) is None
    answer = talk.read(1, 98, 1, attempts=1)
    assert answer is not None
    assert answer.data == bytes([0])  # not 5, which came late
    assert sent == [asked(64, 1), PING_ONE, asked(98, 1)]


def test_a_ping_that_is_answered_by_an_error_alone_is_no_answer() -> None:
    with scripted(pong=status(error=7)) as motor:
        assert not motor.answers()


def test_a_wrong_checksum_is_counted_as_corrupt() -> None:
    with scripted((PRESENT, GOOD[:-1] + b"\0"), (PRESENT, GOOD)) as motor:
        motor.measurements()
        assert (motor.counts.lost, motor.counts.corrupt) == (1, 1)


@pytest.mark.parametrize(
    "before",
    [status(), status(b"\1\0"), status(bytes(10), device_id=2), b"\xff\xff\xfd\xfd", bytes(5)],
    ids=["a late answer to a write", "one to another read", "of another motor", "half a header", "noise"],
)
def test_what_comes_before_the_answer_is_passed_over(before: bytes) -> None:
    with scripted((PRESENT, before + GOOD)) as motor:
        assert motor.currents_a() == pytest.approx((7 * 0.00269,))
        assert motor.counts.lost == 0


def test_a_damaged_request_is_sent_again() -> None:
    with scripted((PRESENT, status(error=3)), (PRESENT, GOOD)) as motor:
        motor.measurements()
        assert motor.counts.lost == 1


def test_a_line_that_was_gone_for_a_moment_is_used_again() -> None:
    calls = iter((DeviceError("line", wanted="a line", found="none", do="Wait."), GOOD))

    def device(data: bytes) -> bytes:
        answer = next(calls)
        if isinstance(answer, DeviceError):
            raise answer
        return answer

    clock = VirtualClock()
    motor = Dynamixel(LoopbackLine("torn", device, clock), DynamixelSettings(kind="dynamixel"), clock=clock)
    with pytest.raises(DeviceError, match="expected a line"):
        motor.measurements()
    assert motor.measurements().shaft_deg == 0
    assert motor.counts.lost == 0


def test_what_an_earlier_answer_left_behind_is_not_the_next_answer() -> None:
    with scripted((PRESENT, GOOD + reading(8, 0, 2048)[1]), reading(9, 0, 2048)) as motor:
        assert motor.currents_a() == pytest.approx((7 * 0.00269,))
        assert motor.currents_a() == pytest.approx((9 * 0.00269,))


def test_a_parameter_is_set_with_the_torque_off_and_read_back() -> None:
    pairs = read(64, 1, 0), *written(11, 1, 5), read(11, 1, 5)
    with scripted(*pairs) as motor:
        assert motor.set_parameter(11, (5.0,)).values == (5,)


def test_zeros_are_a_homing_offset() -> None:
    pairs = read(64, 1, 0), read(20, 4, -24), read(132, 4, 2500), *written(20, 4, -476), reading(0, 0, 2049)
    with scripted(*pairs) as motor:
        assert motor.set_zeros().shaft_deg == pytest.approx(0.088, abs=0.001)


EEPROM = [
    (7, 1, 1), (8, 1, 3), (9, 1, 0), (10, 1, 0), (11, 1, 3), (12, 1, 255), (13, 1, 2), (20, 4, -7), (31, 1, 80),
    (32, 2, 160), (34, 2, 95), (36, 2, 885), (38, 2, 1193), (44, 4, 200), (48, 4, 4095), (52, 4, 0), (60, 1, 0),
    (63, 1, 52),
]  # fmt: skip


def test_what_the_motor_says_of_itself() -> None:
    pairs = [*info({(11, 1): 3}), reading(-50, 0, 1024), read(64, 1, 1)]
    with scripted(*pairs, full_stiffness_nm_per_rad=None) as motor:
        lines = list(motor.about())
    assert lines[:6] == [
        "xm430-w350, firmware 46, id 1",
        "operating mode 3, drive mode 0, protocol 2",
        "position limits: -180.00 to 179.91 degrees",
        "homing offset 0 pulses, current limit 3.209 A",
        "gains: P 800, I 0, D 0",
        "supply 12.1 V, 31 degrees Celsius inside",
    ]
    assert lines[6:8] == ["torque on, shaft at -90.00 degrees", "current -0.135 A"]
    assert lines[8].startswith("not ready for a run: script, dynamixel 1, operating mode: expected 5")
    assert lines[9:] == ["full stiffness not commissioned: no schedules"]


def test_parameters_are_what_is_kept_without_power() -> None:
    with scripted(*(read(*each) for each in EEPROM)) as motor:
        found = motor.parameters()
    assert [(number, parameter.values) for number, parameter in found.items()] == [
        (address, (value,)) for address, _, value in EEPROM
    ]
    assert found[7] == Parameter(7, "ID", (1,), "i")
    assert found[20].name == "Homing Offset"


def test_a_run_may_use_what_the_position_limits_leave() -> None:
    with scripted(*info({(52, 4): 1024, (48, 4): 3072})) as motor:
        assert motor.usable(motor.identify()) == Usable((-90.0, 90.0), 4.0)


def test_a_motor_with_a_hardware_error_still_tells_of_itself() -> None:
    alerted = [(sent, status(answer[9:-2], 0x80)) for sent, answer in info({(70, 1): 4})]
    pairs = [*alerted, reading(0, 0, 2048, error=0x80), read(64, 1, 0, 0x80)]
    with scripted(*pairs) as motor:
        lines = list(motor.about())
    assert "hardware error: overheating" in lines
    assert any(line.startswith("not ready for a run: script, dynamixel 1, hardware error:") for line in lines)


def test_a_scan_lists_who_answers() -> None:
    known = {5: b"\xfc\x03\x2e", 7: b"\x24\x04\x2d"}

    def device(data: bytes) -> bytes:
        assert data == packet(data[4], PING)
        return status(known[data[4]], device_id=data[4]) if data[4] in known else b""

    clock = VirtualClock()
    line = LoopbackLine("bus", device, clock)
    assert list(answers(line, clock, (), 0.005)) == ["id 5, xm430-w350, firmware 46", "id 7, model 1060, firmware 45"]
    assert clock.now_s() == pytest.approx(251 * 2 * 0.005)


def test_a_missing_extra_is_one_clear_error(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "dynamixel_sdk", None)
    with (
        pytest.raises(DeviceError, match=r'found no dynamixel_sdk. Install it: pip install "\.\[dynamixel\]"'),
        scripted(),
    ):
        pass
