// The panel's folded part "Map": make a map, keep it, use one of the library.

import { ask } from "./address.js";
import { element, find, setText } from "./elements.js";
import { withUnit } from "./format.js";
import { LibraryPart } from "./library_part.js";
import { obstacle } from "./permissions.js";

export class Mapping extends LibraryPart {
  constructor(state, commands, token) {
    super(find("#mapping-note"), state, commands, token);
    this.box = find("#mapping");
    this.name = find("#map-name");
    this.wasMapping = false;
    find("[data-map=toggle]").addEventListener("click", () => this.toggle());
    find("[data-map=reset]").addEventListener("click", () => this.give("map_reset", {}, () => "Begun anew"));
    find("#map-save").addEventListener("submit", (event) => {
      event.preventDefault();
      this.save();
    });
    this.box.addEventListener("toggle", () => this.box.open && this.list());
  }

  get status() {
    return this.state.message("mapping_status");
  }

  toggle() {
    if (this.state.isMapping()) return this.give("map_stop", {}, () => "Finished: the localizer takes over");
    return this.give("map_start", {}, () => "Drive about: the map grows");
  }

  save() {
    return this.keep("map_save", this.name);
  }

  update() {
    const isMapping = this.state.isMapping();
    if (isMapping && !this.wasMapping) this.box.open = true;
    this.wasMapping = isMapping;
    const toggle = find("[data-map=toggle]");
    setText(toggle, isMapping ? "Stop mapping" : "Start mapping");
    const command = isMapping ? "map_stop" : "map_start";
    const reason = obstacle(command, this.state);
    toggle.disabled = reason !== null;
    find("[data-map=reset]").disabled = reason !== null || !isMapping;
    find("#map-save button").disabled = reason !== null || !this.state.entry("map");
    this.say(reason ?? this.summary(isMapping));
  }

  summary(isMapping) {
    if (!isMapping) return "A new map begins where the robot stands.";
    const { steps, redraws } = this.status;
    const anew = redraws ? `, drawn anew ${redraws === 1 ? "once" : `${redraws} times`}` : "";
    return `${steps} scans in the map${anew}.`;
  }

  /** Shows the maps of the library, each with what can be done with it. */
  async list() {
    const response = await ask("/api/v1/maps", this.token()).catch(() => null);
    const answer = response?.ok ? await response.json() : { maps: [] };
    const key = JSON.stringify(answer.maps);
    if (key === this.listed) return;
    this.listed = key;
    find("#library").replaceChildren(...answer.maps.map((map) => this.row(map)));
  }

  row(map) {
    const size = [map.cols, map.rows].map((cells) => withUnit(cells * map.resolution, 0, "m")).join(" × ");
    const words = element("span", {}, element("span", {}, map.name), element("span", { class: "small faint" }, size));
    const load = element("button", { type: "button", class: "plain" }, "Use");
    load.setAttribute("aria-label", `Use the map ${map.name}`);
    load.addEventListener("click", () => this.give("map_load", { map: map.name }, () => `${map.name} is in use`));
    return element("li", {}, words, load);
  }
}
