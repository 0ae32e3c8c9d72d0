// A planned travel as a command, and as Rust.

const C0 = ["exact", "0.676", "c1"];
const CORE_C0 = ["Exact", "Reduced", "FirstStep"];

/** Laws with a choice of first delay. */
const LED = ["austin", "linear-factor", "power", "piecewise"];

/** A word, quoted for a shell. */
export const quoted = (word) => (/^[\w./:-]+$/.test(word) ? word : `'${word.replaceAll("'", "'\\''")}'`);

/** The command that moves an axis so, on `port` or a virtual board. */
export function command(law, travel, port, axis) {
  const { steps, top, accel, decel, start, jerk, c0, divisor, knee, power, breaks } = travel;
  const own = law !== "trapezoid" && law !== "s-curve";
  const words = ["stepwright move", steps];
  if (port) words.push(`--port ${quoted(port)}`);
  if (axis > 1) words.push(`--axis ${axis}`);
  if (own) words.push(`--law ${law}`);
  words.push(`--top-speed ${top}`, `--accel ${accel}`);
  if (decel !== accel) words.push(`--decel ${decel}`);
  if (!own) words.push(`--start-speed ${start}`);
  if (law === "s-curve") words.push(`--jerk ${jerk}`);
  if (law === "austin" && divisor === 1) words.push("--divisor 2n");
  else if (LED.includes(law) && c0 !== 1) words.push(`--c0 ${C0[c0]}`);
  if (law === "linear-factor") words.push(`--knee ${knee}`);
  if (law === "power") words.push(`--power ${power}`);
  if (law === "piecewise") words.push(`--breaks ${breaks}`);
  return words.join(" ");
}

const whole = (number) => String(number).replace(/\B(?=(\d{3})+$)/g, "_");

/** A quantity of the core: in whole steps, or else in thousandths. */
function quantity(kind, value) {
  const milli = Math.round(value * 1000);
  if (milli === 0) return `${kind}::ZERO`;
  return milli % 1000 === 0 && milli < 4e12
    ? `${kind}::from_steps(${whole(milli / 1000)})?`
    : `${kind}::from_millisteps(${whole(milli)})?`;
}

/** The travel's delays as Rust. */
export function rust(law, travel, figures) {
  const { rate, steps, start, top, accel, decel, jerk, c0, divisor, knee, power, breaks } = travel;
  const name = {
    trapezoid: "Trapezoid", "s-curve": "SCurve", austin: "Austin", "austin-fixed": "Fixed",
    "linear-factor": "LinearFactor", power: "PowerTerm", piecewise: "Piecewise",
  }[law];
  const count = whole(steps);
  if (law === "austin-fixed") {
    return [
      "use stepwright_austin::Fixed;", "",
      `// A first delay of ${figures.first} ticks, none below ${figures.shortest}, at ${whole(rate)} ticks a second.`,
      `for delay in Fixed::new(${count}, ${whole(figures.first)}, ${whole(figures.shortest)}) {`,
      "    // ticks until the next step", "}", "",
    ].join("\n");
  }
  const closed = law === "trapezoid" || law === "s-curve";
  const values = [`Rate::from_hz(${whole(rate)})?`];
  if (closed) values.push(quantity("Speed", start));
  values.push(quantity("Speed", top), quantity("Accel", accel));
  if (law === "s-curve") values.push(quantity("Jerk", jerk));
  if (law === "power") values.push(String(power));
  const more = [];
  if (decel !== accel) more.push(`.with_decel(${quantity("Accel", decel)})`);
  const halves = law === "austin" && divisor === 1;
  if (halves) more.push(".with_divisor(Divisor::TwoN)");
  const led = LED.includes(law) && c0 !== 1 && !halves;
  if (led) more.push(`.with_c0(C0::${CORE_C0[c0]})`);
  if (law === "linear-factor") more.push(`.with_knee(${Math.round(knee * 1000)})`);
  if (law === "piecewise") more.push(`.with_breaks(${breaks})`);
  const units = ["Accel", ...(law === "s-curve" ? ["Jerk"] : []), "Rate", "Speed"];
  const own = [name, ...(led ? ["C0"] : []), ...(halves ? ["Divisor"] : [])].sort();
  const brace = (names) => (names.length > 1 ? `{${names.join(", ")}}` : names[0]);
  return [
    closed
      ? `use stepwright::{${units.join(", ")}, profile::${name}};`
      : `use stepwright::{${units.join(", ")}};\nuse stepwright_austin::${brace(own)};`,
    "",
    `let law = ${name}::new(`, ...values.map((value) => `    ${value},`), `)${more.length ? "" : ";"}`,
    ...more.map((call, i) => `${call}${i === more.length - 1 ? ";" : ""}`),
    `for delay in law.delays(${count})? {`, "    // ticks until the next step", "}", "",
  ].join("\n");
}
