// The conversation with a board: a line, its answer, and what to do when the answer does not come.
//
// A line that got no answer was lost, or its answer was; nobody knows which. So the session gets
// in step with the board again, and says once more what is harmless twice: a question, A, Z, K, I.

/** A board answers within milliseconds; in ms. */
const PATIENCE = 500;

/** A board that the opening of its port has reset passes its boot loader first; in ms. */
const BOOT = 4000;

/** How often a line is said before the board counts as silent. */
const TRIES = 4;

const MEANINGS = { yes: "accepted", no: "refused: nothing has changed", ready: "at rest", busy: "on its way", settings: "all settings and their numbers" };

/** The conversation can't go on. */
export class Lost extends Error {}

export class Session {
  /** `tell(line, answer, question)` hears all that is said. */
  constructor(host, wire, tell) {
    this.host = host;
    this.wire = wire;
    this.tell = tell;
    this.waiting = null;
    this.info = null;
    this.sums = false;
    this.selected = null;
    this.gone = null;
    wire.onbytes = (bytes) => bytes.forEach((byte) => this.hear(byte));
    wire.ongone = (error) => {
      this.gone ??= error;
      this.waiting?.fail(this.lost());
    };
  }

  lost() {
    return new Lost(`${this.wire.name}: ${this.gone ? `the line is gone (${this.gone.message})` : "the board does not answer"}`);
  }

  hear(byte) {
    const text = this.text;
    this.text = byte === 13 ? "" : byte === 10 ? text : (text + String.fromCharCode(byte)).slice(0, 1024);
    const answer = this.host.hear(byte);
    if (answer) this.waiting?.take({ ...answer, text });
  }

  /** Puts bytes on the line, and waits for what is answered; null if nothing is. */
  exchange(bytes) {
    if (this.gone) throw this.lost();
    this.text = "";
    return new Promise((take, fail) => {
      const end = (act) => (value) => {
        clearTimeout(timer);
        this.waiting = null;
        act(value);
      };
      const timer = setTimeout(() => end(take)(null), PATIENCE);
      this.waiting = { take: end(take), fail: end(fail) };
      this.wire.write(bytes);
    });
  }

  /** Says a line once. */
  async once(line) {
    const bytes = this.host.say(line);
    if (!bytes) throw new RangeError(`'${line}' is no line of the protocol`);
    const answer = await this.exchange(bytes);
    const said = new TextDecoder().decode(bytes).trimEnd();
    this.tell({
      line: said,
      means: this.host.meaning(said),
      answer: answer && answer.text,
      answer_means: answer ? this.means(answer) : "no answer",
      question: /^(F|V.*|\?|A.*)$/.test(line),
    });
    return answer;
  }

  means(answer) {
    if (answer.kind === "position") return `at ${answer.position} steps`;
    if (answer.kind === "info") return `what the board is${answer.info.last ? `; refused last: ${answer.info.last}` : ""}`;
    return MEANINGS[answer.kind];
  }

  /** Gets in step with the board again. What moves goes on. */
  async resync() {
    for (let i = 0; i < TRIES; i++) {
      if (await this.step()) return;
    }
    throw this.lost();
  }

  step() {
    this.selected = null;
    return this.exchange(this.host.resync());
  }

  /** Gets in step with the board, and asks what it is. */
  async meet() {
    const end = performance.now() + BOOT;
    this.host.useSums(false);
    const first = await this.once("F");
    if (!first || first.kind === "no") {
      while (!(await this.step())) {
        if (performance.now() > end) throw this.lost();
      }
    }
    for (let i = 0; i < 2 * TRIES && !this.info; i++) {
      const answer = await this.once("?");
      if (answer?.kind === "info") this.info = answer.info;
      // A board that knows no `?`: one axis.
      else if (answer) return;
      else await this.resync();
    }
    this.sums = Boolean(this.info?.can?.includes("sum"));
    this.host.useSums(this.sums);
  }

  /** Says a line until it is answered: only for one that is harmless twice. */
  async ask(line) {
    for (let i = 0; i < (line === "?" ? 2 * TRIES : TRIES); i++) {
      const answer = await this.once(line);
      if (!answer) await this.resync();
      else if (!(await this.damaged(line, answer))) return answer;
    }
    throw this.lost();
  }

  /** Whether it is the answer to a line that noise has changed on its way. */
  async damaged(line, answer) {
    if (!this.sums || answer.kind !== "no" || line === "?") return false;
    return (await this.why())?.refusal === "sum";
  }

  /** Why the last line was refused, and what else the board says of itself. */
  async why() {
    if (!this.info) return null;
    const answer = await this.ask("?");
    if (answer.kind === "info") this.info = answer.info;
    return this.info;
  }

  /** Has the next lines speak of this axis; 0: of all. */
  async select(axis) {
    if (!this.info || this.selected === axis) return;
    for (let i = 0; i < TRIES; i++) {
      if ((await this.ask(`A${axis}`)).kind === "yes") {
        this.selected = axis;
        return;
      }
    }
    throw this.lost();
  }

  /** Says a line that speaks of the selected axis. */
  async askOf(axis, line) {
    for (let i = 0; i < TRIES; i++) {
      await this.select(axis);
      const answer = await this.once(line);
      if (!answer) await this.resync();
      else if (!(await this.damaged(line, answer))) return answer;
    }
    throw this.lost();
  }

  async busy(axis) {
    for (let i = 0; i < TRIES; i++) {
      const { kind } = await this.askOf(axis, "F");
      if (kind === "ready" || kind === "busy") return kind === "busy";
    }
    throw this.lost();
  }

  /** Where an axis is; null if the board does not know. */
  async position(axis) {
    for (let i = 0; i < TRIES; i++) {
      const answer = await this.ask(`V${axis}`);
      if (answer.kind === "position") return answer.position;
      if (((await this.why())?.uncertain ?? 0) >> (axis - 1) & 1) return null;
    }
    return null;
  }

  /** Where an axis is that rests: said twice alike, for a digit may be lost on its way. */
  async restPosition(axis) {
    let last = await this.position(axis);
    for (let i = 0; i < TRIES; i++) {
      const again = await this.position(axis);
      if (again === last) return again;
      last = again;
    }
    throw this.lost();
  }

  /** Says the lines of an order, each after the Y of the one before: null, or what was answered
   *  to which. */
  async play(lines) {
    for (const line of lines) {
      // PO and A move the selection.
      this.selected = null;
      const answer = await this.once(line);
      if (answer?.kind !== "yes") return { line, answer };
    }
    return null;
  }
}
