// Small pieces of the document.

const SVG = "http://www.w3.org/2000/svg";

export const find = (selector, root = document) => root.querySelector(selector);

/** Returns an element with attributes and children; strings become text, never markup. */
export function element(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (value !== undefined && value !== null && value !== false) node.setAttribute(key, value);
  }
  node.append(...children);
  return node;
}

/** Returns the shape of a status: ok, warning, fault or none. */
export function shape(kind) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "shape");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS(SVG, "use");
  use.setAttribute("href", `#s-${kind}`);
  svg.append(use);
  return svg;
}

/** Sets text only where it differs, so that nothing is laid out or read aloud anew. */
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

/** Puts a list of definitions: [[term, text], ...]. */
export function setTerms(list, terms) {
  const key = JSON.stringify(terms);
  if (list.dataset.terms === key) return;
  list.dataset.terms = key;
  list.replaceChildren(
    ...terms.flatMap(([term, text]) => [element("dt", {}, term), element("dd", {}, text)]),
  );
}
