"""Where a study differs from its registration, and which claims each difference touches."""

from __future__ import annotations

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
from fnmatch import fnmatchcase
from typing import Any, Literal

from emg2vsa.claims import kappa, people, rig
from emg2vsa.claims.claim import Judged
from emg2vsa.registration.plan import EMULATED, Plain, claim_plan

Kind = Literal["protocol", "rig", "analysis", "judgement", "data", "code", "claim"]
Path = tuple[str, ...]
ABSENT = "absent"
_KINDS: dict[str, Kind] = {
    **dict.fromkeys(("participants", "specimens", "order of specimens", "recordings", "session", "window"), "protocol"),
    "judgements": "judgement", "rig tables": "rig", "plate": "rig",
}  # fmt: skip
"""Of what else is registered the kind is "analysis"."""

_PEOPLE, _KAPPA = people.QUESTION, (kappa.QUESTION,)
_RIG = (rig.AREAS, rig.RATES, rig.CONDITIONS, *_KAPPA)
_DATA = (_PEOPLE, *_RIG)
_OF_PRESSES = (_PEOPLE, "curves")
TOUCHES: dict[str, tuple[str, ...]] = {
    "mode": (*_DATA, "curves"), "participants": _OF_PRESSES,
    "specimens": (*_DATA, "curves", "plate_r2", "interpolation_weight"), "order of specimens": (_PEOPLE,),
    "recordings": _OF_PRESSES, "judgements": (_PEOPLE,), "rig tables": _RIG, "filters": _OF_PRESSES,
    "cocontraction": _OF_PRESSES, "fit": _OF_PRESSES, "hypotheses": (_PEOPLE,), "session": (_PEOPLE,),
    "window": _OF_PRESSES, "profile": (*_RIG, "interpolation_rmse", "interpolation_weight"),
    "schedule": (*_RIG, "schedule_range"), "runs": _RIG, "discrimination": _RIG, "calibration": _KAPPA, "claims": (),
    "calibration.mounting_sd_percent": _RIG, "plate": (*_RIG, "plate_r2"),
}  # fmt: skip
"""Each part of a plan, and the claims that may hang on it, by question or by key. [claims] has none here: the claims
themselves tell which of them a margin moves."""
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
    """One difference. what : it is of. registered, now : in words. claims : keys of those that may hang on it."""

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
        touched = f"{count} claim{'s' if count > 1 else ''} ({_some(self.claims)})" if count else "no claim"
        return f"{self.what}: {self.registered} when registered, {self.now} now; may touch {touched}"


@dataclass(frozen=True)
class Registered:
    """A registration, and how the study differs from it now.

    registered_at : ISO 8601. collected : which data there were then, in a sentence. amends : hash of the registration
    that this one follows, "" for none. claims : key to what was registered of it. awaited, awaited_runs : planned
    recordings and measured runs that are not there yet. after_data : any data were there. from_amended : deviations
    from the plans that it amends, in words.
    """

    file: str
    sha256: str
    registered_at: str
    collected: str
    amends: str
    claims: Mapping[str, Plain]
    deviations: tuple[Deviation, ...]
    awaited: tuple[str, ...] = ()
    awaited_runs: tuple[str, ...] = ()
    after_data: bool = False
    from_amended: tuple[str, ...] = ()

    @property
    def of_plan(self) -> tuple[Deviation, ...]:
        """All but those of code and libraries, which differ from computer to computer."""
        return tuple(each for each in self.deviations if each.kind != "code")

    @property
    def waits(self) -> str:
        """What is planned and not there yet, in words; "" for nothing."""
        awaited = (("recordings", self.awaited), ("runs of the rig", self.awaited_runs))
        said = " and ".join(f"{len(keys)} planned {what}" for what, keys in awaited if keys)
        return f"{said} are not there yet" if said else ""

    def state(self, judged: Judged) -> str:
        """State of a verdict: "registered", which may be "after data", with "deviates: ..." and why; or "not
        registered".
        """
        key, now = judged.claim.key, claim_plan(judged)
        if key not in self.claims:
            return "not registered"
        of = [each.what for each in self.of_plan if key in each.claims]
        of = of or [f"its {name}" for name, was in self.claims[key].items() if now[name] != was]
        return f"registered{' after data' * self.after_data}" + (f", deviates: {'; '.join(of)}" if of else "")

    def lines(self) -> Iterator[str]:
        """For a screen: what was registered, then each deviation."""
        count = len(self.deviations) or "no"
        about = f"registered {self.registered_at[:10]}, {self.file}, SHA-256 {self.sha256[:12]}"
        about += f", which amends {self.amends[:12]}" if self.amends else ""
        yield f"{about}: {count} deviation{'s' if count != 1 else ''}{', ' * bool(self.waits)}{self.waits}"
        yield from (f"deviation: {each}" for each in self.deviations)
        yield from (f"deviation from the plan that was amended: {each}" for each in self.from_amended)
        if self.after_data:
            yield f"Data when it was registered: {self.collected}"

    def as_json(self) -> dict[str, object]:
        """All but the claims."""
        return {name: value for name, value in asdict(self).items() if name != "claims"}


