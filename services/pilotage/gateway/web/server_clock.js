// The gateway's clock, read from here: stamps are compared with it, never with the page's own.
//
// Each ping gives one reading; the one with the shortest round trip is off by half of that at
// the most, so it is kept until readings as good come, or until it is a minute old.

const KEPT_MS = 60_000;

export class ServerClock {
  constructor(now = () => performance.now()) {
    this.now = now;
    this.roundTripMs = null;
    this.best = null;
  }

  /** Takes a reading: the gateway's Unix time in ms, asked at `askedAt`, answered now. */
  sync(serverMs, askedAt) {
    const at = this.now();
    const roundTrip = at - askedAt;
    const isOld = this.best && at - this.best.at > KEPT_MS;
    if (!this.best || isOld || roundTrip <= this.best.roundTrip) {
      this.best = { at, roundTrip, offset: serverMs + roundTrip / 2 - at };
    }
    this.roundTripMs = roundTrip;
  }

  /** Forgets everything: the next reading counts. */
  reset() {
    this.best = null;
    this.roundTripMs = null;
  }

  /** The gateway's Unix time in ms; the page's own before the first reading. */
  unixMs() {
    return this.best ? this.now() + this.best.offset : Date.now();
  }
}
