"""Boards to try things on."""

from __future__ import annotations

import os
import signal
import subprocess
from typing import Iterator

import pytest

import stepwright_motion as sw

COMMAND = os.environ.get("STEPWRIGHT_COMMAND", "stepwright")

# A shell's job in the background ignores Ctrl-C, and so would the programs that these tests begin.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture
def board() -> Iterator[sw.Board]:
    """A virtual board whose time passes while it is waited for."""
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
        """Switches it off."""
        self.process.kill()
        self.process.wait()
        assert self.process.stdout is not None
        self.process.stdout.close()


@pytest.fixture
def pty() -> Iterator[Pty]:
    """A virtual board behind a pseudo-terminal."""
    pty = Pty()
    yield pty
    pty.close()
