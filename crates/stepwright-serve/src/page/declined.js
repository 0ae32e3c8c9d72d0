// A request that was declined. Nothing here knows a page: Node has it as well.

/** What was wrong, what is allowed, what to do. */
export class Declined extends Error {
  constructor(body, status) {
    const parts = [body.what, body.allowed && `Allowed: ${body.allowed}`, body.do];
    super(parts.filter(Boolean).join(". "));
    this.status = status;
  }
}
