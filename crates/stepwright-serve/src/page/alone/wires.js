// Two lines to a board, which carry bytes and nothing else: to the virtual board in a worker, and
// to a serial port of the browser (WebSerial).
//
//   open() · write(bytes) · close() · onbytes(bytes) · ongone(error)

/** Bits per second of the line. */
const BAUD = 115200;

export class VirtualWire {
  /** From the bytes of the module. */
  constructor(module) {
    this.module = module;
    this.name = "the virtual board";
    this.asked = {};
  }

  async open() {
    this.worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.worker.onmessage = ({ data }) => {
      if (data.bytes) this.onbytes(data.bytes);
      // The worker answers in the order of the questions.
      for (const [name, value] of Object.entries(data)) this.asked[name]?.shift()?.(value);
    };
    const ready = this.answer("ready");
    this.worker.onerror = () => this.ongone(new Error("its worker has failed"));
    this.worker.postMessage({ module: this.module });
    await ready;
  }

  answer(name) {
    return new Promise((told) => (this.asked[name] ??= []).push(told));
  }

  write(bytes) {
    this.worker.postMessage({ bytes });
  }

  /** The edges of the last seconds, as GET /api/scope has them. */
  scope(seconds) {
    const record = this.answer("record");
    this.worker.postMessage({ scope: seconds });
    return record;
  }

  /** Steps that its shafts have made, counted at the pins. */
  shafts() {
    const shafts = this.answer("shafts");
    this.worker.postMessage({ shafts: true });
    return shafts;
  }

  async close() {
    this.worker.terminate();
  }
}

export class SerialWire {
  /** A port that the browser has granted. */
  constructor(port) {
    this.port = port;
    const { usbVendorId, usbProductId } = port.getInfo();
    const hex = (number) => number.toString(16).padStart(4, "0");
    this.name = usbVendorId === undefined ? "the serial port" : `the serial port ${hex(usbVendorId)}:${hex(usbProductId)}`;
  }

  /** Opens the port; one that was plugged in again may be another of the same kind. */
  async open() {
    const kind = (port) => JSON.stringify(port.getInfo());
    const others = (await navigator.serial.getPorts()).filter((port) => port !== this.port && kind(port) === kind(this.port));
    let failed;
    for (const port of [this.port, ...others]) {
      try {
        await port.open({ baudRate: BAUD });
        this.port = port;
        this.writer = port.writable.getWriter();
        this.reading = this.read();
        return;
      } catch (error) {
        failed ??= error;
      }
    }
    throw failed;
  }

  async read() {
    const { port } = this;
    let error = new Error("the port was closed");
    try {
      // An error of framing ends a stream, and the port has another one.
      while (port.readable && !this.closing) {
        this.reader = port.readable.getReader();
        try {
          for (;;) {
            const { value, done } = await this.reader.read();
            if (done) break;
            this.onbytes(value);
          }
        } catch (broken) {
          error = broken;
        } finally {
          this.reader.releaseLock();
        }
      }
    } finally {
      if (!this.closing) this.ongone(error);
    }
  }

  write(bytes) {
    this.writer.write(bytes).catch((error) => this.ongone(error));
  }

  async close() {
    this.closing = true;
    try {
      await this.reader?.cancel();
      await this.reading;
      this.writer?.releaseLock();
      await this.port.close();
    } catch {
      // It is gone already.
    }
    this.closing = false;
  }
}
