"""A study file drafted from the names of recordings and what one of them holds, for a person to read and complete."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

from emg2vsa.study_file.draft_channel import FILL, DraftChannel, channel_lines, toml_text
from emg2vsa.study_file.patterns import REPETITION, Cell
from emg2vsa.study_file.plain_names import cell_of, in_ascii, numbered, plain_parts, plain_path

_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9.-]*")
_DATE = re.compile(
    r"(19|20)\d{2}-?(0[1-9]|1[0-2])-?([0-2]\d|3[01])([T-]?\d{2}[-.h]?\d{2}([-.m]?\d{2})?)?s?|\d{6,}|\d{2}[-.]\d{2}[-.](\d{2}){1,2}"
)
_PERSON = re.compile(
    r"(?:p|sub|subj|subject|participant|part|vp|pt|person|patient|proband|volunteer)-?\d+|sub-\w+", re.IGNORECASE
)
_PRESSED = re.compile(r"(?:s|spec|specimen|sample|probe)-?\d+", re.IGNORECASE)
_ORDER = re.compile(r"(?:block|trial|run|ses|session|set|rep|take|file)-?\d+", re.IGNORECASE)
"""What counts recordings and names nothing that was pressed, where another part does."""
_KEY = re.compile(r"[A-Za-z]{3,}-(?=.)")
"""``sub-`` or ``task-``: a key before a value, as BIDS and LabRecorder write them."""
_CONTROL = re.compile(r"[\x00-\x08\x0a-\x1f\x7f]")
"""What no comment of TOML may hold; names of files may."""
_NO_SPECIMEN = re.compile(
    r"(mvi?c|rest|ruhe|baseline|practi[cs]e|training|warm-?up|calib\w*|pilot|test|dummy|demo)[-.]?\d*", re.IGNORECASE
)
"""What files are called that hold no presses on a specimen."""
_SEPARATORS, _HYPHENS = re.compile(r"([/_ ]+)"), re.compile(r"(-)")


@dataclass(frozen=True)
class Naming:
    """How the files of a folder are named.

    pattern : with placeholders and ``*``. participants, specimens : as the names have them, in their order.
    left_out : files that are named otherwise. guessed : what a person should check, a sentence each.
    force_pattern : where force has files of its own, or "". cells : of files whose names no id may have, which no
    pattern finds. forces : the force file of each of them that has one.
    """

    pattern: str
    participants: tuple[str, ...]
    specimens: tuple[str, ...]
    left_out: tuple[str, ...]
    guessed: tuple[str, ...]
    force_pattern: str = ""
    cells: Mapping[str, Cell] = field(default_factory=dict)
    forces: Mapping[str, str] = field(default_factory=dict)


_EMG_FILE, _FORCE_FILE = (
    re.compile(rf"(^|[/_ .-])({words})([/_ .-]|$)", re.IGNORECASE)
    for words in ("emg|delsys|trigno|bagnoli", "force|load|loadcell|ft|ati|mini45|netft|kraft")
)


def naming_of_pairs(files: Sequence[str], pressed: Collection[str] = ()) -> tuple[Naming | None, list[str]]:
    """The naming of all files, or of those of the EMG where as many are named after the force; and the latter.

    pressed : names of specimens that are known.
    """
    found, force = _pairs_as_written(files, pressed)
    if found is None or "*" in found.pattern:
        plain = _in_plain_names(files, pressed)
        if plain is not None and (found is None or _n_cells(plain[0]) > _n_cells(found)):
            return plain
    return found, force


def _n_cells(naming: Naming) -> int:
    return len(naming.participants) * len(naming.specimens)


def _in_plain_names(files: Sequence[str], pressed: Collection[str]) -> tuple[Naming, list[str]] | None:
    """The naming as if all names were in letters that ids may have; None where they are or show no pattern."""
    written = plain_parts(files)
    own = {plain_path(file, written): file for file in files}
    found, force = _pairs_as_written(list(own), pressed)
    if found is None or list(own) == list(files):
        return None
    tokens = {plain for part, plain in written.items() if part and not in_ascii(part)}
    people, specimens = numbered(found.participants, tokens, "P"), numbered(found.specimens, tokens, "S")
    who = found.participants, found.specimens
    told = {file: cell_of(file, found.pattern, *who) for file in own if file not in force}
    by_cell = {cell_of(file, found.force_pattern, *who): own[file] for file in force}
    known = [(cell, own[file]) for file, cell in told.items() if cell is not None and file not in found.left_out]
    origin = {plain: part for part, plain in written.items()}
    ids = [(origin.get(name, name), new) for name, new in [*people.items(), *specimens.items()]]
    changed = ", ".join(f"{name} is {new}" for name, new in ids if name != new)
    guessed = found.guessed
    for plain in (name for both in who for name in both):
        guessed = tuple(guess.replace(repr(plain), repr(origin.get(plain, plain))) for guess in guessed)
    naming = replace(
        found,
        participants=tuple(people[name] for name in found.participants),
        specimens=tuple(specimens[name] for name in found.specimens),
        left_out=tuple(own[file] for file in found.left_out),
        guessed=(*guessed, *([f"ids have ASCII letters only: {changed}."] if changed else [])),
        cells={file: (people[cell[0]], specimens[cell[1]]) for (cell, _), file in sorted(known)},
        forces={file: by_cell[cell] for cell, file in known if cell in by_cell},
    )
    return naming, [own[file] for file in force]


def _pairs_as_written(files: Sequence[str], pressed: Collection[str]) -> tuple[Naming | None, list[str]]:
    emg, force = ([file for file in files if kind.search(file)] for kind in (_EMG_FILE, _FORCE_FILE))
    forces = partners(files)
    if emg and len(emg) == len(force) and not set(emg) & set(force):
        found = naming_of_kinds(files, emg, force, pressed)
        if found is not None and not (forces and set(emg) & set(found.left_out)):
            return found, [file for file in force if file not in found.left_out]
    if forces:
        return None, list(forces.values())
    return naming_of(files, pressed), []


def naming_of_kinds(
    files: Sequence[str], emg: Sequence[str], force: Sequence[str], pressed: Collection[str] = ()
) -> Naming | None:
    """The naming of the EMG's files with that of the force's; None where they do not tell the same pairs."""
    own, other = naming_of(emg, pressed), naming_of(force, pressed)
    if not own or not other or (own.participants, own.specimens) != (other.participants, other.specimens):
        return None
    left_out = tuple(file for file in files if file not in (*emg, *force))
    return replace(own, left_out=(*left_out, *own.left_out, *other.left_out), force_pattern=other.pattern)


def halves(files: Sequence[str]) -> list[tuple[list[str], list[str]]]:
    """Ways to part the files into two halves alike: by the form of their names, or by a part that has two values.

    Which half holds the EMG and which the force, if any does, only the files tell.
    """
    shapes: dict[tuple[int, str], list[str]] = {}
    for file in files:
        parts = _parts(file)
        shapes.setdefault((len(parts), parts[-2].lower()), []).append(file)
    first, *others = shapes.values()
    if others:
        return [(first, others[0])] if len(others) == 1 and len(first) == len(others[0]) else []
    rows, found = {file: _parts(file) for file in files}, []
    for i in range(len(next(iter(rows.values())))):
        by_value: dict[str, dict[tuple[str, ...], str]] = {}
        for file, row in rows.items():
            by_value.setdefault(row[i], {})[*row[:i], *row[i + 1 :]] = file
        if len(by_value) == 2:
            first_half, second_half = by_value.values()
            if set(first_half) == set(second_half):
                found.append((list(first_half.values()), list(second_half.values())))
    return found


def partners(files: Sequence[str]) -> dict[str, str]:
    """The force file of each EMG file, whose names differ in the word for the kind alone; {} where one has none."""
    emg, force = (
        {kind.sub(r"\1\3", file): file for file in files if kind.search(file)} for kind in (_EMG_FILE, _FORCE_FILE)
    )
    if not emg or set(emg) != set(force) or set(emg.values()) & set(force.values()):
        return {}
    return {emg[stem]: force[stem] for stem in emg}


def naming_of(files: Sequence[str], pressed: Collection[str] = ()) -> Naming | None:
    """What the paths have in common, ``/`` between folders; None where no pattern names every file once.

    A path is cut at ``/ _`` and blanks, and at hyphens where no name has any of these. Parts that are the same in every
    file stay; dates become ``*``. Of the others, two must tell participant and specimen; whole numbers may count
    repetitions. pressed : names of specimens.
    """
    hyphens = not any(_SEPARATORS.search(file) for file in files) and all("-" in file for file in files)
    split = {file: _parts(file, _HYPHENS if hyphens else _SEPARATORS) for file in files}
    shapes: dict[tuple[str, ...], list[str]] = {}
    for file, parts in split.items():
        shapes.setdefault(tuple(parts[1::2]), []).append(file)  # separators and extension
    alike = max(shapes.values(), key=len)
    left_out = tuple(file for file in files if file not in alike)
    rows = [split[file] for file in alike]
    columns = {i: [row[i] for row in rows] for i in range(0, len(rows[0]), 2)}
    varying = {i: values for i, values in columns.items() if len(set(values)) > 1}
    dates = {i for i, values in columns.items() if all(_DATE.fullmatch(value) for value in values)}
    named = {i: v for i, v in varying.items() if i not in dates and all(_NAME.fullmatch(value) for value in v)}
    people = [
        i for i, values in named.items()
        if all(map(_PERSON.fullmatch, values)) or _PERSON.fullmatch(f"{columns[i - 2][0] if i else ''}{values[0]}")
    ]  # fmt: skip
    roles = _roles(named, people, pressed)
    if len(left_out) > len(alike) or roles is None or (len(alike) > 1 and not named):
        return None
    participant, specimen, repetition, guessed = roles
    keys = {i: _KEY.match(columns[i][0]) for i in (participant, specimen) if i is not None}
    before = {i: key[0] for i, key in keys.items() if key and all(v.startswith(key[0]) for v in columns[i])}
    columns |= {i: [value.removeprefix(key) for value in columns[i]] for i, key in before.items()}
    unnamed = [i for i in varying if i not in (participant, specimen, repetition)]
    pieces = list(rows[0])
    for index in [*dates, *unnamed]:
        pieces[index] = "*"
    for i, placeholder in ((participant, "{participant}"), (specimen, "{specimen}"), (repetition, REPETITION)):
        if i is not None:
            pieces[i] = before.get(i, "") + placeholder
    return Naming(
        "".join(pieces),
        tuple(dict.fromkeys(columns[participant])) if participant is not None else ("P01",),
        tuple(dict.fromkeys(columns[specimen])) if specimen is not None else ("specimen",),
        left_out,
        tuple(guessed),
    )


def _parts(file: str, separators: re.Pattern[str] = _SEPARATORS) -> list[str]:
    """Texts and separators in turn; the extension is the last separator, with nothing after it."""
    stem, dot, extension = file.rpartition(".")
    return [*separators.split(stem if dot else file), f".{extension}" if dot else "", ""]


_Roles = tuple[int | None, int | None, int | None, list[str]]


def _roles(named: Mapping[int, Sequence[str]], people: Sequence[int], pressed: Collection[str] = ()) -> _Roles | None:
    """Which parts tell participant, specimen and repetition, and what of it was guessed; None where they cannot.

    people : parts that look like the ids of people.
    """
    counts = {i for i, values in named.items() if all(value.isdecimal() for value in values)} - {*people}
    words = [i for i in named if i not in counts]
    if len(words) < 2 and len(counts) == 1 and _counts_up(named, words, *counts):
        return _one_part(named, people, pressed)
    if len(words) < 2:
        words += [i for i in sorted(counts) if i not in words][: 2 - len(words)]
    told = [i for i in words if pressed and set(pressed) <= set(named[i])]
    ordinal = [i for i in words if all(_ORDER.fullmatch(value) for value in named[i])]
    pairs = _pairs(sorted(words), people)
    for pair in sorted(pairs, key=lambda pair: (bool(told) and pair[1] not in told, pair[1] in ordinal)):
        rest = [i for i in named if i not in pair]
        keys = list(zip(*(named[i] for i in pair), strict=True))
        guess = f"{named[pair[0]][0]!r} was taken for a participant and {named[pair[1]][0]!r} for a specimen."
        if len(set(keys)) == len(keys):
            return *pair, None, [guess]
        for i in rest:
            numbers = [int(value) if value.isdecimal() else None for value in named[i]]
            if None not in numbers and len(set(zip(keys, numbers, strict=True))) == len(keys):
                return (
                    *pair,
                    i,
                    [guess, "The number that tells further files of a pair apart was taken for the repetition."],
                )
    return _one_part(named, people, pressed)


def _counts_up(named: Mapping[int, Sequence[str]], others: Sequence[int], number: int) -> bool:
    """Whether the number runs 1, 2, 3 and so on for each of the others, as repetitions do."""
    found: dict[tuple[str, ...], list[int]] = {}
    for *key, value in zip(*(named[i] for i in others), named[number], strict=True):
        found.setdefault(tuple(key), []).append(int(value))
    return all(sorted(values) == list(range(1, len(values) + 1)) for values in found.values())


def _pairs(words: Sequence[int], people: Sequence[int]) -> list[tuple[int, int]]:
    """(participant, specimen) to be tried: a part that looks like people's ids first, else in their order."""
    pairs = sorted([(i, j) for i in words for j in words if i != j], key=lambda pair: pair[0] > pair[1])
    if people:
        chosen = people[0]
        own = [(chosen, j) for j in words if j != chosen]
        return own + [pair for pair in pairs if pair not in own and chosen not in pair]
    return pairs


