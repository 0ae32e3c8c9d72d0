// What several views do with the document.

export const by = (id) => document.getElementById(id);

/** An element with a text or with parts, and with a class or other properties. */
export function element(tag, inner = [], more = {}) {
  const made = document.createElement(tag);
  made.append(...[inner].flat());
  return Object.assign(made, typeof more === "string" ? { className: more } : more);
}

/** Loads something once; what has failed is tried again when it is asked for again. */
export function once(load) {
  let loaded;
  return () => (loaded ??= load().catch((error) => {
    loaded = null;
    throw error;
  }));
}

/** Numbers of so many digits at most. */
export const formatter = (most) => new Intl.NumberFormat("en", { maximumSignificantDigits: most, useGrouping: false });

export const digits = (value, most) => formatter(most).format(value).replace("-", "−");

/** Calls `look()` when a view is looked at, and at once if it is. */
export function looked(view, look) {
  const act = () => location.hash === view && look();
  addEventListener("hashchange", act);
  act();
}

/** Makes one of these rows stand out, by its number. */
export const choose = (rows, chosen) => [...rows].forEach((row, n) => {
  row.classList.toggle("chosen", n === chosen);
  row.querySelector("button").setAttribute("aria-pressed", n === chosen);
});

/** Gives a file. */
export function save(name, bytes, type = "text/plain") {
  const link = element("a", [], { href: URL.createObjectURL(new Blob([bytes], { type })), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}

/** Copies a text, and shows it there: also where the clipboard is closed. */
export async function copy(text, place) {
  place.textContent = text;
  place.hidden = false;
  try {
    await navigator.clipboard.writeText(text);
  } catch {
    getSelection().selectAllChildren(place);
  }
}
