// The weave in space as it is looked at: two shapes, colours, what is under a finger, what is changed.
"use strict";

const RAMP = ["#efe9dc", "#f0c48a", "#e08a5a", "#b5475c", "#5b2358"].map((text) => [1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16)));
const PLAIN = [214, 207, 194], HARD = [216, 54, 28], CHANGED = "#1f5fa8";
const NEAR = 0.6, REACH = 2.5, LEVEL = 0.5, LEVEL_SHARE = 0.4;

class ViewSpace extends WeaveInSpace {
  constructor(canvas, content, edits) {
    super(canvas, content, content.strips.map(([label, family, closed, length]) => ({ label, family, closed, length })));
    Object.assign(this, { edits, shapes: [], colour: "family", selected: null, over: null, tags: [], mode: "look" });
    this.ring = this.marker();
    this.scene.add(this.ring);
    this.pointed = new THREE.Group();
    this.scene.add(this.pointed);
    this.shape(content.states.length - 1);
    this.start();
  }

  // ---- shapes

  // Show one of the shapes, as designed or at rest.
  shape(number) {
    if (this.now) this.now.group.visible = false;
    this.now = this.built(number);
    this.number = number;
    this.now.group.visible = true;
    Object.assign(this, { ways: this.now.ways, meshes: this.now.meshes });
    if (!this.middle) this.measure();
    this.selected = null;
    this.over = null;
    // A design has no forces.
    if (this.colour === "force" && !this.content.states[number].force) this.colour = "family";
    this.refresh();
  }