def compared(of: Plain, now: Plain, file: str, *, final: bool = False) -> Registered:
    """The registration ``of`` beside the same parts of the study ``now``.

    final : the data are complete, so that a planned recording or measured run that is not there is a deviation.
    """
    found = [*_of_plan(of, now), *_of_sessions(of, now), *_of_data(of, now), *_of_runs(of, now), *_of_code(of, now)]
    there = of["data"]["recordings"].keys() | now["data"]["recordings"].keys()
    awaited = tuple(key for key in of["plan"]["recordings"] if key in now["plan"]["recordings"] and key not in there)
    measured = now["plan"]["tables"].get("runs", {}).get("source", EMULATED) != EMULATED
    runs_there = of["data"]["runs"].keys() | now["data"]["runs"].keys()
    runs = tuple(name for name in of["plan"].get("runs", ()) if measured and name not in runs_there)
    if final:
        hang = _hang_on(of, TOUCHES["recordings"])
        found += [Deviation("data", f"recording {key}", "planned", ABSENT, hang) for key in awaited]
        found += [Deviation("data", f"run {_some(runs)}", "planned", ABSENT, _hang_on(of, _RIG))] * bool(runs)
    explained = {key for each in found for key in each.claims}
    for key in sorted(of["claims"].keys() - explained):
        for path, was, present in _changed(of["claims"][key], now["claims"].get(key, {})):
            found.append(Deviation("claim", f"claim {key}, {'.'.join(path)}", _shown(was), _shown(present), (key,)))
    whole = (of["sha256"], of["registered_at"], of["collected"], of["amends"], of["claims"])
    awaited, runs = ((), ()) if final else (awaited, runs)
    return Registered(file, *whole, tuple(found), awaited, runs, any(of["data"].values()))


def _hang_on(of: Plain, questions: Iterable[str]) -> tuple[str, ...]:
    """Keys of the claims of these questions, or of these keys."""
    return tuple(key for key, claim in of["claims"].items() if {claim["question"], key} & {*questions})


def _of_plan(of: Plain, now: Plain) -> Iterator[Deviation]:
    """Recordings that changed alike, whoever they are of, are one deviation; the first says how."""
    alike: dict[tuple[Path, str], list[tuple[str, str, str]]] = defaultdict(list)
    for path, was, present in _changed(of["plan"], _on_common_ground(of["plan"], now["plan"])):
        recording, said = path[1] if path[0] == "recordings" else "", (_shown(was), _shown(present))
        whoever = re.sub("|".join(map(re.escape, recording.split("/"))), "*", "\n".join(said))
        alike[("recordings", *path[2:]) if recording else path, whoever].append((recording, *said))
    for (path, _), ((first, was_said, said_now), *others) in alike.items():
        where = path[1] if path[0] == "tables" or path[:2] == ("rig tables", "plate") else path[0]
        touched = _hang_on(of, TOUCHES.get(".".join(path[1:]), TOUCHES[where]))
        if where == "claims":
            touched = tuple(key for key, claim in of["claims"].items() if now["claims"].get(key) != claim)
        what = _what(path, f"{first} and {len(others)} more" if others else first)
        yield Deviation(_KINDS.get(where, "analysis"), what, was_said, said_now, touched)


