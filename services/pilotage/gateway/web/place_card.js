// The card of a place that was pressed: what is seen there, where it leads, the way to it.
//
// Without a pointer: N opens the card of the place nearest to the middle of the picture, and its
// ways lead from place to place.

import { element, find, setText } from "./elements.js";
import { number, withUnit } from "./format.js";
import { distance } from "./geometry.js";
import { countText, lengthOf, nameOf } from "./graph.js";
import { obstacle } from "./permissions.js";

const [REACH_PX, TOUCH_PX] = [14, 24];
const [RIM_PX, TOOLS_PX, SCALE_PX] = [8, 60, 48];
const ROBOT_PX = 12;
const STEPS = 8;
const ANY_HEADING = 3.14;
const MOST_WAYS = 6;
const SAID_MS = 4000;
const MOVED_M = 0.5;
const KINDS = { node: "Place", door: "Door", corner: "Corner", passage: "Passage" };

export class PlaceCard {
  /** `askRoute(start, end)` returns the way from a point to a node: {way: [[x, y], ...], nodes}; `commands` can send `go_to`. */
  constructor(state, view, scene, commands, askRoute) {
    Object.assign(this, { state, view, scene, commands, askRoute });
    this.box = find("#place");
    this.said = new Map();
    this.node = null;
    this.listen();
  }

  listen() {
    this.part("close").addEventListener("click", () => this.close());
    this.part("route").addEventListener("click", () => this.route());
    this.part("go").addEventListener("click", () => this.go());
    document.addEventListener("keydown", (event) => this.key(event));
  }

  key(event) {
    const isTyping = event.target.closest?.("input, select, textarea");
    if (event.ctrlKey || event.metaKey || event.altKey || isTyping) return;
    if (event.key === "Escape" && this.node) this.close();
    if (event.key.toLowerCase() !== "n" || !this.scene.hasGraph()) return;
    const node = this.graph?.nearest(this.view.toMap(this.view.focus));
    if (node) this.open(node, true);
  }

  get graph() {
    return this.scene.graph.graph;
  }

  part(name) {
    return find(`[data-place=${name}]`, this.box);
  }

  /** Opens the card of the place under a point of the screen, or closes the open one. */
  press(point, isTouch) {
    const reach = isTouch ? TOUCH_PX : REACH_PX;
    const node = this.scene.hasGraph() ? this.scene.graph.pick(this.view, point, reach) : undefined;
    if (node) this.open(node);
    else this.close();
  }

  open(node, takesFocus = false) {
    if (node.id !== this.node?.id) this.forgetRoute();
    this.node = node;
    this.scene.chosen = node.id;
    setText(find("#place-name"), nameOf(node));
    const kind = KINDS[node.kind] ?? node.kind;
    setText(this.part("where"), `${kind} at x ${number(node.pose.x, 1)}, y ${withUnit(node.pose.y, 1, "m")}`);
    setText(this.part("features"), featuresText(node.features));
    this.part("ways").replaceChildren(...this.ways(node));
    this.said.clear();
    this.box.hidden = false;
    this.update();
    this.place();
    if (takesFocus) this.part("close").focus();
    this.scene.touch();
  }

  close() {
    if (!this.node) return;
    const hadFocus = this.box.contains(document.activeElement);
    this.node = this.scene.chosen = null;
    this.forgetRoute();
    this.box.hidden = true;
    if (hadFocus) find("#live").focus();
    this.scene.touch();
  }

  /** The graph is another one: the card goes on if the place is still there. */
  renew() {
    if (!this.node) return;
    const node = this.graph?.node(this.node.id);
    if (!node || node.name !== this.node.name) this.close();
    else this.node = node;
  }

  ways(node) {
    const near = this.graph.neighbours(node.id).slice(0, MOST_WAYS);
    if (!near.length) return [element("li", { class: "small faint" }, "No way leads from here")];
    return near.map(({ node: other, cost }) => {
      const length = element("span", { class: "quiet" }, withUnit(cost, 1, "m"));
      const button = element("button", { type: "button", class: "way" }, element("span", {}, nameOf(other)), length);
      button.addEventListener("click", () => {
        this.open(other, true);
        this.bringIntoView(other);
      });
      return element("li", {}, button);
    });
  }

  bringIntoView({ pose }) {
    const { x, y } = this.view.toScreen(pose);
    const { width, height } = this.view.size;
    if (x > 0 && y > 0 && x < width && y < height - this.scene.covered) return;
    this.view.follows = false;
    this.view.goTo(pose);
    this.scene.touch();
  }

