"""Which deviations from a registered plan are named, and what harmless changes of a study are called one.

Run as ``python -m benchmarks.planted_deviations``; it prints a Markdown table. The study is that of the demo
with files in place of recordings, which nobody decodes: 12 of its 14 people had been recorded when it was registered.
Each plant is made in a fresh copy; it counts as named if exactly its own deviations are named. Harmless changes follow
one another, at random: tables and keys in another order, comments, line ends, numbers written otherwise, the folder
moved or copied, further planned recordings, limits of decoders, addresses, texts, titles.
"""

from __future__ import annotations

import contextlib
import io
import random
import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

from benchmarks.bench.record import print_page
from emg2vsa.cli import main
from emg2vsa.errors import DataError
from emg2vsa.pipeline.registered import registered
from emg2vsa.registration import Registered
from emg2vsa.study_file import load_study

STUDIES = Path(__file__).resolve().parents[1] / "studies" / "palpation"
RECORDED = [f"P{n:02d}" for n in range(1, 13)]
"""Of fourteen planned people, those who had been when the study was registered."""


@dataclass(frozen=True)
class RegisteredStudy:
    """Its folder, and what is done to it."""

    folder: Path

    @property
    def file(self) -> Path:
        return self.folder / "study.toml"

    @property
    def registration(self) -> Path:
        return self.folder / "registration.json"

    def recording(self, participant: str, specimen: str = "S1") -> Path:
        """Where it is, or will be."""
        name = f"sub-{participant}_task-{load_study(self.file).task}_acq-{specimen}_emg.bdf"
        return self.folder / "data" / f"sub-{participant}" / "emg" / name

    def record(self, participant: str, specimen: str) -> None:
        path = self.recording(participant, specimen)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{participant} {specimen}")

    def edit(self, old: str, new: str, name: str = "study.toml") -> None:
        path = self.folder / name
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new, 1))

    def add(self, table: str, line: str) -> None:
        """A line below the head of a table of the study file, which may be new."""
        text = self.file.read_text()
        head = f"[{table}]\n"
        self.file.write_text(text.replace(head, head + line + "\n") if head in text else f"{text}\n{head}{line}\n")

    def found(self, *, final: bool = False) -> Registered:
        found = registered(load_study(self.file), final=final)
        assert found is not None
        return found


Plant = Callable[[RegisteredStudy], None]


def line(table: str, text: str) -> Plant:
    return lambda study: study.add(table, text)


def swap(old: str, new: str, name: str = "study.toml") -> Plant:
    return lambda study: study.edit(old, new, name)


def both(*plants: Plant) -> Plant:
    def plant(study: RegisteredStudy) -> None:
        for each in plants:
            each(study)

    return plant


JUDGED = '[[{}]]\nparticipant = "P03"\nspecimen = "S2"\nrepetition = 4\nreason = "coughed"\n\n[study]'
OWN = 'participant = "P13"\nspecimen = "S1"\n{}'
S4 = '[[specimens]]\nname = "S4"\nstiffness_n_per_mm = 3.12\n\n'
S5 = '[[specimens]]\nname = "S5"\nstiffness_n_per_mm = 1.11\n'
WITHOUT_S4 = both(swap(S4, ""), swap(", S4 = 27e-6", ""), swap(", S4 = 12.5e-6", ""))
WITH_S6 = both(
    swap(S5, S5 + '\n[[specimens]]\nname = "S6"\n'),
    swap("S5 = 16e-6", "S5 = 16e-6, S6 = 1e-6"),
    swap("S5 = 7e-6", "S5 = 7e-6, S6 = 1e-6"),
)

