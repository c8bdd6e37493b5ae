// The layers of the map: their names, keys, swatches, and which topic fills each.

import { element, find, setText } from "./elements.js";
import { settings } from "./settings.js";

export const LAYERS = [
  { id: "belief", name: "Belief", colour: "mode", form: "fill", topic: "belief", from: "localizer" },
  { id: "places", name: "Places", colour: "mode", form: "ring", topic: "belief", from: "localizer" },
  { id: "trail", name: "Trail", colour: "trail", form: "line", topic: "pose", from: "localizer" },
  { id: "scan", name: "Scan", colour: "text-2", form: "dots", topic: "scan", from: "robot", off: true },
  { id: "truth", name: "Reference", colour: "text-2", form: "dashes", topic: "ground_truth", from: "robot" },
  { id: "potential", name: "Potential", colour: "goal", form: "contours", topic: "potential", from: "planner" },
  { id: "looks", name: "Looks", colour: "robot", form: "diamond", topic: "plan", from: "planner" },
  { id: "goal", name: "Goal", colour: "goal", form: "cross", topic: "goal", from: "planner" },
];
const ON_PHONE = 3;

const FORMS = {
  fill: "M1 2h14v8H1z",
  ring: "M8 1a5 5 0 1 1 0 10A5 5 0 1 1 8 1z",
  line: "M1 6h14",
  dots: "M2 6h.1M6 6h.1M10 6h.1M14 6h.1",
  dashes: "M1 6h4M7 6h3M12 6h3",
  contours: "M1 11C3 1 13 1 15 11M5 11c1-4 5-4 6 0",
  diamond: "M8 1l5 5-5 5-5-5z",
  cross: "M8 1a5 5 0 1 1 0 10A5 5 0 1 1 8 1zM8 4v4M6 6h4",
};

export class LayerList {
  constructor(state, onChange) {
    this.state = state;
    this.onChange = onChange;
    this.shown = new Set();
    this.buttons = new Map();
    const unfold = find("#unfold");
    LAYERS.forEach((layer, i) => unfold.before(this.chip(layer, i)));
    setText(unfold, `+${LAYERS.length - ON_PHONE}`);
    unfold.addEventListener("click", () => {
      const isOpen = find("#layers").classList.toggle("is-unfolded");
      unfold.setAttribute("aria-expanded", isOpen);
    });
    this.restore();
  }

  has(id) {
    return this.shown.has(id);
  }

  /** Switches the layer of key `number`; says whether there is one. */
  toggleNumber(number) {
    const layer = LAYERS[number - 1];
    if (layer) this.toggle(layer.id);
    return Boolean(layer);
  }

  toggle(id) {
    if (this.shown.has(id)) this.shown.delete(id);
    else this.shown.add(id);
    // Choices are kept, not the list: layers that a later version adds are shown all the same.
    settings.set("layers", { ...settings.get("layers", {}), [id]: this.shown.has(id) });
    this.show();
  }

  /** Takes the remembered layers, or those shown at first. */
  restore() {
    const chosen = settings.get("layers", {});
    const shown = LAYERS.filter(({ id, off }) => chosen[id] ?? !off);
    this.shown = new Set(shown.map(({ id }) => id));
    this.show();
  }

  /** Says of each layer whether its data have come. */
  update() {
    for (const layer of LAYERS) {
      const isEmpty = !this.hasData(layer);
      const button = this.buttons.get(layer.id);
      setText(button.querySelector("span"), isEmpty ? `${layer.name} · none yet` : layer.name);
      const missing = `Topic ${layer.topic} has not come; ${layer.from} should send it`;
      button.title = isEmpty ? missing : `Key ${LAYERS.indexOf(layer) + 1}`;
    }
  }

  hasData({ id, topic }) {
    if (id === "scan") return Boolean(this.state.entry("scan") ?? this.state.entry("sonar"));
    return Boolean(this.state.entry(topic));
  }

  chip(layer, i) {
    const isMore = i >= ON_PHONE ? "is-more" : "";
    const button = element("button", { type: "button", class: `layer ${isMore}`, "data-layer": layer.id });
    button.append(swatch(layer), element("span", {}, layer.name));
    button.addEventListener("click", () => this.toggle(layer.id));
    this.buttons.set(layer.id, button);
    return button;
  }

  show() {
    for (const [id, button] of this.buttons) button.setAttribute("aria-pressed", this.shown.has(id));
    this.onChange();
  }
}

function swatch({ colour, form }) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("viewBox", "0 0 16 12");
  svg.setAttribute("aria-hidden", "true");
  svg.style.color = `var(--${colour})`;
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", FORMS[form]);
  path.setAttribute("stroke-width", form === "dots" ? "2.5" : "2");
  path.setAttribute("stroke-linecap", "round");
  if (form === "fill") path.setAttribute("fill", "currentColor");
  svg.append(path);
  return svg;
}
