// The layers of the map: their names, keys, swatches, and which topic fills each.

import { element, find, setText } from "./elements.js";
import { settings } from "./settings.js";
import { graphTrouble, matchTrouble } from "./topology.js";

export const LAYERS = [
  { id: "belief", name: "Belief", colour: "mode", form: "fill", topic: "belief", from: "localizer" },
  { id: "places", name: "Places", colour: "mode", form: "ring", topic: "belief", from: "localizer" },
  { id: "trail", name: "Trail", colour: "trail", form: "line", topic: "pose", from: "localizer" },
  { id: "scan", name: "Scan", colour: "text-2", form: "dots", topic: "scan", from: "robot", off: true },
  { id: "truth", name: "Reference", colour: "text-2", form: "dashes", topic: "ground_truth", from: "robot" },
  { id: "potential", name: "Potential", colour: "goal", form: "contours", topic: "potential", from: "planner" },
  { id: "looks", name: "Looks", colour: "robot", form: "diamond", topic: "plan", from: "planner" },
  { id: "goal", name: "Goal", colour: "goal", form: "cross", topic: "goal", from: "planner" },
  { id: "graph", name: "Graph", colour: "graph", form: "graph", topic: "topology", from: "topology" },
  { id: "matches", name: "Matched", colour: "graph", form: "pairs", key: "m", topic: "matched_lines", from: "localizer", or: ["matched_features", "topology"] },
  { id: "camera", name: "Camera", colour: "text-2", form: "star", key: "c", topic: "vertical_edges", from: "robot", or: ["landmarks", "robot"], off: true },
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
  graph: "M2 9l5-6 7 6M7 3h.1M2 9h.1M14 9h.1",
  pairs: "M1 3h14M5 10h8M8 4v1M8 7v1",
  star: "M8 1v10M3.700 3.500l8.600 5M12.300 3.500l-8.600 5",
  cross: "M8 1a5 5 0 1 1 0 10A5 5 0 1 1 8 1zM8 4v4M6 6h4",
};

const WIDTHS = { dots: "2.5", pairs: "1.8" };

export class LayerList {
  constructor(state, onChange) {
    this.state = state;
    this.onChange = onChange;
    this.shown = new Set();
    this.buttons = new Map();
    const unfold = find("#unfold");
    LAYERS.forEach((layer, i) => unfold.before(this.chip(layer, i)));
    const more = `+${LAYERS.length - ON_PHONE}`;
    setText(unfold, more);
    unfold.addEventListener("click", () => {
      const isOpen = find("#layers").classList.toggle("is-unfolded");
      unfold.setAttribute("aria-expanded", isOpen);
      setText(unfold, isOpen ? "Fewer" : more);
    });
    this.restore();
  }

  has(id) {
    return this.shown.has(id);
  }

  /** Switches the layer of a key; says whether there is one. */
  toggleKey(key) {
    const layer = LAYERS.find((candidate, i) => keyOf(candidate, i) === key);
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
      const button = this.buttons.get(layer.id);
      const isEmpty = !this.hasData(layer);
      const trouble = isEmpty ? { word: "none yet", text: missing(layer) } : this.troubleOf(layer);
      const key = keyOf(layer, LAYERS.indexOf(layer)).toUpperCase();
      setText(button.querySelector("span"), trouble ? `${layer.name} · ${trouble.word}` : layer.name);
      button.title = trouble ? trouble.text : `Key ${key}`;
    }
  }

  hasData({ id, topic, or = [] }) {
    if (id === "scan") return Boolean(this.state.entry("scan") ?? this.state.entry("sonar"));
    return Boolean(this.state.entry(topic) ?? this.state.entry(or[0]));
  }

  /** Why a layer whose data have come is not as it should be: {word, text}, or null. */
  troubleOf({ id }) {
    if (id === "graph") return graphTrouble(this.state);
    return id === "matches" ? matchTrouble(this.state) : null;
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

/** The first nine layers have the digits, the others a letter. */
const keyOf = ({ key }, i) => key ?? String(i + 1);

function missing({ topic, from, or }) {
  if (!or) return `Topic ${topic} has not come; ${from} should send it`;
  return `Neither ${topic} of ${from} nor ${or[0]} of ${or[1]} has come`;
}

function swatch({ colour, form }) {
  const svg = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  svg.setAttribute("class", "swatch");
  svg.setAttribute("viewBox", "0 0 16 12");
  svg.setAttribute("aria-hidden", "true");
  svg.style.color = `var(--${colour})`;
  const path = document.createElementNS("http://www.w3.org/2000/svg", "path");
  path.setAttribute("d", FORMS[form]);
  path.setAttribute("stroke-width", WIDTHS[form] ?? "2");
  path.setAttribute("stroke-linecap", "round");
  if (form === "fill") path.setAttribute("fill", "currentColor");
  svg.append(path);
  return svg;
}
