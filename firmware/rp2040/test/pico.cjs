// Tests of the firmware for the Pico: node pico.cjs FOLDER-OF-ELVES [WORDS.json]
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const { Machine } = require('./machine.cjs');

const MICRO = 125;
const [, , folder, wordsFile] = process.argv;
const rounds = Number(process.env.STEPWRIGHT_ROUNDS || 250);
const AXES = [0, 1, 2, 3];
const REFILL = 400; // the most cycles per group, including the interrupt's entry and exit
const elf = (name) => path.join(folder, `rp2040-${name}.elf`);

let seed = 20261126;
const random = (below) => {
  seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
  return Math.floor(seed / 2 ** 32 * below);
};
const begin = () => {
  const m = new Machine(elf('trial'));
  m.ask(7);
  m.limit = (axis, speed, accel) => assert.equal(m.ask(6, axis, speed, accel), 0);
  m.rest = () => { while (m.ask(7)) m.run(2000); m.run(5000); };
  return m;
};
const median = (list) => [...list].sort((a, b) => a - b)[list.length >> 1];

/// The times of the edges in cycles, computed from the words in the FIFO; `high` is the pulse's width.
function computed(words, start, high) {
  const edges = [];
  let at = start;
  for (let n = 0; n < words.length; n += 2) {
    const [wait, steps] = [words[n][1], (words[n + 1][1] >>> 1) + 1];
    for (let k = 0; k < steps; k++) {
      at += n === 0 && k === 0 ? wait + 7 : wait + high + 7;
      edges.push(at);
    }
  }
  return edges;
}

/// Checks that every edge of an axis since its start, from edge `from` on, is at the computed cycle.
function exact(m, axis, from, high = MICRO) {
  const want = computed(m.words[axis], m.starts[axis], high);
  const have = m.edges[axis].slice(from).map(([time]) => time);
  assert.equal(have.length, want.length, `axis ${axis}: edges`);
  have.forEach((time, n) => assert.equal(time, want[n], `axis ${axis}, edge ${n}`));
}

/// Checks that DIR is set up and held, pulses are whole, and no interval is too short.
function keeps(m, { longer = 0, high = MICRO, setup = MICRO, hold = MICRO, least = 2 * MICRO } = {}) {
  for (const axis of AXES) {
    const edges = m.edges[axis];
    for (const width of m.widths[axis]) {
      // A pulse during a halt stays high for longer.
      assert(width === high || width > high && longer-- > 0, `axis ${axis}: a pulse of ${width}`);
    }
    for (let n = 1; n < edges.length; n++) {
      assert(edges[n][0] - edges[n - 1][0] >= least, `axis ${axis}: ${edges[n][0] - edges[n - 1][0]} cycles`);
    }
    let n = 0;
    for (const [time] of m.turns[axis]) {
      while (n < edges.length && edges[n][0] < time) n++;
      if (n > 0) assert(time - edges[n - 1][0] >= hold, `axis ${axis}: DIR is held for ${time - edges[n - 1][0]}`);
      if (n < edges.length) assert(edges[n][0] - time >= setup, `axis ${axis}: DIR is set up for ${edges[n][0] - time}`);
    }
  }
}

/// The pulses of a trapezoid from rest in closed form, in seconds from the first pulse, which marks the start;
/// only the others are steps.
function trapezoid(pulses, speed, accel) {
  const steps = pulses - 1;
  const ramp = Math.min(speed * speed / accel / 2, steps / 2);
  const top = Math.sqrt(2 * accel * ramp);
  const cruise = top / accel + (steps - 2 * ramp) / top;
  return Array.from({ length: pulses }, (_, n) => {
    if (n <= ramp) return Math.sqrt(2 * n / accel);
    if (n <= steps - ramp) return top / accel + (n - ramp) / top;
    return cruise + (top - Math.sqrt(Math.max(0, 2 * accel * (steps - n)))) / accel;
  });
}