  built(number) {
    if (this.shapes[number]) return this.shapes[number];
    const state = this.content.states[number], ways = this.read(state.shape), group = new THREE.Group();
    const bends = new Int16Array(bytesOf(state.bend.steps).buffer);
    let first = 0;
    const meshes = ways.map((way, r) => {
      way.bend = bends.subarray(first, first + way.count);
      first += way.count;
      const { family } = this.strips[r], mesh = this.ribbon(way, r, this.content.families[family % this.content.families.length]);
      const tint = new THREE.InterleavedBuffer(new Uint8Array(4 * 8 * way.count), 4);
      mesh.geometry.setAttribute("tint", new THREE.InterleavedBufferAttribute(tint, 3, 0, true));
      way.plain = mesh.geometry.attributes.position.array.slice();
      this.flatten(way, this.strips[r].closed);
      group.add(mesh);
      return mesh;
    });
    const lines = ways.map((way) => {
      const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(way.centre), new THREE.LineDashedMaterial({ color: "#a59d8f", dashSize: this.content.width, gapSize: 0.7 * this.content.width }));
      line.computeLineDistances();
      line.visible = false;
      group.add(line);
      return line;
    });
    const lengths = state.shape.lengths;
    const crossings = state.crossings.map(([a, b, s, t, over, angle, designs]) => ({ strips: [a, b], at: [s * lengths[a], t * lengths[b]], over, angle, designs }));
    const passages = ways.map(() => []);
    crossings.forEach((each, x) => [0, 1].forEach((side) => passages[each.strips[side]].push({ crossing: x, side, at: each.at[side], partner: each.strips[1 - side] })));
    passages.forEach((each) => each.sort((one, two) => one.at - two.at));
    group.visible = false;
    this.scene.add(group);
    this.shapes[number] = { ways, meshes, lines, group, crossings, passages, lengths };
    return this.shapes[number];
  }

  // For picking: cross sections as flat pieces, ten numbers each, and a ball round the ribbon.
  flatten(way, closed) {
    const { count } = way, flat = new Float32Array(10 * count), ahead = new THREE.Vector3(), side = new THREE.Vector3();
    for (let k = 0; k < count; k++) {
      const next = k + 1 < count ? k + 1 : closed ? 1 : k, before = k ? k - 1 : closed ? count - 2 : k;
      ahead.subVectors(way.centre[next], way.centre[before]);
      const half = Math.max(k ? way.at[k] - way.at[k - 1] : 0, k + 1 < count ? way.at[k + 1] - way.at[k] : 0) / 2;
      side.crossVectors(way.up[k], ahead).normalize();
      flat.set([...way.centre[k].toArray(), ...way.up[k].toArray(), ...side.toArray(), half], 10 * k);
    }
    way.flat = flat;
    const box = new THREE.Box3().setFromPoints(way.centre);
    way.ball = box.getBoundingSphere(new THREE.Sphere());
  }

  // Which side is above at a crossing, after what was changed.
  overAt(x) {
    const each = this.now.crossings[x];
    return each.designs.length && each.designs.every((design) => this.edits.flipped.has(design)) ? 1 - each.over : each.over;
  }

  // ---- what is to be seen

  refresh() {
    const { now, edits } = this, there = new Set();
    this.strips.forEach((strip, r) => { if (!edits.dropped.has(r)) there.add(r); });
    const passages = now.passages.map((each) => each.map((one) => ({ ...one, over: this.overAt(one.crossing) === one.side })));
    this.flipped();
    this.shaded(there, passages);
    this.coloured();
    this.focus();
    this.points();
    this.dirty = true;
  }

  // Ribbons change places at flipped crossings, between level stretches there and at the next crossings.
  flipped() {
    const { now, content } = this, reach = LEVEL * content.width;
    now.ways.forEach((way, r) => {
      const met = now.passages[r], { closed } = this.strips[r], length = now.lengths[r];
      const flips = met.map((each) => this.overAt(each.crossing) !== now.crossings[each.crossing].over);
      const key = flips.map(Number).join("");
      if ((way.flips || "") === key || (!way.flips && !flips.includes(true))) return;
      way.flips = key;
      const position = now.meshes[r].geometry.attributes.position, n = way.count, lift = new Float32Array(n);
      met.forEach((each, k) => {
        if (!flips[k]) return;
        const here = this.spot(r, each.at), { strips, at } = now.crossings[each.crossing];
        const apart = here.point.clone().sub(this.spot(strips[1 - each.side], at[1 - each.side]).point).dot(here.up);
        const gap = (other, wrap) => other ? Math.abs(other.at - each.at) : closed && met.length > 1 ? Math.abs(wrap.at - each.at + (wrap.at < each.at ? length : -length)) : Infinity;
        const back = gap(met[k - 1], met[met.length - 1]), ahead = gap(met[k + 1], met[0]);
        for (let p = 0; p < n; p++) {
          let d = way.at[p] - each.at;
          if (closed) d -= length * Math.round(d / length);
          const room = d < 0 ? back : ahead, level = Math.min(reach, LEVEL_SHARE * room);
          const share = room === Infinity ? 0 : Math.min(Math.max((Math.abs(d) - level) / Math.max(room - 2 * level, 1e-9), 0), 1);
          if (Math.abs(d) < room) lift[p] -= apart * (1 - share * share * (3 - 2 * share));
        }
      });
      for (let block = 0; block < 8; block++) {
        for (let p = 0; p < n; p++) {
          const i = 3 * (block * n + p), up = way.up[p];
          position.array[i] = way.plain[i] + lift[p] * up.x;
          position.array[i + 1] = way.plain[i + 1] + lift[p] * up.y;
          position.array[i + 2] = way.plain[i + 2] + lift[p] * up.z;
        }
      }
      position.needsUpdate = true;
    });
  }

  // How much counts as most bent: what one cross section in fifty exceeds.
  get mostBent() {
    if (this.now.bent === undefined) {
      const all = [];
      this.now.ways.forEach((way) => way.bend.forEach((step) => all.push(Math.abs(step))));
      const sorted = Int32Array.from(all).sort();
      this.now.bent = Math.max(sorted[Math.floor(0.98 * sorted.length)], 1);
    }
    return this.now.bent;
  }

  coloured() {
    const { now, colour } = this;
    const key = `${colour}`;
    now.meshes.forEach((mesh) => { mesh.material.uniforms.tinted.value = colour === "family" ? 0 : 1; });
    if (colour === "family" || now.tinted === key) return;
    now.tinted = key;
    const near = colour === "hard" ? this.hard() : null, most = this.mostBent, forces = colour === "force" ? this.pulled() : null;
    now.meshes.forEach((mesh, r) => {
      const way = now.ways[r], n = way.count, { data } = mesh.geometry.attributes.tint, mixed = [0, 0, 0];
      for (let k = 0; k < n; k++) {
        if (near) for (let c = 0; c < 3; c++) mixed[c] = PLAIN[c] + near[r][k] * (HARD[c] - PLAIN[c]);
        else ramp(forces ? forces[r][k] : Math.abs(way.bend[k]) / most, mixed);
        for (let block = 0; block < 8; block++) data.array.set(mixed, 4 * (block * n + k));
      }
      data.needsUpdate = true;
    });
  }

  // For each cross section, 1 at a hard place on its ribbon and 0 away from all.
  hard() {
    const { width } = this.content, found = this.now.ways.map((way) => new Float32Array(way.count)), point = new THREE.Vector3();
    for (const place of this.content.places) {
      point.set(...place.at[Math.min(this.number, place.at.length - 1)]);
      for (const r of place.ribbons) {
        this.now.ways[r].centre.forEach((each, k) => {
          const d = each.distanceTo(point) / width;
          if (d < 3) found[r][k] = Math.max(found[r][k], Math.min(1, Math.max(0, 2.5 - d)));
        });
      }
    }
    return found;
  }

  // The force that counts as most: what one crossing in fifty exceeds.
  get mostPulled() {
    const sorted = Float64Array.from(this.content.states[this.number].force.map((each) => each || 0)).sort();
    return sorted[Math.floor(0.98 * (sorted.length - 1))] || 1;
  }

  // For each cross section the force at its crossing as a share of the most, linear between crossings.
  pulled() {
    const { force } = this.content.states[this.number], most = this.mostPulled;
    return this.now.ways.map((way, r) => {
      const met = this.now.passages[r].map((each) => [each.at, (force[each.crossing] || 0) / most]);
      const found = new Float32Array(way.count);
      for (let k = 0, i = 0; met.length && k < way.count; k++) {
        while (i + 1 < met.length && met[i + 1][0] < way.at[k]) i++;
        const [s, one] = met[i], [t, other] = met[Math.min(i + 1, met.length - 1)];
        const share = t > s ? Math.min(Math.max((way.at[k] - s) / (t - s), 0), 1) : 0;
        found[k] = one + share * (other - one);
      }
      return found;
    });
  }

  // What is selected, or under the pointer, stands out.
  focus() {
    const { now, edits, selected } = this;
    const own = selected === null ? [] : selected.kind === "ribbon" ? [selected.strip] : now.crossings[selected.crossing].strips;
    now.meshes.forEach((mesh, r) => {
      const u = mesh.material.uniforms, hovered = this.over && (this.over.kind === "ribbon" ? this.over.strip === r : now.crossings[this.over.crossing].strips.includes(r));
      mesh.visible = !edits.dropped.has(r);
      now.lines[r].visible = edits.dropped.has(r);
      u.quiet.value = own.length && !own.includes(r) ? 0.55 : 0;
      u.arrows.value = selected && selected.kind === "ribbon" && own.includes(r) ? 1 : 0;
      u.glow.value = hovered ? 1.4 : 0;
    });
    this.ring.visible = Boolean(selected && selected.kind === "crossing");
    if (this.ring.visible) {
      const { point, up } = this.placeOf(selected);
      this.ring.position.copy(point);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), up);
    }
    this.dirty = true;
  }

  // Where a ribbon or a crossing is, and which way is outwards there.
  placeOf(what) {
    if (what.kind === "ribbon") return this.spot(what.strip, what.at === undefined ? this.now.lengths[what.strip] / 2 : what.at);
    const { strips, at } = this.now.crossings[what.crossing], here = this.spot(strips[0], at[0]);
    here.point.add(this.spot(strips[1], at[1]).point).multiplyScalar(0.5);
    return here;
  }

  select(what) {
    this.selected = what;
    this.focus();
  }

  // Branch points and the line to follow, while they are worked on.
  points() {
    const { width } = this.content, { pointed, edits } = this;
    pointed.children.slice().forEach((each) => { pointed.remove(each); each.geometry.dispose(); each.material.dispose(); });
    const ball = (point, colour, size) => {
      const mesh = new THREE.Mesh(new THREE.SphereGeometry(size * width, 20, 14), new THREE.MeshBasicMaterial({ color: colour, transparent: true, depthTest: false }));
      mesh.position.set(...point);
      mesh.renderOrder = 5;
      pointed.add(mesh);
    };
    const line = (points, colour) => {
      const geometry = new THREE.BufferGeometry().setFromPoints(points.map((each) => new THREE.Vector3(...each)));
      const drawn = new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: colour, depthTest: false, transparent: true }));
      drawn.renderOrder = 4;
      pointed.add(drawn);
    };
    edits.points.forEach((each, k) => {
      const changed = each.pinned || edits.moved(k);
      if (this.mode !== "points" && !changed) return;
      if (edits.moved(k)) line([each.from, each.point], CHANGED);
      ball(each.point, k === this.chosen ? ACCENT : changed ? CHANGED : "#22262b", 0.4);
    });
    edits.line.forEach((each) => ball(each, CHANGED, 0.3));
    if (edits.line.length > 1) line(edits.line, CHANGED);
  }

  // ---- what is under a finger

  ray(x, y) {
    const box = this.canvas.getBoundingClientRect(), caster = new THREE.Raycaster();
    caster.setFromCamera(new THREE.Vector2(2 * (x - box.left) / box.width - 1, 1 - 2 * (y - box.top) / box.height), this.camera);
    return caster.ray;
  }

  // The frontmost cross section that a ray hits, or passes within some length of: its ribbon, number and point.
  hit(ray, slack) {
    const o = ray.origin, d = ray.direction, half = this.content.width / 2, { ways, edits } = this;
    let best = null;
    for (let r = 0; r < ways.length; r++) {
      const way = ways[r];
      if (edits.dropped.has(r) || ray.distanceToPoint(way.ball.center) > way.ball.radius + half + slack) continue;
      const f = way.flat;
      for (let k = 0, i = 0; k < way.count; k++, i += 10) {
        const facing = d.x * f[i + 3] + d.y * f[i + 4] + d.z * f[i + 5];
        if (Math.abs(facing) < 0.03 || (slack > half && Math.abs(facing) < 0.2)) continue;
        const x = f[i] - o.x, y = f[i + 1] - o.y, z = f[i + 2] - o.z;
        const t = (x * f[i + 3] + y * f[i + 4] + z * f[i + 5]) / facing;
        if (t <= 0 || (best && t >= best.t)) continue;
        const p = t * d.x - x, q = t * d.y - y, s = t * d.z - z;
        const across = p * f[i + 6] + q * f[i + 7] + s * f[i + 8];
        if (Math.abs(across) > half + slack) continue;
        if (p * p + q * q + s * s - across * across > (f[i + 9] + slack) ** 2) continue;
        best = { strip: r, section: k, t, at: way.at[k] };
      }
    }
    if (best) best.point = ray.at(best.t, new THREE.Vector3());
    return best;
  }

  // The ribbon or the crossing at a place of the screen; a finger may miss by so many pixels.
  at(x, y, pixels) {
    const ray = this.ray(x, y), hit = this.hit(ray, 0) || this.hit(ray, pixels * this.pixel());
    if (!hit) return null;
    const { closed } = this.strips[hit.strip], length = this.now.lengths[hit.strip];
    let near = null, least = NEAR * this.content.width;
    for (const each of this.now.passages[hit.strip]) {
      if (this.edits.dropped.has(each.partner)) continue;
      let far = Math.abs(each.at - hit.at);
      if (closed) far = Math.min(far, length - far);
      if (far < least) { least = far; near = each; }
    }
    return near ? { kind: "crossing", crossing: near.crossing, point: hit.point } : { kind: "ribbon", strip: hit.strip, at: hit.at, point: hit.point };
  }

  // A point of the surface there; between ribbons it is that of the nearest one's face, continued.
  surface(x, y) {
    const hit = this.hit(this.ray(x, y), REACH * this.content.width);
    return hit ? hit.point.toArray().map((each) => Number(each.toPrecision(7))) : null;
  }

  // The branch point under a finger.
  pointAt(x, y, pixels) {
    const box = this.canvas.getBoundingClientRect();
    let best = -1, least = Math.max(pixels, 14);
    this.edits.points.forEach((each, k) => {
      const seen = this.seen(new THREE.Vector3(...each.point));
      const far = Math.hypot(seen.x - (x - box.left), seen.y - (y - box.top));
      if (seen.front && far < least) { least = far; best = k; }
    });
    return best;
  }

  listen() {
    super.listen();
    const { canvas } = this;
    let asked = null;
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons || event.pointerType === "touch" || this.mode !== "look") return;
      if (!asked) requestAnimationFrame(() => { const { clientX, clientY } = asked; asked = null; this.hover(this.at(clientX, clientY, 2)); });
      asked = event;
    });
    canvas.addEventListener("pointerleave", () => this.hover(null));
  }

  hover(what) {
    const before = this.over;
    this.over = what;
    if (what || before) { this.focus(); this.onHover(what); }
  }

  onHover() {}

  pick(event) { this.tapped(event.clientX, event.clientY, event.pointerType === "touch" ? 14 : 3); }

  // ---- the camera

  // Look at a place from outside.
  flyTo(point, up, far) {
    const target = new THREE.Vector3(...point), out = up || target.clone().sub(this.middle).normalize();
    this.free = true;
    this.fly({ direction: out.lengthSq() > 0 ? out : this.direction, distance: Math.max(far * this.content.width, 0.3 * this.radius), target });
  }

  draw() {
    this.dirty = false;
    const { camera, renderer, canvas } = this, wide = canvas.clientWidth, tall = canvas.clientHeight;
    this.aim(wide, tall, 0);
    this.ring.scale.setScalar(Math.max(1, 13 * this.pixel() / this.content.width));
    const least = 5 * this.pixel() / this.content.width / 0.4;
    this.pointed.children.forEach((each) => each.isMesh && each.scale.setScalar(Math.max(1, least)));
    renderer.setViewport(0, 0, wide, tall);
    renderer.clear();
    renderer.render(this.scene, camera);
    if (this.onDraw) this.onDraw();
  }
}

// A colour of the ramp, in bytes, for a number from 0 to 1.
function ramp(share, mixed) {
  const place = Math.min(Math.max(share, 0), 1) * (RAMP.length - 1), k = Math.min(Math.floor(place), RAMP.length - 2), t = place - k;
  for (let c = 0; c < 3; c++) mixed[c] = RAMP[k][c] + t * (RAMP[k + 1][c] - RAMP[k][c]);
}
