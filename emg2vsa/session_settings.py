"""The table [session] of a study file: how one participant's session is run. Plain data, as every setting."""

from __future__ import annotations

from dataclasses import field
from typing import Annotated, Literal

from emg2vsa.settings import Fraction, Ge, Gt, Le, MinLen, NonNegative, Positive, Tagged
from emg2vsa.settings_class import settings_class

Text = Annotated[str, MinLen(1)]
Port = Annotated[int, Ge(1), Le(65535)]

PARTICIPANT_CODE = r"[A-Za-z]{0,4}[0-9]{1,6}"
"""Form of a code: at most four letters and a number. No person's name has this form."""

MOST_FORCE_N = 50.0
"""No session presses harder."""


@settings_class
class EmgSettings:
    """Where the EMG of a session comes from. The channels of the study ([channels.emg]) are the ones that are kept."""

    kind: str
    "Kind of the device; each kind has keys of its own."
    delay_s: Annotated[float, Ge(0), Le(1)] = 0.0
    "Fixed delay from skin to arrival (Trigno about 0.048 s), taken off every time stamp."


@settings_class
class SessionForceSettings:
    """Where the pressing force of a session comes from."""

    kind: str
    "Kind of the device; each kind has keys of its own."
    delay_s: Annotated[float, Ge(0), Le(1)] = 0.0
    "Fixed delay from finger to arrival, taken off every time stamp."


@settings_class
class SessionTexts:
    """What the participant reads; write them in the participant's language."""

    language: Text = "en"
    "Language of the texts, for the browser (en, it, de)."
    wait: Text = "Please wait"
    "While the operator prepares something."
    start: Text = "START"
    "Command to press."
    press: Text = "Press"
    "While force rises."
    stop: Text = "STOP"
    "Command to lift the finger."
    rest: Text = "Rest"
    "Between presses."
    pause: Text = "Break"
    "Between specimens."
    relax: Text = "Relax your arm"
    "While the rest level of the EMG is measured."
    contract: Text = "Tense your forearm as hard as you can"
    "While the maximum contraction is measured."
    training: Text = "Practice"
    "Beside the number of a practice press."
    done: Text = "Finished. Thank you!"
    "Text at the end."
    too_fast: Text = "slower"
    "While force rises too fast."
    too_slow: Text = "faster"
    "While force rises too slowly."
    falling: Text = "keep increasing"
    "While force falls before the upper force."
    lost: Text = "The display has lost the connection"
    "While no force arrives."


@settings_class
class SessionAbout:
    """What no device says of a recording, for the side files of the data set. Texts that are empty are left out."""

    power_line_hz: Literal[50, 60] | None = None
    "Frequency of the mains; omitted: not stated."
    electrode_mm: Positive | None = None
    "Distance of the two electrodes of a pair, mm (Bagnoli: 10)."
    manufacturer: str = ""
    "Maker of the amplifier; here as in the next three: omitted, what the device says of itself."
    model: str = ""
    "Its model."
    serial_number: str = ""
    "Its serial number."
    band_hz: tuple[Positive, Positive] | None = None
    "Pass band of its own filters (Bagnoli: 20 to 450)."
    electrodes: str = ""
    "Model of the electrodes."
    electrode_manufacturer: str = ""
    "Their maker."
    electrode_type: str = ""
    "Such as bar, disc or wire."
    electrode_material: str = ""
    "Such as Ag or Ag/AgCl."
    skin_preparation: str = ""
    "How the skin was prepared."
    ground: str = ""
    "Where the ground electrode is."
    instructions: str = "Press with rising force when the screen says START; lift the finger when it says STOP."
    "What participants are told to do."
    institution: str = ""
    "Where the study is done."
    institution_address: str = ""
    "Its address."
    department: str = ""
    "Department of the institution."
    authors: tuple[Text, ...] = ()
    "Authors of the data set; not participants."
    licence: str = ""
    "Licence of the data set, such as CC0 or CC-BY-4.0."


@settings_class
class ElectrodePlaces:
    """Where the electrodes are on the forearm, for electrodes.tsv and coordsystem.json."""

    system: Text
    "Where 0 is and what x and y follow, such as from the lateral epicondyle to the ulnar styloid process."
    unit: Literal["mm", "cm", "percent"] = "mm"
    "Unit of the coordinates; percent: of the distance that system names."
    pairs: dict[str, tuple[tuple[float, float], tuple[float, float]]]
    "Muscle to x and y of its two electrodes."


@settings_class
class FormColumn:
    """A column of participants.tsv that is filled in before a session: a number in a range, or one of some words."""

    description: Text
    "What is asked; it describes the column in participants.json."
    range: tuple[float, float] | None = None
    "Smallest and largest number."
    unit: str = ""
    "Unit of the number."
    levels: dict[str, Text] = field(default_factory=dict)
    "Word to its meaning."


@settings_class
class SessionLimits:
    """How well a press must be done, beside what [window] asks of every recording: what only a live session knows.

    Of two values the first warns and the second rejects. None depends on b or on the fit.
    """

    reaction_s: tuple[Positive, Positive] = (1.5, 5.0)
    "Time from START to the lower force; after the second the press is given up."
    early_s: NonNegative = 0.1
    "A press that follows START sooner began before it: nobody reacts so fast. It is rejected."
    peak_n: Positive = 9.0
    "Largest force after STOP; more is warned."
    lift_s: Positive = 2.0
    "The finger must be lifted so soon after STOP; later is rejected."
    zero_n: tuple[Positive, Positive] = (0.05, 0.2)
    "Mean force of the half second before START, beside the zero taken when the specimen was placed."
    lost_share: tuple[NonNegative, Fraction] = (0.0, 0.01)
    "Share of the samples of a press that are lost."
    age_ms: Positive = 60.0
    "Age of the force on the participant's page (95 %); more is warned. A page that is hidden rejects."


