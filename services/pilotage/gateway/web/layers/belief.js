// The belief: the only filled layer. Baked once per message, clipped to the free floor.

import { beliefColour, rampOf } from "../palette.js";
import { into } from "../geometry.js";
import { placeImage } from "./walls.js";

const MOST_PIXELS = 2_000_000;

export class BeliefLayer {
  constructor(walls) {
    this.walls = walls;
    this.marginal = null;
    this.baked = null;
  }

  /** Takes the marginal of a Belief; null clears. */
  take(marginal, palette) {
    this.marginal = marginal;
    this.colour(palette);
  }

  colour(palette) {
    this.baked = this.marginal && this.walls.grid ? this.bake(rampOf(palette)) : null;
  }

  draw(context, view, ratio) {
    if (!this.baked) return;
    const { origin, resolution, mass } = this.marginal;
    const [rows, cols] = mass.shape;
    view.applyTo(context, ratio);
    placeImage(context, origin);
    context.imageSmoothingEnabled = true;
    context.drawImage(this.baked, 0, 0, cols * resolution, rows * resolution);
  }

  /** Probability of the cell at a point of the map, or null off the marginal. */
  massAt(point) {
    if (!this.marginal) return null;
    const { origin, resolution, mass } = this.marginal;
    const local = into(origin, point.x, point.y);
    const [row, col] = [Math.floor(local.y / resolution), Math.floor(local.x / resolution)];
    const [rows, cols] = mass.shape;
    if (row < 0 || col < 0 || row >= rows || col >= cols) return 0;
    return mass.data[row * cols + col];
  }

  bake(ramp) {
    const { origin, resolution, mass } = this.marginal;
    const [rows, cols] = mass.shape;
    const level = this.walls.maskLevel(this.finest(rows * resolution, cols * resolution));
    const factor = Math.max(1, Math.round(resolution / level.cell));
    const canvas = new OffscreenCanvas(cols * factor, rows * factor);
    const context = canvas.getContext("2d");
    context.drawImage(this.image(ramp), 0, 0, canvas.width, canvas.height);
    context.globalCompositeOperation = "destination-in";
    context.imageSmoothingEnabled = false;
    this.drawMask(context, level, factor / resolution, origin);
    return canvas;
  }

  /** Cell size that keeps the baked image of `height` x `width` m within its limit. */
  finest(height, width) {
    return Math.max(this.walls.levels[0].cell, Math.sqrt((height * width) / MOST_PIXELS));
  }

  drawMask(context, level, perMetre, origin) {
    const corner = into(origin, this.walls.grid.origin.x, this.walls.grid.origin.y);
    context.scale(perMetre, perMetre);
    context.translate(corner.x, corner.y);
    context.rotate(this.walls.grid.origin.theta - origin.theta);
    context.drawImage(level.floor, 0, 0, level.cols * level.cell, level.rows * level.cell);
  }

  image(ramp) {
    const { resolution, mass } = this.marginal;
    const [rows, cols] = mass.shape;
    const image = new ImageData(cols, rows);
    const area = resolution * resolution;
    for (let i = 0; i < mass.data.length; i++) {
      const colour = beliefColour(ramp, mass.data[i] / area);
      if (colour) image.data.set(colour, 4 * i);
    }
    const canvas = new OffscreenCanvas(cols, rows);
    canvas.getContext("2d").putImageData(image, 0, 0);
    return canvas;
  }
}
