"""The table [session] of a study file: how one participant's session is run. Plain data, as every setting."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Annotated, Literal

from emg2vsa.settings import Ge, Gt, Le, MinLen, NonNegative, Positive

Text = Annotated[str, MinLen(1)]
Port = Annotated[int, Ge(1), Le(65535)]

TRIGNO_COMMAND_PORT, TRIGNO_EMG_PORT, TRIGNO_AUX_PORT = 50040, 50043, 50044
"""Of the Trigno Control Utility (SDK guide MAN-025); the legacy ports 50041 and 50042 are not read."""


@dataclass(frozen=True, kw_only=True)
class EmgSourceSettings:
    """Where the EMG of a session comes from. The channels of the study ([channels.emg]) are the ones that are kept."""

    kind: Literal["ni-daq", "trigno", "lsl", "simulated"]
    "ni-daq: analogue inputs; trigno: Trigno SDK server; lsl: stream of the Lab Streaming Layer; simulated: no person."
    channels: dict[str, Text] = field(default_factory=dict)
    """Muscle role (EDC, FDS) to the source's name of it: ni-daq Dev1/ai0, trigno the number of the sensor (1 to 16),
    lsl the label of the channel."""
    gain: Positive = 1.0
    "ni-daq: of the amplifier, by which volts are divided (Bagnoli: 100, 1000 or 10000)."
    fs_hz: Positive = 1000.0
    "ni-daq: sampling rate; the other sources tell theirs."
    range_v: Positive = 5.0
    "ni-daq: largest voltage of the inputs, before the gain."
    host: Text = "127.0.0.1"
    "trigno: computer on which the Trigno Control Utility runs."
    command_port: Port = TRIGNO_COMMAND_PORT
    "trigno: command port."
    emg_port: Port = TRIGNO_EMG_PORT
    "trigno: port of the EMG of every sensor."
    stream: Text | None = None
    "lsl: name of the stream; omitted: the only one of type EMG."
    delay_s: NonNegative = 0.0
    "Fixed delay from skin to arrival (Trigno about 0.048 s), taken off every time stamp."


@dataclass(frozen=True, kw_only=True)
class ForceSourceSettings:
    """Where the pressing force of a session comes from."""

    kind: Literal["rig", "lsl", "simulated"]
    "rig: the force sensor of a rig file; lsl: stream of the Lab Streaming Layer; simulated: no person."
    rig: Text | None = None
    "rig: the rig file, relative to the folder of the study file; its [force] table is used and no other."
    axis: tuple[float, float, float] = (0.0, 0.0, -1.0)
    "rig: direction, in the sensor's axes, in which a pressing finger pushes."
    stream: Text | None = None
    "lsl: name of the stream; omitted: the only one of type Force."
    channel: Text | None = None
    "lsl: label of the channel; omitted: the only one."
    delay_s: NonNegative = 0.0
    "Fixed delay from finger to arrival, taken off every time stamp."


@dataclass(frozen=True, kw_only=True)
class SessionTexts:
    """What the participant reads; write them in the participant's language."""

    language: Text = "en"
    "Of the texts, for the browser (en, it, de)."
    wait: Text = "Please wait"
    start: Text = "START"
    press: Text = "Press"
    stop: Text = "STOP"
    rest: Text = "Rest"
    pause: Text = "Break"
    training: Text = "Practice"
    done: Text = "Finished. Thank you!"
    too_fast: Text = "slower"
    too_slow: Text = "faster"
    falling: Text = "keep increasing"
    lost: Text = "The display has lost the connection"


@dataclass(frozen=True, kw_only=True)
class SessionSettings:
    """One participant's session: devices, order, force range, speed, pauses and texts.

    The paper (section IV.A): 2 training specimens with 5 presses each, then 5 specimens in random order with 10 presses
    each, up to 7 N, start and stop told by the screen. It gives no speed and no pauses: these defaults are a choice.
    """

    emg: EmgSourceSettings
    "Source of the EMG."
    force: ForceSourceSettings
    "Source of the force."
    repetitions: Annotated[int, Ge(1), Le(1000)] = 10
    "Presses of each specimen."
    order: Literal["blocked", "interleaved", "listed"] = "blocked"
    "blocked: specimens in random order, all presses of one in a row; interleaved: at random; listed: as listed."
    seed: Annotated[int, Ge(0)] = 1
    "Of the order, with the study's name and the participant's code."
    training_specimens: tuple[Text, ...] = ()
    "Specimens pressed before the others; not among [[specimens]]."
    training_repetitions: Annotated[int, Ge(1), Le(100)] = 5
    "Presses of each training specimen."
    force_n: tuple[Positive, Positive] = (0.5, 7.0)
    "Range to press through; STOP comes at the upper force."
    bar_n: Positive = 7.0
    "Force at the top of the bar; more is drawn as a full bar with a mark."
    load_s: tuple[Positive, Positive] = (1.0, 5.0)
    "Speed band: shortest and longest time from the lower to the upper force."
    rest_s: NonNegative = 2.0
    "Shortest rest between presses."
    pause_s: NonNegative = 30.0
    "Shortest break between specimens."
    ready_n: Positive = 0.3
    "START is given only while the force is below this; a press that begins before START is early."
    most_repeats: Annotated[int, Ge(0)] = 3
    "Largest number of presses of a specimen that are done again for a fault of execution."
    stop: Literal["count", "width"] = "count"
    "count: repetitions; width: further presses are suggested while the interval of b is wider than width."
    width: Annotated[float, Gt(0), Le(2)] = 0.2
    "stop = width: half width of the interval of the mean b, as a share of the amplitude at 1 N; never of b itself."
    most_presses: Annotated[int, Ge(1)] = 20
    "stop = width: largest number of presses of a specimen."
    palette: Literal["paper", "safe"] = "safe"
    "paper: green and red; safe: blue and vermillion, for people who confuse those."
    sound: bool = False
    "A short tone with START and STOP."
    bar_filter_hz: Positive = 15.0
    "Low-pass of the bar's force, which delays it by about 11 ms; stored forces are not filtered."
    ethics: str = ""
    "Number of the ethics approval, for the record."
    texts: SessionTexts = field(default_factory=SessionTexts)
    "What the participant reads."
