"""Checks of names: given twice, or used but never given."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from emg2vsa.study_file.draft import Draft
from emg2vsa.study_file.lines import KeyPath
from emg2vsa.study_file.problems import Problem, nearest


def name_problems(draft: Draft) -> Iterator[Problem]:
    """Participants, specimens and every key that refers to them."""
    at: KeyPath = ("participants", "ids" if draft.participants and draft.participants.ids else "file")
    yield from _twice(draft.participant_ids or (), at)
    yield from _specimens_twice(draft)
    if draft.participant_ids is not None:
        yield from _unknown_participants(draft, draft.participant_ids)
    if draft.specimen_names is not None:
        yield from _unknown_specimens(draft, draft.specimen_names)


def _twice(names: Iterable[str], at: KeyPath) -> Iterator[Problem]:
    seen: dict[str, str] = {}
    for index, name in enumerate(names):
        if name.casefold() in seen:
            first = seen[name.casefold()]
            found = f"{name!r} again" if name == first else f"{name!r} after {first!r}, one file name for some systems"
            yield Problem((*at, index), "every name once", found)
        seen.setdefault(name.casefold(), name)


def _specimens_twice(draft: Draft) -> Iterator[Problem]:
    kept = [(index, specimen.name) for index, specimen in enumerate(draft.specimens) if specimen]
    for problem in _twice([name for _, name in kept], ()):
        index = kept[int(problem.path[0])][0]
        yield Problem(("specimens", index, "name"), problem.wanted, problem.found)


def _unknown(names: Sequence[str], known: Sequence[str], at: KeyPath, what: str) -> Iterator[Problem]:
    for index, name in enumerate(names):
        if name not in known:
            listed = f"The study's {what}s are {', '.join(known)}."
            path = (*at, index) if len(names) > 1 or at[-1] in ("specimens", "kept_specimens") else at
            yield Problem(path, f"a {what} of this study", repr(name), nearest(name, known, listed))


def _unknown_participants(draft: Draft, known: Sequence[str]) -> Iterator[Problem]:
    for index, file in enumerate(draft.files):
        if file:
            yield from _unknown([file.participant], known, ("recordings", "files", index, "participant"), "participant")
    if draft.profile and draft.profile.participant is not None:
        yield from _unknown([draft.profile.participant], known, ("profile", "participant"), "participant")


def _unknown_specimens(draft: Draft, known: Sequence[str]) -> Iterator[Problem]:
    for index, file in enumerate(draft.files):
        if file:
            yield from _unknown([file.specimen], known, ("recordings", "files", index, "specimen"), "specimen")
    if draft.hypotheses:
        kept = draft.hypotheses.kept_specimens
        yield from _unknown(kept, known, ("hypotheses", "kept_specimens"), "specimen")
        yield from _twice(kept, ("hypotheses", "kept_specimens"))
    if draft.profile:
        yield from _unknown(draft.profile.specimens, known, ("profile", "specimens"), "specimen")
        yield from _twice(draft.profile.specimens, ("profile", "specimens"))
        if draft.profile.new_specimen in known:
            do = "Give it a name of its own."
            yield Problem(("profile", "new_specimen"), "a new name", f"the specimen {draft.profile.new_specimen!r}", do)
    if draft.simulation:
        yield from _simulated(draft, known)


def _simulated(draft: Draft, known: Sequence[str]) -> Iterator[Problem]:
    for key in ("a_v", "b_v"):
        given: dict[str, float] = getattr(draft.simulation, key)
        for name in given:
            if name not in known:
                listed = f"The study's specimens are {', '.join(known)}."
                path = ("simulation", key, name)
                yield Problem(path, "a specimen of this study", repr(name), nearest(name, known, listed))
        for name in known:
            if name not in given:
                yield Problem(("simulation", key, name), f"{key} of every specimen", f"none for {name!r}")
