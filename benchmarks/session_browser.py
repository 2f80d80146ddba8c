"""A whole session through a real browser, in real time: the participant reads one page, the operator works the other.

Run as ``python -m benchmarks.session_browser [--keep DIR]``; it prints Markdown, and ``--of DIR`` prints it again of a
session that was kept. ``emg2vsa session`` is a process of
its own. Its EMG comes from the emulated Trigno server and its force from the emulated ATI box. The participant has
nothing but what stands on the page in Chromium: the words and ``aria-valuenow`` of the bar, read 50 times a second.
The operator's part is a presenter's forward key, which does what the large button says. Two practice presses, then ten
on each of five specimens in random order; three mistakes are planted; and once, in the middle of a press, the browser
is killed and started again.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.browser import Browser, Window, running
from benchmarks.session_over_ports import PALPATION, emulated_devices
from emg2vsa import artifacts
from emg2vsa.cli.progress import progress
from emg2vsa.devices.clock import WallClock
from emg2vsa.fits import usable
from emg2vsa.pipeline.run_study import run_study
from emg2vsa.rig_file import load_rig
from emg2vsa.session.journal import JOURNAL_FILE, Decided, Judged, PressBegun, read_journal
from emg2vsa.session.views import ForceMessage, ParticipantState, ScreenReport
from emg2vsa.session_settings import SessionTexts
from emg2vsa.study_file import load_study
from emg2vsa.worlds.far_ends.serve import Table, serve
from emg2vsa.worlds.people.mistakes import parse_mistakes
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import person_of

PARTICIPANT = "P03"
MISTAKES = "dips@12", "electrode-off:FDS@25", "early@33"
CLOSED_AT, CLOSED_AT_N, CLOSED_S = 28, 3.0, 2.0
"Press, of the fifty, in which the browser is killed; force shown then; and how long there is none."
LOOK_S, BLANK_S = 0.02, 0.5
"Between two looks at the page; and how long the bar may be grey before the participant gives up."
READY_S, PLACING_S, BOUNCE_S = 1.1, 0.6, 0.45
"The operator: from a participant who is ready to START; hands off the specimen; and between two keys."
MOST_S = 1200.0
DONE_N = 6.5
"A press that reached less is not done, whatever was the cause."
TRUTH, READS, SAID = "truth.json", "reads.npy", "said.txt"
SESSION = """
[session]
training_specimens = ["T1", "T2"]
training_repetitions = 1
rest_s = 1.0
pause_s = 2.0
"""
PAGE = """(() => {
  const text = (id) => document.querySelector(id).textContent;
  return [text("#word"), text("#hint"), text("#phase"),
          +document.querySelector("#bar").getAttribute("aria-valuenow"), document.body.dataset.look];
})()"""
OPERATOR = """(() => {
  const button = document.querySelector("#primary");
  return [button.querySelector("b").textContent, !button.matches(":disabled, .early"),
          document.querySelector("#specimen").textContent];
})()"""


class ReadPage:
    """The participant's page as its words and bar tell it: a `emg2vsa.worlds.people.participant.Page`.

    reads : (time, force on the bar, true force, whether the word is that of a press), of every look.
    """

    def __init__(self, person: EmulatedParticipant, clock: WallClock) -> None:
        self._person, self._clock = person, clock
        self._window: Window | None = None
        self._before, self._grey_s = "", 0.0
        self.greys = 0
        self.reads: list[tuple[float, float, float, bool]] = []
        texts = SessionTexts()
        self._commands = {
            texts.start: "start", texts.press: "press", texts.stop: "stop", texts.rest: "rest", texts.pause: "pause",
            texts.done: "done", texts.contract: "start",
        }  # fmt: skip
        self._texts = texts
        self._state = ParticipantState("wait", "", "quality", 0, 0, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")
        self._force = ForceMessage(0, 0.0, 0.0, "none", "", "wait")

    def participant(self) -> ParticipantState:
        """As last read."""
        return self._state

    def force(self) -> ForceMessage:
        """As last read."""
        return self._force

    def show(self, window: Window | None) -> None:
        """From now on this window is before the participant; None: no display."""
        self._window = window

    def follow(self, over: threading.Event) -> None:
        """Look at the page until it is over."""
        while not over.wait(LOOK_S):
            window = self._window
            try:
                seen = None if window is None else window.value(PAGE)
            except Exception:  # the browser has been killed
                seen = None
            self._take(seen)

    def _take(self, seen: list[Any] | None) -> None:
        now_s = self._clock.now_s()
        word, hint, phase, value_n, look = seen or ("", "", "", 0.0, "lost")
        if look == "lost":
            if seen and not self._grey_s:
                self.greys, self._grey_s = self.greys + 1, now_s
            if seen and now_s - self._grey_s < BLANK_S:
                return
            word = ""
        else:
            self._grey_s = 0.0
        command = self._commands.get(word, "wait")
        if word == self._texts.wait and self._before in (self._texts.rest, self._texts.wait + self._texts.rest):
            command, word = "ready", self._texts.wait + self._texts.rest  # the rest is over
        self._before = word
        numbers = re.search(r"(\d+) / (\d+)", phase)
        press, presses = map(int, numbers.groups()) if numbers else (0, 0)
        named: Any = "quality" if not phase else "training" if phase.startswith(self._texts.training) else "main"
        told: Any = command
        speed: Any = {self._texts.too_fast: "too fast", self._texts.too_slow: "too slow"}.get(hint, "")
        self._state = replace(self._state, command=told, text=word, phase=named, press=press, presses=presses)
        self._force = ForceMessage(self._force.sequence + 1, now_s, value_n, "none", speed, told)
        true_n = float(self._person.force_n(np.array([now_s]))[0])
        self.reads.append((now_s, value_n, true_n, word == self._texts.press))


@dataclass
class Scene:
    """What stands around one session."""

    folder: Path
    person: EmulatedParticipant
    page: ReadPage
    addresses: dict[str, str]

    def __post_init__(self) -> None:
        self._stack = ExitStack()
        self._browsers = 0

    def open(self) -> Window:
        """A new browser with both pages; the operator's is returned."""
        self._browsers += 1
        browser: Browser = self._stack.enter_context(running(self.folder / f"browser-{self._browsers}"))
        operator = browser.open(self.addresses["operator"], 1280, 800)
        participant = browser.open(self.addresses["participant"], 1920, 1080)
        participant.until("document.body.dataset.look !== 'lost'", 30)
        operator.until("document.querySelector('#who').textContent !== ''", 30)
        self.page.show(participant)
        return operator

    def close(self) -> None:
        """Kill the browser."""
        self.page.show(None)
        self._stack.close()


