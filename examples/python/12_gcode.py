"""How long does a G-code job take, and which corners cost most?"""

import stepwright_motion as sw

with open("part.nc", "w") as file:
    file.write("G0 X10 Y10\nG1 X60 F3000\nY40\nG3 X30 Y40 I-15\nG1 X10 Y10\nG0 X0 Y0\n")
plan = sw.gcode("part.nc").plan(steps_per_mm=80, speed="200mm/s", accel="1000mm/s2")
print(f"{plan.duration:.2f} s for {plan.lines} lines, X {plan.extents['x']}")
for corner in plan.corners[:3]:
    print(f"line {corner.line}: {corner.cost:.3f} s")
