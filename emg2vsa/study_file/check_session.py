"""Checks of [session]: against itself, and against the tables that say how its recordings are read."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from emg2vsa.bids.names import is_label
from emg2vsa.session_settings import (
    MOST_FORCE_N,
    PARTICIPANT_CODE,
    SessionSettings,
)
from emg2vsa.settings import LABEL_CHARACTERS, ChannelSettings, WindowSettings
from emg2vsa.study_file.problems import KeyPath, Problem, nearest, shown
from emg2vsa.study_file.tables import RecordingsTable, SpecimenTable


def _codes(session: SessionSettings, ids: tuple[str, ...]) -> Iterator[Problem]:
    for name in ids if session else ():
        if not re.fullmatch(PARTICIPANT_CODE, name):
            do = "Names stay out of the data: keep the list of codes and names apart, on paper."
            yield Problem(("participants",), "codes with [session]: at most four letters and a number", repr(name), do)


def _training(session: SessionSettings, specimens: tuple[SpecimenTable, ...]) -> Iterator[Problem]:
    known = {specimen.name.casefold() for specimen in specimens}
    seen: set[str] = set()
    for index, name in enumerate(session.training_specimens):
        at: KeyPath = ("session", "training_specimens", index)
        if name.casefold() in known:
            do = "The practice would make this specimen better known than the others. Take another one."
            yield Problem(at, "a specimen that is not among [[specimens]]", repr(name), do)
        if name.casefold() in seen:
            yield Problem(at, "every name once", f"{name!r} again")
        if not is_label(name):
            yield Problem(at, "letters and digits only, as it is a label in BIDS file names", repr(name))
        seen.add(name.casefold())


def _orders(session: SessionSettings, specimens: tuple[SpecimenTable, ...], ids: tuple[str, ...]) -> Iterator[Problem]:
    at: KeyPath = ("session", "orders")
    if session.orders and session.order != "listed":
        do = "Set order = 'listed', or remove the table."
        yield Problem(at, "order = 'listed' with orders of participants", f"order = {session.order!r}", do)
    names = [specimen.name for specimen in specimens]
    for participant, order in session.orders.items():
        if participant not in ids:
            do = nearest(participant, ids, "Name participants of [participants].")
            yield Problem((*at, participant), "a participant of the study", repr(participant), do)
        if sorted(order) != sorted(names):
            wanted = f"every specimen once ({', '.join(names)})"
            yield Problem((*at, participant), wanted, ", ".join(order) or "none", "Correct the list.")
    if session.orders and (without := [name for name in ids if name not in session.orders]):
        yield Problem(at, "an order for every participant", f"none for {', '.join(without)}", "Add their orders.")


_NAMING = ("name", "birth", "dob", "mail", "phone", "address", "initial", "passport", "insurance", "participant_id")
"""Words that a column's name must not hold: such a column would say who somebody is."""


def _form(session: SessionSettings) -> Iterator[Problem]:
    for name, column in session.form.items():
        at: KeyPath = ("session", "form", name)
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            yield Problem(at, "a name of small letters, digits and _, as BIDS has columns", repr(name))
        if any(word in name for word in _NAMING):
            do = "Keep the list of codes and names apart from the data, on paper."
            yield Problem(at, "a column that does not say who somebody is", repr(name), do)
        if (column.range is None) == (not column.levels):
            found = "both" if column.levels else "neither"
            yield Problem(at, "either range or levels", found, "There is no free text, so that no name gets in.")
        elif column.range and column.range[0] >= column.range[1]:
            yield Problem((*at, "range"), "the smaller number first", shown(list(column.range)))
        for word in column.levels:
            if not word.strip() or word == "n/a" or word[0] in "=+-@" or re.search(r"[\t\r\n]", word):
                do = "A table would take it for nothing, or a formula. Write another word."
                yield Problem((*at, "levels", word), "a word without tab or a sign such as = before it", repr(word), do)
        if column.unit and not column.range:
            yield Problem((*at, "unit"), "range with this key", "levels")


def _forces(session: SessionSettings, window: WindowSettings) -> Iterator[Problem]:
    lower, upper = session.force_n
    at: KeyPath = ("session", "force_n")
    if lower >= upper:
        yield Problem(at, "the smaller number first", shown(list(session.force_n)))
        return
    if lower > window.force_n[0] or upper < window.force_n[1]:
        wanted = f"at least the range that is analysed, [window] force_n = {shown(list(window.force_n))}"
        yield Problem(at, wanted, shown(list(session.force_n)))
    if session.bar_n < upper:
        yield Problem(("session", "bar_n"), f"at least the upper force, {upper:g}", f"{session.bar_n:g}")
    if session.ready_n >= lower:
        yield Problem(("session", "ready_n"), f"less than the lower force, {lower:g}", f"{session.ready_n:g}")
    if session.limits.peak_n <= upper:
        wanted = f"more than the upper force, {upper:g}"
        yield Problem(("session", "limits", "peak_n"), wanted, f"{session.limits.peak_n:g}")


