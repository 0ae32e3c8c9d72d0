// Document functions shared by views.

export const by = (id) => document.getElementById(id);

/** An element with a text or parts, and a class or other properties. */
export function element(tag, inner = [], more = {}) {
  const made = document.createElement(tag);
  made.append(...[inner].flat());
  return Object.assign(made, typeof more === "string" ? { className: more } : more);
}

/** Loads something once; after a failure it is tried again when asked for. */
export function once(load) {
  let loaded;
  return () => (loaded ??= load().catch((error) => {
    loaded = null;
    throw error;
  }));
}

/** Formats numbers to `most` digits. */
export const formatter = (most) => new Intl.NumberFormat("en", { maximumSignificantDigits: most, useGrouping: false });

export const digits = (value, most) => formatter(most).format(value || 0).replace("-", "−");

/** Calls `look()` when a view opens, and at once if it is open. */
export function looked(view, look) {
  const act = () => location.hash === view && look();
  addEventListener("hashchange", act);
  act();
}

/** Highlights one of these rows, by number. */
export const choose = (rows, chosen) => [...rows].forEach((row, n) => {
  row.classList.toggle("chosen", n === chosen);
  row.querySelector("button").setAttribute("aria-pressed", n === chosen);
});

/** Saves a file. */
export function save(name, bytes, type = "text/plain") {
  const link = element("a", [], { href: URL.createObjectURL(new Blob([bytes], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Copies a text, and shows it there, in case the clipboard is closed. */
export async function copy(text, place) {
  place.textContent = text;
  place.hidden = false;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    getSelection().selectAllChildren(place);
  }
}
