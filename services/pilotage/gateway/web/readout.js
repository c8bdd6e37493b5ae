// One line by the legend: where the pointer is on the map, and how likely the robot is there.

import { find, setText } from "./elements.js";
import { into } from "./geometry.js";
import { number, withUnit } from "./format.js";

export class Readout {
  constructor(view, scene, state) {
    Object.assign(this, { view, scene, state });
    this.at = null;
  }

  point(at) {
    this.at = at;
    if (at === null) setText(find("#readout"), "");
  }

  update() {
    const grid = this.scene.walls.grid;
    if (!this.at || !grid) return;
    const { x, y } = this.view.toMap(this.at);
    const local = into(grid.origin, x, y);
    const [row, col] = [local.y, local.x].map((value) => Math.floor(value / grid.resolution));
    const mass = this.scene.belief.massAt({ x, y });
    const share = mass === null ? "" : ` · mass ${withUnit(mass * 100, 2, "%")}`;
    const height = this.scene.layers.has("potential") ? this.scene.potential.valueAt({ x, y }) : null;
    const rise = height === null ? "" : ` · potential ${number(height, 2)}`;
    setText(find("#readout"), `x ${number(x, 2)} y ${number(y, 2)}\u202fm · cell ${row}, ${col}${share}${rise}`);
  }
}
