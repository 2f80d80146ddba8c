"""The emulated qbmove of generation 6 against byte pairs of its protocol, with its silences and its faults."""

from __future__ import annotations

import itertools
import math
import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.qbmove.packets import lrc
from emg2vsa.worlds.far_ends.qbmove.firmware import QbmoveFirmware
from emg2vsa.worlds.far_ends.qbmove.memory import ADVANCED, MAKER_PRO, Memory, Switches, slots

PING, PONG = "3a3a 01 02 00 00", "3a3a 01 02 00 00"
ACTIVATE, IS_ACTIVE = "3a3a 01 03 80 03 83", "3a3a 01 02 81 81"
ACTIVE, INACTIVE = "3a3a 01 03 81 03 82", "3a3a 01 03 81 00 81"
MEASURE = "3a3a 01 02 84 84"
TICK_RAD = 2 * math.pi / 32768


class Free:
    """A shaft that stays halfway between its motors."""

    def shaft_rad(self, time_s: float, motors_rad: tuple[float, float]) -> float:
        return sum(motors_rad) / 2


class Bench:
    """A device, its clock, and talk in hex."""

    def __init__(self, switches: Switches = MAKER_PRO, motors_ticks: tuple[int, int] = (0, 0)) -> None:
        self.clock = VirtualClock()
        at = (motors_ticks[0] * TICK_RAD + 1e-6, motors_ticks[1] * TICK_RAD + 1e-6)
        self.device = QbmoveFirmware(switches, Free(), self.clock, motors_rad=at)

    def say(self, data: str, after_ms: float = 0) -> str:
        self.clock.sleep_until(self.clock.now_s() + after_ms / 1000)
        return self.device(bytes.fromhex(data)).hex()

    def words(self, request: str, after_ms: float = 0) -> tuple[int, ...]:
        body = bytes.fromhex(self.say(request, after_ms))[5:-1]
        return struct.unpack(f">{len(body) // 2}h", body)

    def references(self, after_ms: float = 0) -> tuple[int, int]:
        """That the motors follow, wire ticks."""
        self.clock.sleep_until(self.clock.now_s() + after_ms / 1000)
        first, second = self.device.state.ticks
        return first >> 1, second >> 1


def framed(command: int, payload: bytes) -> str:
    body = bytes((command,)) + payload
    return (b"::" + bytes((1, len(body) + 1)) + body + bytes((lrc(body),))).hex()


def hexed(data: str) -> str:
    return bytes.fromhex(data).hex()


PAIRS = [
    ("ping", PING, PONG),
    ("ping of all is answered", "3a3a 00 02 00 00", PONG),
    ("ping of another", "3a3a 02 02 00 00", ""),
    ("wrong checksum", "3a3a 01 02 00 01", ""),
    ("unknown command", "3a3a 01 02 8b 8b", ""),
    ("a command that nobody sends", "3a3a 01 02 86 86", ""),
    ("length 1", "3a3a 01 01 00", ""),
    ("length 129 and on to the next", "3a3a 01 81" + PING, PONG),
    ("garbage before", "00 ff 3a 41" + PING, PONG),
    ("a stray colon kills the frame", "78 3a" + PING, ""),
    ("and the next is heard", "78 3a" + PING + PING, PONG),
    ("a truncated frame swallows the next ping, the second is answered", "3a3a 01 06 82" + PING + PING, PONG),
    ("two frames in one write", PING + MEASURE, PONG + "3a3a 01 08 84 0000 0000 0000 84"),
    ("replies of others are skipped by length", "3a3a 02 08 84 3a3a 0102 0000 84" + PING, PONG),
    ("motors off", IS_ACTIVE, INACTIVE),
    ("activate is silent", ACTIVATE, ""),
    ("set inputs is silent", "3a3a 01 06 82 09c4 fe0c bd", ""),
    ("currents", "3a3a 01 02 85 85", "3a3a 01 06 85 0000 0000 85"),
    ("set position and stiffness is silent", "3a3a 01 06 87 03e8 4000 2c", ""),
    ("watchdog is silent", "3a3a 01 03 8f 19 96", ""),
    ("set zeros", "3a3a 01 08 01 0000 0000 0000 01", "3a3a 01 02 01 01"),
    ("store", "3a3a 01 02 03 03", "3a3a 01 02 01 01"),
    ("info of an unknown type", "3a3a 01 04 06 0001 07", ""),
    ("set a parameter is silent", "3a3a 01 05 0c 0006 01 0b", ""),
]


