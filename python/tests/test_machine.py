"""Machine files, which the command reads too."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest
from conftest import COMMAND, Pty

import stepwright_motion as sw

FILE = """
lease = "500ms"

[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
top-speed = "4mm/s"
accel = "40mm/s2"
start-speed = 20
home-within = "1mm"
home-back-off = 30

[axis.2]
steps-per-rev = 3200

[axis.3]
top-speed = 1000
ramp = 200
"""


def test_a_file_says_how_axes_are_built(tmp_path: Path, pty: Pty) -> None:
    path = tmp_path / "m.toml"
    path.write_text(f"port = '{pty.port}'\n{FILE}")
    with sw.open(machine=path) as board:
        assert board.name == pty.port
        assert [axis.unit for axis in board] == ["mm", "deg", "steps"]
        began = board.time
        assert board.x.move_to(4).wait().steps == (1600,)
        # 4 mm at 4 mm/s and ramps of 0.1 s.
        assert board.time - began == pytest.approx(1.1, abs=0.12)
        assert board.y.move_to(90).wait().steps == (800,)
        began = board.time
        board.z.move_to(1000).wait()
        # 600 steps at 1000 steps/s, and ramps of 200 steps from 50 steps/s.
        assert board.time - began == pytest.approx(0.6 + 2 * 200 / 525, abs=0.12)
    # The command reads the same file, and finds the axis at its last position.
    words = [COMMAND, "position", "--machine", str(path)]
    said = subprocess.run(words, capture_output=True, text=True, check=True).stdout
    assert "1600" in said and "4 mm" in said


@pytest.mark.parametrize("speeds", ["top-speed = 30", "top-speed = 900\nstart-speed = 900"])
def test_a_ramp_between_equal_speeds_is_none(tmp_path: Path, speeds: str) -> None:
    """The command moves in the same way with such a file."""
    file = tmp_path / "mill.toml"
    file.write_text(f"[axis.1]\nramp = 200\n{speeds}\n")
    with sw.virtual(fast=True, machine=file) as board:
        assert board.x.move_to(300).wait().steps == (300,)


def test_homing_by_the_file(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text(FILE)
    with sw.virtual(fast=True, machine=path, switches={"x": -300}) as board:
        assert board.x.home().wait().steps == (30,)
        with pytest.raises(sw.OutOfRange, match="within"):
            board.y.home()
    with sw.virtual(fast=True, machine=path, switches={"x": -3000}) as board:
        with pytest.raises(sw.Stopped):
            board.x.home().wait()


def test_a_file_is_found_where_the_command_finds_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.delenv("STEPWRIGHT_MACHINE", raising=False)
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path / "user"))
    (tmp_path / "stepwright.toml").write_text("[axis.1]\nmm-per-rev = 40\n")
    with sw.open() as board:
        assert board.x.unit == "mm" and board.x.steps_per_mm == 5
    with sw.open(machine="none") as board:
        assert board.x.unit == "steps"
    monkeypatch.setenv("STEPWRIGHT_MACHINE", "none")
    with sw.open() as board:
        assert board.x.unit == "steps"


def test_a_mistake_has_its_file_and_line(tmp_path: Path) -> None:
    path = tmp_path / "m.toml"
    path.write_text("[axis.1]\n\ntop-speed = '3furlong/s'\n")
    with pytest.raises(ValueError, match=r"m.toml: line 3: .*no unit of a speed"):
        sw.open(machine=path)
    with pytest.raises(OSError):
        sw.open(machine=tmp_path / "none.toml")
