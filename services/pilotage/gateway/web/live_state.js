// What the page knows now: the newest message of every topic and service, and how old it is.

export class LiveState {
  constructor(clock) {
    this.clock = clock;
    this.newest = new Map();
    this.listeners = new Map();
    this.link = "connecting";
    this.retryS = 0;
    this.lostAtMs = null;
    this.contactMs = null;
    /** Why no command may be given by this page, once that is known. */
    this.forbidden = null;
  }

  /** Calls `listener(entry)` at each message of `topic`. */
  on(topic, listener) {
    this.listeners.set(topic, [...(this.listeners.get(topic) ?? []), listener]);
  }

  take({ topic, service, message, receivedNs }) {
    const stampMs = (message.stamp_ns ?? receivedNs) / 1e6;
    const entry = { topic, service, message, stampMs, at: performance.now() };
    this.contactMs = this.clock.unixMs();
    this.newest.set(topic, entry);
    this.newest.set(`${topic}/${service}`, entry);
    for (const listener of this.listeners.get(topic) ?? []) listener(entry);
  }

  /** The newest message of a topic (of one service), or undefined. */
  message(topic, service) {
    return this.entry(topic, service)?.message;
  }

  entry(topic, service) {
    return this.newest.get(service ? `${topic}/${service}` : topic);
  }

  /** The newest messages of a topic by service, of topics that every service sends. */
  byService(topic) {
    const prefix = `${topic}/`;
    const entries = [...this.newest].filter(([key]) => key.startsWith(prefix));
    return new Map(entries.map(([, entry]) => [entry.service, entry]));
  }

  /**
   * Seconds since a message was measured, by the gateway's clock; null when none has come. A log
   * replayed at N times real time stamps ahead of every clock: there the time since arrival.
   */
  age(topic, service) {
    const entry = this.entry(topic, service);
    if (!entry) return null;
    const sinceArrival = (performance.now() - entry.at) / 1000;
    if (!this.isRealTime()) return sinceArrival;
    const sinceMeasured = (this.clock.unixMs() - entry.stampMs) / 1000;
    // A sender whose clock is ahead measures in the future: its data are as old as their arrival.
    return Math.max(sinceMeasured, sinceArrival, 0);
  }

  /** Whether a map is being made, so that the mapper says where the robot is. */
  isMapping() {
    return this.message("mapping_status")?.mode === "mapping";
  }

  isRealTime() {
    return (this.message("status")?.speed_factor ?? 1) === 1;
  }

  /** Whether the page reaches the gateway and the gateway the bus. */
  isLinked() {
    return this.link === "open" && this.message("link")?.connected !== false;
  }
}