@pytest.mark.parametrize(("request_hex", "reply_hex"), [pair[1:] for pair in PAIRS], ids=[pair[0] for pair in PAIRS])
def test_bytes_in_bytes_out(request_hex: str, reply_hex: str) -> None:
    assert Bench().say(request_hex) == hexed(reply_hex)


@pytest.mark.parametrize(("request_hex", "reply_hex"), [pair[1:] for pair in PAIRS], ids=[pair[0] for pair in PAIRS])
def test_the_same_byte_by_byte(request_hex: str, reply_hex: str) -> None:
    bench = Bench()
    assert "".join(bench.say(f"{byte:02x}", after_ms=3) for byte in bytes.fromhex(request_hex)) == hexed(reply_hex)


@given(st.binary(max_size=400))
def test_garbage_never_raises_and_ends_after_128_bytes(garbage: bytes) -> None:
    bench = Bench()
    bench.device(garbage)
    bench.device(bytes(131))
    assert bench.say(PING) == hexed(PONG)


def test_activation_shows_after_the_next_turns_of_the_loop() -> None:
    bench = Bench()
    assert bench.say(ACTIVATE + IS_ACTIVE) == hexed(INACTIVE)
    assert bench.say(IS_ACTIVE, after_ms=3) == hexed(ACTIVE)


@pytest.mark.parametrize("motors_ticks", [(13008, 0), (0, -13008), (15000, 15000)])
@pytest.mark.parametrize("switches", [MAKER_PRO, ADVANCED], ids=["maker-pro", "advanced"])
def test_activation_is_refused_in_silence_beyond_13000_ticks(switches: Switches, motors_ticks: tuple[int, int]) -> None:
    bench = Bench(switches, motors_ticks)
    assert bench.say(ACTIVATE) == ""
    assert bench.say(IS_ACTIVE, after_ms=3) == hexed(INACTIVE)


def test_activation_holds_the_motors_where_they_are() -> None:
    bench = Bench(motors_ticks=(1600, -800))
    bench.say("3a3a 01 06 82 0000 0000 82" + ACTIVATE)
    assert bench.words(MEASURE, after_ms=500)[:2] == (1600, -800)
    assert bench.references() == (1600, -800)


# positions and stiffness as the compiled firmware was seen to map them
@pytest.mark.parametrize(
    ("position", "stiffness", "motors"),
    [
        (1000, 16384, (2500, -500)),
        (1000, -16384, (-500, 2500)),
        (14000, 32767, (14999, 9000)),
        (-14000, 0, (-12000, -12000)),
        (0, 0, (0, 0)),
    ],
)
@pytest.mark.parametrize("switches", [MAKER_PRO, ADVANCED], ids=["maker-pro", "advanced"])
def test_position_and_stiffness_become_references(
    switches: Switches, position: int, stiffness: int, motors: tuple[int, int]
) -> None:
    bench = Bench(switches)
    bench.say(framed(0x87, struct.pack(">hh", position, stiffness)))
    assert bench.references(after_ms=3) == motors


def test_position_clamps_to_limits_of_12000() -> None:
    bench = Bench()
    bench.say(framed(12, struct.pack(">H4i", 11, -12000, 12000, -12000, 12000)) + "3a3a 01 02 03 03")
    bench.say("3a3a 01 06 87 36b0 7fff 81")
    assert bench.references(after_ms=3) == (11999, 6000)


def test_inputs_are_clamped_to_the_limits() -> None:
    bench = Bench()
    bench.say("3a3a 01 06 82 7530 8ad0 9d")
    assert bench.references(after_ms=3) == (15000, -15000)


@pytest.mark.parametrize("switches", [MAKER_PRO, ADVANCED], ids=["maker-pro", "advanced"])
def test_motors_move_to_their_references_in_steps_of_8_ticks(switches: Switches) -> None:
    bench = Bench(switches)
    bench.say(ACTIVATE)
    # 400 ticks: not a saturated move, which the Advanced with its default PWM rate would never start
    bench.say("3a3a 01 06 82 0190 fe70 9d", after_ms=5)
    path = [bench.words(MEASURE, after_ms=1) for _ in range(400)]
    assert all(ticks % 8 == 0 for ticks in sum(path, ()))
    assert path[-1] == pytest.approx((400, -400, 0), abs=8)
    speed = max(abs(after[0] - before[0]) for before, after in itertools.pairwise(path))
    assert speed <= switches.motor_speed_rad_per_s / TICK_RAD / 1000 + 8


def test_a_full_move_takes_as_long_as_the_motor_needs() -> None:
    bench = Bench()
    bench.say(ACTIVATE)
    bench.say("3a3a 01 06 82 2710 2710 82", after_ms=5)
    quarter_s = 10000 * TICK_RAD / 3.75
    assert bench.words(MEASURE, after_ms=500 * quarter_s)[0] < 5100
    assert bench.words(MEASURE, after_ms=500 * quarter_s + 300)[0] == pytest.approx(10000, abs=8)


