// A refused request. Nothing here depends on a page: Node uses it too.

/** The reason, what is allowed, the remedy. */
export class Declined extends Error {
  constructor(body, status) {
    const parts = [body.what, body.allowed && `Allowed: ${body.allowed}`, body.do];
    super(parts.filter(Boolean).join(". "));
    this.status = status;
  }
}
