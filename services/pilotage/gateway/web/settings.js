// What the page remembers of its user: layers, theme, hidden notice. Works without storage too.

const KEY = "pilotage";

export const settings = {
  values: read(),

  get(name, fallback) {
    return this.values[name] ?? fallback;
  },

  set(name, value) {
    this.values[name] = value;
    try {
      localStorage.setItem(KEY, JSON.stringify(this.values));
    } catch {
      // Private windows may have no storage: then the choice lasts as long as the page.
    }
  },

  forget(...names) {
    for (const name of names) this.set(name, undefined);
  },
};

function read() {
  try {
    return JSON.parse(localStorage.getItem(KEY)) ?? {};
  } catch {
    return {};
  }
}