def _one_part(
    named: Mapping[int, Sequence[str]], people: Sequence[int], pressed: Collection[str] = ()
) -> _Roles | None:
    """A folder of one person, or of one specimen, or of both: who has one specimen names files after people."""
    numbers = [i for i, values in named.items() if all(value.isdecimal() for value in values)]
    counted = "The number in their names was taken for the repetition."
    for i, values in named.items():
        repetition = next((j for j in numbers if j != i), None)
        keys = list(zip(values, named[repetition] if repetition is not None else values, strict=True))
        if len(set(keys)) < len(keys) or (len(named) == 1 and i in numbers and _counts_up(named, (), i)):
            continue
        guessed = [counted] if repetition is not None else []
        is_known = bool(pressed) and set(pressed) <= set(values)
        if is_known or (i not in people and all(_PRESSED.fullmatch(value) for value in values)):
            return None, i, repetition, ["All files were taken for recordings of one participant.", *guessed]
        told = "All files were taken for recordings on one specimen."
        if i not in people:
            told = f"{FILL}: {values[0]!r} was taken for a participant; it may be a specimen of one participant."
        return i, None, repetition, [told, *guessed]
    if len(named) == 1 and numbers:
        return None, None, numbers[0], ["All files were taken for one participant on one specimen.", counted]
    return (None, None, None, ["The one file was taken for one participant on one specimen."]) if not named else None


