// An RP2040 in rp2040js, whose PIO runs in lock-step with the processor, cycle by cycle. rp2040js itself steps
// the state machines independently, one instruction at a time, without joined FIFOs and without refilling
// the output register ahead; here both work as in the datasheet.
'use strict';
const fs = require('fs');
const { RP2040 } = require('rp2040js');

const AUTOPULL = 1 << 17;
const TEST = 0x20040000; // the last 8 KB of the RAM

class Machine {
  constructor(elf) {
    const chip = (this.chip = new RP2040());
    const complain = (...words) => { throw new Error(words.join(' ')); };
    chip.logger = { debug() {}, info() {}, warn() {}, error: complain };
    this.program = this.load(fs.readFileSync(elf));
    this.pio = chip.pio[0];
    this.pio.run = () => {};
    this.now = 0;
    this.pins = new Array(32).fill(0);
    this.edges = [[], [], [], []]; // edges of STEP: [time, level of DIR]
    this.turns = [[], [], [], []]; // edges of DIR: [time, level]
    this.widths = [[], [], [], []]; // widths of STEP's pulses
    this.words = [[], [], [], []]; // words put into the FIFO since the last start: [time, word]
    this.starts = [0, 0, 0, 0];
    this.stopped = [[], [], [], []];
    this.groups = 0;
    this.cut = 0; // halts while STEP was high
    this.busy = 0; // cycles in the PIO's interrupt, including entry and exit
    this.visits = [];
    const changed = this.pio.pinValuesChanged.bind(this.pio);
    this.pio.pinValuesChanged = (value, first, count) => {
      changed(value, first, count);
      for (let n = 0; n < count; n++) this.pin(first + n, value >> n & 1);
    };
    // The PIO catches up before each access by the processor.
    this.wake = 0;
    for (const name of ['readUint32', 'writeUint32']) {
      const plain = this.pio[name].bind(this.pio);
      this.pio[name] = (...words) => {
        this.follow(chip.core.cycles);
        this.now = chip.core.cycles;
        const answer = plain(...words);
        this.wake = 0;
        return answer;
      };
    }
    this.pio.machines.forEach((m, axis) => this.asInTheDatasheet(m, axis));
    // The other PIO, whose first machine may watch the pins of this one.
    const other = (this.other = chip.pio[1]);
    other.run = () => {};
    for (const name of ['readUint32', 'writeUint32']) {
      const plain = other[name].bind(other);
      other[name] = (...words) => {
        this.follow(chip.core.cycles);
        const answer = plain(...words);
        this.wake = 0;
        return answer;
      };
    }
    // rp2040js does not update the input of an output pin.
    const [watcher] = other.machines;
    const condition = watcher.jmpCondition.bind(watcher);
    watcher.jmpCondition = (which) => which === 6 ? this.pins[watcher.jmpPin] === 1 : condition(which);
    const core = chip.core;
    core.VTOR = 0x10000100;
    core.SP = chip.readUint32(core.VTOR);
    core.PC = chip.readUint32(core.VTOR + 4) & ~1;
  }

  load(elf) {
    const at = elf.readUInt32LE(28);
    let end = 0;
    for (let n = 0; n < elf.readUInt16LE(44); n++) {
      const head = at + 32 * n;
      const [type, offset, , to, size] = [0, 4, 8, 12, 16].map((k) => elf.readUInt32LE(head + k));
      if (type === 1 && size) {
        this.chip.flash.set(elf.subarray(offset, offset + size), to - 0x10000000);
        end = Math.max(end, to - 0x10000000 + size);
      }
    }
    // After the second stage of the boot loader.
    return this.chip.flash.subarray(0x100, end);
  }

  pin(pin, level) {
    if (this.pins[pin] === level) return;
    this.watch(this.now);
    this.pins[pin] = level;
    if (pin >= 2 && pin < 6) {
      const axis = pin - 2;
      if (level) this.edges[axis].push([this.now, this.pins[6 + axis]]);
      else this.widths[axis].push(this.now - this.edges[axis].at(-1)[0]);
    } else if (pin >= 6 && pin < 10) this.turns[pin - 6].push([this.now, level]);
  }

  asInTheDatasheet(m, axis) {
    const FIFO = m.txFIFO.constructor;
    const write = m.writeUint32.bind(m);
    m.writeUint32 = (offset, value) => {
      // A change of FJOIN clears the FIFOs.
      if (offset === 8 && (value ^ m.shiftCtrl) >>> 30) {
        const joined = value >>> 30 & 1;
        m.txFIFO = new FIFO(joined ? 8 : 4);
        m.rxFIFO = new FIFO(joined ? 0 : 4);
      }
      write(offset, value);
    };
    const restart = m.restart.bind(m);
    m.restart = () => { const { cycles } = m; restart(); m.cycles = cycles; };
    const put = m.writeFIFO.bind(m);
    m.writeFIFO = (value) => {
      if (m.txFIFO.full) throw new Error(`axis ${axis}: its FIFO is full`);
      this.words[axis].push([this.chip.core.cycles, value]);
      this.groups += 0.5;
      this.now = this.chip.core.cycles; // a waiting machine goes on at once
      put(value);
    };
    // A start begins a new list of words: the earlier ones are no longer in the FIFO.
    let enabled = false;
    Object.defineProperty(m, 'enabled', {
      get: () => enabled,
      set: (on) => {
        if (on && !enabled) {
          this.starts[axis] = m.cycles;
          this.stopped[axis] = [];
        }
        if (!on && enabled) {
          if (this.pins[2 + axis]) this.cut++;
          this.stopped[axis] = this.words[axis];
          this.words[axis] = [];
        }
        enabled = on;
      },
    });
  }

