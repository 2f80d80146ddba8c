"""Where a study differs from its registration, and which claims each difference touches."""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Literal

from emg2vsa.claims import arithmetic, kappa, people, rig
from emg2vsa.claims.claim import Judged
from emg2vsa.registration.plan import Plain, claim_plan

Kind = Literal["protocol", "rig", "analysis", "judgement", "data", "code", "claim"]
Path = tuple[str, ...]
ABSENT = "absent"
_KINDS: dict[str, Kind] = {
    **dict.fromkeys(("participants", "specimens", "order of specimens", "recordings", "session", "window"), "protocol"),
    "judgements": "judgement", "rig tables": "rig",
}  # fmt: skip
"""Of what else is registered the kind is "analysis"."""

_PEOPLE, _SETTINGS = people.QUESTION, arithmetic.QUESTION
_KAPPA = (kappa.QUESTION,)
_RIG = (rig.AREAS, rig.RATES, rig.CONDITIONS, *_KAPPA)
_DATA = (_PEOPLE, *_RIG)
TOUCHES: dict[str, tuple[str, ...]] = {
    "mode": _DATA, "participants": (_PEOPLE, _SETTINGS), "specimens": (*_DATA, _SETTINGS),
    "order of specimens": (_PEOPLE,), "recordings": (_PEOPLE, _SETTINGS), "judgements": (_PEOPLE,), "rig tables": _RIG,
    "filters": (_PEOPLE,), "cocontraction": (_PEOPLE,), "fit": (_PEOPLE,), "hypotheses": (_PEOPLE,),
    "session": (_PEOPLE,), "window": (_PEOPLE, _SETTINGS), "profile": (*_DATA, _SETTINGS),
    "schedule": (*_RIG, _SETTINGS), "runs": _RIG, "discrimination": _RIG, "calibration": _KAPPA, "claims": (),
    "calibration.mounting_sd_percent": _RIG,
}  # fmt: skip
"""What is registered to the questions whose claims hang on it; which claims a key of [claims] moves, they tell."""
CODE: dict[str, tuple[str, tuple[str, ...]]] = {
    "presses": ("extraction.extract", (_PEOPLE,)), "fits": ("pipeline.stages.fits", (_PEOPLE,)),
    "tests": ("pipeline.stages.hypotheses", (_PEOPLE,)), "profiles": ("pipeline.stages.profiles", (_PEOPLE,)),
    "schedules": ("pipeline.stages.schedules", _RIG), "scores": ("run_scores.score_run", _RIG),
    "discrimination": ("pipeline.stages.discrimination", _RIG), "calibration": ("pipeline.stages.calibration", _KAPPA),
    "claims": ("registration.plan", _DATA),
}  # fmt: skip
"""Parts of the analysis: the module of emg2vsa whose code, with all that it imports, makes it, and the questions that
hang on it. The modules lack their first word, lest this one counts as naming them (``emg2vsa.pipeline.code``)."""


@dataclass(frozen=True)
class Deviation:
    """One difference. what : it is of. registered, now : in words. claims : keys of those that it touches."""

    kind: Kind
    what: str
    registered: str
    now: str
    claims: tuple[str, ...]

    @property
    def touched(self) -> str:
        """The claims, for a table."""
        return ", ".join(self.claims)

    def __str__(self) -> str:
        count = len(self.claims)
        touched = f"{count} claim{'s' if count != 1 else ''}" if count else "no claim"
        return f"{self.what}: {self.registered} when registered, {self.now} now; touches {touched}"


