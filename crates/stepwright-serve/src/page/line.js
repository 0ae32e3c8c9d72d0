// A line of all axes: together and straight to their targets.

import { FAR } from "./axis.js";
import { by, element } from "./dom.js";
import { post } from "./server.js";

/** A field for each of these axes; one with an empty field stays. */
export function lineForm(axes, tell) {
  const form = by("line");
  form.hidden = axes.length < 2;
  const fields = axes.map((axis) => {
    const most = axis.shown(FAR);
    return element("input", [], { type: "number", step: "any", min: -most, max: most, placeholder: "stays" });
  });
  const labels = fields.map((field, n) => element("label", [`Axis ${axes[n].number}, ${axes[n].unit} `, field]));
  form.lastElementChild.replaceChildren(...labels, form.querySelector("button"));
  form.onsubmit = (event) => {
    event.preventDefault();
    const to = fields.map((field, n) => (field.value ? Math.round(field.valueAsNumber * axes[n].scale) : null));
    const ways = to.map((place, n) => (place === null ? -1 : Math.abs(place - axes[n].position)));
    const lead = axes[ways.indexOf(Math.max(...ways))];
    if (!lead.valid("speed", "accel", "jerk")) return;
    post("/api/line", { to, top_speed: lead.steps("speed"), ...lead.motion() }).catch(tell);
  };
}
