// The health strip: source, THE state, one chip per service, the link, the age of the picture.

import { capitalized, number, seconds, timeOfDay, withUnit } from "./format.js";
import { element, find, setText, shape } from "./elements.js";
import {
  heartbeatChip,
  lateChip,
  mainRate,
  mainStream,
  mainStreams,
  processChip,
  sourceText,
  stateChip,
} from "./status.js";

const HEALTH_LIMIT_S = 3;
const QUIET_WHEN_WELL = new Set(["router", "gateway", "launcher"]);
const WORST_FIRST = { fault: 0, warning: 1, none: 2, ok: 3 };

export class Strip {
  constructor(state, places, popover, { say, alarm }) {
    Object.assign(this, { state, places, popover, say, alarm });
    this.chips = new Map();
    this.row = find("#chips");
    this.lastState = "";
    this.troubled = new Set();
  }

  update() {
    const { state } = this;
    setText(find("#source"), sourceText(state.message("hello")?.robot, state.message("status")));
    const updated = find("#updated");
    const age = state.age("pose");
    setText(updated, age === null ? "no data yet" : `updated ${seconds(age)} ago`);
    const chips = [this.stateChip(), ...this.serviceChips(), this.linkChip()];
    this.show(chips);
    this.announce(chips);
  }

  stateChip() {
    const estimate = this.state.message("pose");
    const chip = stateChip(estimate, this.places.list.length, this.state.age("pose"), this.state.isMapping());
    return { id: "state", ...chip, terms: () => this.stateTerms() };
  }

  serviceChips() {
    const { state } = this;
    const processes = state.message("deployment")?.processes;
    const names = processes ? processes.map((p) => p.name) : [...state.byService("heartbeat").keys()];
    const chips = names.map((name) => {
      const chip = this.serviceChip(name, processes?.find((p) => p.name === name));
      return { id: name, ...chip, terms: () => this.serviceTerms(name) };
    });
    return chips
      .filter((chip) => isTrouble(chip) || !QUIET_WHEN_WELL.has(chip.id))
      .sort((a, b) => WORST_FIRST[a.kind] - WORST_FIRST[b.kind]);
  }

  /** The chip of a service; `process` is what its launcher tells of it, if there is one. */
  serviceChip(name, process) {
    const { state } = this;
    if (state.link !== "open") return { kind: "none", text: capitalized(name) };
    const isTold = (state.age("health", name) ?? Infinity) < HEALTH_LIMIT_S;
    const health = isTold ? state.message("health", name) : undefined;
    const beat = state.message("heartbeat", name);
    const chip = process
      ? processChip(process, mainRate(health))
      : heartbeatChip(name, beat, state.age("heartbeat", name), mainRate(health));
    const late = chip.kind === "ok" ? this.lateness(health) : null;
    return late === null ? chip : lateChip(name, late);
  }

  /** Age in s of a service's fastest stream if it is past its limit, or null. */
  lateness(health) {
    const stream = mainStream(health);
    const age = stream ? this.state.age(stream.topic) : null;
    const isOver = this.state.message("status")?.mode === "finished";
    return age !== null && age > stream.limit && !isOver ? age : null;
  }

  linkChip() {
    const { state } = this;
    const terms = () => this.linkTerms();
    if (state.link !== "open") return { id: "link", kind: "fault", text: "No contact", terms };
    if (!state.isLinked()) return { id: "link", kind: "fault", text: "Bus lost", terms };
    const trip = state.clock.roundTripMs;
    const text = trip === null ? "Link" : `Link ${withUnit(Math.max(1, trip), 0, "ms")}`;
    return { id: "link", kind: "ok", text, terms };
  }

  show(chips) {
    const ids = new Set(chips.map((chip) => chip.id));
    for (const [id, button] of this.chips) {
      if (!ids.has(id)) {
        button.remove();
        this.chips.delete(id);
      }
    }
    chips.forEach((chip, place) => this.put(chip, place));
    this.popover.update();
  }

