"""What other people's clients of the Trigno SDK server get from the emulated one, each as its authors wrote it.

Run as ``python -m benchmarks.trigno_clients [--pytrigno DIR] [--pytrigno-fork DIR] [--delsys-trigno-client DIR]
[--libemg PYTHON] [--seconds 10]``; it prints a Markdown table. DIR holds a client's source; PYTHON is the interpreter
of an environment with libemg 2.0.3, which needs NumPy below 2. A client that is not given stands as absent. The clients
have the server's own ports written into them, so that 50040 to 50044 must be free.

All 16 slots have a sensor. Slot 16 carries a count instead of EMG, one up each sample: a step other than 1 is a sample
lost, doubled or misread. Rate: samples over the time between the first and the last reading.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from emg2vsa.devices.clock import WallClock
from emg2vsa.worlds.far_ends.trigno_server import Ports, TrignoServer
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response

SLOTS = {slot: "counter" if slot == 16 else f"muscle {slot}" for slot in range(1, 17)}
PERSON = Person(
    name="P01",
    responses={"S1": Response(42e-6, 20e-6, 7.63)},
    muscle_share={muscle: 1 / 15 for muscle in SLOTS.values() if muscle != "counter"},
)
_HEAD = """
import json, sys, time
import numpy as np
seconds = float(sys.argv[1])
def told(name, counter, time_s, others, **more):
    counter = np.asarray(counter)
    steps = np.diff(counter)
    rate_hz = (len(counter) - more.pop("first", 0)) / time_s
    quiet = int((np.std(others, axis=0) < 1e-8).sum())
    print("RESULT", json.dumps(dict(reading=name, samples=len(counter), wrong_steps=int((steps != 1).sum()),
        rate_hz=rate_hz, quiet_channels=quiet, **more)))
"""
_PYTRIGNO = """
import pytrigno
for again in range(2):
    if not again:
        device = pytrigno.TrignoEMG(channels=range(16), samples_per_read=270)
    device.start()
    reads = [device.read()]
    begun = time.monotonic()
    while time.monotonic() - begun < seconds:
        reads.append(device.read())
    took = time.monotonic() - begun
    device.stop()
    data = np.concatenate(reads, axis=1)
    name = "EMG, 50041" + (", after STOP and START" if again else "")
    told(name, data[15], took, data[:15].T, first=270)
    # what was on its way when STOP was said belongs to this run
    device._data_socket.settimeout(0.3)
    left = 0
    try:
        while more := device._data_socket.recv(65536):
            left += len(more)
    except OSError:
        pass
    print("RESULT", json.dumps(dict(reading=name + ": bytes after STOP", left=left, whole=left % 64 == 0)))
    device._data_socket.settimeout(2)
del device
device = pytrigno.TrignoACC(channels=range(16), samples_per_read=20)
device.start()
data = device.read()
begun = time.monotonic()
while time.monotonic() - begun < seconds / 2:
    data = np.concatenate([data, device.read()], axis=1)
took = time.monotonic() - begun
device.stop()
print("RESULT", json.dumps(dict(reading="accelerometer, 50042", samples=data.shape[1],
    rate_hz=(data.shape[1] - 20) / took, gravity=sorted(set(data[2::3].ravel().tolist())))))
"""
_FORK = """
import io, contextlib, pytrigno
device = pytrigno.TrignoIMU(16)
device.start()
with contextlib.redirect_stdout(io.StringIO()):
    reads = [device.getEMG()]
    begun = time.monotonic()
    while time.monotonic() - begun < seconds:
        reads.append(device.getEMG())
    took = time.monotonic() - begun
    imu = device.getData()
