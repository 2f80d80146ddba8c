"""The reader of values against pydantic, told the same kinds and limits: both take and refuse the same tables.

Files found by patterns with * and {repetition}.

Whatever a study file holds, it is loaded or refused by problems on lines, never with a traceback.
"""

from __future__ import annotations

import copy
import dataclasses
import json
import math
import re
import tomllib
import typing
from collections.abc import Callable
from functools import reduce
from operator import or_
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, Union, get_args, get_origin

import annotated_types
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import Field, TypeAdapter, ValidationError, create_model

from emg2vsa.devices.netft import NetFtSettings
from emg2vsa.devices.ni_daq import NiEmgSettings
from emg2vsa.devices.opencv_camera import OpenCvSettings
from emg2vsa.devices.rig_force import RigForceSettings
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.errors import StudyError
from emg2vsa.rig.experiment import ExperimentSettings
from emg2vsa.rig.rig_settings import RigSettings
from emg2vsa.settings import ForceChannelSettings, Limit, StageSettings
from emg2vsa.study import Study
from emg2vsa.study_file import load_study, missing_files
from emg2vsa.study_file.problems import KeyPath, Pattern, checked, required_keys
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


PATTERN = 'pattern = "data/{participant}_{specimen}.csv"'
Load = Callable[[str], Study]


def touch(tmp_path: Path, *names: str) -> None:
    for name in names:
        path = tmp_path / "studies" / "small" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()


def names(study: Study) -> dict[str, list[str]]:
    return {entry.key: [part.emg_file.name for part in entry.parts] for entry in study.recordings}