def make_study(folder: Path) -> Path:
    """The palpation study with one participant, and emulated devices on free ports."""
    text = (PALPATION / "study.toml").read_text(encoding="utf-8")
    truth = text.rpartition("[simulation]")[2].partition("# `emg2vsa session`")[0]
    text = text.partition("# The rig presses")[0] + "[simulation]" + truth
    text = re.sub(r'ids = \[.*"P14"\]', f'ids = ["{PARTICIPANT}"]', text)
    text = text.replace('participant = "P07"', f'participant = "{PARTICIPANT}"')
    study = folder / "study.toml"
    study.write_text(text + SESSION.rstrip("\n") + emulated_devices(folder), encoding="utf-8")
    return study


def play(folder: Path, study_file: Path) -> None:
    """Carry the session out, and write what is true of it, what was read, and what the command said."""
    begun_s, busy = time.monotonic(), os.getloadavg()[1]
    study = load_study(study_file)
    assert study.session is not None
    clock = WallClock()
    person = EmulatedParticipant(
        person_of(study, PARTICIPANT), mistakes=parse_mistakes(MISTAKES, study.simulation.muscle_share)
    )
    page, over = ReadPage(person, clock), threading.Event()
    person.watch(page)
    force = load_rig(folder / "rig.toml").devices.force
    command = [sys.executable, "-m", "emg2vsa.cli", "session", "study.toml", "--participant", PARTICIPANT]
    environment = os.environ | {"PYTHONUNBUFFERED": "1"}
    with (
        serve(Table(person, study.session, force, clock, 1.8)),
        subprocess.Popen(
            [*command, "--port", "0"], cwd=folder, env=environment, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
        ) as session,
    ):  # fmt: skip
        assert session.stdout is not None
        said: list[str] = []
        addresses: dict[str, str] = {}
        while len(addresses) < 2:
            line = session.stdout.readline()
            if not line:
                raise SystemExit("the session did not begin:\n" + "".join(said))
            said.append(line)
            addresses |= dict(re.findall(r"^(\w+): +(http://\S+)", line))
        scene = Scene(folder, person, page, addresses)
        follower = threading.Thread(target=page.follow, args=(over,))
        reader = threading.Thread(target=lambda: said.extend(session.stdout or ()))
        follower.start()
        reader.start()
        try:
            _operate(scene)
            session.wait(120)
        finally:
            over.set()
            follower.join()
            scene.close()
            session.terminate()
            reader.join()
    person.write_truth(folder / TRUTH)
    np.save(folder / READS, np.array(page.reads))
    took_s = time.monotonic() - begun_s
    head = (
        f"Real time (factor 1), {took_s:.0f} s; load of the two cores {busy:.1f} before, {os.getloadavg()[1]:.1f} "
        f"after; exit status {session.returncode}; the bar was grey {page.greys} times."
    )
    (folder / SAID).write_text(f"{head}\n{''.join(said)}", encoding="utf-8")