device.stop()
data = np.concatenate(reads, axis=1)
told("EMG, 50043", data[15], took, data[:15].T, first=270)
print("RESULT", json.dumps(dict(reading="IMU, 50044", samples=imu.shape[1])))
"""
_DELSYS = """
from delsys_trigno_client import TrignoClient
client = TrignoClient("127.0.0.1")
paired = sum(client.is_sensor_paired(n) for n in range(1, 17))
pair = client.pair_sensor(3)
client.start_acquisition()
first = client.get_readings_emg(max_size=270)
begun = time.monotonic()
data = client.get_readings_emg(max_size=int(seconds * 2000))
took = time.monotonic() - begun
aux = client.get_readings_aux(max_size=200)
client.stop_acquisition()
client.close()
# the client lays samples out as (channels, n) without turning them: its order is undone
rows = data[1:].reshape(-1, 16)
told("EMG, 50043", rows[:, 15], took, rows[:, :15], paired=paired, pairing=pair)
gravity = sorted(set(aux[1:].reshape(-1, 16, 9)[:, :, 2].ravel().tolist()))
print("RESULT", json.dumps(dict(reading="AUX, 50044", samples=aux.shape[1], gravity=gravity)))
"""
_LIBEMG = """
from libemg.shared_memory_manager import SharedMemoryManager
from libemg.streamers import delsys_streamer
if __name__ == "__main__":
    streamer, items = delsys_streamer(channel_list=list(range(16)))
    memory = SharedMemoryManager()
    while not all(memory.find_variable(*item) for item in items):
        time.sleep(0.05)
    counter, others, begun = [], [], None
    while begun is None or time.monotonic() - begun < seconds:
        time.sleep(0.2)
        rows = memory.get_variable("emg")[::-1]
        if begun is None:
            if not rows.any():
                continue
            begun = time.monotonic()
            rows = rows[rows.any(axis=1)]
            first = len(rows)
        else:
            # the memory holds the newest 3000 rows; those that were seen end with the count seen last
            at = np.flatnonzero(rows[:, 15] == counter[-1])
            rows = rows[at[-1] + 1 :] if len(at) else rows
        counter += rows[:, 15].tolist()
        others.append(rows[:, :15])
    took = time.monotonic() - begun
    count = int(memory.get_variable("emg_count")[0, 0])
    streamer.signal.set()
    streamer.join(5)
    told("EMG, 50043", counter, took, np.concatenate(others), first=first, its_own_count=count)
"""


class CountingServer(TrignoServer):
    """Slot 16 counts."""

    count = 0

    def _send_frame(self, run: int, muscles_v: NDArray[np.float64]) -> None:
        muscles_v[:, -1] = self.count + np.arange(len(muscles_v))
        self.count += len(muscles_v)
        super()._send_frame(run, muscles_v)


def result_of(name: str, given: Path | None, script: str, seconds: float) -> list[str]:
    """Rows of a client."""
    if given is None:
        return [f"| {name} | absent | | | | | |"]
    of_libemg = script is _LIBEMG
    interpreter, folder = (str(given), "") if of_libemg else (sys.executable, str(given))
    person = EmulatedParticipant(PERSON)
    own = Path(os.environ.get("TMPDIR", "/tmp")) / f"trigno_client_{os.getpid()}.py"
    own.write_text(_HEAD + script)
    try:
        with CountingServer(person, SLOTS, WallClock(), ports=Ports()):
            environment = os.environ | {"PYTHONPATH": folder}
            done = subprocess.run(
                [interpreter, str(own), str(seconds)], env=environment, capture_output=True, text=True, timeout=180
            )
    finally:
        own.unlink()
    said = done.stdout.splitlines()
    results = [json.loads(line.removeprefix("RESULT ")) for line in said if line.startswith("RESULT ")]
    errors = sum("rror" in line or "warning" in line for line in said)
    last = done.stderr.strip().splitlines()[-1:] if done.returncode else []
    failed = f"| {name} | failed: {' '.join(last)} | | | | | |"
    return [row(name, result, errors, last) for result in results] or [failed]


def row(name: str, result: dict[str, object], errors: int, last: list[str]) -> str:
    """A row of the table."""
    samples, wrong, rate = (result.pop(key, "") for key in ("samples", "wrong_steps", "rate_hz"))
    rate = f"{rate:.2f}" if isinstance(rate, float) else ""
    reading = result.pop("reading")
    more = ", ".join([*(f"{key} {value}" for key, value in result.items()), *last])
    return f"| {name} | {reading} | {samples} | {wrong} | {rate} | {errors} | {more} |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("pytrigno", "pytrigno-fork", "delsys-trigno-client", "trignoclient", "libemg"):
        parser.add_argument(f"--{name}", type=Path)
    parser.add_argument("--seconds", type=float, default=10.0)
    arguments = parser.parse_args()
    print("| client | reading | samples | wrong steps | rate, Hz | errors and warnings it printed | more |")
    print("|---|---|---|---|---|---|---|")
    for name, given, script in (
        ("pytrigno", arguments.pytrigno, _PYTRIGNO),
        ("pytrigno, a fork", arguments.pytrigno_fork, _FORK),
        ("delsys-trigno-client", arguments.delsys_trigno_client, _DELSYS),
        ("libemg 2.0.3", arguments.libemg, _LIBEMG),
        ("trignoclient (C++)", None, ""),
    ):
        print("\n".join(result_of(name, given, script, arguments.seconds)), flush=True)


if __name__ == "__main__":
    main()
