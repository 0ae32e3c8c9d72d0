// A straight line of several axes, as `stepwright line` orders it: the axis that goes furthest has
// the whole speeds and ramps, the others their share, so that all end together.

/** A number's share, to the nearest thousandth, and no less than `least`. */
const share = (number, part, least) => Math.max(least, Math.round(number * part * 1000) / 1000);

/** The orders of axes that go so far, each `[axis, steps]`, by the limits of the furthest. */
export function shares(ways, limits) {
  const pulses = (steps) => Math.abs(steps) - 1;
  const most = Math.max(...ways.map(([, steps]) => pulses(steps)));
  return ways.map(([axis, steps]) => {
    const part = pulses(steps) ? pulses(steps) / most : 1;
    const order = { axis, steps, endless: 0, ...limits };
    if (part === 1) return order;
    order.start_speed = share(limits.start_speed, part, 0);
    order.top_speed = share(limits.top_speed, part, 0.001);
    // Without a ramp its slope does not matter, but has to be said.
    const even = order.top_speed <= order.start_speed;
    for (const name of ["accel", "decel"]) order[name] = even ? 1 : share(limits[name], part, 0.001);
    if (limits.jerk) order.jerk = share(limits.jerk, part, 0.001);
    return order;
  });
}
