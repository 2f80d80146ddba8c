"""What the emulated participant and its Trigno server cost, in real time and faster.

Run as ``python -m benchmarks.emulated_participant [--seconds 20]``; it prints Markdown tables. Alone: 16 channels of
EMG at 2000 Hz in frames of 13.5 ms and the force at 1000 Hz, in turns of 5 ms of a clock that jumps, while the
participant presses every 6 s. Served: the same EMG behind the Trigno server and the force behind the ATI box, in real
time and six times faster, with one client of each in a process of its own; the cost is that of the server's process.
"""

from __future__ import annotations

import argparse
import contextlib
import multiprocessing
import socket
import time
from multiprocessing.connection import Connection

from emg2vsa.devices.clock import FastClock, VirtualClock, WallClock
from emg2vsa.devices.netft.box import Command, parse_records, request_bytes
from emg2vsa.devices.netft.datagrams import UdpLine
from emg2vsa.session.views import Command as Told
from emg2vsa.session.views import ForceMessage, ParticipantState
from emg2vsa.worlds.far_ends.netft_server import RdtServer
from emg2vsa.worlds.far_ends.serve import force_box
from emg2vsa.worlds.far_ends.trigno_base import FRAME_S
from emg2vsa.worlds.far_ends.trigno_server import TrignoServer
from emg2vsa.worlds.people.participant import EmulatedParticipant
from emg2vsa.worlds.people.person import Person, Response
from emg2vsa.worlds.people.sensors import EmgSampler, ForceSampler

MUSCLES = tuple(f"muscle {number}" for number in range(1, 17))
PERSON = Person(
    name="P01",
    responses={"S3": Response(28e-6, 13e-6, 3.35)},
    muscle_share=dict.fromkeys(MUSCLES, 1 / 16),
)
EMG_HZ, FORCE_HZ, TURN_S, PERIOD_S = 2000.0, 1000.0, 0.005, 6.0


class Metronome:
    """A page that asks for a press every 6 s of its clock."""

    def __init__(self, clock: WallClock | FastClock | VirtualClock) -> None:
        self._clock = clock

    def _now(self) -> Told:
        phase_s = self._clock.now_s() % PERIOD_S
        return "start" if phase_s < 3.2 else "stop" if phase_s < 4.5 else "ready"

    def participant(self) -> ParticipantState:
        return ParticipantState(self._now(), "", "main", 1, 1, (0.5, 7.0), 7.0, (1.0, 5.0), "safe", False, "en")

    def force(self) -> ForceMessage:
        return ForceMessage(0, 0.0, 0.0, "none", "", self._now())


def alone(seconds: float) -> str:
    """A row: cost within a process that does nothing else."""
    clock, person = VirtualClock(), EmulatedParticipant(PERSON)
    person.watch(Metronome(clock))
    emg, force = EmgSampler(person, MUSCLES, EMG_HZ), ForceSampler(person, FORCE_HZ)
    begun_s, samples, per_frame = time.process_time(), 0, round(EMG_HZ * FRAME_S)
    while clock.now_s() < seconds:
        clock.sleep_until(clock.now_s() + TURN_S)
        force.take(force.due(clock.now_s()))
        if emg.due(clock.now_s()) >= per_frame:
            samples += len(emg.take(per_frame))
    cost = (time.process_time() - begun_s) / seconds
    return f"| alone | {samples / seconds:.1f} | {len(person.presses)} | {100 * cost:.1f} % | {1 / cost:.0f} |"


def client(emg_port: int, command_port: int, rdt_port: int, box_port: int, seconds: float, told: Connection) -> None:
    """Reads the EMG and the force, and tells how many samples came."""
    commands = socket.create_connection(("127.0.0.1", command_port))
    commands.recv(1024)
    data = socket.create_connection(("127.0.0.1", emg_port))
    line = UdpLine("127.0.0.1", rdt_port)
    commands.sendall(b"START\r\n\r\n")
    commands.recv(128)
    data.recv(64)
    line.send(request_bytes(Command.STREAM))
    data.setblocking(False)
    got, first, last, records, end_s = 64, None, 0, 0, time.monotonic() + seconds
    while time.monotonic() < end_s:
        time.sleep(0.002)
        with contextlib.suppress(BlockingIOError):
            got += len(data.recv(1 << 20))
        while (datagram := line.receive()) is not None:
            for record in parse_records(datagram.data):
                records, last = records + 1, record.rdt_sequence
                first = last if first is None else first
    told.send((got // 64, records, last - (first or 0) + 1 - records))


def served(speed: float, seconds: float) -> str:
    """A row: cost of the servers, with clients elsewhere."""
    clock = WallClock() if speed == 1 else FastClock(speed)
    person = EmulatedParticipant(PERSON)
    person.watch(Metronome(clock))
    slots = dict(enumerate(MUSCLES, start=1))
    with (
        TrignoServer(person, slots, clock, start_delay_s=0.3) as trigno,
        RdtServer(force_box(person, (0.0, 0.0, -1.0)), clock) as box,
    ):
        here, there = multiprocessing.Pipe()
        context = multiprocessing.get_context("spawn")
        ports = trigno.ports.emg, trigno.ports.command, box.rdt_port, box.http_port
        process = context.Process(target=client, args=(*ports, seconds, there))
        process.start()
        while not trigno.base.streaming:
            time.sleep(0.01)
        time.sleep(0.3 / speed)
        begun_s = time.process_time()
        samples, records, lost = here.recv()
        cost = (time.process_time() - begun_s) / seconds
        process.join()
        rates = f"{samples / seconds / speed:.1f} | {records / seconds / speed:.1f}"
        return f"| {speed:g} | {rates} | {trigno.lost_frames} | {lost} | {100 * cost:.1f} % |"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=20.0)
    seconds = parser.parse_args().seconds
    print("| 16 channels at 2000 Hz, force at 1000 Hz | EMG, Hz | presses | of one core | times real time |")
    print("|---|---|---|---|---|")
    print(alone(3 * seconds), flush=True)
    print("\n| served, times real time | EMG, Hz | force, Hz | EMG frames lost | force records lost | of one core |")
    print("|---|---|---|---|---|---|")
    for speed in (1.0, 6.0):
        print(served(speed, seconds), flush=True)


if __name__ == "__main__":
    main()