def _times(session: SessionSettings, window: WindowSettings) -> Iterator[Problem]:
    shortest, longest = session.load_s
    at: KeyPath = ("session", "load_s")
    if shortest >= longest:
        yield Problem(at, "the smaller number first", shown(list(session.load_s)))
    elif shortest < window.min_duration_s or longest > window.max_duration_s:
        wanted = f"times that [window] accepts, {window.min_duration_s:g} to {window.max_duration_s:g}"
        yield Problem(
            at, wanted, shown(list(session.load_s)), "Else a press could be right on the screen and rejected."
        )
    for key in ("reaction_s", "zero_n", "lost_share"):
        pair = getattr(session.limits, key)
        if pair[0] > pair[1]:
            yield Problem(("session", "limits", key), "the smaller number first", shown(list(pair)))


def _plausible(session: SessionSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    """Values that no session has, which a slip of the pen or of the unit makes."""
    limits = session.limits
    if session.force_n[1] > MOST_FORCE_N:
        yield Problem(("session", "force_n", 1), f"at most {MOST_FORCE_N:g} N", f"{session.force_n[1]:g}")
    if limits.early_s >= limits.reaction_s[0]:
        wanted = f"less than the time of a reaction, {limits.reaction_s[0]:g}"
        yield Problem(("session", "limits", "early_s"), wanted, f"{limits.early_s:g}")
    if session.texts.start.strip().casefold() == session.texts.stop.strip().casefold():
        yield Problem(("session", "texts", "stop"), "another text than that of start", repr(session.texts.stop))
    if (trigger := session.trigger) and trigger.pulse != "byte" and not trigger.pulse_s:
        yield Problem(("session", "trigger", "pulse_s"), f"more than 0 with pulse = {trigger.pulse!r}", "0")
    if trigger and trigger.start == trigger.stop and trigger.pulse == "byte":
        yield Problem(("session", "trigger", "stop"), "another byte than that of start", str(trigger.stop))
    for key in ("start", "stop", "verdict"):
        if trigger and trigger.pulse != "byte" and key in raw["session"]["trigger"]:
            do = 'Set pulse = "byte", or remove the key.'
            yield Problem(("session", "trigger", key), "pulse = 'byte' with this key", f"pulse = {trigger.pulse!r}", do)
    if (band := session.about.band_hz) and band[0] >= band[1]:
        yield Problem(("session", "about", "band_hz"), "the smaller number first", shown(list(band)))
    if session.check_each_press and not session.checklist:
        do = "Write what is confirmed before each press, or set check_each_press = false."
        yield Problem(("session", "checklist"), "an item with check_each_press", "none", do)


def _counts(session: SessionSettings, window: WindowSettings, raw: Mapping[str, Any]) -> Iterator[Problem]:
    yield from _of_width(session, raw["session"])
    expected = window.expected_trials
    if expected is not None and session.stop == "count" and expected != session.repetitions:
        wanted = f"as many as [window] expected_trials, {expected}"
        yield Problem(("session", "repetitions"), wanted, str(session.repetitions), "Correct one of the two.")


def _of_width(session: SessionSettings, given: Mapping[str, Any]) -> Iterator[Problem]:
    if session.stop == "width" and session.most_presses < session.repetitions:
        wanted = f"at least repetitions = {session.repetitions}"
        yield Problem(("session", "most_presses"), wanted, str(session.most_presses))
    for key in ("width", "most_presses"):
        if session.stop == "count" and key in given:
            do = 'Set stop = "width", or remove the key.'
            yield Problem(("session", key), "stop = 'width' with this key", "stop = 'count'", do)


def _muscles(session: SessionSettings, channels: ChannelSettings) -> Iterator[Problem]:
    """Each muscle of the study has a channel of the source, where those are named, and no other muscle has."""
    named = getattr(session.emg, "channels", None)
    if named is None:
        return
    at: KeyPath = ("session", "emg", "channels")
    for role in named:
        if role not in channels.emg:
            do = nearest(role, channels.emg, f"The muscles are {', '.join(channels.emg)}.")
            yield Problem((*at, role), "a muscle of [channels.emg]", repr(role), do)
    for role in channels.emg:
        if role not in named:
            yield Problem((*at, role), f"the source's channel of the muscle {role!r}", "nothing")


def _places(session: SessionSettings, channels: ChannelSettings) -> Iterator[Problem]:
    """Each muscle of the study has two places, as far apart as the electrodes are."""
    if session.places is None:
        return
    at: KeyPath = ("session", "places", "pairs")
    pairs, apart_mm = session.places.pairs, session.about.electrode_mm
    for role in (*pairs, *channels.emg):
        if role not in channels.emg or role not in pairs:
            found = "nothing" if role in channels.emg else repr(role)
            yield Problem((*at, role), "two electrodes of each muscle of [channels.emg], and of no other", found)
    places = [place for pair in pairs.values() for place in pair]
    if len(set(places)) < len(places):
        yield Problem(at, "a place of its own for each electrode", "two at one place", "Correct the places.")
    if session.places.unit == "percent" and not all(0 <= each <= 100 for place in places for each in place):
        yield Problem(at, "0 to 100 with unit = 'percent'", "another number", "Correct the places.")
    scale = {"mm": 1.0, "cm": 10.0}.get(session.places.unit, 0.0)
    for role, pair in pairs.items():
        own = scale * math.dist(*pair)
        if scale and apart_mm and abs(own - apart_mm) > _APART_MM:
            wanted = f"electrodes that are about.electrode_mm = {apart_mm:g} mm apart"
            yield Problem((*at, role), wanted, f"{own:.3g} mm", "Correct one of the two.")


_APART_MM = 1.0
"""Places are read off a tape on the skin."""


def _layout(
    session: SessionSettings,
    recordings: RecordingsTable | None = None,
    ids: tuple[str, ...] = (),
) -> Iterator[Problem]:
    """What a session writes must be where the study looks for it."""
    at: KeyPath = ("session",)
    if recordings is None:
        yield Problem(at, "a table [recordings] with layout = 'bids', into which a session writes", "nothing")
        return
    if recordings.layout != "bids":
        wanted = "[recordings] layout = 'bids', in which a session writes its recordings"
        yield Problem(at, wanted, f"layout = {recordings.layout!r}", "Set layout, root and task.")
    elif recordings.extension != "bdf":
        yield Problem(("recordings", "extension"), "'bdf' with [session]", repr(recordings.extension))
    elif recordings.task == "training":
        yield Problem(("recordings", "task"), "another name than that of the practice", "'training'")


def _written_as_read(session: SessionSettings, channels: ChannelSettings | None = None) -> Iterator[Problem]:
    """A session writes EMG in uV, gain divided out, and force in N: the channels must not convert once more."""
    if channels is None:
        yield Problem(("session",), "tables [channels.emg.<muscle>] and [channels.force] of the study", "nothing")
        return
    for role, channel in channels.emg.items():
        at: KeyPath = ("channels", "emg", role)
        yield from _label(channel.name, (*at, "name"))
        if channel.gain != 1.0:
            do = "Give the amplifier's gain in [session.emg]; what a session writes is free of it."
            yield Problem((*at, "gain"), "1 with [session]", f"{channel.gain:g}", do)
        for key, good in (("unit", "uV"), ("fs_hz", None)):
            yield from _omitted(getattr(channel, key), good, (*at, key))
    force = channels.force
    yield from _label(force.name, ("channels", "force", "name"))
    for key, good in (
        ("unit", "N"), ("newtons_per_unit", None), ("fs_hz", None), ("cal_file", None), ("trigger", None),
    ):  # fmt: skip
        yield from _omitted(getattr(force, key), good, ("channels", "force", key))
    if force.delay_s:
        do = "Give the delay in [session.force]; a session takes it off the times that it writes."
        yield Problem(("channels", "force", "delay_s"), "0 with [session]", f"{force.delay_s:g}", do)


def _omitted(value: object, good: str | None, at: KeyPath) -> Iterator[Problem]:
    if value not in (None, good):
        wanted = f"no such key with [session]{f', or {good!r}' if good else ''}"
        yield Problem(at, wanted, shown(value), "A session writes EMG in uV and force in N, and states the rates.")


def _label(name: str, at: KeyPath) -> Iterator[Problem]:
    if len(name) > LABEL_CHARACTERS or not name.isascii():
        wanted = f"at most {LABEL_CHARACTERS} ASCII characters with [session]: BDF holds no more"
        yield Problem(at, wanted, repr(name))


CHECKS = (
    _codes, _training, _orders, _form, _forces, _times, _plausible, _counts, _muscles, _places,
    _layout, _written_as_read,
)  # fmt: skip
