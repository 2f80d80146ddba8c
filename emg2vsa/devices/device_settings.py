"""Which devices a rig has and how they are reached: tables [actuator], [motor], [force] and [camera] of rig.toml.

The facts that drivers and settings share stand here, so that a rig file is read without loading a driver.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from emg2vsa.devices.serial_speed import BAUD, Baud
from emg2vsa.settings import Ge, Gt, Le, MinLen, Positive

Generation = Literal["v6", "v7"]
"""Of a qbmove's firmware; they differ in acknowledgements, and in replies that do not fit one length byte."""
Model = Literal["maker-pro", "advanced"]
RDT_PORT = 49152
"""UDP port of the raw data of ATI's boxes."""
RATE_HZ = 20.0
"""Frames a second of the tactile camera."""
SHAPE = (300, 300)
"""(height, width) of the paper's frames, px."""
LOST_S = 0.5
"""A camera that gives no frame for so long is lost."""
LARGEST_PRESS_BYTES = 2**32 - 1
"""Frames of a press are one TIFF, whose offsets have 32 bits."""

Text = Annotated[str, MinLen(1)]
DeviceId = Annotated[int, Ge(1), Le(255)]
REPLY_S = 0.016
"""Three attempts of it, and a turn of the loop before them, name a dead board within 60 ms."""
WatchdogS = Annotated[float, Ge(0.06), Le(5)]
"""Steps of 20 ms, at most 250; 1 and 2 are rounded to a period of 0, whose meaning is unknown (cmd_set_watchdog)."""
NetPort = Annotated[int, Ge(1), Le(65535)]


@dataclass(frozen=True, kw_only=True)
class ActuatorSettings:
    """The qbmove."""

    port: Text | None = None
    "Serial port, as emg2vsa rig scan lists it: /dev/ttyUSB0, COM3. Omitted: only the emulated rig can run."
    id: DeviceId = 1
    "Device id, as emg2vsa rig scan lists it."
    baud: Baud = BAUD
    "Bits a second on the serial line; devices of generation 5 have 460800."
    generation: Generation = "v6"
    "Of the firmware: the first digit of its version."
    model: Model = "maker-pro"
    "The Advanced counts its encoders the other way round."
    watchdog_s: WatchdogS = 0.5
    """The device is told to switch its motors off when the program has been silent for so long. Whether it does is
    unknown until emg2vsa rig prove-watchdog has shown it on this very device."""
    reply_s: Positive = REPLY_S
    "How long each of three attempts waits for a reply."


@dataclass(frozen=True, kw_only=True)
class MotorSettings:
    """The rigid motor of the condition high-stiffness: motor 1 of a board that speaks as a qbmove does."""

    port: Text | None = None
    "Serial port; may be the actuator's when the ids differ."
    id: DeviceId = 1
    "Device id."
    baud: Baud = BAUD
    "Bits a second on the serial line."
    generation: Generation = "v6"
    "Of the firmware: the first digit of its version."
    watchdog_s: WatchdogS = 0.5
    "The board is told to switch its motor off when the program has been silent for so long; as for [actuator]."
    reply_s: Positive = REPLY_S
    "How long each of three attempts waits for a reply."


@dataclass(frozen=True, kw_only=True)
class ForceSettings:
    """The force sensor under the specimen: an ATI Net F/T box, or an ATI transducer on a National Instruments card."""

    kind: Literal["net-ft", "ni-daq"]
    "net-ft: Net F/T box or Ethernet Axia; ni-daq: gauge voltages and the transducer's calibration."
    host: Text | None = None
    "net-ft: address of the box; 192.168.1.1 when it leaves the factory. Omitted: only the emulated rig can run."
    rdt_port: NetPort = RDT_PORT
    "net-ft: UDP port of its raw data."
    http_port: NetPort = 80
    "net-ft: port of its web page, which tells scales and units."
    buffered: bool = False
    "net-ft: many records in a datagram; less work for both ends, and later by a buffer's time."
    channels: Text | None = None
    "ni-daq: six differential channels in the order of the gauges: Dev1/ai0:5."
    cal_file: Text | None = None
    "ni-daq: the transducer's .cal file, relative to the folder of the rig file."
    bias: bool = False
    "true: the load on the sensor when a run begins becomes its zero; needed where the sensor has no zero of its own."


@dataclass(frozen=True, kw_only=True)
class CameraSettings:
    """The tactile camera."""

    source: Annotated[int, Ge(0)] | Text
    "Number of the camera (0 is the first), or the address of a network camera."
    height: Annotated[int, Gt(0)] = SHAPE[0]
    "Rows of the frames that are kept, pixels."
    width: Annotated[int, Gt(0)] = SHAPE[1]
    "Columns of the frames that are kept, pixels."
    rate_hz: Positive = RATE_HZ
    "Frames kept a second; a faster camera is thinned out."
    delay_s: Annotated[float, Ge(0), Le(0.5)] = 0.0
    "From exposure to arrival, as rig camera-delay measures it; frames are timed so much earlier."
    lock: bool = True
    "Exposure, gain and white balance stay as they are when a run begins: what changes by itself looks like a touch."
    exposure: float | None = None
    "Exposure in the camera's own unit (V4L2: 0.1 ms; DirectShow: powers of 2 s); omitted: what it has now."
    gain: float | None = None
    "Gain in the camera's own unit; omitted: what it has now."
    white_balance_k: float | None = None
    "White balance, kelvin; omitted: what it has now."


@dataclass(frozen=True, kw_only=True)
class DeviceSettings:
    """All devices of a rig. motor : None without a rigid motor. camera : None where no frames are wanted."""

    actuator: ActuatorSettings
    force: ForceSettings
    motor: MotorSettings | None = None
    camera: CameraSettings | None = None
