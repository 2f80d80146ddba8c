"""What an emulated participant, or an electrode, does wrong on plan: ``dips@12``, ``electrode-off:FDS@training-3``."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from emg2vsa.errors import SettingError

OF_HAND = {
    "too-fast": "force rises four times as fast as usual",
    "too-slow": "force rises at a third of the usual rate",
    "dips": "force falls by about 1 N on its way up",
    "aborted": "the finger is lifted at 4 N",
    "overshoot": "STOP is obeyed a second late",
    "never-lifts": "the finger stays on the specimen for 6 s after STOP",
    "early": "the finger presses before START",
}
OF_SENSOR = {
    "electrode-off": "an electrode comes off: no muscle, and much mains hum",
    "mains": "mains hum of 30 uV rms on every muscle",
    "clipping": "EMG far too large, cut at the end of the range",
    "sensor-offset": "the force reads 0.25 N too much",
    "zeros": "a muscle's sensor sends nothing but zeros",
    "radio-loss": "one in twenty frames of the EMG, 13.5 ms each, never comes, and nothing tells it",
    "half-rate": "so does every second one",
}
OF_MUSCLE = ("electrode-off", "zeros")
_FORM = "KIND[:MUSCLE]@[training-]NUMBER[-NUMBER]"
_WORDS = re.compile(r"(?P<kind>[a-z-]+)(:(?P<muscle>[^@]+))?@(?P<training>training-)?(?P<first>\d+)(-(?P<last>\d+))?")


@dataclass(frozen=True)
class Mistake:
    """What goes wrong at the first attempt of a press. press : its number within the phase, as the page counts; 0 is
    from the start to the first press, of a sensor only.

    muscle : of electrode-off and zeros; "" is the first one.
    """

    kind: str
    press: int
    phase: str = "main"
    muscle: str = ""


def parse_mistakes(texts: Iterable[str], muscles: Mapping[str, object]) -> tuple[Mistake, ...]:
    """Mistakes in words; SettingError for words that say none."""
    return tuple(mistake for text in texts for mistake in _parsed(text, muscles))


def _parsed(text: str, muscles: Mapping[str, object]) -> list[Mistake]:
    kinds = OF_HAND | OF_SENSOR
    said = _WORDS.fullmatch(text)
    if said is None or said["kind"] not in kinds:
        raise _no_mistake(text, f"{_FORM}, KIND one of {', '.join(kinds)}")
    muscle = said["muscle"] or ""
    if muscle and (said["kind"] not in OF_MUSCLE or muscle not in muscles):
        raise _no_mistake(text, f"a muscle only for {' and '.join(OF_MUSCLE)}, one of {', '.join(muscles)}")
    first = int(said["first"])
    last = int(said["last"] or first)
    if not (1 <= first <= last or (first == last == 0 and said["kind"] in OF_SENSOR)):
        raise _no_mistake(
            text, "numbers of presses from 1, in rising order; 0 alone, of a sensor, before the first press"
        )
    phase = "training" if said["training"] else "main"
    return [Mistake(said["kind"], press, phase, muscle) for press in range(first, last + 1)]


def _no_mistake(text: str, wanted: str) -> SettingError:
    return SettingError("--mistake", wanted=wanted, found=repr(text), do="For example: --mistake dips@12.")