  async route() {
    const { node } = this;
    const from = this.state.message("pose").pose;
    this.tell("route", "Asking…", false);
    try {
      const answer = await this.askRoute(from, node);
      if (this.node !== node) return;
      this.scene.route = { way: answer.way, nodes: answer.nodes, from };
      this.said.delete("route");
    } catch (error) {
      if (this.node === node) this.tell("route", error.message, true);
    }
    this.update();
    this.place();
    this.scene.touch();
  }

  forgetRoute() {
    this.scene.route = null;
  }

  async go() {
    const { node } = this;
    this.tell("go", "Asking the planner…", false);
    try {
      await this.commands.send("go_to", { pose: node.pose, heading_tolerance: ANY_HEADING });
      this.tell("go", "On the way", false);
    } catch (error) {
      this.tell("go", error.message, true);
    }
  }

  tell(name, text, isFault) {
    this.said.set(name, { text, isFault, until: performance.now() + SAID_MS });
    this.update();
  }

  update() {
    if (!this.node) return;
    if (!this.scene.hasGraph()) this.close();
    else {
      this.show("route", obstacle("topology_route", this.state));
      this.show("go", obstacle("go_to", this.state));
      setText(this.part("length"), this.routeText);
    }
  }

  /** Shows whether a button can act; below it why not, or what came of it. */
  show(name, reason) {
    const button = this.part(name);
    const said = this.said.get(name);
    const isFresh = Boolean(said) && performance.now() < said.until;
    button.disabled = reason !== null;
    setText(button.nextElementSibling, reason ?? (isFresh ? said.text : ""));
    button.nextElementSibling.classList.toggle("is-fault", reason === null && isFresh && said.isFault);
  }

  /** How long the way is; it begins where the robot was when it was asked for. */
  get routeText() {
    const { route } = this.scene;
    if (!route) return "";
    const pose = this.state.message("pose")?.pose;
    const text = `${withUnit(lengthOf(route.way), 1, "m")} over ${placesText(route.nodes.length)}`;
    return pose && distance(pose, route.from) > MOVED_M ? `${text}, from where it was` : text;
  }

  /** Puts the card into the corner where it hides least: neither its place nor robot nor way. */
  place() {
    if (!this.node) return;
    const { view, scene } = this;
    const { size, inset } = view;
    const card = { width: this.box.offsetWidth, height: this.box.offsetHeight };
    const [right, left] = [size.width - TOOLS_PX - card.width, RIM_PX];
    const low = size.height - scene.covered - card.height;
    const [bottom, top] = [low - (scene.covered ? RIM_PX : SCALE_PX), inset.top - RIM_PX];
    const spots = [[right, bottom], [right, top], [left, bottom], [left, top]].map(([x, y]) => ({ x, y }));
    const robot = scene.motion.pose();
    // The robot counts twice: nothing may cover it, while a place keeps its name in the card.
    const kept = [this.node.pose, ...(robot ? [robot, robot] : [])].map((pose) => view.toScreen(pose));
    const losses = spots.map((spot) => 100 * hidden(spot, card, kept, ROBOT_PX) + hidden(spot, card, this.onWay(), 0));
    const { x, y } = spots[losses.indexOf(Math.min(...losses))];
    this.box.style.transform = `translate(${Math.round(Math.max(RIM_PX, x))}px, ${Math.round(y)}px)`;
  }

  /** Points of the screen along the route. */
  onWay() {
    const ends = (this.scene.route?.way ?? []).map(([x, y]) => this.view.toScreen({ x, y }));
    const steps = Array.from({ length: STEPS }, (_, i) => i / STEPS);
    return ends.slice(1).flatMap((end, i) => steps.map((u) => mixed(ends[i], end, u)));
  }
}

const placesText = (n) => (n === 1 ? "1 place" : `${n} places`);

/** "2 doors, 1 corner, 0.88 to 0.90 m wide". */
function featuresText(features) {
  if (!features.length) return "No feature is bound to it";
  const widths = features.map(({ width }) => width).filter(Boolean);
  const ends = [Math.min(...widths), Math.max(...widths)].map((width) => number(width, 2));
  const wide = widths.length ? `, ${[...new Set(ends)].join(" to ")}\u202fm wide` : "";
  return `${countText(features.map(({ kind }) => kind))}${wide}`;
}

/** How many of the points a card at a spot comes within `margin` px of. */
const hidden = (spot, { width, height }, points, margin) =>
  points.filter(
    ({ x, y }) =>
      x > spot.x - margin && x < spot.x + width + margin && y > spot.y - margin && y < spot.y + height + margin,
  ).length;

const mixed = (a, b, u) => ({ x: a.x + u * (b.x - a.x), y: a.y + u * (b.y - a.y) });
