"""The form of a participant: answers for participants.tsv, checked before a session, and stored there alone.

An answer is a number in a range or one of some words. There is no free text, so that no name gets in.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from emg2vsa.bids.dataset import write_person
from emg2vsa.bids.tables import ABSENT, Column, read_tsv
from emg2vsa.errors import SettingError
from emg2vsa.session_settings import FormColumn

_PERSON = "participant_id"
Form = Mapping[str, FormColumn]
"""Column of participants.tsv to what may stand in it."""


def blank_form(form: Form, participant: str) -> str:
    """A form to be filled in, as TOML."""
    lines = [f"# {participant}. Codes, no names. Every other line may be {json.dumps(ABSENT)}: not told."]
    lines += [f"{_PERSON} = {json.dumps(participant)}"]
    for name, column in form.items():
        lines += ["", f"# {column.description} ({wanted(column)})", f"{name} = {json.dumps(ABSENT)}"]
    return "\n".join(lines) + "\n"


def wanted(column: FormColumn) -> str:
    """What may stand in a column, in words."""
    if column.range is None:
        return "one of " + ", ".join(f"{word!r} ({meaning})" for word, meaning in column.levels.items())
    low, high = column.range
    return f"{low:g} to {high:g}{f' {column.unit}' if column.unit else ''}"


def read_form(path: Path, form: Form, participant: str) -> dict[str, str]:
    """The answers in a file, as participants.tsv has them. SettingError for the first one that cannot be."""
    try:
        answers = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError) as error:
        found = "no file" if isinstance(error, FileNotFoundError) else getattr(error, "strerror", None) or str(error)
        do = "emg2vsa session form writes an empty one."
        raise SettingError(f"--form {path}", wanted="a form in TOML", found=found, do=do) from error
    if (whose := answers.pop(_PERSON, None)) != participant:
        found = "no such line" if whose is None else "another person's form"
        do = "Take the form of this participant; emg2vsa session form writes an empty one."
        raise SettingError(f"--form {path}, {_PERSON}", wanted=json.dumps(participant), found=found, do=do)
    for name in (*answers, *form):
        if name not in form or name not in answers:
            columns = f"the columns of [session.form] ({', '.join(form) or 'none'})"
            raise SettingError(
                f"--form {path}, {name}", wanted=columns, found="another one" if name not in form else "no such line",
                do=f"Write {json.dumps(ABSENT)} where something is not told.",
            )  # fmt: skip
    for name, column in form.items():
        if not _fits(answers[name], column):
            found = "a number out of range" if type(answers[name]) in (int, float) else "something else"
            do = f"Correct the line, or write {json.dumps(ABSENT)}."
            raise SettingError(f"--form {path}, {name}", wanted=wanted(column), found=found, do=do)
    return {name: _cell(answer) for name, answer in answers.items()}


def _cell(answer: object) -> str:
    """A number has all its digits."""
    return np.format_float_positional(answer, trim="-") if isinstance(answer, float) else str(answer)


def _fits(answer: object, column: FormColumn) -> bool:
    if column.range is None or answer == ABSENT:
        return answer == ABSENT or answer in tuple(column.levels)
    return type(answer) in (int, float) and column.range[0] <= answer <= column.range[1]  # type: ignore[operator]


def is_answered(root: Path, participant: str, form: Form) -> bool:
    """Whether the participants.tsv of the data set has every answer of a participant."""
    with suppress(OSError, ValueError):
        head, *rows = read_tsv(root / "participants.tsv")
        people = (dict(zip(head, row, strict=False)) for row in rows)
        return any(row.get(_PERSON) == f"sub-{participant}" and all(map(row.get, form)) for row in people)
    return not form


def store_answers(root: Path, participant: str, form: Form, answers: Mapping[str, str]) -> None:
    """Into participants.tsv and .json of the data set, beside what else they hold. DataError : as `write_person`."""
    columns = {name: Column(column.description, column.unit, column.levels) for name, column in form.items()}
    write_person(root, participant, columns, answers)