def test_a_star_stands_for_one_text(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/2026-05-01_P01_S1.csv", "data/2026-05-02_P01_S3.csv", "data/x_P02_S1.csv", "data/P02_S3.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/*_{participant}_{specimen}.csv"'))
    assert names(study)["P01/S1"] == ["2026-05-01_P01_S1.csv"]
    assert names(study)["P02/S3"] == ["*_P02_S3.csv"]  # none: the pattern tells what was looked for
    assert [entry.key for entry in missing_files(study)] == ["P02/S3"]
    assert study.data.name == "data"


def test_several_matches_are_refused_with_their_names(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/1_P01_S1.csv", "data/2_P01_S1.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/*_{participant}_{specimen}.csv"'))
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert entry.fault == "2 files, 1_P01_S1.csv, 2_P01_S1.csv"
    assert not any(entry.fault for entry in study.recordings if entry.key != "P01/S1")


def test_a_file_of_two_cells_is_refused(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_S3.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_*{specimen}*.csv"'))
    faults = {entry.key: entry.fault for entry in study.recordings}
    assert faults["P01/S1"] == "P01_S1_S3.csv, which matches for P01/S3 too"
    assert faults["P01/S3"] == "P01_S1_S3.csv, which matches for P01/S1 too"


def test_repetitions_are_in_the_order_of_their_numbers(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, *(f"data/P01_S1_{n}.csv" for n in (10, 2, 1)), "data/P01_S1_x.csv", "data/P01_S3_007.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_{specimen}_{repetition}.csv"'))
    assert names(study)["P01/S1"] == ["P01_S1_1.csv", "P01_S1_2.csv", "P01_S1_10.csv"]
    assert names(study)["P01/S3"] == ["P01_S3_007.csv"]


def test_one_repetition_twice_is_refused(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_1.csv", "data/P01_S1_01.csv", "data/P01_S1_2.csv")
    study = load(small.replace(PATTERN, 'pattern = "data/{participant}_{specimen}_{repetition}.csv"'))
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert [part.fault for part in entry.parts] == ["2 files, P01_S1_01.csv, P01_S1_1.csv", ""]


def test_force_files_go_with_their_repetition(tmp_path: Path, small: str, load: Load) -> None:
    touch(tmp_path, "data/P01_S1_1_e.csv", "data/P01_S1_2_e.csv", "data/P01_S1_2_f.csv")
    both = 'pattern = "data/{participant}_{specimen}_{repetition}_e.csv"\n'
    both += 'force_pattern = "data/{participant}_{specimen}_{repetition}_f.csv"'
    entry = next(e for e in load(small.replace(PATTERN, both)).recordings if e.key == "P01/S1")
    assert [part.force_file.name if part.force_file else None for part in entry.parts] == [
        "P01_S1_{repetition}_f.csv",
        "P01_S1_2_f.csv",
    ]


def test_listed_recordings_of_one_cell_follow_each_other(small: str, load: Load) -> None:
    more = '[[recordings.files]]\nparticipant = "P01"\nspecimen = "S1"\nemg = "{}.csv"\n'
    channel = 'channels.force = {{ name = "Fz", sign = -1 }}\n'
    study = load(small + more.format("a") + more.format("b") + channel.format())
    entry = next(entry for entry in study.recordings if entry.key == "P01/S1")
    assert [part.emg_file.name for part in entry.parts] == ["a.csv", "b.csv"]
    assert [part.channels.force.sign for part in entry.parts] == [1, -1]


@pytest.mark.parametrize("names", [("run-1", "run-02"), ("run-02", "run-1")])
def test_runs_of_a_bids_folder(tmp_path: Path, small: str, load: Load, names: tuple[str, ...]) -> None:
    touch(tmp_path, *(f"d/sub-P01/emg/sub-P01_task-t_acq-S1_{name}_emg.bdf" for name in names))
    study = load(small.replace('layout = "pattern"\n' + PATTERN, 'layout = "bids"\nroot = "d"\ntask = "t"'))
    found = next(entry for entry in study.recordings if entry.key == "P01/S1").parts
    assert [part.emg_file.name.split("_")[3] for part in found] == ["run-1", "run-02"]


ROOT = Path(__file__).resolve().parents[2]
STUDIES = [tomllib.loads(path.read_text()) for path in sorted(ROOT.glob("studies/*/study.toml"))]
VALUES = st.one_of(
    st.sampled_from([-1, 0, 1, 2**70, 1e-320, 1.5, math.inf, math.nan, True, "", "S1", "P01", "{", "{x}", "1", [], {}]),
    st.lists(st.sampled_from([1, -2.5, "S1", True, [], {}]), max_size=3),
    st.dictionaries(st.sampled_from(["name", "emg", "S1", "force", "files", "EDC"]), st.sampled_from([1, "a", [], {}])),
)


def as_toml(value: Any) -> str:
    if isinstance(value, dict):
        return "{" + ", ".join(f"{json.dumps(key)} = {as_toml(inner)}" for key, inner in value.items()) + "}"
    if isinstance(value, list):
        return "[" + ", ".join(map(as_toml, value)) + "]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)


def places(value: Any, path: KeyPath = ()) -> list[KeyPath]:
    """Paths of all that may be replaced."""
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [found for key, inner in items for found in [(*path, key), *places(inner, (*path, key))]]


@st.composite
def changed_studies(draw: st.DrawFn) -> dict[str, Any]:
    study = copy.deepcopy(draw(st.sampled_from(STUDIES)))
    for _ in range(draw(st.integers(1, 3))):
        *parents, last = draw(st.sampled_from(places(study)))
        node: Any = study
        for part in parents:
            node = node[part]
        match draw(st.sampled_from(["replace", "remove", "add"])):
            case "replace":
                node[last] = draw(VALUES)
            case "remove" if isinstance(node, dict):
                del node[last]
            case _ if isinstance(node, dict):
                node[draw(st.sampled_from(["extra", "window", "files", "ids", "file", "channels"]))] = draw(VALUES)
        if not places(study):
            break
    return study


@settings(max_examples=150, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(changed_studies())
def test_any_change_is_taken_or_refused(tmp_path_factory: Any, study: dict[str, Any]) -> None:
    path = tmp_path_factory.mktemp("study") / "study.toml"
    path.write_text("".join(f"{json.dumps(key)} = {as_toml(value)}\n" for key, value in study.items()))
    said: tuple[str, ...] = ()
    try:
        assert load_study(path).recordings
    except StudyError as error:
        said = error.problems
    for problem in said:
        assert re.match(rf"{re.escape(str(path))}:\d+: .+: expected .+, but found .+\.", problem)
