// What both halves of the folded part "Map" do alike: send a command and say what came of it.

import { setText } from "./elements.js";

const NOTE_MS = 4000;
const NAME = /^[A-Za-z0-9_][A-Za-z0-9_.-]{0,63}$/;

export class LibraryPart {
  constructor(note, state, commands, token) {
    Object.assign(this, { note, state, commands, token });
    this.noteUntil = 0;
    this.listed = "";
  }

  /** Keeps what is in use under the name in a field, if it is one. */
  async keep(command, field) {
    const name = field.value.trim();
    if (!NAME.test(name)) return this.tell("A name has letters, digits, _ . and -, at most 64", true);
    await this.give(command, { name }, () => `Kept as ${name}`);
    return this.list();
  }

  async give(command, body, done) {
    try {
      this.tell(done(await this.commands.send(command, body)), false);
    } catch (error) {
      this.tell(error.message, true);
    }
  }

  tell(text, isFault) {
    this.noteUntil = performance.now() + NOTE_MS * (isFault ? 2 : 1);
    setText(this.note, text);
    this.note.classList.toggle("is-fault", isFault);
  }

  /** Says how things stand, once what came of a command has been read. */
  say(text) {
    if (performance.now() < this.noteUntil) return;
    this.note.classList.remove("is-fault");
    setText(this.note, text);
  }
}