def draft(
    name: str, naming: Naming | None, files: Sequence[str], emg: Mapping[str, DraftChannel], force: DraftChannel | None,
    stiffness: Mapping[str, float], seen: Sequence[str], presses: int | None = None, left_out: Sequence[str] = (),
    base: str = "", said: Sequence[str] = (),
) -> str:  # fmt: skip
    """The text of the study file. seen : what was looked at. presses : of each participant on each specimen.

    left_out : channels that may be EMG, and why they are not used. base : the folder of the files, "" or with "/" at
    its end. said : of the files, what a person must look at. Files that no pattern finds are listed one by one.
    """
    lines = [f"# Drafted by emg2vsa new. Lines marked {FILL} wait for you; the others are worth a look.", ""]
    lines += ["[study]", f"name = {toml_text(name)}", ""]
    people, specimens = people_and_specimens(naming, files)
    lines += [f"# {FILL}: {doubt}" for doubt in doubtful((*people, *specimens))]
    lines += ["[participants]", f"ids = [{', '.join(map(toml_text, people))}]"]
    if naming and "{participant}" not in naming.pattern:
        lines[-1] += f"  # {FILL}: the names of the files do not tell who was recorded"
    for specimen in specimens:
        lines += ["", "[[specimens]]", f"name = {toml_text(specimen)}"]
        if naming and "{specimen}" not in naming.pattern:
            lines[-1] += f"  # {FILL}: the names of the files do not tell what was pressed"
        if specimen in stiffness:
            lines.append(f"stiffness_n_per_mm = {stiffness[specimen]:g}")
        else:
            lines.append(f"# stiffness_n_per_mm =   # {FILL} where it was measured (emg2vsa tools stiffness)")
    lines += ["", "[recordings]", *(f"# {FILL}: {one}" for one in said), *_recordings(naming, files, base)]
    lines += ["", "# Channels, guessed from", *(f"#   {one}" for one in seen)]
    lines += [f"# {FILL} a table as those below where it is to be used; left out: {one}" for one in left_out]
    for role, channel in emg.items():
        lines += ["", f"[channels.emg.{toml_text(role)}]", *channel_lines(channel)]
    if not emg:
        lines += ["", f"# {FILL}: no channel looks like EMG. Name one for each muscle, as:", "# [channels.emg.EDC]"]
        lines += ['# name = "..."']
    lines += ["", "[channels.force]"]
    lines += [f'name = "..."  # {FILL}: no channel looks like the force'] if force is None else channel_lines(force)
    planned = f"# expected_trials = 10   # {FILL}: presses of each participant on each specimen"
    lines += [
        "", "[window]", planned if presses is None else f"expected_trials = {presses}", "",
        "# A specimen that nobody pressed, for which schedules are to be made; specimens need their stiffness for it:",
        "# [profile]", '# new_specimen = "new"', "# new_stiffness_n_per_mm = 3.0", "",
    ]  # fmt: skip
    return "\n".join(_CONTROL.sub(lambda match: toml_text(match[0])[1:-1], line) for line in lines)


