// The weave in space: ribbons with width and thickness, which of them are woven, and which crossing is next.
"use strict";

const VERTEX = `
attribute vec3 place;
attribute float shade;
varying vec3 vPlace; varying vec3 vNormal; varying float vShade; varying float vDepth;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  vPlace = place; vShade = shade; vDepth = -seen.z;
  vNormal = normalMatrix * normal;
  gl_Position = projectionMatrix * seen;
}`;

// place: length along the ribbon; -1 to 1 across it; 1 on its outer face, -1 on its inner face, 0 on its edges.
const FRAGMENT = `
uniform vec3 colour; uniform vec3 ground; uniform vec2 haze;
uniform float width; uniform float reach; uniform float quiet; uniform float arrows; uniform float glow;
varying vec3 vPlace; varying vec3 vNormal; varying float vShade; varying float vDepth;
void main() {
  vec3 n = normalize(vNormal);
  vec3 paper = vec3(0.953, 0.933, 0.894);
  vec3 base = vPlace.z > 0.5 ? colour : vPlace.z < -0.5 ? mix(paper, colour, 0.28) : colour * 0.62;
  base = mix(base, mix(vec3(dot(base, vec3(0.3, 0.59, 0.11))), paper, 0.72), quiet);
  float px = fwidth(vPlace.y);
  if (vPlace.z > 0.5) {
    float s = fract((vPlace.x + 0.5 * width * abs(vPlace.y)) / (2.4 * width));
    float ds = fwidth(vPlace.x) / (2.4 * width) + 0.01;
    float line = smoothstep(0.0, ds, s) * (1.0 - smoothstep(0.09, 0.09 + ds, s)) * step(abs(vPlace.y), 0.72);
    base = mix(base, mix(base, vec3(1.0), 0.62), line * arrows);
  }
  float key = max(dot(n, normalize(vec3(-0.45, 0.75, 0.6))), 0.0);
  float fill = 0.5 + 0.5 * dot(n, normalize(vec3(0.5, 0.2, 0.8)));
  vec3 lit = base * (0.50 + 0.34 * key + 0.24 * fill) * mix(1.0, vShade, 1.0 - 0.4 * quiet);
  lit += glow * 0.08;
  float edge = smoothstep(1.0 - 2.2 * px, 1.0 - 0.6 * px, abs(vPlace.y)) * clamp(1.25 - 2.2 * px, 0.0, 1.0);
  lit *= 1.0 - edge * mix(0.5, 0.28, quiet) * step(0.5, abs(vPlace.z));
  float far = smoothstep(haze.x, haze.y, vDepth) * 0.62;
  if (vPlace.x > reach) far = max(far, 0.66);
  gl_FragColor = vec4(mix(lit, ground, far), 1.0);
}`;

const ACCENT = "#d8361c", GROUND = "#fbfaf7";

class Space {
  constructor(canvas, content, plan) {
    Object.assign(this, { canvas, content, plan, following: true, later: true, dirty: true, flight: null });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.autoClear = false;
    this.scene = new THREE.Scene();
    this.scene.background = null;
    this.renderer.setClearColor(GROUND, 1);
    this.camera = new THREE.PerspectiveCamera(30, 1, 1, 10);
    this.eye = new THREE.PerspectiveCamera(30, 1, 1, 10);
    this.shared = { width: { value: content.width }, haze: { value: new THREE.Vector2(1e9, 2e9) },
      ground: { value: rgb(GROUND) } };
    this.read();
    this.build();
    this.tip(0);
    this.whole();
    this.listen();
    const frame = () => { this.tick(); requestAnimationFrame(frame); };
    requestAnimationFrame(frame);
  }

  // Cross sections of all ribbons.
  read() {
    const { shape } = this.content, places = new Uint16Array(bytesOf(shape.places).buffer);
    const ups = new Int16Array(bytesOf(shape.ups).buffer), along = new Uint16Array(bytesOf(shape.along).buffer);
    const [x, y, z] = shape.low;
    let first = 0;
    this.ways = shape.counts.map((count, r) => {
      const way = { count, at: new Float32Array(count), centre: [], up: [] };
      for (let k = 0; k < count; k++) {
        const p = 3 * (first + k);
        way.at[k] = along[first + k] / 65535 * shape.lengths[r];
        way.centre.push(new THREE.Vector3(x + places[p] * shape.unit, y + places[p + 1] * shape.unit, z + places[p + 2] * shape.unit));
        way.up.push(new THREE.Vector3(ups[p], ups[p + 1], ups[p + 2]).normalize());
      }
      first += count;
      return way;
    });
    const box = new THREE.Box3();
    this.ways.forEach((way) => way.centre.forEach((each) => box.expandByPoint(each)));
    this.middle = box.getCenter(new THREE.Vector3());
    this.radius = 0;
    this.ways.forEach((way) => way.centre.forEach((each) => { this.radius = Math.max(this.radius, each.distanceTo(this.middle)); }));
  }

