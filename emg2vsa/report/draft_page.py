"""The page beside a drafted study file: what was guessed, and one recording as the study file has it."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

import numpy as np

from casr import html
from emg2vsa import __version__
from emg2vsa.extraction import Trials
from emg2vsa.report.recordings import file_section
from emg2vsa.report.session_plots import LEGEND, MARKS, emg_trace, force_trace
from emg2vsa.report.wording import count
from emg2vsa.study import RecordingEntry
from emg2vsa.study_file.draft_channel import FILL, DraftChannel
from emg2vsa.study_file.drafting import Found

_HEADS = ("role", "channel", "unit", "rate, Hz", "why")


_DRAFTED = "Drafted from "


def is_draft_page(file: Path) -> bool:
    """Whether the file is a page of this kind."""
    return f'<p class="sub">{_DRAFTED}' in file.read_text(encoding="utf-8", errors="replace")


def draft_page(found: Found, text: str, file: Path, shown: tuple[RecordingEntry, Trials] | str) -> str:
    """The page. text : of the study file. shown : a recording and its presses, or why it has none."""
    marked = [f"Line {n}: {line}" for n, line in enumerate(text.splitlines(), 1) if FILL in line and n > 1]
    body = html.section("guessed", "What was guessed", html.bullets(_names(found)), _channels(found))
    if isinstance(shown, str):
        told = html.statement("repeat", "No press was looked for.", shown)
        body += html.section("unsure", "Why no press is shown", told)
        files = {each.path: each for each in (found.emg, found.force)}
        body += "".join(file_section(n, each.path.name, each) for n, each in enumerate(files.values(), 1))
    else:
        body += html.section("recording", "One recording, with its presses", _recording(found, *shown))
    if marked:
        body += html.section("fill-in", "What waits for you in the study file", html.bullets(marked))
    title = f"{file.parent.resolve().name}/{file.name}"
    header = f'<h1>{escape(title)}</h1><p class="sub">{_DRAFTED}{count(found.named, "recording")}</p>'
    return html.page(title, header, [], body, html.paragraph(f"Made by emg2vsa {__version__}.", "small"))


def _names(found: Found) -> list[str]:
    if found.naming is None:
        files = ["The names of the files show no pattern, so the study file lists them one by one."]
    else:
        files = [f"Files: {found.naming.pattern}"]
        files += [f"Force files: {found.naming.force_pattern}"] if found.naming.force_pattern else []
    return [*files, *(f"{one[0].upper()}{one[1:]}" if one.startswith("wh") else one for one in found.told)]


def _channels(found: Found) -> str:
    roles: Sequence[tuple[str, DraftChannel | None]] = [*found.emg_channels.items(), ("force", found.force_channel)]
    rows = [(role, c.name, *_unit_and_rate(found, c), c.said) for role, c in roles if c is not None]
    missing = [f"{FILL}: no channel looks like EMG."] if not found.emg_channels else []
    missing += [f"{FILL}: no channel looks like the force."] if found.force_channel is None else []
    return (
        html.table("Channels and their roles", _HEADS, rows, classes=("", "", "", "n", "")) if rows else ""
    ) + html.bullets(missing)


def _unit_and_rate(found: Found, channel: DraftChannel) -> tuple[str, str]:
    unit = channel.told_unit or (f"{channel.guessed_unit}, a guess" if channel.is_unit_guessed else channel.unit or "")
    rate_hz = channel.fs_hz or found.rate_hz(channel)
    return unit, f"{rate_hz:.6g}" if rate_hz > 0 else "unknown"


def _recording(found: Found, entry: RecordingEntry, trials: Trials) -> str:
    verdicts = [f"{np.count_nonzero(trials.verdict == verdict)} {verdict}" for verdict in MARKS]
    presses = "1 press" if trials.verdict.size == 1 else f"{trials.verdict.size} presses"
    body = html.paragraph(f"{entry.key}: {presses} found, of these {', '.join(verdicts)}.") + LEGEND
    force = found.force_channel
    assert force is not None  # or the study file would have none
    unit, rate = _unit_and_rate(found, force)
    way = "turned round, as pressing lowers it" if force.sign < 0 else "as it is"
    low_n, high_n = entry.window.force_n
    body += html.figure(
        force_trace(trials, (low_n, high_n), "f"),
        f"Force: channel {force.name} in {unit} at {rate} Hz, {way}. Loading phases from {low_n:g} to {high_n:g} N "
        "(dashed) are shaded and numbered.",
    )
    for muscle, name in enumerate(trials.muscles if trials.overviews else ()):
        channel = found.emg_channels[name]
        unit, rate = _unit_and_rate(found, channel)
        said = f"{name}: channel {channel.name} in {unit} at {rate} Hz. Grey is raw EMG; red is its mean rectified."
        body += html.figure(emg_trace(trials, muscle, f"e{muscle}"), said)
    return body
