"""A session whose devices, participant and operator are another process: over TCP, UDP, LSL and HTTP, in real time.

Run as ``python -m benchmarks.session_over_ports [--devices trigno lsl] [--keep DIR]``; it prints Markdown tables. One
process is ``emg2vsa session emulate --operate``, the other ``emg2vsa session``: one press of practice, then three on
each of two specimens, with three planted mistakes. trigno: EMG from the Trigno server, force from the ATI box; lsl:
both as LSL streams. True: of the emulated participant; fitted: by the session, live.
"""

from __future__ import annotations

import argparse
import json
import os
import re
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

from benchmarks.small_study import small_study

PALPATION = Path(__file__).parents[1] / "studies" / "palpation"
MISTAKES = "too-fast@2", "aborted@3", "electrode-off:FDS@5"
PARTICIPANT, MOST_S = "P03", 240.0
_STUDY = small_study(
    name="ports",
    title="A session over ports",
    participants=["P01", "P02", "P03"],
    specimens=["S1", "S5"],
    simulation="seed = 11\n",
    tables="""
[window]
force_n = [0.5, 7.0]
expected_trials = 3
[session]
training_specimens = ["T1"]
training_repetitions = 1
repetitions = 3
pause_s = 1.0
rest_s = 1.0
""",
)
_TRIGNO = """
emg.kind = "trigno"
emg.command_port = {command}
emg.emg_port = {emg}
emg.channels = {{ EDC = "1", FDS = "5" }}
force.kind = "rig"
force.rig = "rig.toml"
"""
_LSL = """
emg.kind = "lsl"
emg.channels = { EDC = "ch7", FDS = "ch9" }
force.kind = "lsl"
"""


def free_port(kind: int = socket.SOCK_STREAM) -> int:
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def emulated_devices(folder: Path) -> str:
    """Write a rig.toml with free ports of the force box; the lines of [session] for it and for a Trigno server."""
    rig = (PALPATION / "rig.toml").read_text(encoding="utf-8")
    ports = f'host = "127.0.0.1"\nhttp_port = {free_port()}\nrdt_port = {free_port(socket.SOCK_DGRAM)}\n'
    (folder / "rig.toml").write_text(rig.replace("[force]\n", f"[force]\n{ports}"), encoding="utf-8")
    return _TRIGNO.format(command=free_port(), emg=free_port())


def make_study(folder: Path, devices: str) -> None:
    """study.toml, and the rig.toml that it names."""
    of_trigno = emulated_devices(folder)
    (folder / "study.toml").write_text(_STUDY + (_LSL if devices == "lsl" else of_trigno))
    (folder / "lsl_api.cfg").write_text(
        f"[multicast]\nResolveScope = machine\n[lab]\nKnownPeers = {{127.0.0.1}}\nSessionID = {folder.name}\n"
    )


def carry_out(folder: Path) -> tuple[int | None, str]:
    """Exit status of the session, None where it was too slow; and what it said."""
    environment = os.environ | {"PYTHONUNBUFFERED": "1", "LSLAPICFG": str(folder / "lsl_api.cfg")}
    command = [sys.executable, "-m", "emg2vsa.cli", "session"]
    chosen = ["study.toml", "--participant", PARTICIPANT]
    planted = [word for mistake in MISTAKES for word in ("--mistake", mistake)]
    pipes: Any = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    pipes |= {"cwd": folder, "env": environment}
    far = subprocess.Popen([*command, "emulate", *chosen, "--operate", "--truth", "truth.json", *planted], **pipes)
    assert far.stdout is not None
    assert far.stdin is not None
    while "help for faults" not in (line := far.stdout.readline()):
        if not line:
            raise SystemExit("the emulation did not begin")
    near = subprocess.Popen([*command, "run", *chosen, "--port", "0"], **pipes)
    said: list[str] = []
    reader = threading.Thread(target=_introduce, args=(near.stdout, far.stdin, said))
    reader.start()
    try:
        status: int | None = near.wait(MOST_S)
    except subprocess.TimeoutExpired:
        near.terminate()
        status = None
    reader.join()
    far.communicate("quit\n")
    return status, "".join(said)


def _introduce(near: IO[str], far: IO[str], said: list[str]) -> None:
    """Give the two addresses that the session prints to the emulation."""
    for line in near:
        said.append(line)
        for address in re.findall(r"http://\S+/(?:operator|participant)/", line):
            far.write(f"{'operator-page' if '/operator/' in address else 'page'} {address}\n")
            far.flush()


def rows(folder: Path) -> Iterator[str]:
    """A row for each attempt, and one for the two streams."""
    session = next((folder / "data" / "sourcedata").rglob("journal.jsonl"))
    lines = [json.loads(line) for line in session.read_text().splitlines()]
    events = [(line["kind"], line["event"]) for line in lines]
    begun = [(event["press"], event["attempt"]) for kind, event in events if kind == "press-begun"]
    judged: dict[tuple[int, int], list[Any]] = {key: [] for key in begun}
    for kind, event in events:
        if kind == "judged":
            judged[event["press"], event["attempt"]].append(event)
    pressed = json.loads((folder / "truth.json").read_text())["presses"]
    for (number, attempt), true in zip(begun, pressed, strict=True):
        event, last = judged[number, attempt][0], judged[number, attempt][-1]
        why = "; ".join(problem for problem, _ in event["problems"])
        b_v = event["values"].get("b_v")
        fitted = f"{1e6 * b_v:.1f}" if b_v is not None else ""
        told = f"{event['verdict']}{': ' if why else ''}{why}"
        cells = (
            true["specimen"],
            number,
            attempt,
            true["mistake"],
            told,
            last["verdict"],
            f"{1e6 * true['b_v']:.1f}",
            fitted,
        )
        yield f"| {' | '.join(map(str, cells))} |"
    clocks = {event["stream"]: event for kind, event in events if kind == "clock-fitted"}
    for name, clock in clocks.items():
        accuracy = f"s.e. of their times {1e3 * clock['se_s']:.2f} ms"
        yield f"\n{name}: {clock['samples']} samples, measured {clock['fs_hz']:.3f} Hz, {accuracy}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--devices", nargs="+", choices=("trigno", "lsl"), default=["trigno", "lsl"])
    parser.add_argument("--keep", type=Path, help="a folder for what the sessions wrote")
    arguments = parser.parse_args()
    for devices in arguments.devices:
        folder = Path(tempfile.mkdtemp(prefix="session_over_ports_"))
        make_study(folder, devices)
        begun_s = time.monotonic()
        status, said = carry_out(folder)
        print(f"\n## {devices}\n\nExit status {status} after {time.monotonic() - begun_s:.0f} s.\n")
        print("| specimen | press | attempt | planted | verdict at once | at the end | true b, uV | fitted b, uV |")
        print("|---|---|---|---|---|---|---|---|")
        print("\n".join(rows(folder)), flush=True)
        print("\n```text\n" + re.sub(r"http://\S+|/\S+/(?=data|reports)", "…", said).strip() + "\n```", flush=True)
        if arguments.keep:
            shutil.copytree(folder, arguments.keep / devices)
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