PEOPLE = {"specimens_differ", "equal_participants", "log_fit_r2"}
RIG = {"casr_rigid", "human_like_contrast", "kappa_error_rigid"}
KAPPA = {"kappa_error_rigid"}
PLANTS: list[tuple[str, Plant, str, set[str]]] = [
    ("margin of the slope", line("claims", "slope_percent = 30.0"), "[claims] slope_percent", {"specimens_differ"}),
    ("false verdicts", line("claims", "false_verdict_percent = 25"), "[claims] false_verdict_percent", PEOPLE | RIG),
    ("alpha", line("hypotheses", "alpha = 0.1"), "[hypotheses] alpha", PEOPLE),
    ("verdicts that count", line("hypotheses", 'use = "ok+doubtful"'), "[hypotheses] use", PEOPLE),
    ("force window", swap("force_n = [0.5, 7.0]", "force_n = [1.0, 6.0]"), "[window] force_n", PEOPLE),
    ("shortest press", line("window", "min_duration_s = 0.2"), "[window] min_duration_s", PEOPLE),
    ("presses asked", both(swap("expected_trials = 10", "expected_trials = 8"), line("session", "repetitions = 8")),
     "[window] expected_trials; [session] repetitions", PEOPLE),
    ("bins", line("fit", "bin_n = 0.6"), "[fit] bin_n", PEOPLE),
    ("weights of the law", line("fit", 'weights = "none"'), "[fit] weights", PEOPLE),
    ("points of the fit", line("fit", 'points = "samples"'), "[fit] points", PEOPLE),
    ("least R²", line("fit", "min_adj_r2 = 0.5"), "[fit] min_adj_r2", PEOPLE),
    ("index", line("cocontraction", 'index = "minimum"'), "[cocontraction] index", PEOPLE),
    ("band", line("filters", "band_hz = [20.0, 400.0]"), "[filters] band_hz", PEOPLE),
    ("sign of the force", swap("sign = -1", "sign = 1"), "recording P01/S1 and 69 more, channels.force.sign", PEOPLE),
    ("muscle", swap('name = "FDS"', 'name = "FCR"'), "recording P01/S1 and 69 more, channels.emg.FDS.name", PEOPLE),
    ("stiffness", swap("stiffness_n_per_mm = 3.12", "stiffness_n_per_mm = 2.12"), "specimen S4, stiffness_n_per_mm",
     PEOPLE | RIG),
    ("specimen added", WITH_S6, "specimen S6", PEOPLE),
    ("specimen removed", WITHOUT_S4, "specimen S4", PEOPLE),
    ("specimens in another order", both(swap(S4, ""), swap(S5, S5 + "\n" + S4)),
     "order of [[specimens]], from which orders of pressing are drawn", PEOPLE),
    ("participant added", swap('"P14"', '"P14", "P15"'), "participant P15", PEOPLE),
    ("participant removed", swap('"P01", ', ""), "participant P01", PEOPLE),
    ("order of pressing", line("session", 'order = "listed"'), "[session] order", PEOPLE),
    ("seed of pressing", line("session", "seed = 2"), "[session] seed", PEOPLE),
    ("pause of a session", line("session", "rest_s = 0.5"), "[session] rest_s", PEOPLE),
    ("seed of the runs", swap("[experiment]\n", "[experiment]\nseed = 3\n", "rig.toml"), "rig file, [experiment] seed",
     RIG),
    ("mountings", swap("mountings = 3", "mountings = 5", "rig.toml"), "rig file, [experiment] mountings", RIG),
    ("largest force of the rig", swap("f_max_n = 7.0", "f_max_n = 6.0", "rig.toml"),
     "rig file, [experiment] f_max_n", RIG),
    ("trials of the plate", swap("[plate]\ntrials = 3", "[plate]\ntrials = 4", "rig.toml"), "rig file, [plate] trials",
     RIG | {"plate_r2"}),
    ("rig file dropped", swap('rig = "rig.toml"', 'root = "runs-virtual"'), "[runs] source", RIG),
    ("rig file gone", lambda study: (study.folder / "rig.toml").unlink(), "rig file", RIG),
    ("SD between mountings", line("calibration", "mounting_sd_percent = 1.0"), "[calibration] mounting_sd_percent",
     RIG),
    ("algorithm", line("runs", 'algorithm = "hexagon"'), "[runs] algorithm", RIG),
    ("rate rule", both(line("runs", 'algorithm = "hexagon"'), line("runs", 'rate = "slope"')),
     "[runs] algorithm; [runs] rate", RIG),
    ("law of kappa", line("calibration", 'law = "power"'), "[calibration] law", KAPPA),
    ("range of schedules", swap("[20.0, 80.0]", "[10.0, 90.0]"), "[schedule] stiffness_percent", RIG),
    ("specimens that are kept", swap('kept_specimens = ["S1", "S3", "S5"]', 'kept_specimens = ["S1", "S5"]'),
     "[hypotheses] kept_specimens", PEOPLE),
    ("stiffness of the new specimen", swap("new_stiffness_n_per_mm = 5.32", "new_stiffness_n_per_mm = 4.0"),
     "[profile] new_stiffness_n_per_mm", RIG | {"interpolation_weight"}),
    ("mode", swap('mode = "default"', 'mode = "paper"'), "[study] mode", PEOPLE | RIG),
    ("press rejected by hand", swap("[study]", JUDGED.format("exclude")), "P03/S2, press 4", PEOPLE),
    ("press accepted by hand", swap("[study]", JUDGED.format("accept")), "P03/S2, press 4", PEOPLE),
    ("file of another person", line("[recordings.files]", OWN.format("emg = \"data/sub-P02/emg/sub-P02_emg.bdf\"")),
     "recording P13/S1, files", PEOPLE),
    ("own band of a recording", line("[recordings.files]", OWN.format("filters.band_hz = [30.0, 400.0]")),
     "recording P13/S1, filters", PEOPLE),
    ("another task", swap('task = "palpation"', 'task = "again"'),
     "recording P01/S1 and 69 more, files; recording P01/S1, P01/S2, P01/S3, P01/S4, P01/S5 and 55 more", PEOPLE),
    ("recording replaced", lambda study: study.recording("P02").write_text("another"), "recording P02/S1", PEOPLE),
    ("recording removed", lambda study: study.recording("P02").unlink(), "recording P02/S1", PEOPLE),
]  # fmt: skip


