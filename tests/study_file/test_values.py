"""The reader of values against pydantic, told the same kinds and limits: both take and refuse the same tables."""

from __future__ import annotations

import dataclasses
import json
import math
import typing
from functools import reduce
from operator import or_
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
import pytest
from pydantic import Field, TypeAdapter, ValidationError, create_model

from emg2vsa.devices.netft.settings import NetFtSettings
from emg2vsa.devices.ni_daq.settings import NiEmgSettings
from emg2vsa.devices.opencv_camera.settings import OpenCvSettings
from emg2vsa.devices.rig_force.settings import RigForceSettings
from emg2vsa.devices.trigno.settings import TrignoSettings
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.settings import ForceChannelSettings, Limit, StageSettings
from emg2vsa.study_file.problems import Pattern, checked, required_keys
from emg2vsa.study_file.tables import (
    FileTable,
    ParticipantsTable,
    RecordingsTable,
    RunsTable,
    SpecimenTable,
    StudyTable,
)

LIMITS = {
    ">": annotated_types.Gt, ">=": annotated_types.Ge, "<": annotated_types.Lt, "<=": annotated_types.Le,
    "length >=": annotated_types.MinLen,
}  # fmt: skip


def for_pydantic(hint: Any) -> Any:
    """The hint with dataclasses as models, and limits as pydantic knows them."""
    of, parts = get_origin(hint), get_args(hint)
    if dataclasses.is_dataclass(hint):
        return model_of(hint)
    if of is Annotated:
        limits = [_limit(limit) for limit in parts[1:]]
        return Annotated[for_pydantic(parts[0]), *limits]
    if of in (Union, UnionType):
        return reduce(or_, (part if part is NoneType else for_pydantic(part) for part in parts))
    if of in (tuple, dict):
        return of[tuple(part if part is Ellipsis else for_pydantic(part) for part in parts)]
    return hint


def _limit(limit: Limit | Pattern) -> Any:
    if isinstance(limit, Pattern):
        return Field(pattern=f"^(?:{limit.text})$")
    return LIMITS[limit.sign](limit.bound)


def model_of(table: Any) -> Any:
    hints = typing.get_type_hints(table, include_extras=True)
    made: dict[str, Any] = {}
    for each in dataclasses.fields(table):
        is_required = each.default is dataclasses.MISSING and each.default_factory is dataclasses.MISSING
        made[each.name] = (for_pydantic(hints[each.name]), ... if is_required else None)
    config = {"extra": "forbid", "allow_inf_nan": False, "protected_namespaces": ()}
    return create_model(table.__name__, __config__=config, **made)


STAGES = [kind for hint in typing.get_type_hints(StageSettings).values() for kind in (hint, *get_args(hint))]
TABLES = [
    *(kind for kind in STAGES if dataclasses.is_dataclass(kind)), ForceChannelSettings, StudyTable, ParticipantsTable,
    SpecimenTable, FileTable, RecordingsTable, RunsTable, RigSettings, OpenCvSettings, NetFtSettings,
    NiEmgSettings, TrignoSettings, RigForceSettings, ExperimentSettings,
]  # fmt: skip
ADAPTERS = {table: TypeAdapter(model_of(table)) for table in TABLES}

BASE = {
    "name": "S1", "participant": "P1", "specimen": "S1", "specimens": ["S1"], "layout": "files",
    "source": 0, "channels": {"EDC": "1"}, "rig": "rig.toml", "emg": {"EDC": {"name": "E"}}, "force": {"name": "Fz"},
}  # fmt: skip
SCALARS = [
    0, 1, -1, 2, 2**70, 1.0, -1.0, 2.0, 0.5, 1e-320, math.inf, math.nan, True, False,
    "", "S1", "a/b", "a\n", ".a", "native", "1.5", "\u00e9",
]  # fmt: skip


def limits_in(hint: Any) -> list[float]:
    """Every bound of a hint, of its branches and of its entries."""
    own = [limit.bound for limit in getattr(hint, "__metadata__", ()) if isinstance(limit, Limit)]
    return own + [bound for part in get_args(hint) for bound in limits_in(part)]


def choices_in(hint: Any) -> list[Any]:
    if get_origin(hint) is Literal:
        return list(get_args(hint))
    return [choice for part in get_args(hint) for choice in choices_in(part)]


def tries(hint: Any) -> list[Any]:
    """Values at and beside the limits of ``hint`` and of all kinds, alone, in arrays and in tables."""
    beside = [value for bound in limits_in(hint) for value in (bound, bound - 1, bound + 1, math.nextafter(bound, 1e9))]
    values = [*SCALARS, *choices_in(hint), *beside]
    arrays = [[], *([value] for value in values), *([value, 1.5] for value in values), [1, 2, 3], [[1]], [{}]]
    tables = [{"S1": value} for value in values] + [{"modular": value} for value in arrays]
    return [*values, *arrays, *tables, {}, {"EDC": {"name": "E"}}, {"EDC": {}}, {"name": "Fz"}, [BASE]]


def taken_by_pydantic(table: Any, value: dict[str, Any]) -> Any:
    """The model, or None where it refuses."""
    try:
        return ADAPTERS[table].validate_json(json.dumps(value), strict=True)
    except ValidationError:
        return None


def plain(value: Any) -> Any:
    """Arrays as lists, tables as nothing: their defaults differ."""
    return json.loads(json.dumps(value, default=lambda table: None))


def default_of(table: Any, key: str) -> Any:
    each = next(each for each in dataclasses.fields(table) if each.name == key)
    return each.default if each.default_factory is dataclasses.MISSING else each.default_factory()


def is_of_tables(hint: Any) -> bool:
    return dataclasses.is_dataclass(hint) or any(is_of_tables(part) for part in get_args(hint))


@pytest.mark.parametrize("table", TABLES, ids=lambda table: table.__name__)
def test_tables_are_taken_and_refused_as_pydantic_does(table: Any) -> None:
    hints = typing.get_type_hints(table, include_extras=True)
    taken = 0
    for key, hint in hints.items():
        base = {name: BASE[name] for name in required_keys(table) if name != key}
        for value in tries(hint):
            if value is True and choices_in(hint) == [1, -1]:
                continue  # pydantic takes true for 1
            made, problems = checked(table, {**base, key: value}, ("table",))
            theirs = taken_by_pydantic(table, {**base, key: value})
            assert (theirs is None) == bool(problems), (key, value, problems)
            if theirs is not None:
                taken += 1
                assert plain(getattr(made, key)) == plain(getattr(theirs, key))
            elif made is not None and not is_of_tables(hint):
                assert getattr(made, key) == default_of(table, key), "a faulty key has its default"
    assert taken > len(hints)
    assert checked(table, {"unknown": 1}, ("table",))[1]
