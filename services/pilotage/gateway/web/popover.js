// One popover for all chips: opened by click or Enter, closed by Escape, a press elsewhere or Tab.

import { element, find, setTerms } from "./elements.js";

export class Popover {
  constructor() {
    this.box = find("#popover");
    this.list = this.box.appendChild(element("dl"));
    this.owner = null;
    document.addEventListener("pointerdown", (event) => {
      if (!this.box.contains(event.target) && !this.owner?.contains(event.target)) this.close();
    });
    document.addEventListener("keydown", (event) => {
      if (event.key === "Escape") this.close();
    });
  }

  /** Opens at `owner`, or closes when it is open there; `terms()` gives [[term, text], ...]. */
  toggle(owner, terms) {
    if (this.owner === owner) this.close();
    else this.show(owner, terms);
  }

  show(owner, terms) {
    this.owner = owner;
    this.terms = terms;
    this.box.hidden = false;
    this.update();
    const at = owner.getBoundingClientRect();
    const left = Math.max(8, Math.min(at.left, innerWidth - this.box.offsetWidth - 8));
    this.box.style.left = `${left}px`;
    this.box.style.top = `${at.bottom + 8}px`;
  }

  close() {
    this.box.hidden = true;
    this.owner = null;
  }

  update() {
    if (!this.owner) return;
    if (!this.owner.isConnected) this.close();
    else setTerms(this.list, this.terms());
  }
}