def edited(study: RegisteredStudy) -> None:
    """The margin in the registration itself."""
    study.edit('"slope_percent": 10.0', '"slope_percent": 30.0', "registration.json")


def shuffled_tables(text: str, numbers: random.Random) -> str:
    """The tables in another order, and the keys of each; comments go, blanks come."""
    head, *tables = re.split(r"\n(?=\[)", re.sub(r"(?m)^#.*\n|(?<=[\]\d}\"]) #.*$", "", text))
    arrays = [table for table in tables if table.startswith("[[")]  # their order counts
    others = []
    for table in (table for table in tables if not table.startswith("[[")):
        name, *lines = filter(None, table.split("\n"))
        numbers.shuffle(lines)
        others.append("\n".join([name, *lines]))
    numbers.shuffle(others)
    at = numbers.randrange(len(others) + 1)
    return "\n\n".join([head, *others[:at], *arrays, *others[at:]]) + "\n" * numbers.randrange(3)


def harmless(study: RegisteredStudy, numbers: random.Random) -> RegisteredStudy:
    """One of many things that change no plan."""
    n = numbers.randrange(10**6)
    edits: list[Callable[[], object]] = [
        lambda: study.file.write_text(shuffled_tables(study.file.read_text(), numbers)),
        lambda: study.file.write_text(study.file.read_text().replace("\n", "\r\n")),
        lambda: study.edit("[study]", f"# looked at {n} times\n[study]"),
        lambda: study.edit("7.0]", "7]") if "7.0]" in study.file.read_text() else None,
        lambda: study.edit("# ", f"# {n} ", "rig.toml"),
        lambda: study.edit('title = "', f'title = "{n} '),
        lambda: study.record(numbers.choice(["P13", "P14"]), numbers.choice(["S1", "S2", "S3", "S4", "S5"])),
        lambda: (study.folder / "data" / f"notes-{n}.txt").write_text("windy"),
        lambda: (
            study.add("reading", f"max_seconds = {10 + n % 99}") if "[reading]" not in study.file.read_text() else None
        ),
        lambda: study.edit("seed = 20260105", f"seed = {n}") if "seed = 20260105" in study.file.read_text() else None,
        lambda: study.add("session", f'texts.wait = "{n}"') if "texts.wait" not in study.file.read_text() else None,
        lambda: (
            study.edit('# port = "/dev/ttyUSB0"', 'port = "/dev/ttyUSB7"', "rig.toml")
            if "ttyUSB0" in (study.folder / "rig.toml").read_text()
            else None
        ),
        lambda: shutil.rmtree(study.folder / ".emg2vsa", ignore_errors=True) if n % 50 == 0 else None,
        lambda: study.registration.write_bytes(study.registration.read_bytes()),
    ]
    numbers.choice(edits)()
    if n % 3:
        return study
    place = study.folder.parent / f"moved-{n}"
    return RegisteredStudy(Path((shutil.move if n % 2 else shutil.copytree)(study.folder, place)))


