// The live stream: a WebSocket that comes back by itself, and knows when it hangs.
//
// Tells: onMessage({topic, service, message, receivedNs}), onState("connecting" | "open" | "lost",
// seconds until the next try). Hidden pages pause the stream and get a full picture on return.

import { CborError, decode } from "./cbor.js";

const FIRST_RETRY_S = 0.25;
const LAST_RETRY_S = 3;
const PING_MS = 1000;
const SILENCE_MS = 3500;

export class Stream {
  constructor(address, clock, { onMessage, onState, onRefused }) {
    this.address = address;
    this.clock = clock;
    this.onMessage = onMessage;
    this.onState = onState;
    this.onRefused = onRefused;
    this.retryS = FIRST_RETRY_S;
    this.socket = null;
    this.asked = new Map();
    this.pings = 0;
    setInterval(() => this.beat(), PING_MS);
    document.addEventListener("visibilitychange", () => this.pauseOrResume());
    addEventListener("online", () => this.retryNow());
  }

  open() {
    const socket = new WebSocket(this.address());
    socket.binaryType = "arraybuffer";
    socket.onopen = () => this.opened(socket);
    socket.onmessage = (event) => socket === this.socket && this.take(event.data);
    socket.onclose = () => this.lost(socket);
    this.socket = socket;
    this.heardAt = performance.now();
    this.onState("connecting", 0);
  }

  opened(socket) {
    if (socket !== this.socket) return;
    this.clock.reset();
    this.openedAt = performance.now();
    this.onState("open", 0);
    this.pauseOrResume();
    this.beat();
  }

  take(data) {
    this.heardAt = performance.now();
    let envelope, message;
    try {
      envelope = decode(new Uint8Array(data));
      message = decode(envelope.payload);
    } catch (error) {
      if (!(error instanceof CborError)) throw error;
      this.onRefused(envelope?.topic ?? "stream", error.message);
      return;
    }
    this.retryS = FIRST_RETRY_S;
    if (envelope.topic === "pong") this.pong(message, envelope.received_ns);
    else {
      if (envelope.topic === "hello") this.clock.sync(message.now_ns / 1e6, this.openedAt);
      const { topic, service, received_ns: receivedNs } = envelope;
      this.onMessage({ topic, service, message, receivedNs });
    }
  }

  /** A connection that went away without a word is noticed here: pings stay unanswered. */
  beat() {
    if (document.hidden || !this.socket) return;
    if (performance.now() - this.heardAt > SILENCE_MS) {
      this.lost(this.socket);
      return;
    }
    if (this.socket.readyState !== WebSocket.OPEN) return;
    this.asked.set(++this.pings, performance.now());
    this.socket.send(JSON.stringify({ ping: this.pings }));
  }

  pong(number, receivedNs) {
    const askedAt = this.asked.get(number);
    if (askedAt !== undefined) this.clock.sync(receivedNs / 1e6, askedAt);
    this.asked.clear();
  }

  lost(socket) {
    if (socket !== this.socket) return;
    this.socket = null;
    this.asked.clear();
    socket.onclose = socket.onmessage = null;
    socket.close();
    this.onState("lost", this.retryS);
    this.timer = setTimeout(() => this.open(), this.retryS * 1000);
    this.retryS = Math.min(LAST_RETRY_S, this.retryS * 2);
  }

  retryNow() {
    if (this.socket) return;
    clearTimeout(this.timer);
    this.open();
  }

  pauseOrResume() {
    this.heardAt = performance.now();
    if (!document.hidden) this.retryNow();
    if (this.socket?.readyState !== WebSocket.OPEN) return;
    this.socket.send(JSON.stringify({ pause: document.hidden }));
  }
}