@dataclass(frozen=True)
class Registered:
    """A registration, and how the study differs from it now.

    registered_at : ISO 8601. collected : which data there were then, in a sentence. amends : hash of the registration
    that this one follows, "" for none. claims : key to what was registered of it. awaited : planned recordings that are
    not there yet.
    """

    file: str
    sha256: str
    registered_at: str
    collected: str
    amends: str
    claims: Mapping[str, Plain]
    deviations: tuple[Deviation, ...]
    awaited: tuple[str, ...] = ()

    @property
    def of_plan(self) -> tuple[Deviation, ...]:
        """All but those of code and libraries, which differ from computer to computer."""
        return tuple(each for each in self.deviations if each.kind != "code")

    def state(self, judged: Judged) -> str:
        """Of a verdict: "registered", "registered, deviates: ..." with what it hangs on, or "not registered"."""
        key, now = judged.claim.key, claim_plan(judged)
        if key not in self.claims:
            return "not registered"
        of = [each.what for each in self.of_plan if key in each.claims]
        of = of or [f"its {name}" for name, was in self.claims[key].items() if now[name] != was]
        return f"registered, deviates: {'; '.join(of)}" if of else "registered"

    def lines(self) -> Iterator[str]:
        """For a screen: what was registered, then each deviation."""
        count = len(self.deviations) or "no"
        waits = f", {len(self.awaited)} planned recordings are not there yet" if self.awaited else ""
        about = f"registered {self.registered_at[:10]}, {self.file}, SHA-256 {self.sha256[:12]}"
        yield f"{about}: {count} deviation{'s' if count != 1 else ''}{waits}"
        yield from (f"deviation: {each}" for each in self.deviations)

    def as_json(self) -> dict[str, object]:
        """All but the claims."""
        return {name: value for name, value in asdict(self).items() if name != "claims"}


def compared(of: Plain, now: Plain, file: str, *, final: bool = False) -> Registered:
    """The registration ``of`` beside the same parts of the study ``now``.

    final : the data are complete, so that a planned recording that is not there is a deviation.
    """
    found = [*_of_plan(of, now), *_of_sessions(of, now), *_of_data(of, now), *_of_code(of, now)]
    there = of["data"]["recordings"].keys() | now["data"]["recordings"].keys()
    awaited = tuple(key for key in of["plan"]["recordings"] if key in now["plan"]["recordings"] and key not in there)
    if final:
        hang = _hang_on(of, TOUCHES["recordings"])
        found += [Deviation("data", f"recording {key}", "planned", ABSENT, hang) for key in awaited]
    explained = {key for each in found for key in each.claims}
    for key in sorted(of["claims"].keys() - explained):
        for path, was, present in _changed(of["claims"][key], now["claims"].get(key, {})):
            found.append(Deviation("claim", f"claim {key}, {'.'.join(path)}", _shown(was), _shown(present), (key,)))
    whole = (of["sha256"], of["registered_at"], of["collected"], of["amends"], of["claims"])
    return Registered(file, *whole, tuple(found), () if final else awaited)


def _hang_on(of: Plain, questions: Sequence[str]) -> tuple[str, ...]:
    return tuple(key for key, claim in of["claims"].items() if claim["question"] in questions)


def _of_plan(of: Plain, now: Plain) -> Iterator[Deviation]:
    """Recordings that changed alike are one deviation."""
    alike: dict[tuple[str, Path, str, str], list[str]] = defaultdict(list)
    for path, was, present in _changed(of["plan"], _on_common_ground(of["plan"], now["plan"])):
        where, shown, recording = path[1] if path[0] == "tables" else path[0], path, ""
        if where == "recordings":
            shown, recording = (where, *path[2:]), path[1]
        alike[where, shown, _shown(was), _shown(present)].append(recording)
    for (where, path, was_said, said), keys in alike.items():
        touched = _hang_on(of, TOUCHES.get(".".join(path[1:]), TOUCHES[where]))
        if where == "claims":
            touched = tuple(key for key, claim in of["claims"].items() if now["claims"].get(key) != claim)
        yield Deviation(_KINDS.get(where, "analysis"), _what(path, keys), was_said, said, touched)


