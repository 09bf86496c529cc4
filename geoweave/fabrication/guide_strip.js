// Strips as they are cut: their drawings are unpacked here, and shown in windows that move along them.
"use strict";

const SVG = "http://www.w3.org/2000/svg";

function svg(kind, attributes, parent) {
  const element = document.createElementNS(SVG, kind);
  for (const key in attributes) element.setAttribute(key, attributes[key]);
  if (parent) parent.appendChild(element);
  return element;
}

// Figures of a strip, as paths of an SVG whose unit is a millimetre and whose y points up.
function unpacked(drawing, grain) {
  const bytes = bytesOf(drawing.data), figures = [];
  let k = 0, x = 0, y = 0;
  const number = () => {
    let value = 0, factor = 1, byte;
    do { byte = bytes[k++]; value += (byte & 127) * factor; factor *= 128; } while (byte & 128);
    return value;
  };
  const signed = () => { const value = number(); return value & 1 ? -(value + 1) / 2 : value / 2; };
  const text = (value) => String(Math.round(value * grain * 1000) / 1000);
  while (k < bytes.length) {
    const ink = number(), crossing = number() - 1, closed = number(), parts = [];
    for (let paths = number(); paths > 0; paths--) {
      let letter = "M";
      for (let points = number(); points > 0; points--) {
        x += signed(); y += signed();
        parts.push(letter, text(x), ",", text(y));
        letter = "L";
      }
      if (closed) parts.push("Z");
    }
    figures.push({ ink, crossing, path: parts.join("") });
  }
  return figures;
}

// The part of a strip on which its partner lies, about the crossing.
function overlapOf(angle, width) {
  const half = width / 2, turn = angle * Math.PI / 180;
  const sine = Math.max(Math.abs(Math.sin(turn)), 0.2) * Math.sign(Math.sin(turn) || 1), cosine = Math.cos(turn);
  return [[half, 1], [half, -1], [-half, -1], [-half, 1]].map(([y, way]) => [(y * cosine + way * half) / sine, y]);
}

class Belt {
  constructor(figure, content, plan, onPick) {
    Object.assign(this, { figure, content, plan, onPick, strip: -1 });
    this.caption = figure.querySelector("figcaption");
    this.box = figure.querySelector(".belt");
    this.map = figure.querySelector(".map");
    this.box.addEventListener("click", (event) => {
      const group = event.target.closest("[data-crossing]");
      if (group) onPick(Number(group.dataset.crossing), this.strip);
    });
    this.box.addEventListener("scroll", () => this.window(), { passive: true });
  }

  // Show a strip near one of its crossings. Crossings are done, being done now, or still to come.
  show(strip, passage, done, now) {
    const fresh = strip !== this.strip;
    if (fresh) this.draw(strip);
    for (const [crossing, groups] of this.groups) {
      const state = done.has(crossing) ? "done" : now.has(crossing) ? "now" : "later";
      groups.forEach((group) => group.setAttribute("class", state));
    }
    this.ticks.replaceChildren();
    const width = this.content.width, drawing = this.content.drawings.strips[strip];
    for (const each of this.plan.passages[strip]) {
      if (done.has(each.crossing)) {
        const x = each.at - drawing.start, y = width * 0.5 + this.pad * 0.62, u = this.pad * 0.3;
        svg("path", { d: `M${x - u},${y}L${x - u / 4},${y - u * 0.7}L${x + u},${y + u}`, class: "tick" }, this.ticks);
      }
    }
    this.current.replaceChildren();
    this.passage = passage;
    if (passage) {
      const x = passage.at - drawing.start, edge = width * 0.5 + this.pad * 0.15, u = this.pad * 0.6;
      const corners = overlapOf(passage.angle, width).map(([a, b]) => `${x + a},${b}`).join(" ");
      svg("polygon", { points: corners, class: "spot", "data-crossing": passage.crossing }, this.current);
      for (const way of [1, -1]) {
        svg("path", { d: `M${x},${way * edge}l${-u * 0.7},${way * u}h${u * 1.4}Z`, class: "caret" }, this.current);
      }
    }
    this.mapped(done, now);
    this.reach(fresh);
  }

