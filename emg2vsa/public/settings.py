"""One object for the settings of every step, checked as a study file is."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

from emg2vsa.errors import SettingError, StudyError
from emg2vsa.public.columns import plain
from emg2vsa.settings import PAPER, StageSettings
from emg2vsa.study_file import contradictions
from emg2vsa.study_file.problems import Problem, checked, nearest, shown

_KINDS = {field.name: field for field in dataclasses.fields(StageSettings)}


class Settings(StageSettings):
    """Settings of reading, filters, fits, tests, profiles and schedules; each has its default.

    Parameters
    ----------
    paper : take the paper's values where nothing else is said, as ``mode = "paper"`` does in a study file.
    tables : the tables of a study file, each a mapping of keys to values, such as ``window={"force_n": (1.0, 6.0)}``.
        docs/reference/study-file.md explains every key.

    Raises
    ------
    SettingError : a table that is none. StudyError : every key or value that cannot be, alone or with others, each in
    a line.
    """

    def __init__(self, *, paper: bool = False, **tables: Mapping[str, Any]) -> None:
        if not isinstance(paper, bool):
            do = "Write paper=True, or leave it out."
            raise SettingError("Settings, paper", wanted="True or False", found=shown(paper), do=do)
        for name in tables:
            if name not in _KINDS:
                do = nearest(name, _KINDS, "Choose one of them.")
                raise SettingError("Settings", wanted=f"tables {', '.join(_KINDS)}", found=repr(name), do=do)
        made: dict[str, Any] = {}
        problems: list[Problem] = []
        for name in _KINDS:
            kind = type(getattr(_DEFAULTS, name))
            values = {**(PAPER.get(name, {}) if paper else {}), **_table(name, tables.get(name, {}))}
            if kind is type(None):
                continue
            made[name], found = checked(kind, values, (name,))
            problems += found
        faulty = {problem.path[0] for problem in problems}
        problems += contradictions({name: table for name, table in made.items() if name not in faulty})
        if problems:
            raise StudyError(tuple(f"Settings: {problem}" for problem in dict.fromkeys(problems)))
        super().__init__(**made)

    def __repr__(self) -> str:
        """Only what differs from the defaults."""
        said = []
        for name in _KINDS:
            mine, usual = getattr(self, name), getattr(_DEFAULTS, name)
            if mine != usual:
                fields = (field.name for field in dataclasses.fields(mine))
                changed = {key: getattr(mine, key) for key in fields if getattr(mine, key) != getattr(usual, key)}
                said.append(f"{name}={changed}")
        return f"Settings({', '.join(said)})"


_DEFAULTS = StageSettings()


def _table(name: str, values: object) -> dict[str, Any]:
    if not isinstance(values, Mapping):
        do = f"Write Settings({name}={{...}})."
        raise SettingError(f"Settings, {name}", wanted="a mapping of keys to values", found=repr(values), do=do)
    for key in values:
        if not isinstance(key, str):
            do = "Name a key of the study file."
            raise SettingError(f"Settings, {name}", wanted="keys as text", found=repr(key), do=do)
    return dict(plain(values))


def settings_or_default(settings: StageSettings | None) -> StageSettings:
    """``settings``, or every default where they are None. SettingError: they are anything else."""
    if settings is None:
        return _DEFAULTS
    if not isinstance(settings, StageSettings):
        do = "Make them so: emg2vsa.Settings(window={...}); a study that load gave, as load(file).study, will do too."
        raise SettingError("settings", wanted="emg2vsa.Settings", found=type(settings).__name__, do=do)
    return settings
