"""The reasons of many presses in few lines: presses that say the same, numbers aside, are named together."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from itertools import groupby

_NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[+-]?\d+)?(?= (?:%|N|s|ms|dB|of|samples)(?!\w))")
"A number with what it counts: one within a channel's name is part of the name."

PRESSES_NAMED = r"^press(es)? [\d, -]+ (ok|doubtful|rejected): "
"What ``grouped`` puts before a reason."

_SESSION = ("operator: ", "session: ")


def by_session(reason: str) -> str:
    """Why a press does not count in the session that it was made in, as one reason that says so."""
    text = reason.replace("; ", ", ")
    return text if text.startswith(_SESSION) else f"session: {text}"


def by_hand(reasons: str) -> bool:
    """Whether a person has judged the press in the study file: the reasons of a press then begin so."""
    return reasons.startswith(("excluded by hand: ", "accepted by hand: "))


def put_aside(reasons: str) -> bool:
    """Whether a session put the press aside: the reasons of a press begin with those of ``by_session``."""
    return reasons.startswith(_SESSION)


def grouped(presses: Iterable[tuple[int, str, str]]) -> list[str]:
    """One line per kind of (repetition, verdict, reason), in order of their first press; presses without reason aside.

    "presses 1-3, 5 rejected: lasted 0.33 to 0.48 s, shorter than 0.5 s".
    """
    alike: dict[tuple[str, str], list[tuple[int, str]]] = {}
    for repetition, verdict, reason in presses:
        if reason:
            alike.setdefault((verdict, _NUMBER.sub("\0", reason)), []).append((repetition, reason))
    return [
        f"{_named([repetition for repetition, _ in group])} {verdict}: {merged([reason for _, reason in group])}"
        for (verdict, _), group in alike.items()
    ]


def most_frequent(reasons: Iterable[str], most: int) -> list[str]:
    """The ``most`` frequent kinds of reason, how often each: "force falls on 3.4 to 3.6 % of its path (2)"."""
    alike: dict[str, list[str]] = {}
    for reason in reasons:
        alike.setdefault(_NUMBER.sub("\0", reason), []).append(reason)
    groups = sorted(alike.values(), key=len, reverse=True)[:most]
    return [f"{merged(group)} ({len(group)})" for group in groups]


def _named(repetitions: Sequence[int]) -> str:
    """ "press 4", or "presses 1-3, 5"."""
    runs = [[r for _, r in run] for _, run in groupby(enumerate(repetitions), key=lambda item: item[1] - item[0])]
    listed = ", ".join(str(run[0]) if len(run) == 1 else f"{run[0]}-{run[-1]}" for run in runs)
    return f"press{'es' if len(repetitions) > 1 else ''} {listed}"


def merged(reasons: Sequence[str]) -> str:
    """The reason all share, numbers that differ as "least to largest"; reasons of another wording left out."""
    wording = _NUMBER.sub("\0", reasons[0])
    reasons = [reason for reason in reasons if _NUMBER.sub("\0", reason) == wording]
    ranges = iter(_range(numbers) for numbers in zip(*map(_NUMBER.findall, reasons), strict=True))
    return _NUMBER.sub(lambda _: next(ranges), reasons[0])


def _range(numbers: Sequence[str]) -> str:
    least, largest = min(numbers, key=float), max(numbers, key=float)
    return least if float(least) == float(largest) else f"{least} to {largest}"