  /// Lets the other PIO's first machine catch up: the watched pin has not changed since the last call. A
  /// change of a pin reaches the machine two cycles later, after the synchroniser.
  watch(time) {
    const [m] = this.other.machines;
    if (!m.enabled) { m.cycles = time; return; }
    const code = this.other.instructions;
    const until = time + 2;
    while (m.cycles < until) {
      const level = this.pins[m.jmpPin] === 1;
      // A loop of two instructions that count X and test the pin: all but its last rounds at once.
      const [op, next] = [code[m.pc], code[m.pc + 1]];
      const low = !level && op === (0x40 | m.pc + 1) && next >>> 5 === 6 && m.wrapTop === m.pc + 1 && m.wrapBottom === m.pc;
      const high = level && op >>> 5 === 6 && code[op & 31] === (0x40 | m.pc);
      const times = low || high ? Math.floor((until - m.cycles) / 2) - 1 : 0;
      if (times > 0 && m.x > times) {
        m.x -= times;
        m.cycles += 2 * times;
        continue;
      }
      m.step();
    }
  }

  /// Lets the machines catch up with the processor. Until `wake` they only count down.
  follow(time) {
    const { instructions } = this.pio;
    this.wake = Infinity;
    for (const m of this.pio.machines) {
      if (!m.enabled || m.waiting) { m.cycles = time; continue; }
      while (m.cycles < time && !m.waiting) {
        const op = instructions[m.pc];
        // An instruction that counts X down and jumps to itself.
        if ((op & 0xe0ff) === (0x40 | m.pc) && m.x > 1) {
          const each = 1 + (op >> 8 & 15);
          const jumps = Math.min(m.x - 1, Math.floor((time - m.cycles) / each));
          if (jumps > 0) {
            m.x -= jumps;
            m.cycles += jumps * each;
            continue;
          }
        }
        const empty = m.shiftCtrl & AUTOPULL && m.outputShiftCount >= 32;
        if (op >>> 13 === 3 && empty && !m.txFIFO.empty) {
          // The register is refilled first, and OUT waits for that.
          this.fill(m);
          m.cycles++;
          continue;
        }
        this.now = m.cycles;
        m.step();
        if (!m.waiting && m.outputShiftCount >= 32 && !m.txFIFO.empty) this.fill(m);
      }
      if (m.waiting) continue;
      const op = instructions[m.pc];
      const counts = (op & 0xe0ff) === (0x40 | m.pc) && m.x > 1;
      const wake = m.cycles + (counts ? (m.x - 1) * (1 + (op >> 8 & 15)) : 0);
      if (wake < this.wake) this.wake = wake;
    }
  }

  fill(m) {
    m.outputShiftReg = m.txFIFO.pull();
    m.outputShiftCount = 0;
    this.pio.checkInterrupts();
  }

  /// Executes an instruction of the processor.
  step() {
    const { core, clock } = this.chip;
    const before = core.cycles;
    const inside = core.IPSR === 16 + 7;
    core.executeInstruction();
    if (core.waiting) core.cycles++;
    const took = core.cycles - before;
    const within = core.IPSR === 16 + 7;
    if (inside || within) {
      if (!inside) this.entered = [before, this.groups];
      if (!within) {
        // Entry and exit are 15 cycles each, which rp2040js leaves out.
        const all = core.cycles - this.entered[0] + 30;
        this.busy += all;
        this.visits.push([all, this.groups - this.entered[1]]);
      }
    }
    clock.tick(took * 8);
    if (core.cycles > this.wake) this.follow(core.cycles);
  }

  get time() { return this.chip.core.cycles; }

  run(cycles) {
    const end = this.time + cycles;
    while (this.time < end) this.step();
  }

  /// Gives the trial's main loop an order, and returns its answer.
  ask(order, ...numbers) {
    numbers.forEach((number, n) => this.chip.writeUint32(TEST + 4 * (n + 1), number >>> 0));
    this.chip.writeUint32(TEST, order);
    const end = this.time + 1e9;
    while (this.chip.readUint32(TEST) !== 0) {
      this.step();
      if (this.time > end) throw new Error(`order ${order} has no end`);
    }
    return this.chip.readUint32(TEST + 32) | 0;
  }

  /// The steps of an axis, forward minus backward, from its edge `from` on.
  net(axis, from = 0) {
    let net = 0;
    const edges = this.edges[axis];
    for (let n = from; n < edges.length; n++) net += edges[n][1] ? 1 : -1;
    return net;
  }
}

module.exports = { Machine };
