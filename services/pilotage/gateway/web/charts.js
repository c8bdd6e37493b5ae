// Three charts of the last two minutes, aligned in time, with one cursor for all; a fourth joins
// them once there are pairs to count.

import { element, find, setText } from "./elements.js";
import { number, timeOfDay, withUnit } from "./format.js";
import { WINDOW_MS } from "./history.js";

const LABEL_PX = 34;

const CHARTS = [
  { id: "mass", title: "Mass near best place", colour: "mode", rules: () => [0, 0.5, 1],
    label: (v) => `${Math.round(v * 100)}`, value: (v) => withUnit(Math.round(v * 100), 0, "%") },
  { id: "entropy", title: "Uncertainty, bits", colour: "series-2", rules: (top) => [0, top / 2, top],
    label: (v) => number(v, 0), value: (v) => number(v, 1), least: 8 },
  { id: "age", title: "Message age p99, ms", colour: "series-3", rules: () => [1, 30, 1000], isLog: true,
    label: (v) => `${v}`, value: (v) => number(v, 0) },
  { id: "pairs", title: "Matched pairs", colour: "graph", rules: (top) => [0, top / 2, top], isLate: true,
    label: (v) => number(v, 0), value: (v) => number(v, 0), least: 8 },
];

export class Charts {
  constructor(series, events, clock, onTime) {
    Object.assign(this, { series, events, clock, onTime });
    this.palette = null;
    this.cursor = null;
    this.figures = CHARTS.map((chart, i) => this.figure(chart, i));
    find("#charts").append(...this.figures.map((f) => f.node));
    this.choose(0);
  }

  figure(chart, i) {
    const canvas = element("canvas", { role: "img", "aria-label": chart.title });
    const output = element("output");
    const caption = element("figcaption", {}, element("span", { class: "label" }, chart.title), output);
    const node = element("figure", { class: "chart", "data-chart": chart.id }, caption, canvas);
    const tab = element("button", { type: "button", class: "plain", role: "tab" }, chart.title);
    tab.addEventListener("click", () => this.choose(i));
    find("#charts-tabs").append(tab);
    node.hidden = tab.hidden = Boolean(chart.isLate);
    canvas.addEventListener("pointermove", (event) => this.point(event, canvas));
    canvas.addEventListener("pointerleave", () => this.leave());
    new ResizeObserver(() => this.draw()).observe(canvas);
    return { ...chart, node, canvas, output, tab };
  }

  /** Shows the chart that waited for its first data. */
  show(id) {
    const { node, tab } = this.figures.find((figure) => figure.id === id);
    node.hidden = tab.hidden = false;
  }

  choose(chosen) {
    this.figures.forEach(({ node, tab }, i) => {
      node.classList.toggle("is-chosen", i === chosen);
      tab.setAttribute("aria-selected", i === chosen);
    });
  }

  point(event, canvas) {
    const share = (event.offsetX - LABEL_PX) / (canvas.clientWidth - LABEL_PX);
    this.cursor = Math.max(0, Math.min(1, share));
    this.draw();
    this.onTime(this.timeAt(this.cursor));
  }

  leave() {
    this.cursor = null;
    this.draw();
    this.onTime(null);
  }

  timeAt(share) {
    return this.clock.unixMs() - WINDOW_MS * (1 - share);
  }

  draw() {
    if (!this.palette || document.hidden) return;
    const now = this.clock.unixMs();
    for (const figure of this.figures) if (figure.canvas.clientWidth) this.drawOne(figure, now);
  }

  drawOne(figure, now) {
    const { canvas, output } = figure;
    const pen = sized(canvas);
    const area = { left: LABEL_PX, top: 6, width: canvas.clientWidth - LABEL_PX, height: canvas.clientHeight - 12 };
    const series = this.series[figure.id];
    const scale = scaleOf(figure, series, area);
    const x = (at) => area.left + area.width * (1 - (now - at) / WINDOW_MS);
    this.drawRules(pen, figure, scale, area);
    this.drawEvents(pen, x, area);
    drawLine(pen, series.samples, x, scale.y, this.palette[figure.colour], area);
    const at = this.cursor === null ? null : this.timeAt(this.cursor);
    const shown = at === null ? series.latest : (series.near(at)?.value ?? null);
    setText(output, shown === null ? "—" : figure.value(shown));
    if (at !== null) this.drawCursor(pen, x(at), at, area);
  }