def register_in(folder: Path) -> RegisteredStudy:
    """The study, registered in ``folder``."""
    study = RegisteredStudy(folder)
    study.folder.mkdir()
    for name in ("study.toml", "rig.toml"):
        shutil.copy(STUDIES / name, study.folder)
    for participant in RECORDED:
        for specimen in ("S1", "S2", "S3", "S4", "S5"):
            study.record(participant, specimen)
    load_study(study.file).results.mkdir(parents=True)  # where digests of code are remembered
    with contextlib.redirect_stdout(io.StringIO()):
        assert main(["register", str(study.file)]) == 0
    return study


def as_planted(named: set[str], what: str) -> bool:
    """Whether exactly the planted deviations are named; "paper" mode sets keys of other tables too."""
    return named == set(what.split("; ")) or (what == "[study] mode" and what in named)


def page(harmless_changes: int = 100) -> Iterator[str]:
    """The tables."""
    with tempfile.TemporaryDirectory() as folder:
        study, count = register_in(Path(folder) / "palpation"), 0
        yield "# Deviations from a registered plan"
        yield ""
        yield "Output of `python -m benchmarks.planted_deviations`. What a row says stands at the head of that file."
        yield ""
        yield "| planted | named | when registered | now | claims touched |"
        yield "|---|---|---|---|---:|"
        for n, (name, plant, what, _) in enumerate(PLANTS):
            copy = RegisteredStudy(Path(shutil.copytree(study.folder, Path(folder) / f"plant-{n}")))
            plant(copy)
            found = copy.found().deviations
            count += as_planted({each.what for each in found}, what)
            one = next((each for each in found if each.what in what), None)
            told = (one.what, one.registered, one.now, str(len(one.claims))) if one else ("NO", "", "", "")
            yield f"| {' | '.join((name, *told))} |"
        edited(study)
        try:
            said = f"NO: {study.found().deviations}"
        except DataError as error:
            said, count = f"refused ({error.found.partition('(')[2]}", count + 1
        yield f"| registration edited | {said} | | | |"
        yield ""
        study.edit('"slope_percent": 30.0', '"slope_percent": 10.0', "registration.json")
        numbers, false = random.Random(33), 0
        for _ in range(harmless_changes):
            study = harmless(study, numbers)
            false += bool(study.found().deviations)
        yield f"{count} of {len(PLANTS) + 1} planted deviations were named."
        yield f"{false} of {harmless_changes} harmless changes were called a deviation."


if __name__ == "__main__":
    print_page(__doc__, page)
