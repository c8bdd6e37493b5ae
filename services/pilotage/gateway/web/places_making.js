// The folded part "Map", its second half: build the topological map, keep it, use a kept one.

import { ask } from "./address.js";
import { element, find } from "./elements.js";
import { withUnit } from "./format.js";
import { LibraryPart } from "./library_part.js";
import { obstacle } from "./permissions.js";
import { graphTrouble } from "./topology.js";

const LIST = "/api/v1/topologies";

export class PlacesMaking extends LibraryPart {
  constructor(state, commands, token) {
    super(find("#topology-note"), state, commands, token);
    this.box = find("#mapping");
    this.build = find("[data-topology=build]");
    this.build.addEventListener("click", () => this.make());
    find("#topology-save").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    this.box.addEventListener("toggle", () => this.box.open && this.list());
  }

  get spacing() {
    const metres = Number(find("#spacing").value);
    return metres ? { spacing: "equal", metres } : { spacing: "variable" };
  }

  async make() {
    this.isBuilding = true;
    this.tell("Building…", false);
    this.update();
    await this.give("topology_build", this.spacing, ({ nodes, edges }) => `${nodes} places and ${edges} ways`);
    this.isBuilding = false;
    this.update();
  }

  save() {
    return this.keep("topology_save", find("#topology-name"));
  }

  update() {
    const reason = obstacle("topology_build", this.state);
    const graph = this.state.message("topology");
    this.build.disabled = reason !== null || Boolean(this.isBuilding);
    find("#spacing").disabled = reason !== null;
    find("#topology-save button").disabled = reason !== null || !graph?.nodes.length;
    for (const button of find("#topologies").querySelectorAll("button")) button.disabled = reason !== null;
    this.say(reason ?? summary(this.state, graph));
  }

  /** Shows the kept topological maps, each with what can be done with it. */
  async list() {
    const response = await ask(LIST, this.token()).catch(() => null);
    const { topologies = [] } = response?.ok ? await response.json() : {};
    const key = JSON.stringify(topologies);
    if (key === this.listed) return;
    this.listed = key;
    find("#topologies").replaceChildren(...topologies.map((stored) => this.row(stored)));
  }

  row({ name, floor, nodes, map_id: mapId }) {
    const about = [floor, `${nodes} places`, mapId === this.state.message("map")?.map_id ? "" : "another map"];
    const words = element("span", {}, element("span", {}, name));
    words.append(element("span", { class: "small faint" }, about.filter(Boolean).join(" · ")));
    const load = element("button", { type: "button", class: "plain" }, "Use");
    load.setAttribute("aria-label", `Use the places ${name}`);
    load.addEventListener("click", () => this.give("topology_load", { name }, () => `${name} is in use`));
    return element("li", {}, words, load);
  }
}

function summary(state, graph) {
  if (!graph) return "None yet: build it from the map in use.";
  const trouble = graphTrouble(state);
  if (trouble) return `${trouble.text}.`;
  const features = graph.nodes.reduce((sum, node) => sum + node.features.length, 0);
  const each = withUnit(graph.nodes.length ? features / graph.nodes.length : 0, 1, "features each");
  return `${graph.nodes.length} places (${each}), ${graph.edges.length} ways.`;
}
