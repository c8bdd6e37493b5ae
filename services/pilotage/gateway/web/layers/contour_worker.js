// Finds the lines of a field beside the page: a large field takes longer than a frame may.

import { contoursOf, isLarge, levelsOf, widened } from "./contours.js";
import { finerBy, refined } from "./smoothing.js";

onmessage = ({ data: { number, field, count } }) => {
  const factor = finerBy(field);
  const fine = refined(factor > 1 ? widened(field) : field, factor);
  // Rings of a few cells of a coarse field are its noise.
  const least = factor > 1 ? 3 * factor : 0;
  const lines = contoursOf(widened(fine), levelsOf(fine, count));
  const kept = lines.map((level) => level.filter((line) => isLarge(line, least)));
  postMessage({ number, lines: kept, fine, factor }, [fine.data.buffer]);
};
