// Checks the answers of the Pico's controller against the protocol: node controller.cjs FOLDER-OF-ELVES
'use strict';
const assert = require('assert');
const path = require('path');
const { USBCDC } = require('rp2040js');
const { Machine } = require('./machine.cjs');

const BYTE = Math.round(125e6 / 11_520);

// Bits of CHIP_RESET: the cause of the last reset.
const POWER = 1 << 8;
const RUN = 1 << 16;

class Controller extends Machine {
  /// `reset` is the cause of the reset that the chip reports, `ram` the RAM's content before it.
  constructor(folder, overUsb, reset = POWER, ram = undefined) {
    super(path.join(folder, 'rp2040-controller.elf'));
    // rp2040js has no such peripheral, and reads it as ones.
    this.chip.peripherals[0x40064].readUint32 = (offset) => offset === 8 ? reset : 0;
    if (ram) this.chip.sram.set(ram);
    this.heard = '';
    if (overUsb) {
      // A host that enumerates the device and opens its port.
      this.host = new USBCDC(this.chip.usbCtrl);
      this.chip.usbCtrl.onEndpointRead = (endpoint, size) => {
        if (endpoint !== 0 && endpoint === this.host.outEndpoint) this.waits = true;
      };
      this.host.onDeviceConnected = () => { this.open = true; };
      this.host.onSerialData = (bytes) => { this.heard += String.fromCharCode(...bytes); };
    }
    this.chip.uart[0].onByte = (byte) => { this.heard += String.fromCharCode(byte); };
    // Switches, emergency stop and fault outputs are pulled up.
    for (const pin of [11, 12, 13, 14, 15]) this.chip.gpio[pin].setInputValue(true);
    this.run(200_000);
    while (overUsb && !this.open) {
      this.run(10_000);
      assert(this.time < 50e6, 'the host sees no port');
    }
    this.run(200_000);
  }

  /// Sends a line, and returns the answer.
  say(line) {
    this.heard = '';
    if (this.host) this.hears(`${line}\r`);
    else {
      for (const byte of `${line}\r`) {
        this.chip.uart[0].feedByte(byte.charCodeAt(0));
        this.run(BYTE);
      }
    }
    const end = this.time + 20e6;
    while (!this.heard.includes('\r')) {
      this.run(1_000);
      assert(this.time < end, `no answer to ${line}`);
    }
    return this.heard.replace(/\r[^]*/, '');
  }

  /// Sends a packet over USB. The host of rp2040js sends only when a buffer becomes ready.
  hears(text) {
    const { host } = this;
    for (let left = 1e6; !this.waits; left--) { this.step(); assert(left, 'the port takes nothing'); }
    this.waits = false;
    host.usb.endpointReadDone(host.outEndpoint, Uint8Array.from(text, (c) => c.charCodeAt(0)));
  }

  rest() {
    this.say('A0');
    while (this.say('F') !== 'R') this.run(200_000);
    this.say('A1');
  }

  /// Plays a table of lines and their answers, with `*` for any characters. `*rest` waits for the travel's end.
  talk(table) {
    for (const row of table.trim().split('\n').map((row) => row.trim())) {
      const [line, ...answer] = row.split(/ +/);
      if (line === '*rest') { this.rest(); continue; }
      const pattern = answer.join(' ').split('*').map((part) => part.replace(/[.*+?^${}()|[\]\\]/g, '\\$&')).join('.*');
      const heard = this.say(line);
      assert(new RegExp(`^${pattern}$`, 's').test(heard), `${row}: ${heard}`);
    }
    return [0, 1, 2].map((axis) => this.net(axis));
  }
}

