// The panel: how sure it is, where, and every place it could be; the map in words.

import { degrees, number, percent, withUnit } from "./format.js";
import { coordinates, placeText, pointText } from "./topology.js";
import { element, find, setTerms, setText } from "./elements.js";
import { certainty, GONE_S, STALE_S } from "./status.js";
import { ellipseOf } from "./geometry.js";

export class Panel {
  /** `graph()` is the Graph of this map, or null. */
  constructor(state, places, graph, { onLight, onGoTo }) {
    Object.assign(this, { state, places, graph, onLight, onGoTo });
    this.rows = new Map();
    this.list = find("#places");
  }

  update() {
    const age = this.state.age("pose");
    const isGone = age !== null && age > GONE_S;
    find("#whereabouts").classList.toggle("is-old", age !== null && age > STALE_S);
    this.list.classList.toggle("is-old", age !== null && age > STALE_S);
    this.showCertainty(isGone);
    this.showPlaces();
    setText(find("#last-place"), isGone ? "" : placeText(this.state, this.graph()));
    this.showAbout();
  }

  showCertainty(isGone) {
    const estimate = this.state.message("pose");
    const best = this.places.best;
    if (this.state.isMapping() && estimate?.state !== "localized") {
      setText(find("#certainty"), "—");
      setText(find("#where"), "Mapping: no scan has come yet");
      return;
    }
    const sure = certainty(estimate, best ? [best] : []);
    if (!sure) return;
    setText(find("#certainty"), isGone ? "—" : percent(sure.share));
    find(".bar i").style.transform = `scaleX(${isGone ? 0 : sure.share})`;
    const at = estimate?.state === "localized" ? estimate.pose : best?.pose ?? estimate.pose;
    const place = {
      localized: pointText(at, this.graph()),
      ambiguous: `${best?.number} · ${pointText(at, this.graph())}`,
    }[estimate?.state] ?? `${best?.number}, not confirmed yet`;
    setText(find("#where"), isGone ? "Nothing has come for a while" : `${sure.about} ${place}`);
  }

  showPlaces() {
    const { list, elsewhere, best } = this.places;
    if (this.state.isMapping()) setText(find("#elsewhere"), "On a map in the making there is only one.");
    if (list.length === 0 && !this.state.isMapping()) return;
    const numbers = new Set(list.map((place) => place.number));
    find(".skeleton", this.list)?.remove();
    for (const [number_, row] of this.rows) {
      if (numbers.has(number_)) continue;
      row.parentElement.remove();
      this.rows.delete(number_);
    }
    list.forEach((place, i) => this.showPlace(place, place === best, i));
    if (list.length) setText(find("#elsewhere"), `Elsewhere ${elsewhere}\u202f%`);
  }

  showPlace(place, isBest, i) {
    const row = this.rows.get(place.number) ?? this.addRow(place.number);
    const { x, y, theta } = place.pose;
    const { major } = ellipseOf(place.covariance, 1);
    const [badge, words, mass] = row.children;
    setText(badge, String(place.number));
    setText(words.firstChild, pointText({ x, y }, this.graph()));
    words.title = coordinates({ x, y });
    setText(words.lastChild, `σ ${withUnit(major, 2, "m")} · ${degrees(theta)}`);
    setText(mass, `${place.percent}\u202f%`);
    row.classList.toggle("is-first", isBest);
    const item = row.parentElement;
    if (this.list.children[i] !== item) this.list.insertBefore(item, this.list.children[i]);
  }

  addRow(number_) {
    const words = element("span", {}, element("span"), element("span", { class: "small faint place-spread" }));
    const row = element("button", { type: "button", class: "place" });
    row.append(element("span", { class: "badge" }), words, element("span", { class: "place-mass" }));
    for (const name of ["pointerenter", "focus"]) row.addEventListener(name, () => this.onLight(number_));
    for (const name of ["pointerleave", "blur"]) row.addEventListener(name, () => this.onLight(null));
    row.addEventListener("click", () => {
      const place = this.places.list.find((p) => p.number === number_);
      if (place) this.onGoTo(place.pose);
    });
    this.list.append(element("li", {}, row));
    this.rows.set(number_, row);
    return row;
  }

  showAbout() {
    const { state } = this;
    const map = state.message("map");
    const description = state.message("description");
    const belief = state.message("belief");
    setTerms(find("#about dl"), [
      ["Pilotage", state.message("hello")?.version ?? "—"],
      ["Robot", description ? `${description.name}, driver ${description.driver}` : "—"],
      ["Map", map ? `${map.name}, ${sizeText(map)}` : "—"],
      ["Map id", map?.map_id ?? "—"],
      ["Method", belief?.method ?? "—"],
      ["Interface", "/api/v1/robots, /api/v1/openapi.json"],
    ]);
  }
}

function sizeText({ cells, resolution }) {
  const [height, width] = cells.shape.map((length) => length * resolution);
  return `${number(width, 0)} × ${withUnit(height, 0, "m")}`;
}