  drawRules(pen, figure, scale, area) {
    pen.font = "11px Inter, system-ui, sans-serif";
    pen.textAlign = "left";
    pen.textBaseline = "middle";
    pen.lineWidth = 1;
    for (const rule of scale.rules) {
      const y = Math.round(scale.y(rule)) + 0.5;
      pen.strokeStyle = this.palette.line;
      line(pen, area.left, y, area.left + area.width, y);
      pen.fillStyle = this.palette["text-3"];
      pen.fillText(figure.label(rule), 0, y);
    }
  }

  drawEvents(pen, x, area) {
    pen.setLineDash([3, 3]);
    pen.strokeStyle = this.palette["text-3"];
    for (const event of this.events) {
      const at = x(event.at);
      if (at >= area.left) line(pen, at, area.top, at, area.top + area.height);
    }
    pen.setLineDash([]);
  }

  drawCursor(pen, x, at, area) {
    pen.strokeStyle = this.palette["text-1"];
    line(pen, x, area.top, x, area.top + area.height);
    const near = this.events.find((event) => Math.abs(event.at - at) < WINDOW_MS / 100);
    const text = near ? near.text : timeOfDay(at);
    const isRight = x > area.left + area.width / 2;
    pen.textAlign = isRight ? "right" : "left";
    pen.font = "11px Inter, system-ui, sans-serif";
    const start = x + (isRight ? -6 : 6);
    const width = pen.measureText(text).width;
    pen.fillStyle = this.palette.panel;
    pen.fillRect(isRight ? start - width - 2 : start - 2, area.top, width + 4, 16);
    pen.fillStyle = this.palette["text-1"];
    pen.textBaseline = "top";
    pen.fillText(text, start, area.top + 2);
  }
}

/** The scale of one chart; a top of `least` grows with its values, the others are fixed. */
function scaleOf(figure, series, area) {
  const values = series.samples.map((s) => s.value).filter((v) => v !== null);
  const top = figure.least ? 4 * Math.ceil(Math.max(figure.least, ...values) / 4) : 1;
  const rules = figure.rules(top);
  const [low, high] = [rules[0], rules.at(-1)].map((v) => (figure.isLog ? Math.log(v) : v));
  const y = (value) => {
    const placed = figure.isLog ? Math.log(Math.max(value, rules[0])) : value;
    const share = Math.max(0, Math.min(1, (placed - low) / (high - low)));
    return area.top + area.height * (1 - share);
  };
  return { rules, y };
}

function sized(canvas) {
  const ratio = Math.min(2, devicePixelRatio);
  const [width, height] = [canvas.clientWidth, canvas.clientHeight].map((s) => Math.round(s * ratio));
  if (canvas.width !== width) canvas.width = width;
  if (canvas.height !== height) canvas.height = height;
  const pen = canvas.getContext("2d");
  pen.setTransform(ratio, 0, 0, ratio, 0, 0);
  pen.clearRect(0, 0, width, height);
  return pen;
}

function drawLine(pen, samples, x, y, colour, area) {
  pen.save();
  pen.beginPath();
  pen.rect(area.left, 0, area.width, area.top + area.height + 6);
  pen.clip();
  pen.beginPath();
  let isOpen = false;
  for (const { at, value } of samples) {
    if (value === null) isOpen = false;
    else {
      if (isOpen) pen.lineTo(x(at), y(value));
      else pen.moveTo(x(at), y(value));
      isOpen = true;
    }
  }
  pen.strokeStyle = colour;
  pen.lineWidth = 1.8;
  pen.lineJoin = "round";
  pen.stroke();
  pen.restore();
}

function line(pen, x0, y0, x1, y1) {
  pen.beginPath();
  pen.moveTo(x0, y0);
  pen.lineTo(x1, y1);
  pen.stroke();
}