def test_the_default_pwm_rate_of_the_advanced_starts_no_saturated_move() -> None:
    bench = Bench(ADVANCED)
    bench.say(ACTIVATE)
    bench.say("3a3a 01 06 82 2710 2710 82", after_ms=5)
    assert bench.words(MEASURE, after_ms=1000) == (0, 0, 0)


def test_without_activation_nothing_moves() -> None:
    bench = Bench()
    bench.say("3a3a 01 06 82 2710 2710 82")
    assert bench.words(MEASURE, after_ms=1000) == (0, 0, 0)


def test_a_long_sleep_equals_many_short_ones() -> None:
    ends = []
    for pause_ms in (1, 600):
        bench = Bench()
        bench.say(ACTIVATE)
        bench.say("3a3a 01 06 82 09c4 fe0c bd", after_ms=10)
        for _ in range(600 // pause_ms):
            bench.say("", after_ms=pause_ms)
        ends.append(bench.words(MEASURE))
    assert ends[0] == ends[1]


def test_the_watchdog_switches_off_after_12_counts() -> None:
    bench = Bench()
    bench.say("3a3a 01 03 8f 19 96" + ACTIVATE)
    assert bench.say(IS_ACTIVE, after_ms=485) == hexed(ACTIVE)
    assert bench.say(IS_ACTIVE, after_ms=495) == hexed(INACTIVE)
    # hearing something does not switch on again
    assert bench.say(IS_ACTIVE, after_ms=5) == hexed(INACTIVE)


def test_any_byte_feeds_the_watchdog() -> None:
    bench = Bench()
    bench.say("3a3a 01 03 8f 19 96" + ACTIVATE)
    for _ in range(10):
        bench.say("3a3a 09 02 00 00", after_ms=400)
    assert bench.say(IS_ACTIVE, after_ms=400) == hexed(ACTIVE)


@pytest.mark.parametrize(("switches", "state"), [(MAKER_PRO, ACTIVE), (ADVANCED, INACTIVE)])
def test_the_watchdog_runs_from_the_start_in_the_advanced_only(switches: Switches, state: str) -> None:
    bench = Bench(switches)
    bench.say(ACTIVATE)
    assert bench.say(IS_ACTIVE, after_ms=5500) == hexed(state)


def test_a_new_id_answers_at_once_and_listens_after_store() -> None:
    bench = Bench()
    assert bench.say("3a3a 01 05 0c 0001 05 08") == ""
    assert bench.say(PING) == hexed("3a3a 05 02 00 00")
    assert bench.say("3a3a 05 02 00 00") == ""
    assert bench.say("3a3a 01 02 03 03") == hexed("3a3a 01 02 01 01")
    assert bench.say(PING) == ""
    assert bench.say("3a3a 05 02 00 00") == hexed("3a3a 05 02 00 00")


def test_the_parameter_list_has_its_length_and_checksum_cut_to_a_byte() -> None:
    reply = bytes.fromhex(Bench().say("3a3a 01 04 0c 0000 0c"))
    body = reply[4:]
    assert reply[:6] == bytes.fromhex("3a3a 01 b1 0c 0d")
    assert len(body) == 1201
    assert body[-1] == lrc(body[:176])
    assert body[2:20] == b"\x02\x01\x01" + b"1 - Device ID:\0"
    assert body[52:93] == bytes.fromhex("0703 3dccc800 00000000 3f4ccc00") + b"2 - Position PID [P, I, D]:"
    assert body[152:183] == b"\x00\x01\x00" + b"4 - Startup Activation: NO\0\3"
    assert body[502:520] == b"\x05\x04" + struct.pack(">4i", -15000, 15000, -15000, 15000)
    assert body[602:606] == b"\x03\x01\x05\xdc"
    assert body[652:661] == b"0 -> Usb\n"
    assert body[802:816] == b"0 -> Position\n"
    assert body[952:973] == b"0 -> Deactivate [NO]\n"


def test_the_advanced_has_a_fourteenth_parameter() -> None:
    body = bytes.fromhex(Bench(ADVANCED).say("3a3a 01 04 0c 0000 0c"))[4:]
    assert (len(body), body[1]) == (1201, 14)
    assert body[52:66] == bytes.fromhex("0703 bdccc800 00000000 bf4ccc00")
    assert body[652:673] == b"\x02\x01\x00" + b"14 - Max PWM rate:"
    assert body[702:711] == b"0 -> Usb\n"
    assert body[852:866] == b"0 -> Position\n"
    assert body[1002:1023] == b"0 -> Deactivate [NO]\n"


def test_a_set_parameter_shows_after_store_only_and_survives_a_reset_only_then() -> None:
    bench = Bench()
    current_limit = slice(4 + 604, 4 + 606)
    bench.say("3a3a 01 06 0c 000d 03e8 ea")
    assert bytes.fromhex(bench.say("3a3a 01 04 0c 0000 0c"))[current_limit] == b"\x05\xdc"
    bench.device.reset()
    bench.say("3a3a 01 02 03 03")
    assert bytes.fromhex(bench.say("3a3a 01 04 0c 0000 0c"))[current_limit] == b"\x05\xdc"
    bench.say("3a3a 01 06 0c 000d 03e8 ea" + "3a3a 01 02 03 03")
    bench.device.reset()
    assert bytes.fromhex(bench.say("3a3a 01 04 0c 0000 0c"))[current_limit] == b"\x03\xe8"


def test_info_is_bare_text() -> None:
    text = bytes.fromhex(Bench().say("3a3a 01 04 06 0000 06"))
    assert text.startswith(b"\r\nFirmware version: QBMMP v6.1.0.\r\n\r\nDEVICE INFO\r\nID: 1\r\n")
    assert b"\r\nMax stiffness: 3000\r\n" in text
    assert b"\r\nP -> 0.099991\r\n" in text
    assert b"\r\nPosition limit motor 2: inf -> -15000  sup -> 15000\r\n" in text
    assert 800 < len(text) < 900


def test_zeros_move_what_is_measured() -> None:
    for switches in (MAKER_PRO, ADVANCED):
        bench = Bench(switches, motors_ticks=(800, 800))
        bench.say("3a3a 01 08 01 fce0 fce0 fce0 1d")
        assert bench.words(MEASURE) == (0, 0, 0)


def test_offsets_of_the_advanced_have_another_sign_as_a_parameter_than_as_zeros() -> None:
    bench = Bench(ADVANCED, motors_ticks=(800, 800))
    bench.say("3a3a 01 0a 0c 0008 0320 0320 fce0 18")
    assert bench.words(MEASURE) == (0, 0, 0)


def test_offsets_and_limits_of_the_list_are_in_ticks_of_each_encoders_resolution() -> None:
    """get_param_list shifts them right by the resolution; the memory keeps internal ticks, 65536 to a turn."""
    memory = Memory(resolutions=[0, 1, 3], offsets=[-800, 800, 4096], limits=[-30000, 30000, -20000, 20000])
    values = {text.partition(" ")[0]: content for _, content, text in slots(memory)}
    assert values["8"] == [-800, 400, 512]
    assert values["11"] == [-30000, 30000, -10000, 10000]


def test_a_position_is_in_ticks_of_the_first_motors_resolution() -> None:
    bench = Bench()
    for body in (bytes((12, 0, 7, 1, 3, 1)), bytes((128, 3)), bytes((135, *struct.pack(">2h", 400, 0)))):
        bench.say(framed(body[0], body[1:]))
    first, second, shaft = bench.words(MEASURE, after_ms=3000)
    assert (first, second, shaft) == (pytest.approx(400, abs=8), pytest.approx(100, abs=2), pytest.approx(400, abs=8))


def test_a_reset_forgets_whole_turns() -> None:
    bench = Bench(motors_ticks=(20000, 0))
    assert bench.words(MEASURE)[0] == 20000 - 32768
    assert bench.say(ACTIVATE) == ""


def test_a_command_is_known_to_the_motors_after_the_latency() -> None:
    clock = VirtualClock()
    at = 1e-6  # off the edge of an encoder's step
    prompt, late = (
        QbmoveFirmware(MAKER_PRO, Free(), clock, motors_rad=(at, at), latency_s=latency_s) for latency_s in (0.0, 0.015)
    )
    seen: dict[QbmoveFirmware, list[float]] = {prompt: [], late: []}
    for device in seen:
        device(bytes.fromhex(ACTIVATE))
    for k in range(300):
        for device, angles in seen.items():
            if k in (10, 100, 105):  # one on its way is not lost to the next
                ticks = {10: 800, 100: 1600, 105: -400}[k]
                device(bytes.fromhex(framed(0x82, struct.pack(">hh", ticks, ticks))))
            angles.append(device.motors.angles_rad()[0])
        clock.sleep_until(clock.now_s() + 0.001)
    assert max(seen[prompt]) > 0.1
    np.testing.assert_array_equal(seen[late][15:], seen[prompt][:-15])