def _operate(scene: Scene) -> None:
    """Do what the large button says until the session is over; kill the browser once."""
    window, killed = scene.open(), False
    last, since_s, end_s = ("", False), time.monotonic(), time.monotonic() + MOST_S
    while time.monotonic() < end_s:
        seen, force = scene.page.participant(), scene.page.force()
        if not killed and (seen.phase, seen.press) == ("main", CLOSED_AT) and force.force_n > CLOSED_AT_N:
            scene.close()
            time.sleep(CLOSED_S)
            window, killed = scene.open(), True
        label, ready, specimen = window.value(OPERATOR)
        if label == "Session is over":
            return
        if (label, ready) != last:
            last, since_s = (label, ready), time.monotonic()
            if label == "Specimen is placed":
                scene.person.place(specimen)
        waited_s = {"START": READY_S, "Specimen is placed": PLACING_S}.get(label, 0.2)
        if ready and time.monotonic() - since_s > waited_s:
            window.key("PageDown")
            ended = label == "End session"
            last = "", False
            time.sleep(BOUNCE_S)
            if ended:
                return
        time.sleep(0.05)
    raise SystemExit("the session took too long:\n" + window.text())


def _journal(folder: Path) -> list[Any]:
    lines, _ = read_journal(folder / "data" / "sourcedata" / f"sub-{PARTICIPANT}" / "palpation" / JOURNAL_FILE)
    return [line.event for line in lines]


def press_rows(folder: Path) -> Iterator[tuple[dict[str, Any], tuple[str, ...]]]:
    """What is true of each attempt, and a row of the table. right : rejected if and only if it was badly done."""
    events = _journal(folder)
    first = {(e.press, e.attempt): e for e in reversed(events) if isinstance(e, Judged)}
    last = {(e.press, e.attempt): e for e in events if isinstance(e, Judged)}
    decided = {(e.press, e.attempt): e.decision for e in events if isinstance(e, Decided)}
    begun = [e for e in events if isinstance(e, PressBegun)]
    true = json.loads((folder / TRUTH).read_text(encoding="utf-8"))["presses"]
    for event, press in zip(begun, true, strict=True):
        key = event.press, event.attempt
        verdict, at_end = first[key], last[key].verdict
        closed = press["phase"] == "main" and press["press"] == CLOSED_AT and event.attempt == 1
        planned = "the browser is killed" if closed else press["mistake"]
        if not planned and press["peak_force_n"] < DONE_N:
            planned = "not planned: the bar was grey"
        right = (verdict.verdict == "rejected") == (at_end == "rejected") == bool(planned)
        said = "; ".join(problem for problem, _ in verdict.problems)
        yield (
            press | {"planned": planned, "verdict": verdict.verdict, "at_end": at_end, "right": right},
            (
                f"{press['phase']} {press['press']}.{event.attempt}", event.specimen, planned,
                f"{verdict.verdict}{': ' if said else ''}{said}", at_end, decided.get(key, ""),
                "yes" if right else "NO",
            ),
        )  # fmt: skip


def screen_lines(folder: Path) -> list[str]:
    """Frames a second and ages, as the page itself told them to the journal."""
    told = [event for event in _journal(folder) if isinstance(event, ScreenReport)][1:]  # without the first second
    made = [f"{len(told)} reports of the page, a second each:", "", "| | median | worst |", "|---|---|---|"]
    for name, text, worst in (
        ("frames_per_s", "frames/s", min), ("age_p50_ms", "age of the force shown, median, ms", max),
        ("age_p95_ms", "age of the force shown, p95, ms", max), ("longest_frame_ms", "longest frame, ms", max),
    ):  # fmt: skip
        values = [getattr(event, name) for event in told]
        made.append(f"| {text} | {np.median(values):.1f} | {worst(values):.1f} |")
    return made


