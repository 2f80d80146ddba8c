"""Checks of names, given twice or used but never given; of where recordings are; of which channel plays which role.

A check takes the tables that it looks at, by their names. ``ids``: the participants. ``raw``: the file, which tells a
key that was set from one that has its default.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any

from emg2vsa.bids.names import is_label
from emg2vsa.settings import (
    GAUGE_AXES,
    MEDOID,
    ChannelSettings,
    CocontractionSettings,
    EmgChannelSettings,
    ForceChannelSettings,
    HypothesisSettings,
    ProfileSettings,
    SimulationSettings,
)
from emg2vsa.study_file.patterns import PLACEHOLDERS, REPETITION
from emg2vsa.study_file.problems import KeyPath, Problem, nearest, shown
from emg2vsa.study_file.tables import (
    FileTable,
    JudgementTable,
    MvcTable,
    ParticipantsTable,
    RecordingsTable,
    SpecimenTable,
)

Specimens = tuple[SpecimenTable, ...]
Judgements = tuple[JudgementTable, ...]


def _participants(participants: ParticipantsTable, ids: tuple[str, ...]) -> Iterator[Problem]:
    yield from _twice(ids, ("participants", "ids" if participants.ids else "file"))


def _specimens(specimens: Specimens) -> Iterator[Problem]:
    for problem in _twice(_names(specimens), ("specimens",)):
        yield Problem((*problem.path, "name"), problem.wanted, problem.found)


def _kept(hypotheses: HypothesisSettings, specimens: Specimens) -> Iterator[Problem]:
    yield from _chosen(hypotheses.kept_specimens, specimens, ("hypotheses", "kept_specimens"))


def _profile(profile: ProfileSettings, specimens: Specimens) -> Iterator[Problem]:
    yield from _chosen(profile.specimens, specimens, ("profile", "specimens"))
    if profile.new_specimen in _names(specimens):
        do = "Give it a name of its own."
        yield Problem(("profile", "new_specimen"), "a new name", f"the specimen {profile.new_specimen!r}", do)


def _exemplary(profile: ProfileSettings, ids: tuple[str, ...]) -> Iterator[Problem]:
    if MEDOID in ids:
        do = "Give the participant another code."
        yield Problem(("participants", "ids"), f"codes other than {MEDOID!r}, which chooses a participant", MEDOID, do)
    if profile.participant not in (None, MEDOID):
        yield from _unknown([(("profile", "participant"), profile.participant)], ids, "participant")


def _files(recordings: RecordingsTable, specimens: Specimens, ids: tuple[str, ...]) -> Iterator[Problem]:
    at: KeyPath = ("recordings", "files")
    people = [((*at, index, "participant"), file.participant) for index, file in enumerate(recordings.files)]
    pressed = [((*at, index, "specimen"), file.specimen) for index, file in enumerate(recordings.files)]
    yield from _unknown(people, ids, "participant")
    yield from _unknown(pressed, _names(specimens), "specimen")


def _judged(
    specimens: Specimens,
    ids: tuple[str, ...],
    exclude: Judgements,
    accept: Judgements,
) -> Iterator[Problem]:
    """People and specimens that are known, and no press under two judgements."""
    seen: dict[tuple[str, str, int | None], str] = {}
    for key, listed in (("exclude", exclude), ("accept", accept)):
        yield from _unknown(
            [((key, i, "participant"), own.participant) for i, own in enumerate(listed)], ids, "participant"
        )
        names = [((key, i, "specimen"), own.specimen) for i, own in enumerate(listed)]
        yield from _unknown(names, _names(specimens), "specimen")
        for i, own in enumerate(listed):
            press = (own.participant, own.specimen, own.repetition)
            if press in seen:
                what = "all presses" if own.repetition is None else f"press {own.repetition}"
                found = f"{what} of {own.participant}/{own.specimen} in [[{seen[press]}]] already"
                yield Problem((key, i), "one judgement of a press", found, "Keep one of the two.")
            seen.setdefault(press, key)


def _mvc(ids: tuple[str, ...], mvc: tuple[MvcTable, ...], cocontraction: CocontractionSettings) -> Iterator[Problem]:
    yield from _unknown([(("mvc", i, "participant"), own.participant) for i, own in enumerate(mvc)], ids, "participant")
    if mvc and cocontraction.normalise != "mvc":
        wanted = 'normalise = "mvc" under [cocontraction] with recordings of contractions'
        yield Problem(("mvc",), wanted, f"normalise = {cocontraction.normalise!r}", "Set it, or remove [[mvc]].")


def _simulated(simulation: SimulationSettings, specimens: Specimens) -> Iterator[Problem]:
    known = _names(specimens)
    for key, given in (("a_v", simulation.a_v), ("b_v", simulation.b_v)):
        yield from _unknown([(("simulation", key, name), name) for name in given], known, "specimen")
        for name in known:
            if name not in given:
                yield Problem(("simulation", key, name), f"{key} of every specimen", f"none for {name!r}")


def _names(specimens: Specimens) -> tuple[str, ...]:
    return tuple(specimen.name for specimen in specimens)


def _chosen(names: Collection[str], specimens: Specimens, at: KeyPath) -> Iterator[Problem]:
    yield from _unknown([((*at, index), name) for index, name in enumerate(names)], _names(specimens), "specimen")
    yield from _twice(names, at)


def _twice(names: Iterable[str], at: KeyPath) -> Iterator[Problem]:
    seen: dict[str, str] = {}
    for index, name in enumerate(names):
        if name.casefold() in seen:
            first = seen[name.casefold()]
            found = f"{name!r} again" if name == first else f"{name!r} after {first!r}, one file name for some systems"
            yield Problem((*at, index), "every name once", found)
        seen.setdefault(name.casefold(), name)


def _unknown(names: Iterable[tuple[KeyPath, str]], known: tuple[str, ...], what: str) -> Iterator[Problem]:
    there, listed = set(known), ", ".join(known[:20]) + (f" and {len(known) - 20} more" if len(known) > 20 else "")
    for path, name in names:
        if name not in there:
            do = nearest(name, known, f"The study's {what}s are {listed}.")
            yield Problem(path, f"a {what} of this study", repr(name), do)


_KEYS_OF_LAYOUT = {
    "bids": ("root", "task", "extension", "visits"),
    "pattern": ("pattern", "force_pattern"),
    "files": (),
}
_REQUIRED = {"bids": ("root", "task"), "pattern": ("pattern",), "files": ("files",)}


def _layout(recordings: RecordingsTable, raw: Mapping[str, Any]) -> Iterator[Problem]:
    given, chosen = raw["recordings"], f"layout = {recordings.layout!r}"
    for name in _REQUIRED[recordings.layout]:
        if not given.get(name):
            yield Problem(("recordings", name), f"a key {name!r} with {chosen}", "nothing")
    for other, names in _KEYS_OF_LAYOUT.items():
        for name in names:
            if name in given and other != recordings.layout:
                wanted = f"keys of this layout only ({name!r} is of {other!r})"
                yield Problem(("recordings", name), wanted, f"{name!r} with {chosen}")


def _patterns(recordings: RecordingsTable, specimens: Specimens, ids: tuple[str, ...]) -> Iterator[Problem]:
    counts = {"participant": len(ids), "specimen": len(specimens)}
    for key, pattern in (("pattern", recordings.pattern), ("force_pattern", recordings.force_pattern)):
        path = ("recordings", key)
        names = re.findall(r"\{([^{}]*)\}", pattern or "")
        unknown = [name for name in names if name not in PLACEHOLDERS]
        for name in unknown:
            do = nearest(name, PLACEHOLDERS)
            yield Problem(path, "{participant}, {specimen} and {repetition} as placeholders", f"{{{name}}}", do)
        for name, count in counts.items():
            if pattern and not unknown and name not in names and count > 1:
                yield Problem(path, f"{{{name}}} in it, as there are {count} {name}s", shown(pattern))
        if pattern and "**" in pattern:
            yield Problem(
                path, "a * for each part of a name", "'**'", "Write * for any text in the name of one folder."
            )
    emg, force = recordings.pattern or "", recordings.force_pattern
    if force and (REPETITION in emg) != (REPETITION in force):
        key, found = ("force_pattern", force) if REPETITION in emg else ("pattern", emg)
        yield Problem(("recordings", key), f"{REPETITION} in it, as the other pattern has", shown(found))


def _labels(recordings: RecordingsTable, specimens: Specimens, ids: tuple[str, ...]) -> Iterator[Problem]:
    if recordings.layout != "bids":
        return
    labels: list[tuple[KeyPath, str]] = [(("recordings", "task"), recordings.task or "0")]
    labels += [(("participants",), name) for name in ids]
    labels += [(("specimens", index, "name"), name) for index, name in enumerate(_names(specimens))]
    labels += [(("recordings", "visits", index), label) for index, label in enumerate(recordings.visits)]
    yield from _twice(recordings.visits, ("recordings", "visits"))
    for path, label in labels:
        if not is_label(label):
            yield Problem(path, "letters and digits only, as it is a label in BIDS file names", repr(label))


def _listed(recordings: RecordingsTable, raw: Mapping[str, Any]) -> Iterator[Problem]:
    cells: dict[tuple[str, str], list[int]] = {}
    given = raw["recordings"].get("files", ())
    for index, file in enumerate(recordings.files):
        at: KeyPath = ("recordings", "files", index)
        earlier = cells.setdefault((file.participant, file.specimen), [])
        if file.emg is None and recordings.layout == "files":
            yield Problem((*at, "emg"), "a key 'emg' with layout = 'files'", "nothing")
        elif earlier and (file.emg is None or recordings.files[earlier[0]].emg is None):
            do = "Give each of several recordings its file."
            found = f"a further recording of {file.participant}/{file.specimen} without a file"
            yield Problem((*at, "emg"), "a key 'emg' in each recording of a participant on a specimen", found, do)
        if file.emg is not None and any(recordings.files[other].emg == file.emg for other in earlier):
            found = f"{shown(file.emg)} again for {file.participant}/{file.specimen}"
            yield Problem((*at, "emg"), "a file of its own for each recording", found)
        for key in ("filters", "window") if earlier else ():
            if key in given[index]:
                do = f"Set it at the first recording of {file.participant}/{file.specimen}; it holds for all of them."
                yield Problem((*at, key), "settings that all recordings of a participant on a specimen share", key, do)
        if "force_n" in given[index].get("window", ()):
            do = "Set it in [window]: fits and profiles share its bins."
            yield Problem((*at, "window", "force_n"), "one force window for all recordings", "another one", do)
        earlier.append(index)


def _roles(channels: ChannelSettings, recordings: RecordingsTable | None = None) -> Iterator[Problem]:
    own = recordings is not None and _force_apart(recordings)
    yield from _one_role_each(channels.emg, None if own else channels.force, ("channels",))


def _own_roles(recordings: RecordingsTable, channels: ChannelSettings | None = None) -> Iterator[Problem]:
    for index, file in enumerate(recordings.files):
        own = file.channels
        if own and (own.emg or own.force):
            emg = own.emg or (channels.emg if channels else {})
            force = None if _is_apart(file, recordings) else own.force or (channels.force if channels else None)
            yield from _one_role_each(emg, force, ("recordings", "files", index, "channels"))


def _force_apart(recordings: RecordingsTable) -> bool:
    """Whether every recording with the study's channels has its force in a file of its own."""
    listed = [file for file in recordings.files if not (file.channels and (file.channels.emg or file.channels.force))]
    if recordings.layout == "files":
        return bool(listed) and all(_is_apart(file, recordings) for file in listed)
    return _by_pattern(recordings) and all(_is_apart(file, recordings) for file in listed)


