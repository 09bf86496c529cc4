// A map of the object: which zones it is put together in, seen from the front and from behind.
"use strict";

const ZONE_COLOURS = ["#2f6690", "#d9a441", "#6a994e", "#a8516a", "#3f8d8c", "#b5651d", "#7b6fae", "#8a8f3a", "#c0563f"];
const MAP_STEP = 3;

class ZoneMap {
  constructor(box, content, plan) {
    this.zones = plan.zones;
    this.views = [["front", 1], ["behind", -1]].map(([name, way]) => this.view(box, content, plan, name, way));
  }

  // The ribbons as lines, as far as they face the eye.
  view(box, content, plan, name, way) {
    const { axes, front } = this.looking(content.up || 0, way), ways = this.lines(content.shape);
    const figure = document.createElement("figure"), caption = document.createElement("figcaption");
    const room = [Infinity, Infinity, -Infinity, -Infinity], drawing = svg("svg", { role: "img" });
    caption.textContent = name === "front" ? "from the front" : "from behind";
    const groups = plan.zones.map((strips, zone) => {
      const group = svg("g", { "data-zone": zone, stroke: ZONE_COLOURS[zone % ZONE_COLOURS.length] });
      const middle = [0, 0, 0];
      for (const r of strips) {
        const parts = [];
        let drawn = false;
        ways[r].forEach(({ point, up }) => {
          const x = dot(point, axes[0]), y = -dot(point, axes[1]), seen = dot(up, front) > 0;
          room[0] = Math.min(room[0], x); room[1] = Math.min(room[1], y);
          room[2] = Math.max(room[2], x); room[3] = Math.max(room[3], y);
          if (seen) {
            parts.push(`${drawn ? "L" : "M"}${x.toFixed(1)},${y.toFixed(1)}`);
            middle[0] += x; middle[1] += y; middle[2] += 1;
          }
          drawn = seen;
        });
        svg("path", { d: parts.join("") || "M0,0", "data-strip": r }, group);
      }
      return { group, middle };
    });
    const whole = groups.reduce((sum, each) => sum + each.middle[2], 0), tall = room[3] - room[1], pad = content.width + 0.04 * tall;
    drawing.setAttribute("viewBox", [room[0] - pad, room[1] - pad, room[2] - room[0] + 2 * pad, tall + 2 * pad].map((each) => each.toFixed(1)).join(" "));
    drawing.setAttribute("stroke-width", content.width);
    groups.forEach(({ group }) => drawing.append(group));
    // A zone has its number where a good part of it is to be seen.
    groups.forEach(({ middle }, zone) => {
      if (middle[2] < 0.5 * whole / groups.length) return;
      const text = svg("text", { x: (middle[0] / middle[2]).toFixed(1), y: (middle[1] / middle[2] + 0.04 * tall).toFixed(1), "font-size": (0.12 * tall).toFixed(1), "data-zone": zone }, drawing);
      text.textContent = zone + 1;
    });
    figure.append(drawing, caption);
    box.append(figure);
    return drawing;
  }

  // To the right and up in the picture, and towards the eye.
  looking(side, way) {
    const [e, f, up] = SIDES[side], mix = (x, y, z) => e.map((_, k) => x * e[k] + y * f[k] + z * up[k]);
    const long = Math.hypot(0.55, 0.75), front = mix(0.92 * way * 0.55 / long, 0.92 * -way * 0.75 / long, 0.39);
    const right = mix(way * 0.75 / long, way * 0.55 / long, 0);
    return { axes: [right, cross(front, right)], front };
  }

  // Places of the ribbons and directions outwards.
  lines(shape) {
    const places = new Uint16Array(bytesOf(shape.places).buffer), ups = new Int16Array(bytesOf(shape.ups).buffer);
    let first = 0;
    return shape.counts.map((count) => {
      const line = [];
      for (let k = 0; k < count; k += k + MAP_STEP < count || k === count - 1 ? MAP_STEP : count - 1 - k) {
        const p = 3 * (first + k);
        line.push({ point: [0, 1, 2].map((axis) => shape.low[axis] + places[p + axis] * shape.unit), up: [ups[p], ups[p + 1], ups[p + 2]] });
      }
      first += count;
      return line;
    });
  }

  // The zone of a step stands out, and the strip in hand.
  show(step) {
    const now = step.kind === "start" || step.kind === "done" ? -1 : step.zone;
    this.views.forEach((drawing) => drawing.querySelectorAll("[data-zone]").forEach((each) => {
      const zone = Number(each.dataset.zone);
      each.setAttribute("class", now < 0 ? "all" : zone === now ? "now" : zone < now ? "done" : "later");
      each.querySelectorAll("path").forEach((path) => path.classList.toggle("own", Number(path.dataset.strip) === step.strip));
    }));
  }
}

function dot(a, b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

function cross(a, b) { return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]; }