def lag_ms(reads: np.ndarray[Any, Any]) -> np.ndarray[Any, Any]:
    """From the finger to the eye: how long before each look the true force was what the bar showed."""
    time_s, shown_n, true_n, pressing = reads.T
    lags = []
    for at in np.flatnonzero((pressing > 0) & (shown_n > 1.0) & (shown_n < 6.5)):
        before = slice(max(0, at - 15), at + 1)
        rising = true_n[before]
        if np.all(np.diff(rising) > 0) and rising[0] < shown_n[at] < rising[-1]:
            lags.append(1e3 * (time_s[at] - np.interp(shown_n[at], rising, time_s[before])))
    return np.array(lags)


def b_rows(study_file: Path, presses: list[dict[str, Any]]) -> Iterator[str]:
    """Mean b of each specimen beside what the muscles did in the presses that count."""
    study = load_study(study_file)
    board = run_study(study, stages=("trials", "fits"), jobs=1, progress=progress(quiet=True))
    yield "| specimen | presses used | true b, uV | recovered b, uV | standard error, uV | error, % | error, s.e. |"
    yield "|---|---|---|---|---|---|---|"
    for entry in study.recordings:
        (path,) = board.done("fits", (entry.key,))
        fits = artifacts.load(path)
        b_v = fits.b_v[usable(fits, "ok+doubtful")]
        true_v = np.mean([p["b_v"] for p in presses if p["specimen"] == entry.specimen and not p["planned"]])
        error_v, standard_v = b_v.mean() - true_v, b_v.std(ddof=1) / np.sqrt(b_v.size)
        yield (
            f"| {entry.specimen} | {b_v.size} | {1e6 * true_v:.2f} | {1e6 * b_v.mean():.2f} | {1e6 * standard_v:.2f} "
            f"| {100 * error_v / true_v:+.1f} | {error_v / standard_v:+.2f} |"
        )


def validator_line(data: Path) -> str:
    """What the standard's own validator says."""
    program = shutil.which("bids-validator-deno", path=str(Path(sys.executable).parent))
    if program is None:
        return "The BIDS validator is not installed."
    done = subprocess.run([program, str(data), "--format", "json"], capture_output=True, text=True, timeout=120)
    issues = json.loads(done.stdout)["issues"]["issues"]
    counts = Counter(issue["severity"] for issue in issues)
    codes = sorted({issue["code"] for issue in issues if issue["severity"] == "error"})
    return f"BIDS validator: {counts['error']} errors {codes or ''}, {counts['warning']} warnings."


def told(folder: Path) -> Iterator[str]:
    """The report of a session, paragraph by paragraph."""
    head, _, said = (folder / SAID).read_text(encoding="utf-8").partition("\n")
    yield head
    rows = list(press_rows(folder))
    right = sum(press["right"] for press, _ in rows)
    counts = Counter(press["verdict"] for press, _ in rows)
    yield f"{len(rows)} attempts, {right} judged rightly; verdicts at once: {dict(counts)}."
    lines = [
        "| press | specimen | what went wrong | verdict at once | at the end | decision | right |",
        "|" + "---|" * 7,
    ]
    lines += [f"| {' | '.join(cells)} |" for press, cells in rows if press["planned"] or press["verdict"] != "ok"]
    yield "\n".join(lines)
    yield "Every other press was ok at once.\n\n## The page"
    yield "\n".join(screen_lines(folder))
    if (folder / READS).exists():
        lag = lag_ms(np.load(folder / READS))
        p50, p95 = np.percentile(lag, (50, 95))
        yield f"From the finger to the eye: p50 {p50:.0f} ms, p95 {p95:.0f} ms ({lag.size} looks during presses)."
    yield f"## The data\n\n{validator_line(folder / 'data')}"
    run = [sys.executable, "-m", "emg2vsa.cli", "run", "study.toml", "--jobs", "1"]
    done = subprocess.run(run, cwd=folder, capture_output=True, text=True)
    yield f"`emg2vsa run`: exit status {done.returncode}."
    yield "\n".join(b_rows(folder / "study.toml", [press for press, _ in rows]))
    yield "```text\n" + re.sub(r"http://\S+|/\S+/(?=data|reports)", "…", said).strip() + "\n```"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--keep", type=Path, metavar="DIR", help="a folder for what the session wrote")
    parser.add_argument("--of", type=Path, metavar="DIR", help="of a session that was kept")
    arguments = parser.parse_args()
    folder = arguments.of or Path(tempfile.mkdtemp(prefix="session_browser_"))
    if arguments.of is None:
        play(folder, make_study(folder))
        if arguments.keep:
            shutil.copytree(folder, arguments.keep, ignore=shutil.ignore_patterns("browser-*"))
    for paragraph in told(folder):
        print(paragraph, end="\n\n", flush=True)
    if arguments.of is None:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
