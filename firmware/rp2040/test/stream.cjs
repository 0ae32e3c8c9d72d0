// The player of streamed runs, for a host: node stream.cjs FOLDER-OF-ELVES [PORT [CLOCK]]
//
// Without a port, a test controls the time by lines on stdin: `b HEX` sends a byte to the UART; `i PIN LEVEL`
// sets an input; `u N` runs until N sixteenths of a µs since the beginning. The answer to `u` is a line: the
// bytes that the player has sent since, in hexadecimal, `|`, the edges, `TIME AXIS PIN LEVEL` separated by
// commas, `|`, and those of the laser, `TIME LEVEL`.
//
// With a port, it is a board at a TCP port. Its simulated time passes more slowly than real time; the file CLOCK
// holds it, in ns, as 8 bytes. When the connection is closed, it prints what it did, and ends.
'use strict';
const fs = require('fs');
const net = require('net');
const path = require('path');
const { GPIOPinState } = require('rp2040js');
const { Machine } = require('./machine.cjs');

const UNIT = 125 / 16;
// The cycles of a byte at 115,200 baud.
const BYTE = Math.round(125e6 / 11_520);
const [, , folder, port, clock] = process.argv;

const m = new Machine(path.join(folder, 'rp2040-stream.elf'));
let said = [];
m.chip.uart[0].onByte = (byte) => said.push(byte);
// Switches, emergency stop and fault outputs are pulled up.
for (const pin of [11, 12, 13, 14, 15]) m.chip.gpio[pin].setInputValue(true);
let pulses = [];
m.chip.gpio[16].addListener((state, before) => {
  if (state === GPIOPinState.High || before === GPIOPinState.High) {
    pulses.push(`${Math.round(m.time / UNIT)} ${state === GPIOPinState.High ? 1 : 0}`);
  }
});
m.run(2_000_000);

const seen = [[0, 0], [0, 0], [0, 0]];
function edges() {
  const all = [];
  for (let axis = 0; axis < 3; axis++) {
    const [steps, turns] = seen[axis];
    for (const [time, level] of m.turns[axis].slice(turns)) all.push([time, axis, 'd', level]);
    for (const [time] of m.edges[axis].slice(steps)) all.push([time, axis, 's', 1]);
    seen[axis] = [m.edges[axis].length, m.turns[axis].length];
  }
  // DIR first if both change in the same cycle.
  all.sort((a, b) => a[0] - b[0] || (a[2] === 'd' ? -1 : 1));
  return all.map(([time, ...rest]) => [Math.round(time / UNIT), ...rest].join(' ')).join(',');
}

function lockStep() {
  const buffer = Buffer.alloc(65536);
  let text = '';
  for (;;) {
    const count = fs.readSync(0, buffer);
    if (!count) return;
    text += buffer.toString('latin1', 0, count);
    const lines = text.split('\n');
    text = lines.pop();
    for (const line of lines) {
      const [what, value, level] = line.split(' ');
      if (what === 'b') m.chip.uart[0].feedByte(parseInt(value, 16));
      else if (what === 'i') m.chip.gpio[Number(value)].setInputValue(level === '1');
      else {
        const end = Number(value) * UNIT;
        if (end > m.time) m.run(end - m.time);
        fs.writeSync(1, `${Buffer.from(said).toString('hex')}|${edges()}|${pulses.join(',')}\n`);
        [said, pulses] = [[], []];
      }
    }
  }
}

function overTcp() {
  const file = clock && fs.openSync(clock, 'r+');
  const now = Buffer.alloc(8);
  const server = net.createServer((socket) => {
    const queue = [];
    socket.setNoDelay(true);
    socket.on('data', (bytes) => queue.push(...bytes));
    const [begun, from] = [Date.now(), m.time];
    let open = true;
    socket.on('close', () => { open = false; });
    socket.on('error', () => {});
    const go = () => {
      if (!open) {
        const [took, own] = [(Date.now() - begun) / 1e3, (m.time - from) / 125e6];
        const first = Math.min(...m.edges.map((edges) => edges.length ? edges[0][0] : Infinity));
        const last = Math.max(...m.edges.map((edges) => edges.length ? edges.at(-1)[0] : 0));
        console.log(JSON.stringify({
          seconds: (last - first) / 125e6,
          position: [0, 1, 2].map((axis) => m.net(axis)),
          steps: m.edges.reduce((all, edges) => all + edges.length, 0),
          slower: took / own,
        }));
        process.exit(0);
      }
      if (queue.length) m.chip.uart[0].feedByte(queue.shift());
      m.run(BYTE);
      if (file) {
        now.writeBigUInt64LE(BigInt(Math.round(m.time * 8)));
        fs.writeSync(file, now, 0, 8, 0);
      }
      if (said.length) socket.write(Buffer.from([said.shift()]));
      setImmediate(go);
    };
    go();
  });
  server.listen(Number(port), '127.0.0.1', () => console.log(`port ${server.address().port}`));
}

if (port === undefined) lockStep();
else overTcp();