  build() {
    const { content, plan } = this;
    this.meshes = this.ways.map((way, r) => {
      const family = content.families[plan.strips[r].family % content.families.length];
      const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, extensions: { derivatives: true },
        uniforms: { ...this.shared, colour: { value: rgb(family) }, reach: { value: 1e9 }, quiet: { value: 0 }, arrows: { value: 0 }, glow: { value: 0 } } });
      const mesh = new THREE.Mesh(this.solid(way, plan.strips[r].closed), material);
      mesh.userData.strip = r;
      this.scene.add(mesh);
      return mesh;
    });
    this.lines = this.ways.map((way) => {
      const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(way.centre), new THREE.LineBasicMaterial({ color: "#d3cdc1" }));
      this.scene.add(line);
      return line;
    });
    const width = content.width, ring = new THREE.TorusGeometry(0.86 * width, 0.055 * width, 12, 64);
    const look = { color: ACCENT, toneMapped: false };
    this.ring = new THREE.Group();
    this.ring.add(new THREE.Mesh(ring, new THREE.MeshBasicMaterial(look)));
    const hidden = new THREE.Mesh(ring, new THREE.MeshBasicMaterial({ ...look, depthTest: false, transparent: true, opacity: 0.4 }));
    hidden.renderOrder = 9;
    this.ring.add(hidden);
    this.ring.visible = false;
    this.scene.add(this.ring);
  }

  // A rectangle swept along the centreline; each of its four sides has normals of its own.
  solid(way, closed) {
    const { width, thickness } = this.content, count = way.count, total = 8 * count;
    const position = new Float32Array(3 * total), normal = new Int8Array(4 * total), place = new Float32Array(3 * total);
    const a = new THREE.Vector3(), b = new THREE.Vector3(), ahead = new THREE.Vector3(), side = new THREE.Vector3();
    const corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    for (let k = 0; k < count; k++) {
      const next = k + 1 < count ? k + 1 : closed ? 1 : k, before = k ? k - 1 : closed ? count - 2 : k;
      ahead.subVectors(way.centre[next], way.centre[before]);
      side.crossVectors(way.up[k], ahead).normalize();
      const ways = [a.copy(way.up[k]).negate().clone(), side.clone(), way.up[k], b.copy(side).negate().clone()];
      for (let face = 0; face < 4; face++) {
        for (let end = 0; end < 2; end++) {
          const v = 2 * count * face + end * count + k, [p, q] = corners[(face + end) % 4];
          a.copy(way.centre[k]).addScaledVector(side, p * width / 2).addScaledVector(way.up[k], q * thickness / 2);
          position.set([a.x, a.y, a.z], 3 * v);
          normal.set([127 * ways[face].x, 127 * ways[face].y, 127 * ways[face].z, 0], 4 * v);
          place.set([way.at[k], face % 2 ? 0 : p, face === 2 ? 1 : face === 0 ? -1 : 0], 3 * v);
        }
      }
    }
    const order = new Uint32Array(24 * (count - 1));
    for (let face = 0, i = 0; face < 4; face++) {
      for (let k = 0; k + 1 < count; k++) {
        const v = 2 * count * face + k;
        order.set([v, v + count, v + count + 1, v, v + count + 1, v + 1], i);
        i += 6;
      }
    }
    const solid = new THREE.BufferGeometry();
    solid.setAttribute("position", new THREE.BufferAttribute(position, 3));
    const packed = new THREE.InterleavedBuffer(normal, 4);
    solid.setAttribute("normal", new THREE.InterleavedBufferAttribute(packed, 3, 0, true));
    solid.setAttribute("place", new THREE.BufferAttribute(place, 3));
    solid.setAttribute("shade", new THREE.BufferAttribute(new Float32Array(total).fill(1), 1));
    solid.setIndex(new THREE.BufferAttribute(order, 1));
    return solid;
  }

  // Ribbons are darker where another one lies on them.
  shaded(there) {
    const wide = 0.8 * this.content.width;
    this.plan.strips.forEach((strip, r) => {
      if (!there.has(r)) return;
      const met = this.plan.passages[r].filter((each) => there.has(each.partner));
      const key = met.map((each) => each.crossing).join();
      const mesh = this.meshes[r], way = this.ways[r], length = strip.length;
      if (mesh.userData.shaded === key) return;
      mesh.userData.shaded = key;
      const outside = new Float32Array(way.count).fill(1), inside = new Float32Array(way.count).fill(1);
      for (const each of met) {
        const dark = each.over ? inside : outside;
        for (let k = 0; k < way.count; k++) {
          let d = Math.abs(way.at[k] - each.at);
          if (strip.closed) d = Math.min(d, length - d);
          if (d < 2.5 * wide) dark[k] = Math.min(dark[k], 1 - 0.42 * Math.exp(-(d * d) / (wide * wide)));
        }
      }
      const shade = mesh.geometry.attributes.shade, n = way.count;
      [[0, inside], [1, inside], [4, outside], [5, outside]].forEach(([block, values]) => shade.array.set(values, block * n));
      shade.needsUpdate = true;
    });
  }

  // Point of a strip at a length along it, with the directions outwards and ahead.
  spot(strip, at) {
    const way = this.ways[strip];
    let k = 1;
    while (k < way.count - 1 && way.at[k] < at) k++;
    const share = Math.min(Math.max((at - way.at[k - 1]) / (way.at[k] - way.at[k - 1] || 1), 0), 1);
    return {
      point: way.centre[k - 1].clone().lerp(way.centre[k], share),
      up: way.up[k - 1].clone().lerp(way.up[k], share).normalize(),
      ahead: way.centre[k].clone().sub(way.centre[k - 1]).normalize(),
    };
  }

  show(step) {
    const { plan, content } = this, all = step.kind === "start" || step.kind === "done";
    const there = new Set(all ? plan.strips.keys() : plan.order.slice(0, step.number + 1));
    const partner = step.kind === "cross" ? step.passage.partner : -1, own = all ? -1 : step.strip;
    this.meshes.forEach((mesh, r) => {
      const u = mesh.material.uniforms;
      mesh.visible = there.has(r);
      this.lines[r].visible = !there.has(r) && this.later;
      u.quiet.value = all || r === own || r === partner ? 0 : own >= 0 && partner >= 0 ? 0.72 : 0.5;
      u.arrows.value = r === own ? 1 : 0;
      u.glow.value = r === own ? 1 : 0;
      u.reach.value = r === own && step.kind === "cross" ? step.passage.at + 0.9 * content.width : 1e9;
    });
    this.shaded(there);
    this.mark = null;
    this.tags = [];
    if (step.kind === "cross") {
      const here = this.spot(own, step.passage.at), other = this.spot(partner, step.passage.away);
      here.point.add(other.point).multiplyScalar(0.5);
      const [lower, upper] = step.passage.over ? [partner, own] : [own, partner];
      this.mark = { crossing: step.passage.crossing, lower, upper, ...here };
      this.ring.position.copy(here.point);
      this.ring.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), here.up);
      this.tags.push(this.tag(own, step.passage.at, -1, "own"));
      if (partner !== own) this.tags.push(this.tag(partner, step.passage.away, step.passage.angle > 0 ? -1 : 1, ""));
    } else if (!all) {
      this.tags.push({ ...this.spot(own, step.kind === "join" ? 0 : 0.15 * content.width), text: plan.strips[own].label, kind: "own" });
    }
    this.ring.visible = this.mark !== null;
    if (this.following) this.turnTo(step, all);
    this.dirty = true;
  }

  // A name beside a crossing, a little way along its strip.
  tag(strip, at, way, kind) {
    const { closed, length, label } = this.plan.strips[strip], far = 1.9 * this.content.width;
    let there = at + way * far;
    if (closed) there = (there + length) % length;
    else if (there < 0 || there > length) there = at - way * far;
    return { ...this.spot(strip, Math.min(Math.max(there, 0), length)), text: label, kind };
  }

  // Turn the weave by the smallest angle that brings a place to the front.
  turnTo(step, all) {
    if (all) { this.back(); return; }
    const strip = this.plan.strips[step.strip];
    const up = this.mark ? this.mark.up : this.spot(step.strip, step.kind === "join" ? 0 : strip.length / 2).up;
    const now = this.flight ? this.flight.to.direction : this.direction, angle = now.angleTo(up), enough = 0.45;
    if (angle > 0.6) {
      const axis = new THREE.Vector3().crossVectors(now, up);
      if (axis.lengthSq() < 1e-9) axis.set(0, 0, 1);
      const direction = now.clone().applyAxisAngle(axis.normalize(), angle - enough);
      const now_at = this.flight ? this.flight.to : this;
      this.fly({ direction, distance: this.free ? now_at.distance : this.fit(direction), target: now_at.target });
    }
  }

  // Which way is up: the weave lies as its file says, and can be tipped over to any of six sides.
  tip(side) {
    this.side = ((side % 6) + 6) % 6;
    const [e, f, up] = [[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
      [[1, 0, 0], [0, -1, 0], [0, 0, -1]], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]][this.side];
    this.axes = new THREE.Matrix4().makeBasis(...[e, f, up].map((axis) => new THREE.Vector3(...axis)));
    this.upward = new THREE.Vector3(...up);
  }

  front() { return new THREE.Vector3(0.55, -0.75, 0.36).normalize().applyMatrix4(this.axes); }

  // Distance from which the whole weave is in view, seen from a direction.
  fit(direction) {
    const tall = 0.95 * Math.tan(this.camera.fov * Math.PI / 360), wide = tall * this.camera.aspect;
    const out = direction || this.front(), right = new THREE.Vector3().crossVectors(this.upward, out);
    if (right.lengthSq() < 1e-6) right.setFromMatrixColumn(this.axes, 0);
    const up = new THREE.Vector3().crossVectors(out, right.normalize()), p = new THREE.Vector3();
    let far = 0;
    for (const { centre, count } of this.ways) {
      for (let k = 0; k < count; k += 2) {
        p.subVectors(centre[k], this.middle);
        const z = p.dot(out);
        far = Math.max(far, z + Math.abs(p.dot(right)) / wide, z + Math.abs(p.dot(up)) / tall);
      }
    }
    return far + this.content.width;
  }

  whole() {
    this.resize();
    Object.assign(this, { direction: this.front(), distance: this.fit(), target: this.middle.clone(), flight: null, free: false });
    this.dirty = true;
  }

  // Show the whole weave again, until the maker zooms in.
  back() {
    this.free = false;
    this.fly({ direction: this.front(), distance: this.fit(), target: this.middle });
  }

  fly(to) {
    const from = { direction: this.direction.clone(), distance: this.distance, target: this.target.clone() };
    const still = window.matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.flight = { from, to: { direction: to.direction.clone(), distance: to.distance, target: to.target.clone() },
      start: performance.now(), lasts: still ? 1 : 650 };
    this.dirty = true;
  }

  turn(dx, dy) {
    this.flight = null;
    const d = this.direction.clone().applyMatrix4(this.axes.clone().transpose());
    const angle = Math.atan2(d.y, d.x) - dx, high = Math.min(Math.max(Math.asin(Math.min(Math.max(d.z, -1), 1)) + dy, -1.5), 1.5);
    d.set(Math.cos(angle) * Math.cos(high), Math.sin(angle) * Math.cos(high), Math.sin(high));
    this.direction.copy(d.applyMatrix4(this.axes));
    this.dirty = true;
  }

  zoom(factor) {
    Object.assign(this, { flight: null, free: true });
    this.distance = Math.min(Math.max(this.distance * factor, 6 * this.content.width), 3 * this.fit());
    this.dirty = true;
  }

  shift(dx, dy) {
    this.flight = null;
    const unit = 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360) / this.canvas.clientHeight;
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 0), up = new THREE.Vector3().setFromMatrixColumn(this.camera.matrix, 1);
    this.target.addScaledVector(right, -dx * unit).addScaledVector(up, dy * unit);
    this.dirty = true;
  }

  listen() {
    const { canvas } = this, fingers = new Map();
    let moved = 0;
    const spread = () => { const [p, q] = [...fingers.values()]; return { x: (p.x + q.x) / 2, y: (p.y + q.y) / 2, d: Math.hypot(p.x - q.x, p.y - q.y) }; };
    canvas.addEventListener("pointerdown", (event) => {
      fingers.set(event.pointerId, { x: event.clientX, y: event.clientY });
      canvas.setPointerCapture(event.pointerId);
      moved = 0;
    });
    canvas.addEventListener("pointermove", (event) => {
      const finger = fingers.get(event.pointerId);
      if (!finger) return;
      const dx = event.clientX - finger.x, dy = event.clientY - finger.y, before = fingers.size === 2 ? spread() : null;
      finger.x = event.clientX;
      finger.y = event.clientY;
      moved += Math.abs(dx) + Math.abs(dy);
      if (before) {
        const after = spread();
        this.zoom(before.d / Math.max(after.d, 1));
        this.shift(after.x - before.x, after.y - before.y);
      } else if (event.shiftKey || event.buttons === 2) {
        this.shift(dx, dy);
      } else {
        this.turn(dx * 0.008, dy * 0.008);
      }
    });
    const up = (event) => {
      if (fingers.delete(event.pointerId) && moved < 5 && event.type === "pointerup") this.pick(event);
    };
    canvas.addEventListener("pointerup", up);
    canvas.addEventListener("pointercancel", up);
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => { event.preventDefault(); this.zoom(Math.exp(event.deltaY * 0.001)); }, { passive: false });
    canvas.addEventListener("webglcontextrestored", () => { this.dirty = true; });
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
  }

  // The name of the strip under a finger.
  pick(event) {
    const box = this.canvas.getBoundingClientRect(), caster = new THREE.Raycaster();
    const at = new THREE.Vector2(2 * (event.clientX - box.left) / box.width - 1, 1 - 2 * (event.clientY - box.top) / box.height);
    caster.setFromCamera(at, this.camera);
    const [hit] = caster.intersectObjects(this.meshes.filter((mesh) => mesh.visible), false);
    this.tags = this.tags.filter((tag) => tag.kind !== "asked");
    if (hit) this.tags.push({ point: hit.point, text: this.plan.strips[hit.object.userData.strip].label, kind: "asked" });
    this.dirty = true;
  }

  resize() {
    const { parentElement } = this.canvas, wide = parentElement.clientWidth, tall = parentElement.clientHeight;
    if (!wide || !tall) return;
    const before = this.camera.aspect, near = this.distance ? this.distance / this.fit(this.direction) : 1;
    this.renderer.setSize(wide, tall, false);
    this.camera.aspect = wide / tall;
    if (before !== this.camera.aspect && this.distance) this.distance = (this.free ? near : 1) * this.fit(this.direction);
    this.dirty = true;
  }

  tick() {
    if (this.flight) {
      const { from, to, start, lasts } = this.flight, t = Math.min((performance.now() - start) / lasts, 1), share = t * t * (3 - 2 * t);
      const angle = from.direction.angleTo(to.direction), axis = new THREE.Vector3().crossVectors(from.direction, to.direction);
      this.direction = axis.lengthSq() > 1e-12 ? from.direction.clone().applyAxisAngle(axis.normalize(), share * angle) : to.direction.clone();
      this.distance = from.distance + share * (to.distance - from.distance);
      this.target = from.target.clone().lerp(to.target, share);
      if (t >= 1) this.flight = null;
      this.dirty = true;
    }
    if (this.dirty) this.draw();
  }

  draw() {
    this.dirty = false;
    const { camera, renderer, canvas } = this, wide = canvas.clientWidth, tall = canvas.clientHeight;
    const d = this.direction;
    camera.up.copy(this.upward);
    const high = d.dot(this.upward);
    // Seen from straight above or below, "up" is replaced by the direction that was ahead.
    if (Math.abs(high) > 0.995) camera.up.copy(this.upward).multiplyScalar(0.1 * Math.sign(high) + high).sub(d).multiplyScalar(Math.sign(high));
    camera.position.copy(this.target).addScaledVector(d, this.distance);
    camera.lookAt(this.target);
    camera.near = Math.max(this.distance - 1.6 * this.radius - this.target.distanceTo(this.middle), 0.02 * this.distance);
    camera.far = this.distance + 2 * this.radius + this.target.distanceTo(this.middle);
    // The main view leaves room for the second view beside it.
    const aside = this.mark && this.lens ? 0.4 * this.lens()[2] : 0;
    camera.setViewOffset(wide, tall, aside, 0, wide, tall);
    camera.updateMatrixWorld();
    const depth = this.middle.clone().sub(camera.position).dot(d.clone().negate());
    this.shared.haze.value.set(depth - 0.1 * this.radius, depth + 1.15 * this.radius);
    const px = 2 * this.distance * Math.tan(camera.fov * Math.PI / 360) / tall;
    this.ring.scale.setScalar(Math.max(1, 13 * px / this.content.width));
    renderer.setViewport(0, 0, wide, tall);
    renderer.setScissorTest(false);
    renderer.clear();
    renderer.render(this.scene, camera);
    this.close(wide, tall);
    if (this.onDraw) this.onDraw();
  }

  // The crossing from outside, its strip from left to right as on the belt. What is in front is cut away, and
  // the two strips are drawn last, the lower one first: where three meet in a point they would cut each other.
  close(wide, tall) {
    if (!this.mark || !this.lens) return;
    const [left, top, size] = this.lens(), { eye, mark } = this, reach = 2.3 * this.content.width;
    const away = reach / Math.tan(eye.fov * Math.PI / 360);
    eye.position.copy(mark.point).addScaledVector(mark.up, away);
    eye.up.crossVectors(mark.up, mark.ahead);
    eye.lookAt(mark.point);
    eye.near = away - 1.1 * this.content.width;
    eye.far = away + 2.5 * this.content.width;
    eye.updateProjectionMatrix();
    this.shared.haze.value.set(away + 0.8 * this.content.width, away + 2.5 * this.content.width);
    this.ring.visible = false;
    const lines = this.lines.filter((line) => line.visible);
    lines.forEach((line) => { line.visible = false; });
    this.renderer.setViewport(left, tall - top - size, size, size);
    this.renderer.setScissor(left, tall - top - size, size, size);
    this.renderer.setScissorTest(true);
    this.renderer.clear();
    const { lower, upper } = mark, seen = this.meshes.filter((mesh) => mesh.visible);
    for (const only of [null, lower, upper]) {
      seen.forEach((mesh) => { const r = mesh.userData.strip; mesh.visible = only === null ? r !== lower && r !== upper : r === only; });
      this.renderer.clearDepth();
      this.renderer.render(this.scene, eye);
    }
    seen.forEach((mesh) => { mesh.visible = true; });
    this.renderer.setScissorTest(false);
    lines.forEach((line) => { line.visible = true; });
    this.ring.visible = true;
  }

  // Where a point is on the canvas, in pixels, and whether it is in front.
  seen(point) {
    const p = point.clone().project(this.camera);
    return { x: (p.x + 1) / 2 * this.canvas.clientWidth, y: (1 - p.y) / 2 * this.canvas.clientHeight, front: p.z < 1 };
  }

  // A picture of the finished weave, to be printed.
  picture() {
    const now = { direction: this.direction, distance: this.distance, target: this.target, flight: this.flight, mark: this.mark };
    const tags = this.tags, step = this.step;
    const visible = this.meshes.map((mesh) => [mesh.visible, mesh.material.uniforms.quiet.value, mesh.material.uniforms.arrows.value, mesh.material.uniforms.reach.value]);
    this.meshes.forEach((mesh) => { mesh.visible = true; Object.assign(mesh.material.uniforms.quiet, { value: 0 }); mesh.material.uniforms.arrows.value = 0; mesh.material.uniforms.reach.value = 1e9; });
    Object.assign(this, { direction: this.front(), distance: this.fit(), target: this.middle, flight: null, mark: null });
    this.ring.visible = false;
    this.draw();
    const data = this.canvas.toDataURL("image/png");
    this.meshes.forEach((mesh, r) => {
      const u = mesh.material.uniforms;
      [mesh.visible, u.quiet.value, u.arrows.value, u.reach.value] = visible[r];
    });
    Object.assign(this, now, { tags, step });
    this.ring.visible = this.mark !== null;
    this.draw();
    return data;
  }
}

// A colour as it is written: shaders here work in that space.
function rgb(text) {
  return new THREE.Vector3(...[1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255));
}