def _on_common_ground(old: Plain, new: Plain) -> Plain:
    """``new`` without what one deviation says already: of people and specimens that came or went no recordings, no
    places in an order; of planned people and specimens every recording that is made as planned."""
    known = list(old["recordings"].values())
    both = {name: [each for each in old[name] if each in new[name]] for name in ("participants", "specimens")}
    recordings = {}
    for key in dict.fromkeys((*old["recordings"], *new["recordings"])):
        was, own = old["recordings"].get(key), new["recordings"].get(key)
        who, _, specimen = key.partition("/")
        if who not in both["participants"] or specimen not in both["specimens"] or (was is None and own in known):
            own = was
        if own is not None:
            recordings[key] = own
    order = [name for name in new["order of specimens"] if name in both["specimens"]]
    kept = order == [name for name in old["order of specimens"] if name in both["specimens"]]
    return new | {"recordings": recordings, "order of specimens": old["order of specimens"] if kept else order}


def _what(path: Path, recordings: Sequence[str]) -> str:
    match path:
        case ("recordings", *keys):
            more = f" and {len(recordings) - 1} more" if len(recordings) > 1 else ""
            return ", ".join(filter(None, (f"recording {recordings[0]}{more}", ".".join(keys))))
        case ("participants", name):
            return f"participant {name}"
        case ("specimens", name, *keys):
            return ", ".join((f"specimen {name}", *keys))
        case ("tables" | "rig tables" as of, table, *keys):
            return f"{'rig file, ' if of == 'rig tables' else ''}[{table}] {'.'.join(keys)}".rstrip()
        case ("judgements", press):
            return press
        case ("mode",):
            return "[study] mode"
    return "order of [[specimens]], from which orders of pressing are drawn"


def _of_sessions(of: Plain, now: Plain) -> Iterator[Deviation]:
    """What plan.json of a recorded session says otherwise than the registered [session]."""
    planned = of["plan"]["tables"].get("session")
    for who, recorded in now["sessions"].items() if planned else ():
        for path, was, present in _changed(planned, recorded) if who in of["plan"]["participants"] else ():
            what = f"session of {who}, {'.'.join(path)}"
            yield Deviation("protocol", what, _shown(was), _shown(present), _hang_on(of, TOUCHES["session"]))


def _of_data(of: Plain, now: Plain) -> Iterator[Deviation]:
    """What was there when the study was registered must be there, as it was."""
    for role, touched in (("recordings", TOUCHES["recordings"]), ("runs", _RIG)):
        for key, was in of["data"][role].items():
            present = now["data"][role].get(key, [])
            if present[: len(was)] != was and (role == "runs" or key in now["plan"]["recordings"]):
                said = "other files" if present else ABSENT
                yield Deviation("data", f"{role[:-1]} {key}", "recorded", said, _hang_on(of, touched))


def _of_code(of: Plain, now: Plain) -> Iterator[Deviation]:
    """Digests are compared under one version of Python, which counts as a library; optional libraries may be absent."""
    old, new = of["code"], now["code"]
    for name, was in old["libraries"].items():
        present = new["libraries"].get(name, was)
        if was != present and ABSENT not in (was, present):
            yield Deviation("code", f"library {name}", was, present, _hang_on(of, _DATA))
    if old["libraries"]["python"] == new["libraries"]["python"]:
        parts = [name for name, (_, questions) in CODE.items() if old["parts"].get(name) != new["parts"].get(name)]
    else:
        parts = list(CODE) if old["emg2vsa"] != new["emg2vsa"] else []
    if parts:
        questions = [question for name in parts for question in CODE[name][1]]
        was, present = (f"emg2vsa {code['emg2vsa']} ({code['digest'][:12]})" for code in (old, new))
        yield Deviation("code", f"code of {', '.join(parts)}", was, present, _hang_on(of, questions))


def _changed(old: Plain, new: Plain, at: Path = ()) -> Iterator[tuple[Path, Any, Any]]:
    """Path and both values of what differs, None where there is none; 7 and 7.0 are the same."""
    for name in dict.fromkeys((*old, *new)):
        was, present = old.get(name), new.get(name)
        if isinstance(was, dict) and isinstance(present, dict):
            yield from _changed(was, present, (*at, name))
        elif was != present:
            yield (*at, name), was, present


def _shown(value: Any) -> str:
    if value is None or isinstance(value, dict):
        return ABSENT if value is None else "planned"
    return value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