// The conversations of firmware/qemu/tests/conversation.rs.
const conversations = {
  'the travel order of the document': [`
    F R
    PO Y
    S5 Y
    T100 Y
    R200 Y
    G+400 Y
    E Y
    F B
    *rest
    V1 400
    P0 Y
    G-1234 Y
    E Y
    *rest
    V1 -834`, [-834, 0, 0]],
  'while busy no line of an order is taken': [`
    g+ Y
    PO E
    S5 E
    G+5 E
    E E
    I1 E
    F B
    A1 Y
    ? stepwright * last=busy uncertain=0*
    ! Y
    Z Y
    K Y
    F R
    V1 E
    I1 Y
    V1 0`],
  'drive until stopped': [`
    T50 Y
    g- Y
    F B
    Z Y
    *rest
    F R
    V1 -*`],
  'what cannot be is refused and nothing moves': [`
    E E
    PO Y
    T1000 E
    G+4000 Y
    E E
    ? stepwright * last=range uncertain=0*
    PO Y
    t1000000 Y
    a100000000 Y
    d100000000 Y
    G+50000 Y
    E E
    ? stepwright * last=too-fast uncertain=0*
    G+-5 E
    V9 E
    12345678901234567 E
    F R`, [0, 0, 0]],
  'settings; an axis turns the other way round': [`
    $ max-speed=1000000 * pulse-us=2 reverse=0 *
    $pulse-us=7 Y
    $reverse=2 Y
    $max-speed=300 Y
    $ max-speed=300 * pulse-us=7 reverse=2 *
    PO Y
    t301 Y
    G+10 Y
    E E
    PO Y
    t300 Y
    G+10 Y
    A2 Y
    t200 Y
    G-20 Y
    E Y
    *rest
    V1 10
    V2 -20`],
  'three axes with ramps': [`
    A0 Y
    PO Y
    A1 Y
    t20000 Y
    a200000 Y
    d90000 Y
    G+3000 Y
    A2 Y
    t5000 Y
    a30000 Y
    d30000 Y
    G-1500 Y
    A3 Y
    t1000 Y
    a4000 Y
    d4000 Y
    j50000 Y
    G+100 Y
    E Y
    *rest
    V1 3000
    V2 -1500
    V3 100
    ? * late=0 *`, [3000, -1500, 100]],
};

