"""Plans a travel by two laws, before anything moves: arrays, and a figure as svg."""

import stepwright_motion as sw

travel = {"steps": 2000, "speed": 1000, "accel": 4000}
for law, more in (("trapezoid", {}), ("s-curve", {"jerk": 80_000})):
    plan = sw.plan(law, **travel, **more)
    print(plan)  # <Plan trapezoid, 2000 steps, 2.249 s>
    print("  delays in µs:", [int(delay) for delay in plan.delays[:4]], "… shortest", min(plan.delays[1:]))
    plan.plot(f"{law}.svg")  # without a path: a figure of matplotlib
