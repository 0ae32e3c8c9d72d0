"""Drive, record and plan stepper motors.

>>> import stepwright_motion as sw
>>> with sw.virtual(fast=True) as board:  # or sw.open("/dev/ttyUSB0")
...     board.x.steps_per_mm = 80
...     board.x.move_to(25, "mm").wait().position
25.0
"""

from ._axis import Axis
from ._board import Board, open, virtual
from ._errors import (
    CantOpen,
    Ended,
    LinkLost,
    OutOfRange,
    Refused,
    StepwrightError,
    Stopped,
    Uncertain,
)
from ._gcode import Corner, Gcode, JobPlan, gcode
from ._move import Move, Outcome
from ._native import PHASES
from ._native import VERSION as __version__
from ._plan import Plan, plan
from ._record import STATES, Recording, Track
from ._run import Cycle, Power, Run, Way, cycle, path
from ._settings import Settings

__all__ = [
    "PHASES",
    "STATES",
    "Axis",
    "Board",
    "CantOpen",
    "Corner",
    "Cycle",
    "Ended",
    "Gcode",
    "JobPlan",
    "LinkLost",
    "Move",
    "Outcome",
    "OutOfRange",
    "Plan",
    "Power",
    "Recording",
    "Refused",
    "Run",
    "Settings",
    "StepwrightError",
    "Stopped",
    "Track",
    "Uncertain",
    "Way",
    "__version__",
    "cycle",
    "gcode",
    "open",
    "path",
    "plan",
    "virtual",
]