let failed = 0;
for (const line of ['UART', 'USB']) {
  for (const [name, [table, net]] of Object.entries(conversations)) {
    try {
      const board = new Controller(process.argv[2], line === 'USB');
      const made = board.talk(table);
      if (net) assert.deepEqual(made, net);
      console.log(`ok ${name}, by ${line}`);
    } catch (error) {
      failed++;
      console.log(`FAILED ${name}, by ${line}: ${error.message}`);
    }
  }
}
try {
  // When the port closes, the UART takes over the line; when it opens again, the port does.
  const board = new Controller(process.argv[2], true);
  const { host } = board;
  assert.equal(board.say('F'), 'R');
  for (let n = 0; n < 3; n++) {
    host.cdcSetControlLineState(0);
    board.run(100_000);
    board.host = undefined;
    assert.match(board.say('?'), /^stepwright /);
    host.cdcSetControlLineState(1);
    board.run(100_000);
    board.host = host;
    assert.equal(board.say('F'), 'R');
  }
  // The same for a suspended bus, whether its bit is a state, as in rp2040js, or a latch that a 1 clears.
  const [SIE_STATUS, SUSPENDED] = [0x50, 1 << 4];
  const { usbCtrl } = board.chip;
  const write = usbCtrl.writeUint32.bind(usbCtrl);
  for (const latch of [false, true]) {
    usbCtrl.sieStatus |= SUSPENDED;
    usbCtrl.writeUint32 = (offset, value) => {
      write(offset, value);
      if (latch && offset === SIE_STATUS) usbCtrl.sieStatus &= ~(value & SUSPENDED);
    };
    board.run(100_000);
    board.host = undefined;
    assert.match(board.say('?'), /^stepwright /);
    if (!latch) usbCtrl.sieStatus &= ~SUSPENDED;
    board.host = host;
    assert.equal(board.say('F'), 'R');
  }
  // An answer of a packet's length or more arrives whole.
  assert.match(board.say('$'), /^max-speed=.* pulse-us=/);
  console.log('ok the line is that of the port while it is open');
} catch (error) {
  failed++;
  console.log(`FAILED the line is that of the port while it is open: ${error.message}`);
}
try {
  // Requests of a host according to USB 2.0, 9.4. Words in the memory shared with the controller: the buffers
  // of the control pipe and of data, sent and received.
  const [CONTROL_IN, DATA_IN, DATA_OUT] = [0x80, 0x90, 0x94];
  const [AVAILABLE, STALL, DATA_1] = [1 << 10, 1 << 11, 1 << 13];
  const board = new Controller(process.argv[2], true);
  const { host, chip: { usbCtrl, usbDPRAMView } } = board;
  const word = (offset) => usbDPRAMView.getUint32(offset, true);
  const onWrite = usbCtrl.onEndpointWrite;
  let answer;
  usbCtrl.onEndpointWrite = (endpoint, bytes) => { if (endpoint === 0) answer = [...bytes]; onWrite(endpoint, bytes); };
  const ask = (...setup) => {
    answer = undefined;
    usbCtrl.sendSetupPacket(Uint8Array.from(setup));
    board.run(100_000);
    return word(CONTROL_IN) & STALL ? 'stall' : answer;
  };
  // Whether the packets are DATA1 for which the device makes its buffers available.
  const toggles = { [DATA_IN]: [], [DATA_OUT]: [] };
  const updated = usbCtrl.DPRAMUpdated.bind(usbCtrl);
  usbCtrl.DPRAMUpdated = (offset, value) => {
    if (value & AVAILABLE) toggles[offset]?.push(Boolean(value & DATA_1));
    updated(offset, value);
  };
  const CLEAR_HALT = [0x02, 1, 0, 0];
  assert.deepEqual(ask(0x80, 8, 0, 0, 0, 0, 1, 0), [1], 'it is configured');
  for (const asked of [1, 2, 1]) {
    for (let n = 0; n < asked; n++) board.say('F');
    toggles[DATA_IN] = [];
    toggles[DATA_OUT] = [];
    for (const end of [0x02, 0x82]) assert.deepEqual(ask(...CLEAR_HALT, end, 0, 0, 0), [], `CLEAR_FEATURE of ${end}`);
    assert.deepEqual(toggles[DATA_OUT], [false], 'the next packet of the host is DATA0');
    assert.equal(board.say('F'), 'R');
    board.run(100_000);
    for (const of of [DATA_IN, DATA_OUT]) {
      assert(toggles[of].length > 0 && toggles[of].every((data1, n) => data1 === (n % 2 === 1)), `${of}: ${toggles[of]}`);
    }
  }
  assert.equal(ask(...CLEAR_HALT, 0x05, 0, 0, 0), 'stall', 'no such endpoint');
  assert.equal(ask(0x00, 9, 2, 0, 0, 0, 0, 0), 'stall', 'no such configuration');
  // Without a configuration there is no port: the UART has the line.
  assert.deepEqual(ask(0x00, 9, 0, 0, 0, 0, 0, 0), []);
  assert.deepEqual(ask(0x80, 8, 0, 0, 0, 0, 1, 0), [0]);
  assert.deepEqual([word(DATA_IN), word(DATA_OUT)], [0, 0], 'no packet waits');
  board.host = undefined;
  board.waits = false;
  assert.match(board.say('?'), /^stepwright /);
  board.host = host;
  assert.deepEqual(ask(0x00, 9, 1, 0, 0, 0, 0, 0), []);
  board.host = undefined;
  assert.match(board.say('?'), /^stepwright /, 'the port is not open yet');
  host.cdcSetControlLineState(1);
  board.run(100_000);
  board.host = host;
  assert.equal(board.say('F'), 'R');
  console.log('ok requests of a host');
} catch (error) {
  failed++;
  console.log(`FAILED requests of a host: ${error.message}`);
}
// docs/safety.md, "After a reset".
for (const [name, reset, moved, known] of [
  ['power-up', POWER, true, true],
  ['the button', RUN, true, false],
  ['the button before anything has moved', RUN, false, true],
]) {
  try {
    const board = new Controller(process.argv[2], false);
    if (moved) board.talk(conversations['the travel order of the document'][0]);
    const again = new Controller(process.argv[2], false, reset, board.chip.sram);
    assert.equal(again.say('V1'), known ? '0' : 'E');
    assert.match(again.say('?'), known ? / uncertain=0/ : / uncertain=[^0]/);
    console.log(`ok the position after a reset: ${name}`);
  } catch (error) {
    failed++;
    console.log(`FAILED the position after a reset: ${name}: ${error.message}`);
  }
}
process.exit(failed ? 1 : 0);
