"""Packets of protocol 2.0 to a motor and back, made and read by ROBOTIS' dynamixel_sdk over a line and a clock of ours.

The SDK's own port opens pyserial and reads the computer's clock. The port here has its methods over a `ByteLine`, so
that one driver speaks to a serial port and to a motor emulated in virtual time.

dynamixel_sdk 4.1.0 sends FF FF FD among the parameters without the byte that must be stuffed in: addStuffing makes a
new list, which txPacket never sees. The driver writes no such value, as all its values lie between -2048 and 16383.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, NamedTuple

from casr.by_name import module_named
from emg2vsa.devices.board import ids_asked
from emg2vsa.devices.clock import Clock
from emg2vsa.devices.dynamixel import ATTEMPTS
from emg2vsa.devices.dynamixel.registers import ALERT, CRC_ERROR, model_named
from emg2vsa.devices.serial_line import ByteLine, LineCounts
from emg2vsa.errors import DeviceError, install_extra

_ID, _LENGTH, _ERROR, _DATA = 4, 5, 8, 9
"""Places in a status packet."""
_PING_BYTES = 3
_SCAN_ATTEMPTS = 2


class Status(NamedTuple):
    """A status packet."""

    error: int
    "Error number; 0 when all is well."
    alert: bool
    "Hardware Error Status is not 0."
    data: bytes


class SdkPort:
    """What the SDK's PacketHandler asks of a port. It never spins: who waits for bytes waits on the line.

    The SDK reckons its timeouts from lengths of packets; here every reply has the same time.
    """

    def __init__(self, line: ByteLine, clock: Clock, reply_s: float) -> None:
        self.is_using, self.silent = False, False
        self._line, self._clock, self._reply_s = line, clock, reply_s
        self._until_s = 0.0

    def clearPort(self) -> None:
        """Throw away what has arrived unread."""
        self._line.drop_input()

    def writePort(self, packet: list[int]) -> int:
        """Send all; how many bytes."""
        self._line.write(bytes(packet))
        return len(packet)

    def setPacketTimeout(self, packet_length: int) -> None:
        """Begin to wait for a reply."""
        self._until_s, self.silent = self._clock.now_s() + self._reply_s, False

    def isPacketTimeout(self) -> bool:
        """Has the line given fewer bytes than were asked for? It does so when the time is over."""
        return self.silent

    def readPort(self, length: int) -> bytes:
        """Up to ``length`` bytes; none from a line that is still heard a whole reply's time too late: noise has no
        end, and the SDK would read it for ever."""
        left_s = self._until_s - self._clock.now_s()
        heard = self._line.read(length, max(left_s, 0.0)) if left_s > -self._reply_s else b""
        self.silent = len(heard) < length
        return heard


class Conversation:
    """Questions to the motors on one line. DeviceError when the SDK is not installed, or the line is gone."""

    def __init__(self, line: ByteLine, clock: Clock, reply_s: float) -> None:
        sdk = load_sdk()
        self.line, self.clock, self.counts = line, clock, LineCounts()
        self._port = SdkPort(line, clock, reply_s)
        self._handler, self._success = sdk.PacketHandler(2.0), sdk.COMM_SUCCESS
        self._behind: set[int] = set()
        "Motors from which a reply may still be under way."

    def read(self, device_id: int, address: int, count: int, attempts: int = ATTEMPTS) -> Status | None:
        """``count`` bytes of the control table; None after so many attempts."""
        send = partial(self._handler.readTx, self._port, device_id, address, count)
        return self._ask(device_id, count, attempts, send)

    def write(self, device_id: int, address: int, data: bytes, attempts: int = ATTEMPTS) -> Status | None:
        """The motor's answer to new bytes of the control table; None after so many attempts."""
        send = partial(self._handler.writeTxOnly, self._port, device_id, address, len(data), list(data))
        return self._ask(device_id, 0, attempts, send)

    def ping(self, device_id: int, attempts: int) -> tuple[int, int] | None:
        """Model number and version of the firmware; None when nobody answers."""
        for _ in range(attempts):
            if data := self._ping(device_id):
                return int.from_bytes(data[:2], "little"), data[2]
        return None

    def _ask(self, device_id: int, count: int, attempts: int, send: Callable[[], object]) -> Status | None:
        """A reply tells not to which question. So after one that did not come in time, a ping is asked first: its
        answer is of another length than all others, and what comes before it is late. Without it the question is sent
        all the same, as the motor may hear and not be heard, but no reply is believed."""
        for _ in range(attempts):
            in_step = device_id not in self._behind or bool(self._ping(device_id))
            self._send(send, count)
            status = self._hear(device_id, count) if in_step else None
            if status and status.error != CRC_ERROR:
                return status
            self._behind.add(device_id)
            self.counts.lost += 1
        return None

    def _ping(self, device_id: int) -> bytes | None:
        request = [0, 0, 0, 0, device_id, 3, 0, 1, 0, 0]
        self._send(partial(self._handler.txPacket, self._port, request), _PING_BYTES)
        while status := self._hear(device_id, _PING_BYTES):
            if status.data:  # an error has none, and may be late
                self._behind.discard(device_id)
                return status.data
        self.counts.lost += 1
        return None

    def _send(self, send: Callable[[], object], count: int) -> None:
        self._port.is_using = False  # a line that was gone for a moment has left it so
        send()
        self._port.setPacketTimeout(count)
        self.counts.requests += 1

    def _hear(self, device_id: int, count: int) -> Status | None:
        """The status packet of this motor with so many bytes of data, or with an error and none; others are late."""
        while True:
            packet, result = self._handler.rxPacket(self._port, False)
            if result != self._success:
                self.counts.corrupt += not self._port.silent
                return None
            held = int.from_bytes(packet[_LENGTH : _LENGTH + 2], "little") - 4
            error, alert = packet[_ERROR] & ~ALERT, bool(packet[_ERROR] & ALERT)
            if packet[_ID] == device_id and (held == count or (error and held == 0)):
                return Status(error, alert, bytes(packet[_DATA : _DATA + held]))


def answers(line: ByteLine, clock: Clock, ids: Sequence[int], reply_s: float) -> Iterator[str]:
    """Ping every id, or all where none is given, and tell who answers within ``reply_s``. About 3 s for all ids.

    A motor that is set to another baud rate than the line, or to protocol 1.0, does not answer.

    SettingError : an id that no motor has."""
    talk = Conversation(line, clock, reply_s)
    for device_id in ids_asked(ids, range(253)):
        if answer := talk.ping(device_id, _SCAN_ATTEMPTS):
            number, firmware = answer
            yield f"id {device_id}, {model_named(number) or f'model {number}'}, firmware {firmware}"


def load_sdk() -> Any:
    """The package dynamixel_sdk. DeviceError when it is not installed."""
    try:
        return module_named("dynamixel_sdk")
    except ImportError as error:
        where, wanted = '[actuator] kind = "dynamixel"', "the extra for Dynamixel motors"
        do = f"Install it: {install_extra('dynamixel')}."
        raise DeviceError(where, wanted=wanted, found="no dynamixel_sdk", do=do) from error