  put(chip, place) {
    let button = this.chips.get(chip.id);
    if (!button) {
      button = element("button", { type: "button", "data-chip": chip.id });
      button.append(shape(chip.kind), element("span"));
      button.addEventListener("click", () => this.popover.toggle(button, () => button.terms()));
      this.chips.set(chip.id, button);
    }
    button.terms = chip.terms;
    const own = chip.id === "state" ? "is-state " : "";
    button.className = `chip ${own}is-${chip.kind}`;
    button.querySelector("use").setAttribute("href", `#s-${chip.kind}`);
    setText(button.lastChild, chip.text);
    if (this.row.children[place] !== button) this.row.insertBefore(button, this.row.children[place]);
  }

  /** A change of state is said politely, a new fault at once. */
  announce(chips) {
    const [state, ...others] = chips;
    if (state.text !== this.lastState) this.say(state.text);
    this.lastState = state.text;
    const faults = others.filter((chip) => chip.kind === "fault");
    for (const chip of faults) if (!this.troubled.has(chip.id)) this.alarm(chip.text);
    this.troubled = new Set(faults.map((chip) => chip.id));
  }

  stateTerms() {
    const { state } = this;
    const estimate = state.message("pose");
    const belief = state.message("belief");
    const matched = belief?.matched;
    const terms = [["Topic", "pose, belief"], ["From", state.isMapping() ? "mapper" : "localizer"], ["Age", ageText(state.age("pose"))]];
    if (estimate) terms.push(["Confidence", withUnit(estimate.confidence * 100, 1, "%")]);
    if (belief) terms.push(["Uncertainty", withUnit(belief.entropy, 1, "bits")]);
    if (matched !== undefined && matched !== null) terms.push(["Beams that fit", withUnit(matched * 100, 0, "%")]);
    // On a phone only this chip is in view: the others are told of here.
    for (const [id, button] of this.chips) if (id !== "state") terms.push([capitalized(id), told(id, button)]);
    return terms;
  }

  serviceTerms(name) {
    const { state } = this;
    const process = state.message("deployment")?.processes.find((p) => p.name === name);
    const health = state.message("health", name);
    const terms = [["Service", name]];
    if (process) {
      terms.push(["State", `${process.state} since ${timeOfDay(process.since_ns / 1e6)}`]);
      terms.push(["Restarts", number(process.restarts, 0)], ["Limit", withUnit(process.limit, 1, "s")]);
      if (process.reason) terms.push(["Reason", process.reason]);
    }
    if (!health) return terms;
    terms.push(["CPU", withUnit(health.cpu_percent, 0, "%")], ["Memory", withUnit(health.rss_mb, 0, "MB")]);
    for (const topic of mainStreams(health)) {
      terms.push([topic.topic, `${withUnit(topic.rate_hz, 1, "Hz")}, limit ${withUnit(topic.limit, 1, "s")}`]);
    }
    terms.push(["Dropped", number(health.dropped, 0)]);
    if (health.last_error) terms.push(["Last error", health.last_error]);
    return terms;
  }

  linkTerms() {
    const { state } = this;
    const trip = state.clock.roundTripMs;
    const link = state.message("link");
    return [
      ["Page to gateway", trip === null ? "—" : `${withUnit(trip, 1, "ms")} round trip`],
      ["Bus", link ? `${link.connected ? "connected" : "lost"} since ${timeOfDay(link.since_ns / 1e6)}` : "—"],
      ["Gateway", state.message("hello")?.version ?? "—"],
    ];
  }
}

const isTrouble = ({ kind }) => kind === "fault" || kind === "warning";

/** What a chip says besides its name. */
const told = (id, button) => button.textContent.replace(capitalized(id), "").trim() || "well";

const ageText = (age) => (age === null ? "—" : withUnit(age, 1, "s"));