def _is_apart(file: FileTable, recordings: RecordingsTable) -> bool:
    if file.force is not None:
        return file.force != file.emg
    return file.emg is None and _by_pattern(recordings)


def _by_pattern(recordings: RecordingsTable) -> bool:
    return recordings.force_pattern not in (None, recordings.pattern)


def _one_role_each(
    emg: Mapping[str, EmgChannelSettings], force: ForceChannelSettings | None, at: KeyPath
) -> Iterator[Problem]:
    """No channel of one file plays two roles; force None: in a file of its own, where any name is free."""
    roles: dict[str, str] = {}
    for role, channel in emg.items():
        first = roles.setdefault(channel.name, role)
        if first != role:
            path = (*at, "emg", role, "name")
            yield Problem(path, "a channel of its own for each muscle", f"{channel.name!r}, as for {first}")
    if force and force.name in roles:
        yield Problem((*at, "force", "name"), "a channel of its own", f"{force.name!r}, as for {roles[force.name]}")


def _gauges(channels: ChannelSettings | None = None, recordings: RecordingsTable | None = None) -> Iterator[Problem]:
    """The gauges of a transducer come with their calibration, and with nothing that is of a force."""
    forces: list[tuple[KeyPath, ForceChannelSettings]] = [(("channels", "force"), channels.force)] if channels else []
    for index, file in enumerate(recordings.files if recordings else ()):
        if file.channels and file.channels.force:
            forces.append((("recordings", "files", index, "channels", "force"), file.channels.force))
    for at, force in forces:
        if force.cal_file is None:
            for key in ("gauges", "volts_per_unit"):
                if getattr(force, key) is not None:
                    yield Problem((*at, key), "a key 'cal_file' with it", "nothing")
            continue
        if force.gauges is None:
            yield Problem((*at, "gauges"), "the six gauge channels with cal_file", "nothing")
        elif len(set(force.gauges)) < len(force.gauges):
            yield Problem((*at, "gauges"), "six different channels", ", ".join(force.gauges))
        if force.name not in GAUGE_AXES:
            yield Problem((*at, "name"), f"{', '.join(GAUGE_AXES)} with cal_file", repr(force.name))
        if force.newtons_per_unit is not None:
            do = "The calibration gives newtons; volts_per_unit is for gauges in counts."
            yield Problem((*at, "newtons_per_unit"), "either cal_file or newtons_per_unit", "both", do)
        if force.unit is not None and force.volts_per_unit is not None:
            do = "unit is for gauges in volts; volts_per_unit for gauges in counts."
            yield Problem((*at, "unit"), "either unit or volts_per_unit", "both", do)


def _channels_of_all(recordings: RecordingsTable, raw: Mapping[str, Any]) -> Iterator[Problem]:
    own = [file.channels for file in recordings.files]
    all_named = bool(own) and all(channels and channels.emg and channels.force for channels in own)
    if "channels" not in raw and not (recordings.layout == "files" and all_named):
        wanted = "a table [channels.emg.<muscle>] for each muscle and [channels.force]"
        do = "Or give every recording its own under [[recordings.files]]."
        yield Problem(("channels",), wanted, "nothing", do)


CHECKS = (
    _participants, _specimens, _kept, _profile, _exemplary, _files, _judged, _mvc, _simulated,
    _layout, _patterns, _labels, _listed, _roles, _own_roles, _gauges, _channels_of_all,
)  # fmt: skip
