// A serial port of the browser (WebSerial), as a wire.

/** Bits per second of the line. */
const BAUD = 115200;

export class SerialWire {
  /** A port that the browser has granted. */
  constructor(port) {
    this.port = port;
    const { usbVendorId, usbProductId } = port.getInfo();
    const hex = (number) => number.toString(16).padStart(4, "0");
    this.name = usbVendorId === undefined ? "the serial port" : `the serial port ${hex(usbVendorId)}:${hex(usbProductId)}`;
  }

  /** Opens the port, or another of its kind: a port plugged in again may differ. */
  async open() {
    const kind = (port) => JSON.stringify(port.getInfo());
    const others = (await navigator.serial.getPorts()).filter((port) => port !== this.port && kind(port) === kind(this.port));
    let failed;
    for (const port of [this.port, ...others]) {
      try {
        await port.open({ baudRate: BAUD });
        this.port = port;
        this.closing = false;
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
      // A framing error ends a stream; the port then has another.
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
    this.writer.write(bytes).catch((error) => this.closing || this.ongone(error));
  }

  /** A port without its device stays open until it is closed, though its streams ended. */
  async close() {
    this.closing = true;
    const ended = (promise) => promise?.catch(() => {});
    await ended(this.reader?.cancel());
    await ended(this.reading);
    this.writer?.releaseLock();
    await ended(this.port.close());
  }
}
