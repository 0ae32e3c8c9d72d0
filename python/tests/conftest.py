"""Boards for the tests."""

from __future__ import annotations

import os
import select
import signal
import socket
import subprocess
import termios
import threading
import tty
from types import TracebackType
from typing import Iterator, Optional, Type

import pytest

import stepwright_motion as sw

COMMAND = os.environ.get("STEPWRIGHT_COMMAND", "stepwright")

# A shell's background job ignores Ctrl-C, and so would the programs that these tests start.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def board() -> Iterator[sw.Board]:
    """A virtual board whose time passes only while something waits."""
    with sw.virtual(fast=True) as board:
        yield board


class Pty:
    """A virtual board in another process, behind a pseudo-terminal."""

    def __init__(self, *options: str):
        self.process = subprocess.Popen(
            [COMMAND, "board", "--pty", *options], stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        said = self.process.stdout.readline()
        assert said.startswith("pty "), said
        self.port = said.split()[1]

    def close(self) -> None:
        """Switches the board off."""
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


class Cable:
    """A socket in front of a serial port, as of ``ser2net``, that can be pulled."""

    def __init__(self, port: str):
        self._port = os.open(port, os.O_RDWR | os.O_NOCTTY)
        tty.setraw(self._port)
        # Drops what was said to the last owner of the port.
        termios.tcflush(self._port, termios.TCIOFLUSH)
        self._server = socket.create_server(("127.0.0.1", 0))
        self.address = f"tcp://127.0.0.1:{self._server.getsockname()[1]}"
        self._muted = self._pulled = False
        self._thread = threading.Thread(target=self._carry)
        self._thread.start()

    def pull(self) -> None:
        """Pulls the cable. Both ends notice."""
        self._pulled = True

    def mute(self) -> None:
        """Carries no more bytes. Neither end notices."""
        self._muted = True

    def _carry(self) -> None:
        self._server.settimeout(30)
        near, _ = self._server.accept()
        with near:
            while not self._pulled:
                ready = select.select([near.fileno(), self._port], [], [], 0.005)[0]
                for end in ready:
                    data = os.read(end, 4096)
                    if not data:
                        self._pulled = True
                    elif not self._muted:
                        os.write(self._port if end == near.fileno() else near.fileno(), data)

    def __enter__(self) -> Cable:
        return self

    def __exit__(
        self,
        kind: Optional[Type[BaseException]],
        value: Optional[BaseException],
        trace: Optional[TracebackType],
    ) -> None:
        self.pull()
        self._thread.join()
        self._server.close()
        os.close(self._port)


@pytest.fixture
def pty() -> Iterator[Pty]:
    """A virtual board behind a pseudo-terminal."""
    pty = Pty()
    yield pty
    pty.close()
