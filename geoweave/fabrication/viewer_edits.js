// What a person changes: ribbons dropped, crossings flipped, branch points moved, a direction to follow.
// This part knows the weave and no page.
"use strict";

class Edits {
  constructor(content) {
    this.content = content;
    this.before = [];
    this.clear();
  }

  clear() {
    this.dropped = new Set();
    this.flipped = new Set();
    this.points = this.content.singularities.map(([x, y, z, index]) => ({ point: [x, y, z], from: [x, y, z], index, pinned: false }));
    this.line = [];
    this.everywhere = false;
  }

  // What there is now, to be able to go back to it.
  keep() {
    this.before.push({ dropped: [...this.dropped], flipped: [...this.flipped], points: this.points.map((each) => ({ ...each })),
      line: this.line.slice(), everywhere: this.everywhere });
  }

  undo() {
    const last = this.before.pop();
    if (last) Object.assign(this, last, { dropped: new Set(last.dropped), flipped: new Set(last.flipped) });
    return Boolean(last);
  }

  drop(strip) {
    this.keep();
    if (!this.dropped.delete(strip)) this.dropped.add(strip);
  }

  // Crossings of the design, by their numbers: ribbons that are held together once are flipped together.
  flip(crossings) {
    this.keep();
    const back = crossings.every((each) => this.flipped.has(each));
    crossings.forEach((each) => { if (back) this.flipped.delete(each); else this.flipped.add(each); });
  }

  pin(number) {
    this.keep();
    this.points[number].pinned = !this.points[number].pinned;
  }

  move(number, point) {
    this.keep();
    this.points[number].point = point;
  }

  mark(point) {
    this.keep();
    this.line.push(point);
  }

  follow(everywhere) {
    this.keep();
    this.everywhere = everywhere;
  }

  forget() {
    this.keep();
    this.line = [];
  }

  moved(number) {
    const { point, from } = this.points[number];
    return point.some((x, k) => x !== from[k]);
  }

  // Whether ribbons or crossings are changed, and whether the weave is to be made anew.
  get changes() { return this.dropped.size > 0 || this.flipped.size > 0; }
  get steers() { return this.line.length > 1 || this.points.some((each, k) => each.pinned || this.moved(k)); }
  get any() { return this.changes || this.steers; }

  // Points of a curve to follow, or one direction.
  get guide() {
    if (this.line.length < 2) return null;
    if (!this.everywhere) return this.line;
    const a = this.line[0], b = this.line[this.line.length - 1];
    return [a.map((x, k) => b[k] - x)];
  }

  // The contents of edits.json.
  document() {
    const { strips, crossings, key, title, units } = this.content, name = (r) => strips[r][0];
    const fixed = this.points.some((each, k) => each.pinned || this.moved(k));
    return {
      format: "geoweave-edits",
      version: 1,
      of: title,
      key,
      units,
      drop: [...this.dropped].sort((a, b) => a - b).map(name),
      flip: [...this.flipped].sort((a, b) => a - b).map((x) => {
        const [a, b, , , over] = crossings[x];
        return { crossing: x, ribbons: [name(a), name(b)], over: 1 - over };
      }),
      // All of them, or none: a field is known only with all its singularities.
      singularities: fixed ? this.points.map((each, k) => ({ point: each.point, index: each.index,
        ...(this.moved(k) ? { moved_from: each.from } : {}), ...(each.pinned ? { pinned: true } : {}) })) : null,
      align: this.guide,
    };
  }

  // One sentence for each change.
  said() {
    const { strips, crossings, symmetry } = this.content, name = (r) => strips[r][0];
    return [
      ...[...this.dropped].map((r) => `${name(r)} is dropped`),
      ...[...this.flipped].map((x) => {
        const [a, b, , , over] = crossings[x];
        return `${name(over ? a : b)} goes over ${name(over ? b : a)}`;
      }),
      ...this.points.flatMap((each, k) => this.moved(k) ? [`Branch point ${k + 1} (${each.index}/${symmetry}) is moved`]
        : each.pinned ? [`Branch point ${k + 1} (${each.index}/${symmetry}) stays`] : []),
      ...(this.line.length < 2 ? [] : [this.everywhere ? "One family follows the direction everywhere" : "One family follows the line"]),
    ];
  }
}