const tests = {
  'four axes at 250,000 steps/s: every edge at the computed cycle': () => {
    const m = begin();
    for (const axis of AXES) m.limit(axis, 250_000, 750_000);
    m.visits = []; m.busy = 0; m.groups = 0;
    const begun = m.time;
    assert.equal(m.ask(1, 90_000, -90_000, 90_000, -90_000), 0);
    m.rest();
    const took = m.time - begun;
    assert.equal(m.ask(8), 0, 'ran dry');
    for (const axis of AXES) {
      exact(m, axis, 0);
      assert.equal(m.net(axis), axis % 2 ? -90_000 : 90_000);
      assert.equal(m.ask(5, axis), m.net(axis));
    }
    const firsts = AXES.map((axis) => m.edges[axis][0][0]);
    assert.deepEqual(firsts, AXES.map(() => firsts[0]), 'the first edges');
    keeps(m, { least: 500 });
    const shape = trapezoid(90_000, 250_000, 750_000).map((t) => t * 125e6);
    const edges = m.edges[0].map(([time]) => time - m.edges[0][0][0]);
    const off = edges.map((time, n) => time - (shape[n] - shape[0]));
    const most = off.reduce((most, by) => Math.max(most, Math.abs(by)), 0);
    const each = m.visits.filter(([, groups]) => groups).map(([cycles, groups]) => cycles / groups);
    console.log(`  ${m.groups} groups; off the closed form by ${(most / MICRO).toFixed(2)} µs at most, the last step ` +
      `by ${(off.at(-1) / MICRO).toFixed(3)} µs; a group costs ${median(each).toFixed(0)} cycles, ` +
      `${(m.busy / m.groups).toFixed(0)} on average; the interrupt takes ${(100 * m.busy / took).toFixed(1)} %, ` +
      `its longest visit ${Math.max(...m.visits.map(([cycles]) => cycles))} cycles`);
    assert(most <= MICRO, `${most} cycles off the closed form`);
    assert(Math.abs(off.at(-1)) <= 1, `the last step is ${off.at(-1)} cycles off`);
    assert(median(each) <= REFILL && m.busy / m.groups <= REFILL, 'what a group costs');
    if (wordsFile) {
      const dump = AXES.map((axis) => ({ words: m.words[axis].map(([, word]) => word), want: computed(m.words[axis], 0, MICRO) }));
      fs.writeFileSync(wordsFile, JSON.stringify({ code: [...m.pio.instructions].slice(0, 10), lists: dump }));
    }
  },

  'axes at 100,000 steps/s: what they take of the processor': () => {
    const m = begin();
    for (const axes of [AXES, [2]]) {
      for (const axis of axes) { m.limit(axis, 100_000, 700_000); assert.equal(m.ask(2, axis, 100_000), 0); }
      m.run(200_000 * MICRO);
      m.visits = []; m.busy = 0; m.groups = 0;
      m.run(100_000 * MICRO);
      const share = m.busy / (100_000 * MICRO);
      console.log(`  ${axes.length} of them: ${(100 * share).toFixed(2)} % of a core, ` +
        `${(m.busy / m.groups).toFixed(0)} cycles a group`);
      assert(share <= 0.15 && m.busy / m.groups <= REFILL);
      m.ask(12);
      m.rest();
    }
    assert.equal(m.ask(8), 0);
    for (const axis of AXES) assert.equal(m.ask(5, axis), m.net(axis));
    keeps(m);
  },

  [`${4 * rounds} halts at random moments: exact counts, no pulse cut`]: () => {
    const m = begin();
    const steps = () => m.edges.reduce((all, edges) => all + edges.length, 0);
    let positions = 0;
    m.base = AXES.map(() => 0);
    // Pulses of 1, 5 and 20 µs, so that many halts hit one, and their widths in cycles.
    for (const [micros, high] of [[1, 125], [5, 642], [20, 2565]]) {
      m.ask(14, micros * MICRO, MICRO, MICRO);
      m.widths = [[], [], [], []];
      for (let round = 0; round < rounds / 3; round++) {
        const zero = AXES.map((axis) => m.edges[axis].length);
        for (const axis of AXES) {
          const speed = Math.floor((1_000 + random(199_000)) / micros);
          m.limit(axis, speed, 600_000 + random(600_000));
          assert.equal(m.ask(2, axis, random(2) ? speed : -speed), 0, `round ${round}`);
        }
        m.run(300_000 + random(2_300_000));
        for (const axis of AXES) {
          const said = m.ask(5, axis);
          assert(Math.abs(said - m.net(axis, zero[axis]) - m.base[axis]) <= 1, `round ${round}: on the way`);
          positions++;
        }
        m.base = AXES.map((axis) => m.ask(3, axis));
        AXES.forEach((axis) => assert.equal(m.base[axis], m.net(axis), `round ${round}, axis ${axis}`));
      }
      m.run(100_000);
      AXES.forEach((axis) => assert.equal(m.base[axis], m.net(axis)));
      keeps(m, { high, longer: m.cut });
    }
    assert.equal(m.ask(8), 0);
    console.log(`  ${steps()} steps, ${m.cut} halts within a pulse, ${positions} positions asked on the way`);
    assert(rounds < 100 || steps() > 60 * rounds && m.cut >= rounds / 25);
  },

  [`${4 * rounds} soft stops at random moments: exact counts`]: () => {
    const m = begin();
    for (let round = 0; round < rounds; round++) {
      for (const axis of AXES) {
        const speed = 1_000 + random(random(4) ? 20_000 : 249_000);
        m.limit(axis, speed, 200_000 + random(500_000));
        assert.equal(m.ask(2, axis, random(2) ? speed : -speed), 0, `round ${round}`);
      }
      m.run(random(random(3) ? 800_000 : 4_000_000));
      for (const axis of AXES) m.ask(4, axis);
      m.rest();
      AXES.forEach((axis) => assert.equal(m.ask(5, axis), m.net(axis), `round ${round}, axis ${axis}`));
    }
    keeps(m);
    assert.equal(m.ask(8), 0);
  },

  'a main loop that is away for 5 ms runs nothing dry; one for 100 ms does, and is counted': () => {
    const m = begin();
    for (const axis of AXES) { m.limit(axis, 100_000, 700_000); assert.equal(m.ask(2, axis, 100_000), 0); }
    m.run(200_000 * MICRO);
    for (let n = 0; n < 5; n++) { m.ask(9, 5_000); m.run(20_000 * MICRO); }
    assert.equal(m.ask(8), 0);
    m.ask(9, 100_000);
    m.run(20_000 * MICRO);
    assert.equal(m.ask(8), 4);
    m.ask(12);
    m.rest();
    assert.equal(m.ask(8), 4);
    for (const axis of AXES) assert.equal(m.ask(5, axis), m.net(axis));
    keeps(m);
  },

  'a target that changes on the way, and pulses of 5 µs': () => {
    const m = begin();
    const high = 642; // at least the requested width, at most an eighth longer
    const times = { high, setup: 2_500, hold: 5_000, least: 1_250 };
    m.ask(14, 625, 2_500, 5_000);
    for (const axis of AXES) m.limit(axis, 50_000, 500_000);
    assert.equal(m.ask(1, 20_000, 300, 0, -7), 0);
    m.run(30_000 * MICRO);
    assert.equal(m.ask(11, 0, -100), 0);
    m.rest();
    assert.deepEqual(AXES.map((axis) => m.net(axis)), [-100, 300, 0, -7]);
    m.ask(1, 100, -300, 5, 7);
    m.rest();
    AXES.forEach((axis) => assert.equal(m.ask(5, axis), m.net(axis)));
    keeps(m, times);
    assert.equal(m.ask(8), 0);
  },
};

const only = process.argv[4];
let failed = 0;
for (const [name, run] of Object.entries(tests)) {
  if (only && !name.includes(only)) continue;
  const begun = Date.now();
  try {
    run();
    console.log(`ok ${name} (${((Date.now() - begun) / 1000).toFixed(1)} s)`);
  } catch (error) {
    failed++;
    console.log(`FAILED ${name}: ${error.stack.split('\n').slice(0, 6).join('\n')}`);
  }
}
process.exit(failed ? 1 : 0);