  draw(strip) {
    const { content } = this, drawing = content.drawings.strips[strip], look = content.drawings.inks;
    const [left, bottom, right, top] = drawing.extent, width = content.width;
    this.strip = strip;
    this.pad = 0.3 * width;
    const low = Math.min(bottom, -0.5 * width - this.pad), high = Math.max(top, 0.5 * width + this.pad);
    this.frame = { left: left - this.pad, low, wide: right - left + 2 * this.pad, tall: high - low, high };
    const picture = svg("svg", { viewBox: `${this.frame.left} ${-high} ${this.frame.wide} ${this.frame.tall}` });
    const turned = svg("g", { transform: "scale(1,-1)", "stroke-linecap": "round", "stroke-linejoin": "round" }, picture);
    this.groups = new Map();
    let group = null, of = null;
    for (const { ink, crossing, path } of unpacked(drawing, content.drawings.grain)) {
      if (of !== crossing || !group) {
        group = svg("g", crossing < 0 ? {} : { "data-crossing": crossing }, turned);
        of = crossing;
        if (crossing >= 0) this.groups.set(crossing, [...(this.groups.get(crossing) || []), group]);
      }
      const [stroke, pen, fill] = look[ink];
      svg("path", { d: path, fill: fill || "none", ...(stroke ? { stroke, "stroke-width": pen } : {}) }, group);
    }
    this.ticks = svg("g", {}, turned);
    this.current = svg("g", { id: `${this.figure.id}-current` }, turned);
    this.box.replaceChildren(picture);
    this.picture = picture;
    this.resize();
  }

  // Pixels per millimetre, so that strips are as wide as a finger.
  resize() {
    if (this.strip < 0) return;
    this.scale = (window.innerWidth < 700 ? 46 : 70) / this.content.width;
    this.picture.setAttribute("width", this.frame.wide * this.scale);
    this.picture.setAttribute("height", this.frame.tall * this.scale);
  }

  reach(at_once) {
    const drawing = this.content.drawings.strips[this.strip];
    const at = this.passage ? this.passage.at - drawing.start : 0;
    const left = (at - this.frame.left) * this.scale - this.box.clientWidth / 2;
    const still = at_once || window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.box.scrollTo({ left, behavior: still ? "auto" : "smooth" });
    this.window();
  }

  // The whole strip, small, with its crossings.
  mapped(done, now) {
    if (!this.map) return;
    const drawing = this.content.drawings.strips[this.strip], strip = this.plan.strips[this.strip];
    const wide = drawing.length, picture = svg("svg", { viewBox: `0 0 ${wide} 10`, preserveAspectRatio: "none" });
    svg("rect", { x: 0, y: 2, width: wide, height: 6, class: "ground" }, picture)
      .style.fill = this.content.families[strip.family % this.content.families.length];
    for (const each of this.plan.passages[this.strip]) {
      const state = each === this.passage ? "here" : done.has(each.crossing) ? "done" : now.has(each.crossing) ? "now" : "later";
      const x = each.at - drawing.start;
      svg("line", { x1: x, x2: x, y1: state === "here" ? 0 : 2, y2: state === "here" ? 10 : 8, class: state }, picture);
    }
    this.pane = svg("rect", { y: 0.5, height: 9, class: "pane" }, picture);
    this.map.replaceChildren(picture);
  }

  window() {
    if (!this.pane || this.strip < 0) return;
    const low = Math.max(this.box.scrollLeft / this.scale + this.frame.left, 0);
    const room = this.content.drawings.strips[this.strip].length - low;
    this.pane.setAttribute("x", low);
    this.pane.setAttribute("width", Math.max(Math.min(this.box.clientWidth / this.scale, room), 0));
  }
}
