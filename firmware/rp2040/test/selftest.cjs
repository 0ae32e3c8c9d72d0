// The self-test of a Pico: node selftest.cjs FOLDER-OF-ELVES FILE. Writes its line to the file, for the command.
'use strict';
const assert = require('assert');
const fs = require('fs');
const path = require('path');
const { Machine } = require('./machine.cjs');

const AXES = [0, 1, 2, 3];
const SECOND = 125e6;

/// Runs the self-test, and returns its first line and the machine. `spoil` may change the machine first.
function line(spoil) {
  const m = new Machine(path.join(process.argv[2], 'rp2040-selftest.elf'));
  let heard = '';
  m.chip.uart[0].onByte = (byte) => { heard += String.fromCharCode(byte); };
  if (spoil) spoil(m);
  while (!heard.includes('\r')) {
    m.run(100_000);
    assert(m.time < 5 * SECOND, 'the self-test says nothing');
  }
  return [heard.split('\r')[0], m];
}

/// The CRC-32 as in zlib, as eight hexadecimal digits.
function crc32(bytes) {
  let crc = ~0;
  for (const byte of bytes) {
    crc ^= byte;
    for (let n = 0; n < 8; n++) crc = crc >>> 1 ^ (crc & 1 ? 0xedb88320 : 0);
  }
  return (~crc >>> 0).toString(16).padStart(8, '0');
}

/// The value of a word of the line.
const word = (said, name) => said.match(new RegExp(` ${name}=([^ ]+)`))[1];

const [said, m] = line();
console.log(said);
const edges = AXES.map((axis) => m.edges[axis].length);
assert.equal(Number(word(said, 'edges')), edges.reduce((all, some) => all + some), 'the edges on the pins');
assert(edges.every((some) => some > 0), `${edges}`);
assert.equal(word(said, 'khz'), '125000');
// The reported checksum of the program matches the file.
assert.equal(word(said, 'firmware').split('-').at(-1), crc32(m.program), 'what is in the flash');
fs.writeFileSync(process.argv[3], `${said}\n`);
console.log('ok the self-test says what is seen on its pins');

// It captures the real pins: the fifth pulse of the second axis is kept from its pin, and is reported missing.
const [missing] = line((m) => {
  const plain = m.pin.bind(m);
  let [rises, cut] = [0, false];
  m.pin = (which, level) => {
    if (which === 3) {
      if (!level) cut = false;
      else if (!m.pins[3] && !cut) cut = ++rises === 5;
    }
    plain(which, which === 3 && cut ? 0 : level);
  };
});
assert.equal(Number(word(missing, 'edges')), Number(word(said, 'edges')) - 1);
assert.equal(word(missing, 'plan'), word(said, 'plan'));
fs.writeFileSync(`${process.argv[3]}.spoilt`, `${missing}\n`);
console.log('ok an edge that does not come is missed');
