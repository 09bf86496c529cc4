// Ribbons in space: with width and thickness, to be turned and looked at from all sides. Pages build on it.
"use strict";

const VERTEX = `
attribute vec3 place;
attribute float shade; attribute vec3 tint;
varying vec3 vPlace; varying vec3 vNormal; varying float vShade; varying float vDepth; varying vec3 vTint;
void main() {
  vec4 seen = modelViewMatrix * vec4(position, 1.0);
  vPlace = place; vShade = shade; vTint = tint; vDepth = -seen.z;
  vNormal = normalMatrix * normal;
  gl_Position = projectionMatrix * seen;
}`;

// place: length along the ribbon; -1 to 1 across it; 1 on its outer face, -1 on its inner face, 0 on its edges.
const FRAGMENT = `
uniform vec3 colour; uniform vec3 ground; uniform vec2 haze;
uniform float width; uniform float reach; uniform float quiet; uniform float arrows; uniform float glow;
uniform float tinted;
varying vec3 vPlace; varying vec3 vNormal; varying float vShade; varying float vDepth; varying vec3 vTint;
void main() {
  vec3 n = normalize(vNormal);
  vec3 paper = vec3(0.953, 0.933, 0.894);
  vec3 own = mix(colour, vTint, tinted);
  vec3 base = vPlace.z > 0.5 ? own : vPlace.z < -0.5 ? mix(paper, own, mix(0.28, 0.6, tinted)) : own * 0.62;
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

// For each axis that may be up (z, y, x, -z, -y, -x): to the right, away from the eye, and up.
const SIDES = [[[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], [[0, 1, 0], [0, 0, 1], [1, 0, 0]],
  [[1, 0, 0], [0, -1, 0], [0, 0, -1]], [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[0, 1, 0], [0, 0, -1], [-1, 0, 0]]];

const ACCENT = "#d8361c", GROUND = "#fbfaf7";

function bytesOf(text) {
  const raw = atob(text), bytes = new Uint8Array(raw.length);
  for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
  return bytes;
}

class WeaveInSpace {
  // content: width and thickness of the ribbons; strips: for each of them whether it is closed.
  constructor(canvas, content, strips) {
    Object.assign(this, { canvas, content, strips, dirty: true, flight: null });
    this.renderer = new THREE.WebGLRenderer({ canvas, antialias: true, powerPreference: "low-power" });
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
    this.renderer.autoClear = false;
    this.scene = new THREE.Scene();
    this.scene.background = null;
    this.renderer.setClearColor(GROUND, 1);
    this.camera = new THREE.PerspectiveCamera(30, 1, 1, 10);
    this.shared = { width: { value: content.width }, haze: { value: new THREE.Vector2(1e9, 2e9) },
      ground: { value: rgb(GROUND) } };
  }

  // Begin to draw, when everything is there.
  start() {
    this.tip(this.content.up || 0);
    this.whole();
    this.listen();
    const frame = () => { this.tick(); requestAnimationFrame(frame); };
    requestAnimationFrame(frame);
  }

  // Cross sections of the ribbons of a shape.
  read(shape) {
    const places = new Uint16Array(bytesOf(shape.places).buffer);
    const ups = new Int16Array(bytesOf(shape.ups).buffer), along = new Uint16Array(bytesOf(shape.along).buffer);
    const shares = bytesOf(shape.shares);
    const [x, y, z] = shape.low;
    let first = 0;
    return shape.counts.map((count, r) => {
      const way = { count, at: new Float32Array(count), share: new Float32Array(count), centre: [], up: [] };
      for (let k = 0; k < count; k++) {
        const p = 3 * (first + k);
        way.at[k] = along[first + k] / 65535 * shape.lengths[r];
        way.share[k] = shares[first + k] / 255;
        way.centre.push(new THREE.Vector3(x + places[p] * shape.unit, y + places[p + 1] * shape.unit, z + places[p + 2] * shape.unit));
        way.up.push(new THREE.Vector3(ups[p], ups[p + 1], ups[p + 2]).normalize());
      }
      first += count;
      return way;
    });
  }

  // The middle of the ribbons, and how far the farthest of them is from it.
  measure() {
    const box = new THREE.Box3();
    this.ways.forEach((way) => way.centre.forEach((each) => box.expandByPoint(each)));
    this.middle = box.getCenter(new THREE.Vector3());
    this.radius = 0;
    this.ways.forEach((way) => way.centre.forEach((each) => { this.radius = Math.max(this.radius, each.distanceTo(this.middle)); }));
  }

  // A ribbon, in the colour of its family.
  ribbon(way, r, colour) {
    const material = new THREE.ShaderMaterial({ vertexShader: VERTEX, fragmentShader: FRAGMENT, extensions: { derivatives: true },
      uniforms: { ...this.shared, colour: { value: rgb(colour) }, reach: { value: 1e9 }, quiet: { value: 0 }, arrows: { value: 0 },
        glow: { value: 0 }, tinted: { value: 0 } } });
    const mesh = new THREE.Mesh(this.solid(way, this.strips[r].closed), material);
    mesh.userData.strip = r;
    return mesh;
  }

  // A ring that is laid round a place; what is behind ribbons shows through.
  marker() {
    const { width } = this.content, ring = new THREE.TorusGeometry(0.86 * width, 0.055 * width, 12, 64);
    const look = { color: ACCENT, toneMapped: false };
    const marker = new THREE.Group();
    marker.add(new THREE.Mesh(ring, new THREE.MeshBasicMaterial(look)));
    const hidden = new THREE.Mesh(ring, new THREE.MeshBasicMaterial({ ...look, depthTest: false, transparent: true, opacity: 0.4 }));
    hidden.renderOrder = 9;
    marker.add(hidden);
    marker.visible = false;
    return marker;
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
          a.copy(way.centre[k]).addScaledVector(side, p * way.share[k] * width / 2).addScaledVector(way.up[k], q * thickness / 2);
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
  shaded(there, passages) {
    const wide = 0.8 * this.content.width;
    this.strips.forEach((strip, r) => {
      if (!there.has(r)) return;
      const met = passages[r].filter((each) => there.has(each.partner));
      const key = met.map((each) => `${each.crossing}${each.over}`).join();
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

  // Which way is up: z, y, x, -z, -y or -x. It begins with the axis that the page says, and can be tipped over.
  tip(side) {
    this.side = ((side % 6) + 6) % 6;
    const [e, f, up] = SIDES[this.side];
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
    const unit = this.pixel();
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

  // A page may say here what a tap means.
  pick() {}

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

  // Put the camera where it is to look from; "aside" pixels of the view are left free at its right.
  aim(wide, tall, aside) {
    const { camera } = this;
    const d = this.direction;
    camera.up.copy(this.upward);
    const high = d.dot(this.upward);
    // Seen from straight above or below, "up" is replaced by the direction that was ahead.
    if (Math.abs(high) > 0.995) camera.up.copy(this.upward).multiplyScalar(0.1 * Math.sign(high) + high).sub(d).multiplyScalar(Math.sign(high));
    camera.position.copy(this.target).addScaledVector(d, this.distance);
    camera.lookAt(this.target);
    camera.near = Math.max(this.distance - 1.6 * this.radius - this.target.distanceTo(this.middle), 0.02 * this.distance);
    camera.far = this.distance + 2 * this.radius + this.target.distanceTo(this.middle);
    camera.setViewOffset(wide, tall, aside, 0, wide, tall);
    camera.updateMatrixWorld();
    const depth = this.middle.clone().sub(camera.position).dot(d.clone().negate());
    this.shared.haze.value.set(depth - 0.1 * this.radius, depth + 1.15 * this.radius);
  }

  // Length in space of a pixel at the distance of what is looked at.
  pixel() { return 2 * this.distance * Math.tan(this.camera.fov * Math.PI / 360) / this.canvas.clientHeight; }

  // Where a point is on the canvas, in pixels, and whether it is in front.
  seen(point) {
    const p = point.clone().project(this.camera);
    return { x: (p.x + 1) / 2 * this.canvas.clientWidth, y: (1 - p.y) / 2 * this.canvas.clientHeight, front: p.z < 1 };
  }
}

// A colour as it is written: shaders here work in that space.
function rgb(text) {
  return new THREE.Vector3(...[1, 3, 5].map((k) => parseInt(text.slice(k, k + 2), 16) / 255));
}