def people_and_specimens(naming: Naming | None, files: Sequence[str]) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Ids of both, in their order."""
    if naming is not None:
        return naming.participants, naming.specimens
    people, specimens = zip(*_one_by_one(naming, files)[0].values(), strict=True)
    return tuple(dict.fromkeys(people)), tuple(dict.fromkeys(specimens))


def doubtful(names: Sequence[str]) -> list[str]:
    """What is to be said of names that sound like neither a person nor a thing that was pressed."""
    doubt = "sounds like neither a person nor a specimen; move its files away if it is none, and begin again"
    return [f"{name} {doubt}" for name in dict.fromkeys(names) if _NO_SPECIMEN.fullmatch(name)]


def _one_by_one(naming: Naming | None, files: Sequence[str]) -> tuple[Mapping[str, Cell], Mapping[str, str]]:
    """Files that are listed with their cells, and the force file of each that has one; empty where a pattern does."""
    if naming is not None:
        return naming.cells, naming.forces
    forces, written = partners(files), plain_parts(files)
    return {file: _listed(plain_path(file, written)) for file in files if file not in forces.values()}, forces


def _recordings(naming: Naming | None, files: Sequence[str], base: str) -> list[str]:
    lines, layout = [], f'layout = "files"   # {FILL}: the names of the files show no pattern; check both ids of each'
    if naming is not None:
        lines = [f"# {guess}" if guess.startswith(FILL) else f"# Check: {guess}" for guess in naming.guessed]
        lines += [f"# Not among them, since it is named otherwise: {file}" for file in naming.left_out]
        layout = 'layout = "files"'
    cells, forces = _one_by_one(naming, files)
    if naming is not None and not cells:
        force = [f"force_pattern = {toml_text(base + naming.force_pattern)}"] if naming.force_pattern else []
        return [*lines, 'layout = "pattern"', f"pattern = {toml_text(base + naming.pattern)}", *force]
    lines.append(layout)
    for file, (person, specimen) in cells.items():
        lines += ["[[recordings.files]]", f"participant = {toml_text(person)}", f"specimen = {toml_text(specimen)}"]
        lines += [f"emg = {toml_text(base + file)}"]
        lines += [f"force = {toml_text(base + forces[file])}"] if file in forces else []
    return lines


def _listed(file: str) -> tuple[str, str]:
    """A participant and a specimen that keep a file apart from others: first part of its path, and the rest."""
    texts = [re.sub(r"[^A-Za-z0-9.-]", "", part) for part in _parts(file)[:-2:2]]
    texts = [text.lstrip(".-") for text in texts if text.lstrip(".-")]
    if len(texts) < 2:
        return "P01", texts[0] if texts else "specimen"
    return texts[0], "_".join(texts[1:])
