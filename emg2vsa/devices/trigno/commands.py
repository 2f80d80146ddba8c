"""The command port of Delsys' Trigno Control Utility: text to it, one reply for each command (SDK guide MAN-025)."""

from __future__ import annotations

import socket

from emg2vsa.errors import DeviceError

GREETING = "Delsys Trigno System Digital Protocol"
END = b"\r\n\r\n"
REPLY_S = 5.0
"START takes up to this time."
LEAVE_S = 0.5
RECEIVE_BYTES = 1 << 16
_BUFFER_BYTES = 1 << 20


class TrignoCommands:
    """The command port of a server: one reply for each command. Every method raises DeviceError when it is lost."""

    def __init__(self, host: str, port: int) -> None:
        self.where = f"Trigno server at {host}:{port}"
        self._heard = b""
        self._socket = connect(host, port, self.where)
        self._socket.settimeout(REPLY_S)
        try:
            greeting = self._reply("the greeting")
        except DeviceError:
            self.close()
            raise
        if not greeting.startswith(GREETING):
            self.close()
            do = "Correct session.emg.host and session.emg.command_port."
            raise DeviceError(self.where, wanted=f'the greeting "{GREETING}"', found=repr(greeting[:60]), do=do)
        self.version = greeting.split()[-1]

    def ask(self, command: str) -> str:
        """The reply, without the blanks around it."""
        try:
            self._socket.sendall(command.encode("ascii") + END)
        except OSError as error:
            raise self._lost(command, error.strerror or str(error)) from error
        reply = self._reply(command)
        while reply.startswith("SENSOR") and reply.endswith(("PAIR COMPLETE", "PAIR INITIATED")):
            reply = self._reply(command)  # told unasked, because somebody pairs a sensor meanwhile
        return reply

    def order(self, command: str, wanted: str = "OK", do: str = "Restart the Trigno Control Utility.") -> None:
        """Give a command that must be obeyed."""
        reply = self.ask(command)
        if not reply.startswith(wanted):
            raise DeviceError(self.where, wanted=f"{wanted} to {command}", found=reply, do=do)

    def leave(self) -> None:
        """End the stream and the conversation; a server that hangs is not waited for long."""
        self._socket.settimeout(LEAVE_S)
        self.ask("STOP")
        self.ask("QUIT")

    def close(self) -> None:
        self._socket.close()

    def _reply(self, command: str) -> str:
        # a reply may end with one newline too many
        while END not in (heard := self._heard.lstrip(b"\r\n")):
            try:
                data = self._socket.recv(RECEIVE_BYTES)
            except TimeoutError as error:
                raise self._lost(command, f"none within {self._socket.gettimeout():g} s") from error
            except OSError as error:
                raise self._lost(command, error.strerror or str(error)) from error
            if not data:
                raise self._lost(command, "a closed connection")
            self._heard += data
        reply, self._heard = heard.split(END, 1)
        return reply.decode("ascii", "replace").strip()

    def _lost(self, command: str, found: str) -> DeviceError:
        do = "Restart the Trigno Control Utility; check the network."
        return DeviceError(self.where, wanted=f"a reply to {command}", found=found, do=do)


def connect(host: str, port: int, where: str) -> socket.socket:
    """A connection by TCP. DeviceError when nobody answers."""
    try:
        connection = socket.create_connection((host, port), timeout=REPLY_S)
    except OSError as error:
        do = "Start the Trigno Control Utility on that computer, or correct session.emg.host and its ports."
        raise DeviceError(where, wanted="a connection", found=error.strerror or str(error), do=do) from error
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, _BUFFER_BYTES)
    return connection