def _on_common_ground(old: Plain, new: Plain) -> Plain:
    """``new`` without what one deviation says already: of people and specimens that came or went no recordings, no
    places in an order; of planned people and specimens every recording that is made as planned, of files of its own."""
    known = [_but_files(own) for own in old["recordings"].values()]
    used = Counter(file for own in new["recordings"].values() for file in {*own["files"]})
    both = {name: [each for each in old[name] if each in new[name]] for name in ("participants", "specimens")}
    recordings = {}
    for key in dict.fromkeys((*old["recordings"], *new["recordings"])):
        was, own = old["recordings"].get(key), new["recordings"].get(key)
        who, _, specimen = key.partition("/")
        if who not in both["participants"] or specimen not in both["specimens"]:
            own = was
        elif was and own and _are_planned(was["files"], own["files"]):
            own = own | {"files": was["files"]}
        elif not was and own and _but_files(own) in known and all(used[file] == 1 for file in own["files"]):
            own = was
        if own is not None:
            recordings[key] = own
    order = [name for name in new["order of specimens"] if name in both["specimens"]]
    kept = order == [name for name in old["order of specimens"] if name in both["specimens"]]
    said = {"recordings": recordings, "order of specimens": old["order of specimens"] if kept else order}
    of_rig = new["rig tables"] if old["rig tables"] and new["rig tables"] else old["rig tables"]
    return new | said | {"rig tables": of_rig, "runs": old.get("runs")}  # a rig file that came or went is one deviation


def _but_files(recording: Plain) -> Plain:
    return {key: value for key, value in recording.items() if key != "files"}


def _are_planned(planned: Sequence[str], files: Sequence[str]) -> bool:
    """Whether these are the planned files, or what was found for them: a ``*`` stands for what a pattern leaves open,
    BIDS numbers runs from 1, further repetitions differ by numbers."""
    runs = [re.sub(r"_run-0*(\d+)_emg\.", r"_run-\1_emg.", file) for file in files]
    if runs == [planned[0].replace("_emg.", f"_run-{n}_emg.") for n in range(1, len(files) + 1)]:
        return True
    alike = {re.sub(r"\d+", "#", file) for file in planned}
    more = all(re.sub(r"\d+", "#", file) in alike or _is_of(file, planned[0]) for file in files[len(planned) :])
    same = all(_is_of(file, plan) or _is_of(plan, file) for plan, file in zip(planned, files, strict=False))
    return same and more and (len(files) >= len(planned) or "*" in files[0])


def _is_of(file: str, pattern: str) -> bool:
    return fnmatchcase(file, pattern.replace("[", "[[]"))


def _what(path: Path, recordings: str) -> str:
    match path:
        case ("recordings", *keys):
            return ", ".join(filter(None, (f"recording {recordings}", ".".join(keys))))
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
    for role, touched in (("recording", TOUCHES["recordings"]), ("run", _RIG)):
        there, changed = now["data"][f"{role}s"], defaultdict(list)
        for key, was in of["data"][f"{role}s"].items():
            present = there.get(key, [])
            if present[: len(was)] != was and (role == "run" or key in now["plan"]["recordings"]):
                changed["other files" if present else ABSENT].append(key)
        for said, keys in changed.items():
            yield Deviation("data", f"{role} {_some(keys)}", "recorded", said, _hang_on(of, touched))


def _of_runs(of: Plain, now: Plain) -> Iterator[Deviation]:
    """The rig file that is gone, and runs that are not planned, where the plan says which are."""
    touched, planned = _hang_on(of, _RIG), of["plan"].get("runs")
    if of["plan"]["rig tables"] and not now["plan"]["rig tables"]:
        yield Deviation("rig", "rig file", _shown(of["rig_file"]), ABSENT, touched)
    known = {*(planned or now["data"]["runs"]), *of["data"]["runs"]}
    if more := [name for name in now["data"]["runs"] if name not in known]:
        yield Deviation("data", f"run {_some(more)}", "not planned", "there", touched)


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
    if value is None:
        return ABSENT
    if isinstance(value, dict):
        return f"{{{_some([f'{key} = {_shown(own)}' for key, own in value.items()], 12)}}}"
    as_it_is = isinstance(value, str) and re.fullmatch(r"[^\s:;,]+", value)
    return value if as_it_is else json.dumps(value, ensure_ascii=False)


def _some(words: Sequence[str], shown: int = 5) -> str:
    more = f" and {len(words) - shown} more" if len(words) > shown else ""
    return ", ".join(words[:shown]) + more
