// Why a board would refuse a planned travel, by GET /api/board.

/** The letters of axes in settings. */
const LETTER = { 1: "x", 2: "y", 3: "z" };

/** Whether a set has an axis: 1 X, 2 Y, 4 Z, added up. */
const holds = (set, axis) => ((set ?? 0) >> (axis - 1)) % 2 === 1;

/**
 * * The reasons, as texts; none if the board would take it.
 *
 * * `peak` is the highest speed of the travel, `board` the sheet of GET /api/board with
 * * its settings by name (`set`),
 * * `place` the axis, as in GET /api/state.
 */
export function refusals(law, travel, peak, board, axis, place) {
  const { steps, top, accel, decel, jerk } = travel;
  const { set } = board;
  const reasons = [];
  const no = (what, remedy) => reasons.push(`${what}: ${remedy}`);
  if (law !== "trapezoid" && law !== "s-curve") {
    no("a controller plans constant acceleration and S-curves", `for ${law} it takes a board with the program laws; copy the command`);
    return reasons;
  }
  if (steps < 1) no("there is nothing to travel", "give 1 step or more");
  for (const [name, value] of [["acceleration", accel], ["deceleration", decel]]) {
    if (value < 1) no(`the ${name} is below 1 step/s²`, "the line carries 1 and more");
    const most = set["max-accel"];
    if (most !== undefined && most < 100_000_000 && value > most) {
      no(`the ${name} is above max-accel`, `lower it to ${most} steps/s², or raise the setting`);
    }
  }
  if (board.max_speed && peak > board.max_speed) {
    no(`the board steps one axis at most ${board.max_speed} steps/s`, "lower the top speed");
  }
  if (set["max-speed"] !== undefined && top > set["max-speed"]) {
    no("the top speed is above max-speed", `lower it to ${set["max-speed"]} steps/s, or raise the setting`);
  }
  if (law === "s-curve") {
    if (!board.can.includes("jerk")) no("the board can't limit the jerk", "take the trapezoid");
    else if (set.law === 0) no("its setting law is 0, so it takes no jerk", "set it to 1");
    if (jerk < 1 || jerk > 4e9) no("the line carries a jerk of 1 to 4000000000 steps/s³", "change it");
  }
  if (place && place.position === null && set["home-first"] === 1) {
    no("its position is not known, and home-first is 1", "home the axis first");
  }
  if (place && place.position !== null && holds(set["soft-limits"], axis)) {
    const end = place.position + steps;
    const most = set[`ahead-${LETTER[axis]}`];
    if (most !== undefined && end > most) no(`it would end at ${end}, beyond the soft limit`, `at most ${most}`);
  }
  return reasons;
}
