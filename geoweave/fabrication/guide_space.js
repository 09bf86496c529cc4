// The weave in space as it is put together: which ribbons are woven, and which crossing is next.
"use strict";

class Space extends WeaveInSpace {
  constructor(canvas, content, plan) {
    super(canvas, content, plan.strips);
    Object.assign(this, { plan, following: true, later: true });
    this.eye = new THREE.PerspectiveCamera(30, 1, 1, 10);
    this.ways = this.read(content.shape);
    this.measure();
    this.build();
    this.start();
  }

  build() {
    const { content, plan } = this;
    this.meshes = this.ways.map((way, r) => {
      const family = content.families[plan.strips[r].family % content.families.length];
      const mesh = this.ribbon(way, r, family);
      this.scene.add(mesh);
      return mesh;
    });
    this.lines = this.ways.map((way) => {
      const line = new THREE.Line(new THREE.BufferGeometry().setFromPoints(way.centre), new THREE.LineBasicMaterial({ color: "#d3cdc1" }));
      this.scene.add(line);
      return line;
    });
    this.ring = this.marker();
    this.scene.add(this.ring);
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
    this.shaded(there, plan.passages);
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

  draw() {
    this.dirty = false;
    const { camera, renderer, canvas } = this, wide = canvas.clientWidth, tall = canvas.clientHeight;
    // The main view leaves room for the second view, or the map, beside it.
    this.aim(wide, tall, this.aside ? 0.4 * this.aside() : 0);
    this.ring.scale.setScalar(Math.max(1, 13 * this.pixel() / this.content.width));
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
