// A robot of base, links and tool with its frames, the names of its axes and its path; three.js draws, nothing here knows what the joints mean.
import * as THREE from "./vendor/three/three.module.min.js";

export class Robot3d {
  constructor(box, reach, t) {
    this.box = box;
    this.reach = reach;
    this.t = t;
    this.named = true;
    this.frames = new Map();
    this.labels = new Map();
    this.names = document.createElement("div");
    this.names.className = "names";
    this.turn = { yaw: -0.9, pitch: 0.45, far: 2.6 * reach };
    this.renderer = new THREE.WebGLRenderer({ antialias: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    box.append(this.renderer.domElement, this.names);
    this.camera = new THREE.PerspectiveCamera(42, 1, 0.01, 40 * reach);
    this.camera.up.set(0, 0, 1);
    this.scene = new THREE.Scene();
    this.light = new THREE.DirectionalLight(0xffffff, 2.2);
    this.light.position.set(1, -2, 3);
    this.scene.add(this.light, new THREE.HemisphereLight(0xffffff, 0x556677, 1.5));
    this.grid = null;
    this.links = [];
    this.joints = [];
    this.path = new THREE.Line(new THREE.BufferGeometry(), new THREE.LineBasicMaterial());
    this.path.frustumCulled = false;
    this.foot = new THREE.Mesh(new THREE.CylinderGeometry(0.1 * reach, 0.12 * reach, 0.04 * reach, 36));
    this.foot.rotation.x = Math.PI / 2;
    this.foot.visible = false;
    this.pedestal = new THREE.Group();
    this.pedestal.matrixAutoUpdate = false;
    this.pedestal.add(this.foot);
    this.scene.add(this.path, this.pedestal);
    this.theme();
    this.watch = new ResizeObserver(() => this.size());
    this.watch.observe(box);
    this.hands();
    this.size();
  }

  theme() {
    const style = getComputedStyle(document.documentElement);
    const colour = (name) => new THREE.Color(style.getPropertyValue(name).trim());
    this.scene.background = colour("--row");
    if (this.grid) this.scene.remove(this.grid);
    this.grid = new THREE.GridHelper(4 * this.reach, 20, colour("--edge"), colour("--line"));
    this.grid.rotation.x = Math.PI / 2;
    this.scene.add(this.grid);
    this.path.material.color = colour("--warn");
    this.bodies = new THREE.MeshStandardMaterial({ color: colour("--accent"), roughness: 0.55 });
    this.knees = new THREE.MeshStandardMaterial({ color: colour("--soft"), roughness: 0.4 });
    this.tools = new THREE.MeshStandardMaterial({ color: colour("--good"), roughness: 0.4 });
    this.foot.material = this.knees;
    this.links.forEach((link, n) => { link.material = n === this.tool ? this.tools : this.bodies; });
    for (const joint of this.joints) joint.material = this.knees;
    this.draw();
  }

  // frames: [name, origin, rotation]; marks: [name of an axis, place].
  mark(frames, marks) {
    const wanted = new Set();
    for (const [name, at, r] of frames) {
      const id = `frame ${name}`;
      wanted.add(id);
      if (!this.frames.has(id)) { const triad = new THREE.AxesHelper((name === "base" ? 0.2 : 0.12) * this.reach); triad.matrixAutoUpdate = false; this.frames.set(id, triad); this.scene.add(triad); }
      const pose = new THREE.Matrix4().set(r[0], r[1], r[2], at[0], r[3], r[4], r[5], at[1], r[6], r[7], r[8], at[2], 0, 0, 0, 1);
      this.frames.get(id).matrix.copy(pose);
      this.frames.get(id).visible = this.named;
      if (name === "base") { this.pedestal.matrix.copy(pose); this.foot.visible = true; }
      this.label(id, this.t(name), at, "frame");
    }
    for (const [name, at] of marks) { const id = `axis ${name}`; wanted.add(id); this.label(id, name, at, "axis"); }
    for (const [id, label] of this.labels) if (!wanted.has(id)) { label.element.remove(); this.labels.delete(id); }
    for (const [id, triad] of this.frames) if (!wanted.has(id)) triad.visible = false;
  }

  label(id, words, at, kind) {
    let label = this.labels.get(id);
    if (!label) { const element = document.createElement("span"); element.className = kind; label = { element }; this.labels.set(id, label); this.names.append(element); }
    if (label.element.textContent !== words) label.element.textContent = words;
    label.at = new THREE.Vector3(...at);
  }

  // Names stand beside their places; where two would cover each other the later one moves down.
  place() {
    this.names.hidden = !this.named;
    if (!this.named) return;
    const { clientWidth: width, clientHeight: height } = this.box;
    const taken = [];
    for (const { element, at } of this.labels.values()) {
      const spot = at.clone().project(this.camera);
      element.hidden = Math.abs(spot.x) > 1 || Math.abs(spot.y) > 1 || spot.z > 1;
      if (element.hidden) continue;
      const x = Math.min(((spot.x + 1) / 2) * width + 10, width - 14 - 8 * element.textContent.length);
      let y = ((1 - spot.y) / 2) * height - 9;
      while (taken.some(([ox, oy, wide]) => Math.abs(oy - y) < 18 && x < ox + wide && ox < x + 9 + 8 * element.textContent.length)) y += 18;
      taken.push([x, y, 9 + 8 * element.textContent.length]);
      element.style.transform = `translate(${x.toFixed(1)}px, ${y.toFixed(1)}px)`;
    }
  }

  name(on) {
    this.named = on;
    for (const triad of this.frames.values()) triad.visible = on;
    this.draw();
  }

  show(lines, trail, frames = [], marks = []) {
    this.mark(frames, marks);
    this.tool = frames.some(([name]) => name === "tool") && lines.length ? lines[0].length - 2 : -1;
    const thick = 0.024 * this.reach;
    const points = lines.flat();
    const rods = lines.flatMap((line) => line.slice(1).map((point, n) => [line[n], point]));
    while (this.joints.length < points.length) { const ball = new THREE.Mesh(new THREE.SphereGeometry(thick * 1.3, 20, 14), this.knees); this.joints.push(ball); this.scene.add(ball); }
    while (this.links.length < rods.length) { const rod = new THREE.Mesh(new THREE.CylinderGeometry(thick, thick, 1, 18), this.bodies); this.links.push(rod); this.scene.add(rod); }
    this.joints.forEach((ball, n) => { ball.visible = n < points.length; if (ball.visible) ball.position.set(...points[n]); });
    this.links.forEach((rod, n) => {
      rod.visible = n < rods.length;
      if (!rod.visible) return;
      const from = new THREE.Vector3(...rods[n][0]);
      const way = new THREE.Vector3(...rods[n][1]).sub(from);
      const length = way.length();
      rod.visible = length > 1e-6;
      if (!rod.visible) return;
      rod.position.copy(from).addScaledVector(way, 0.5);
      rod.material = n === this.tool ? this.tools : this.bodies;
      rod.scale.set(n === this.tool ? 0.6 : 1, length, n === this.tool ? 0.6 : 1);
      rod.quaternion.setFromUnitVectors(new THREE.Vector3(0, 1, 0), way.normalize());
    });
    this.path.geometry.dispose();
    this.path.geometry = new THREE.BufferGeometry().setFromPoints(trail.map((point) => new THREE.Vector3(...point)));
    const tip = lines[0]?.at(-1);
    if (tip) { this.middle ??= new THREE.Vector3(tip[0] / 2, tip[1] / 2, 0.4 * this.reach); this.middle.lerp(new THREE.Vector3(tip[0] / 2, tip[1] / 2, 0.4 * this.reach), 0.1); }
    this.draw();
    if (rods.length) this.box.dataset.drawn = "1";
  }

  hands() {
    const box = this.box;
    box.tabIndex = 0;
    let last = null;
    box.addEventListener("pointerdown", (event) => { last = [event.clientX, event.clientY]; box.setPointerCapture(event.pointerId); });
    box.addEventListener("pointermove", (event) => { if (!last) return; this.move((event.clientX - last[0]) / 180, (event.clientY - last[1]) / 180, 1); last = [event.clientX, event.clientY]; });
    for (const end of ["pointerup", "pointercancel"]) box.addEventListener(end, () => { last = null; });
    box.addEventListener("wheel", (event) => { event.preventDefault(); this.move(0, 0, event.deltaY > 0 ? 1.1 : 0.9); }, { passive: false });
    const keys = { ArrowLeft: [0.15, 0, 1], ArrowRight: [-0.15, 0, 1], ArrowUp: [0, 0.12, 1], ArrowDown: [0, -0.12, 1], "+": [0, 0, 0.9], "-": [0, 0, 1.1] };
    box.addEventListener("keydown", (event) => { const way = keys[event.key]; if (way) { event.preventDefault(); this.move(...way); } });
  }

  move(yaw, pitch, far) {
    this.turn.yaw -= yaw;
    this.turn.pitch = Math.min(1.5, Math.max(-0.1, this.turn.pitch + pitch));
    this.turn.far = Math.min(12 * this.reach, Math.max(0.4 * this.reach, this.turn.far * far));
    this.draw();
  }

  size() {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (!width || !height) return;
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.draw();
  }

  draw() {
    if (!this.grid) return;
    const middle = this.middle ?? new THREE.Vector3(0, 0, 0.4 * this.reach);
    const { yaw, pitch, far } = this.turn;
    this.camera.position.set(middle.x + far * Math.cos(pitch) * Math.sin(yaw), middle.y - far * Math.cos(pitch) * Math.cos(yaw), middle.z + far * Math.sin(pitch));
    this.camera.lookAt(middle);
    this.renderer.render(this.scene, this.camera);
    this.place();
  }

  close() {
    this.watch.disconnect();
    this.renderer.dispose();
    this.renderer.forceContextLoss();
    this.renderer.domElement.remove();
  }
}
