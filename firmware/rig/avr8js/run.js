// Runs a firmware of the Uno on avr8js, and prints the changes of its pins and its output.
//
//   node run.js FIRMWARE.hex MILLISECONDS PIN...      PIN: B4, a port and a bit
//
// A line of JSON on stdout: {"changes": [[cycle, index of the pin, level], ...], "said": "..."}
"use strict";

const { readFileSync } = require("node:fs");
const avr = require("avr8js");

const HZ = 16_000_000;
const FLASH = 32_768;
// An interrupt's entry takes 4 cycles on the chip, and 2 in avr8js.
const ENTRY = 2;
// LPM within 3 cycles after SPMCSR = BLBSET | SPMEN reads fuses and lock bits: low fuse,
// lock, extended and high fuse. avr8js leaves them out; these are an Uno's.
const SPMCSR = 0x57;
const READS_FUSES = 0x09;
const FUSES = [0xff, 0x0f, 0x05, 0xde];

/** Intel's format: `:` length, address, kind, bytes, sum; kind 0 is data. */
function flash(file) {
  const memory = new Uint8Array(FLASH);
  for (const line of readFileSync(file, "ascii").split(/\r?\n/)) {
    const bytes = Buffer.from(line.slice(1), "hex");
    if (line[0] === ":" && bytes[3] === 0) {
      memory.set(bytes.subarray(4, 4 + bytes[0]), bytes.readUInt16BE(1));
    }
  }
  return new Uint16Array(memory.buffer);
}

const [file, millis, ...pins] = process.argv.slice(2);
const cpu = new avr.CPU(flash(file), 2_048);
for (const timer of ["timer0Config", "timer1Config", "timer2Config"]) {
  new avr.AVRTimer(cpu, avr[timer]);
}
const ports = Object.fromEntries(
  ["B", "C", "D"].map((name) => [name, new avr.AVRIOPort(cpu, avr[`port${name}Config`])]),
);

const changes = [];
pins.forEach((pin, which) => {
  const [port, bit] = [ports[pin[0]], Number(pin[1])];
  let high = false;
  port.addListener(() => {
    if ((port.pinState(bit) === avr.PinState.High) !== high) {
      high = !high;
      changes.push([cpu.cycles, which, high]);
    }
  });
});

let said = "";
const usart = new avr.AVRUSART(cpu, avr.usart0Config, HZ);
usart.onByteTransmit = (byte) => {
  said += String.fromCharCode(byte);
};

let fusesUntil = 0;
cpu.writeHooks[SPMCSR] = (value) => {
  fusesUntil = (value & READS_FUSES) === READS_FUSES ? cpu.cycles + 3 : 0;
};

/** Executes an instruction, and handles the interrupts that are due. */
function step() {
  if (cpu.cycles < fusesUntil) {
    const flash = cpu.progBytes.slice(0, 4);
    cpu.progBytes.set(FUSES);
    avr.avrInstruction(cpu);
    cpu.progBytes.set(flash);
  } else {
    avr.avrInstruction(cpu);
  }
  const next = cpu.pc;
  cpu.tick();
  if (cpu.pc !== next) {
    cpu.cycles += ENTRY;
  }
}

const end = (Number(millis) * HZ) / 1_000;
while (cpu.cycles < end) {
  step();
}
process.stdout.write(`${JSON.stringify({ changes, said })}\n`);