TriggerMark = Literal["start", "stop", "verdict"]


@settings_class
class TriggerSettings:
    """Marks for other devices on a serial port, when START and STOP are shown and when a verdict is given."""

    port: Text
    "The serial port: /dev/ttyUSB0, COM3."
    pulse: Literal["byte", "dtr", "rts"] = "byte"
    "byte: the number of the mark is written; dtr, rts: this control line is raised, for every mark alike."
    start: Annotated[int, Ge(1), Le(255)] = 1
    "Byte at START."
    stop: Annotated[int, Ge(1), Le(255)] = 2
    "Byte at STOP."
    verdict: Annotated[int, Ge(1), Le(255)] = 4
    "Byte at a verdict."
    pulse_s: Annotated[float, Ge(0), Le(1)] = 0.01
    "Length of a pulse, which a byte 0 ends; 0: no byte 0 is written. The end is up to 5 ms late."
    baud: Annotated[int, Ge(300), Le(4_000_000)] = 115200
    "Bits a second; 8N1."


@settings_class
class SessionSettings:
    """One participant's session: devices, order, force range, speed, pauses and texts.

    The paper (section IV.A): 2 training specimens with 5 presses each, then 5 specimens in random order with 10 presses
    each, up to 7 N, start and stop told by the screen. It gives no speed and no pauses: these defaults are a choice.
    """

    emg: Annotated[EmgSettings, Tagged("emg")]
    "Source of the EMG."
    force: Annotated[SessionForceSettings, Tagged("session-force")]
    "Source of the force."
    repetitions: Annotated[int, Ge(1), Le(1000)] = 10
    "Presses of each specimen."
    order: Literal["blocked", "interleaved", "listed", "latin-square", "williams"] = "blocked"
    """blocked: specimens in random order, all presses of one in a row; interleaved: at random, press by press. Else all
    presses of one in a row: listed: as listed; latin-square, williams: participants take the rows of a design in turn,
    the next row at each further visit. Williams: each specimen follows each other one equally often."""
    orders: dict[str, tuple[Text, ...]] = field(default_factory=dict)
    "order = listed: participant to the specimens in order; omitted: as [[specimens]] lists them, for all."
    seed: Annotated[int, Ge(0)] = 1
    "Seed of the order, with the study's name and the participant's code."
    training_specimens: tuple[Text, ...] = ()
    "Specimens pressed before the others; not among [[specimens]]."
    training_repetitions: Annotated[int, Ge(1), Le(100)] = 5
    "Presses of each training specimen."
    force_n: tuple[Positive, Positive] = (0.5, 7.0)
    "Range to press through; STOP comes at the upper force."
    bar_n: Annotated[float, Gt(0), Le(50)] = 7.0
    "Force at the top of the bar; more is drawn as a full bar with a mark."
    load_s: tuple[Positive, Positive] = (1.0, 5.0)
    "Speed band: shortest and longest time from the lower to the upper force."
    rest_s: NonNegative = 2.0
    "Shortest rest between presses."
    pause_s: NonNegative = 30.0
    "Shortest break between specimens."
    ready_n: Positive = 0.3
    "START is given only while the force is below this; a press that begins before START is early."
    most_repeats: Annotated[int, Ge(0), Le(1000)] = 3
    "Largest number of presses of a specimen that are done again for a fault of execution."
    stop: Literal["count", "width"] = "count"
    "count: repetitions; width: further presses are suggested while the interval of b is wider than width."
    width: Annotated[float, Gt(0), Le(2)] = 0.2
    "stop = width: half width of the interval of the mean b, as a share of the amplitude at 1 N; never of b itself."
    most_presses: Annotated[int, Ge(1)] = 20
    "stop = width: largest number of presses of a specimen."
    palette: Literal["paper", "safe"] = "safe"
    "paper: green and red; safe: blue and vermilion, for people who confuse those."
    sound: bool = False
    "A short tone with START and STOP."
    bar_filter_hz: Annotated[float, Ge(1), Le(100)] = 15.0
    "Low-pass of the bar's force, which delays it by about 11 ms; stored forces are not filtered."
    ethics: str = ""
    "Number of the ethics approval, for the record."
    checklist: tuple[Text, ...] = (
        "arm on its support",
        "electrodes and cables in place",
        "chair and posture as before",
    )
    "What the operator confirms before the presses on each specimen."
    check_each_press: bool = False
    "true: the operator confirms the first item of the checklist before every press (the paper: arm support)."
    lsl_outlets: bool = False
    "true: EMG, envelopes, force, markers and verdicts are streams of the Lab Streaming Layer; needs the extra lsl."
    trigger: TriggerSettings | None = None
    "Marks for other devices on a serial port; omitted: none."
    limits: SessionLimits = field(default_factory=SessionLimits)
    "How well a press must be done."
    form: dict[str, FormColumn] = field(default_factory=dict)
    "Columns of participants.tsv that are filled in before the session (emg2vsa session form)."
    about: SessionAbout = field(default_factory=SessionAbout)
    "What no device says, for the data set."
    places: ElectrodePlaces | None = None
    "Where the electrodes are; omitted: positions are not stated."
    texts: SessionTexts = field(default_factory=SessionTexts)
    "What the participant reads."
