// The player. Everything that comes from the run is in the elements "data" (JSON) and "runRblobB"
// (base64): names go into text nodes, never into markup.
(function () {
"use strict";

const byId = id => document.getElementById(id);
const data = JSON.parse(byId("data").textContent);
const colours = data.colours;
const noLevel = 255;  // of what is no number
const positionSteps = 65535;

// Hues of cloths, and the paler hues of their backs, as in pictures of `weft render`.
const hues = [[[176, 101, 85], [203, 166, 144]], [[85, 113, 140], [146, 167, 185]],
              [[185, 151, 93], [206, 185, 149]], [[108, 131, 108], [159, 174, 155]],
              [[130, 95, 119], [175, 150, 166]], [[79, 123, 124], [144, 173, 173]]];
const bodyHue = [184, 178, 171];
const grey = [150, 150, 150];

const fallbacks = ["whole", "halved", "rigid", "truncated", "failed"];
const fallbackColours = ["#7d9bb5", "#d9a441", "#d9742b", "#c23b3b", "#7a1010"];

const meanings = {
  plain: "A hue per cloth; backs are paler.",
  strain: "Largest principal stretch of each triangle, less 1; compressed triangles count as 0." +
          (data.live ? "" : " The scale ends at the 99.5th percentile."),
  height: "Height of the cloth above z = 0.",
  contact: "Distance of each vertex to the nearest other surface, over the contact thickness. " +
           "Nearby parts of one cloth do not count.",
  compliance: "Obstacles where they were simulated, and pinned vertices, coloured by their distance " +
              "from their prescribed places. Pinched cloth displaces them.",
};

function hide(element, hidden) { element.hidden = hidden; }

function make(name, text) {
  const element = document.createElement(name);
  if (text !== undefined) element.textContent = text;
  return element;
}

/// A number with three digits that count.
function short(value) {
  if (value === null || value === undefined || !isFinite(value)) return "";
  if (value !== 0 && (Math.abs(value) < 1e-3 || Math.abs(value) >= 1e6)) return value.toExponential(2);
  return String(Number(value.toPrecision(3)));
}

function seconds(value) {
  if (value === null || value === undefined) return "";
  return value < 1 ? short(1000 * value) + " ms" : short(value) + " s";
}

// ------------------------------------------------------------------------------------------ blobs
/// Decoded when they are needed; the oldest make room.
const blobs = {
  kept: new Map(), size: 0, most: 256e6,
  late: [],  // base64 that came after the page, by number from `early` on
  early: document.querySelectorAll("script[id^=run0blob]").length,
  get(run, number) {
    if (number < 0) return null;
    const id = `run${run}blob${number}`;
    const found = this.kept.get(id);
    if (found) return found;
    const element = byId(id);
    const text = atob(element ? element.textContent : this.late[number - this.early]);
    const bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
    for (const [old, value] of this.kept) {
      if (this.size + bytes.length <= this.most) break;
      this.kept.delete(old);
      this.size -= value.length;
    }
    this.kept.set(id, bytes);
    this.size += bytes.length;
    return bytes;
  },
};

// --------------------------------------------------------------------------------------- surfaces
const vertexShader = `
  attribute vec3 front;
  attribute vec3 back;
  varying vec3 vNormal, vFront, vBack, vEye;
  void main() {
    vNormal = normalMatrix * normal;
    vFront = front;
    vBack = back;
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    vEye = -place.xyz;
    gl_Position = projectionMatrix * place;
  }`;
const fragmentShader = `
  varying vec3 vNormal, vFront, vBack, vEye;
  void main() {
    vec3 n = normalize(vNormal), eye = normalize(vEye);
    vec3 tint = gl_FrontFacing ? vFront : vBack;
    if (!gl_FrontFacing) n = -n;
    float lamp = max(dot(n, normalize(vec3(-0.45, 0.65, 0.6))), 0.0);
    float light = 0.50 + 0.42 * lamp + 0.16 * max(dot(n, eye), 0.0);
    gl_FragColor = vec4(min(tint * light, vec3(1.0)), 1.0);
  }`;

/// Triangles with three corners of their own each, so that a colour may end at an edge.
class Surface {
  /// @param crease cosine of the angle from the mean normal of a vertex to that of a triangle beyond
  ///               which the triangle keeps its own, so that a box has edges; -1: all are smooth
  constructor(scene, crease) {
    this.crease = crease;
    this.geometry = new THREE.BufferGeometry();
    this.solid = new THREE.Mesh(this.geometry, new THREE.ShaderMaterial({
      vertexShader, fragmentShader, side: THREE.DoubleSide, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    this.wires = new THREE.Mesh(this.geometry, new THREE.MeshBasicMaterial({
      wireframe: true, color: 0x111418, transparent: true, opacity: 0.2, depthWrite: false }));
    this.group = new THREE.Group();
    for (const mesh of [this.solid, this.wires]) {
      mesh.frustumCulled = false;
      this.group.add(mesh);
    }
    scene.add(this.group);
    this.corners = -1;
  }

  /// Lines need the triangles a little behind them. Without lines, steep triangles would only fall
  /// behind what is close below.
  drawWires(on) {
    this.wires.visible = this.solid.material.polygonOffset = on;
  }

  resize(corners) {
    if (corners === this.corners) return;
    this.corners = corners;
    this.geometry.dispose();
    const add = (name, array, normalized) =>
      this.geometry.setAttribute(name, new THREE.BufferAttribute(array, 3, normalized));
    add("position", new Float32Array(3 * corners), false);
    add("normal", new Float32Array(3 * corners), false);
    add("front", new Uint8Array(3 * corners), true);
    add("back", new Uint8Array(3 * corners), true);
  }

  /// @param places 16 bits a coordinate, relative to `box`
  /// @param centre what positions on the GPU are relative to
  move(places, triangles, box, centre) {
    this.resize(triangles.length);
    const steps = new Uint16Array(places.buffer, 0, places.length >> 1);
    const x = new Float32Array(steps.length), n = new Float32Array(steps.length);
    const flat = new Float32Array(triangles.length);  // unit normals of the triangles
    for (let k = 0; k < 3; ++k) {
      const low = box[0][k] - centre[k], unit = (box[1][k] - box[0][k]) / positionSteps;
      for (let i = k; i < steps.length; i += 3) x[i] = low + unit * steps[i];
    }
    for (let t = 0; t < triangles.length; t += 3) {
      const a = 3 * triangles[t], b = 3 * triangles[t + 1], c = 3 * triangles[t + 2];
      const ux = x[b] - x[a], uy = x[b + 1] - x[a + 1], uz = x[b + 2] - x[a + 2];
      const vx = x[c] - x[a], vy = x[c + 1] - x[a + 1], vz = x[c + 2] - x[a + 2];
      const nx = uy * vz - uz * vy, ny = uz * vx - ux * vz, nz = ux * vy - uy * vx;
      for (const v of [a, b, c]) { n[v] += nx; n[v + 1] += ny; n[v + 2] += nz; }
      const size = Math.hypot(nx, ny, nz) || 1;
      flat[t] = nx / size; flat[t + 1] = ny / size; flat[t + 2] = nz / size;
    }
    for (let v = 0; v < n.length; v += 3) {
      const size = Math.hypot(n[v], n[v + 1], n[v + 2]) || 1;
      n[v] /= size; n[v + 1] /= size; n[v + 2] /= size;
    }
    const position = this.geometry.attributes.position, normal = this.geometry.attributes.normal;
    for (let i = 0; i < triangles.length; ++i) {
      const v = 3 * triangles[i], w = 3 * i, t = i - i % 3;
      const smooth = n[v] * flat[t] + n[v + 1] * flat[t + 1] + n[v + 2] * flat[t + 2] >= this.crease;
      for (let k = 0; k < 3; ++k) {
        position.array[w + k] = x[v + k];
        normal.array[w + k] = smooth ? n[v + k] : flat[t + k];
      }
    }
    position.needsUpdate = normal.needsUpdate = true;
  }

  /// @param pick gives the colour of the front and of the back of a corner
  paint(pick) {
    const front = this.geometry.attributes.front, back = this.geometry.attributes.back;
    for (let i = 0; i < this.corners; ++i) {
      const [f, b] = pick(i);
      for (let k = 0; k < 3; ++k) {
        front.array[3 * i + k] = f[k];
        back.array[3 * i + k] = b[k];
      }
    }
    front.needsUpdate = back.needsUpdate = true;
  }
}

const levelPairs = colours.map(c => [c, c]);
levelPairs[noLevel] = [grey, grey];

/// Number of the part that each triangle belongs to.
function partOfTriangles(parts) {
  const list = new Uint32Array(parts.reduce((sum, part) => sum + part.triangles, 0));
  let at = 0;
  parts.forEach((part, k) => { list.fill(k, at, at + part.triangles); at += part.triangles; });
  return list;
}

// ------------------------------------------------------------------------------------------- runs
class Run {
  constructor(number, content) {
    Object.assign(this, content);
    this.run = number;
    this.scene = new THREE.Scene();
    this.clothSurface = new Surface(this.scene, -1);
    this.bodySurface = new Surface(this.scene, 0.82);
    this.steps = this.facts.steps.map(values => this.stepOf(values));
    this.shown = null;
  }

  stepOf(values) {
    const step = {};
    this.facts.step_fields.forEach((field, k) => { step[field] = values[k]; });
    return step;
  }

  /// The last frame that is not after a time.
  frameAt(time) {
    let low = 0, high = this.frames.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this.frames[middle].time <= time + 1e-9) low = middle; else high = middle - 1;
    }
    return low;
  }

  words(blob) {
    const bytes = blobs.get(this.run, blob);
    return bytes ? new Uint32Array(bytes.buffer) : new Uint32Array(0);
  }

  show(place, look, centre) {
    const frame = this.frames[place];
    const topology = this.topologies[frame.topology];
    const displaced = look === "compliance" && frame.displaced >= 0;
    const cloth = this.words(topology.cloth_triangles), body = this.words(topology.obstacle_triangles);
    const bodyPlaces = displaced ? frame.displaced : frame.obstacles;
    const clothBox = frame.cloth_box || this.cloth_box, bodyBox = frame.obstacle_box || this.obstacle_box;
    const before = this.shown || {};
    const sameBoxes = before.clothBox === clothBox && before.bodyBox === bodyBox;
    const sameTopology = before.topology === frame.topology;
    const sameCloth = sameTopology && sameBoxes && before.cloth === frame.cloth;
    const sameBody = sameTopology && sameBoxes && before.body === bodyPlaces;
    if (!sameCloth && cloth.length)
      this.clothSurface.move(blobs.get(this.run, frame.cloth), cloth, clothBox, centre);
    if (!sameBody && body.length)
      this.bodySurface.move(blobs.get(this.run, bodyPlaces), body, bodyBox, centre);
    const sameLook = sameTopology && before.look === look;
    if (!(sameLook && (look === "plain" || before.place === place)))
      this.paintCloth(frame, topology, cloth, look);
    if (!(sameLook && (look !== "compliance" || before.place === place)))
      this.paintBody(frame, body, look);
    this.shown = { place, look, topology: frame.topology, cloth: frame.cloth, body: bodyPlaces,
                   clothBox, bodyBox };
  }

  paintCloth(frame, topology, corners, look) {
    if (!corners.length) return;
    const parts = partOfTriangles(topology.cloths);
    const plain = i => hues[parts[Math.floor(i / 3)] % hues.length];
    const levels = look === "strain" || look === "contact" ? blobs.get(this.run, frame[look]) : null;
    if (look === "strain" && levels)
      return this.clothSurface.paint(i => levelPairs[levels[Math.floor(i / 3)]]);
    if (look === "contact" && levels) return this.clothSurface.paint(i => levelPairs[levels[corners[i]]]);
    if (look === "height") {
      const steps = new Uint16Array(blobs.get(this.run, frame.cloth).buffer);
      const [low, high] = heights;
      const box = frame.cloth_box || this.cloth_box;
      const a = box[0][2], unit = (box[1][2] - a) / positionSteps;
      const top = noLevel - 1;
      return this.clothSurface.paint(i => {
        const z = a + unit * steps[3 * corners[i] + 2];
        return levelPairs[Math.min(top, Math.max(0, Math.round(top * (z - low) / (high - low))))];
      });
    }
    const pins = look === "compliance" && frame.pins >= 0 ? blobs.get(this.run, frame.pins) : null;
    this.clothSurface.paint(pins ? i => pins[corners[i]] === noLevel ? plain(i) : levelPairs[pins[corners[i]]]
                                 : plain);
  }

  paintBody(frame, corners, look) {
    if (!corners.length) return;
    const bodies = [bodyHue, bodyHue];
    if (look !== "compliance" || !this.scales.compliance) return this.bodySurface.paint(() => bodies);
    const levels = frame.compliance >= 0 ? blobs.get(this.run, frame.compliance) : null;
    this.bodySurface.paint(i => levelPairs[levels ? levels[corners[i]] : 0]);
  }

  /// Number of the steps that end at or before a time.
  stepsUntil(time) {
    const end = time + 1e-6 * Math.max(1, Math.abs(time));
    let low = 0, high = this.steps.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.steps[middle].time <= end) low = middle + 1; else high = middle;
    }
    return low;
  }

  /// Steps that lead to a frame from the one before it, or from the start of the run.
  stepsOf(place) {
    const first = place > 0 ? this.stepsUntil(this.frames[place - 1].time) : 0;
    return this.steps.slice(first, this.stepsUntil(this.frames[place].time));
  }
}

const runs = [];
let heights = [0, 1];

// ------------------------------------------------------------------------------------ the camera
let renderer, camera, controls, home;
let origin = null;  // [m] what positions on the GPU are relative to
let drawing = false;

function boxSize(box) { return Math.hypot(...[0, 1, 2].map(k => box[1][k] - box[0][k])); }

function united(boxes) {
  boxes = boxes.filter(box => box);
  if (!boxes.length) return [[0, 0, 0], [1, 1, 1]];
  return [Math.min, Math.max].map((end, side) => [0, 1, 2].map(k => end(...boxes.map(b => b[side][k]))));
}

/// Where the camera starts: at the scene's own, or so that it sees the cloth all the time, and the
/// obstacles unless they are far larger.
function findHome() {
  const cloths = united(runs.map(run => run.cloth_box || run.obstacle_box));
  const all = united([cloths, ...runs.map(run => run.obstacle_box)]);
  const box = boxSize(all) < 2.5 * boxSize(cloths) ? all : cloths;
  const middle = [0, 1, 2].map(k => (box[0][k] + box[1][k]) / 2);
  const reach = Math.max(boxSize(box) / 2, 1e-6);
  home = { centre: middle, reach, box, far: 40 * Math.max(reach, boxSize(all)), fov: 35 };
  origin = origin || middle;
  home.look = middle.map((v, k) => v - origin[k]);
  const azimuth = -60 * Math.PI / 180, elevation = 22 * Math.PI / 180;
  home.away = [Math.cos(azimuth) * Math.cos(elevation), Math.sin(azimuth) * Math.cos(elevation),
               Math.sin(elevation)];
  const own = data.runs[0].facts.camera;
  if (own && data.runs.every(run => JSON.stringify(run.facts.camera) === JSON.stringify(own))) {
    home.position = own.position.map((v, k) => v - origin[k]);
    home.look = own.look_at.map((v, k) => v - origin[k]);
    home.fov = own.field_of_view * 180 / Math.PI;
    home.aspect = own.aspect;
  }
}

/// From where all corners of a box are in the picture, in a direction from its middle.
function distanceToSee(box, away, aspect) {
  const side = new THREE.Vector3(-away[1], away[0], 0).normalize();
  const toEye = new THREE.Vector3(...away), up = toEye.clone().cross(side);
  const high = Math.tan(home.fov * Math.PI / 360), wide = high * aspect;
  let distance = home.reach;
  for (let corner = 0; corner < 8; ++corner) {
    const p = new THREE.Vector3(...[0, 1, 2].map(k => (box[corner >> k & 1][k]) - home.centre[k]));
    distance = Math.max(distance, p.dot(toEye) + Math.abs(p.dot(side)) / wide,
                        p.dot(toEye) + Math.abs(p.dot(up)) / high);
  }
  return distance;
}

function goHome() {
  const [, , width, height] = viewports()[0];
  // A part of the stage that is narrower than the scene's picture shows as much from side to side.
  const narrower = Math.max(1, (home.aspect || 0) * height / width);
  camera.fov = Math.atan(narrower * Math.tan(home.fov * Math.PI / 360)) * 360 / Math.PI;
  camera.near = home.reach / 200;
  camera.far = home.far;
  if (home.position) {
    camera.position.set(...home.position);
  } else {
    const distance = 1.06 * distanceToSee(home.box, home.away, width / height);
    camera.position.set(...home.away.map((v, k) => home.look[k] + distance * v));
  }
  controls.target.set(...home.look);
  controls.update();
  redraw();
}

/// A part of the stage per run [pixels]: left, bottom, width, height.
function viewports() {
  const { clientWidth: width, clientHeight: height } = byId("stage");
  if (runs.length === 1) return [[0, 0, width, height]];
  if (width >= height) {
    const half = Math.floor(width / 2);
    return [[0, 0, half - 1, height], [half + 1, 0, width - half - 1, height]];
  }
  const half = Math.floor(height / 2);
  return [[0, half + 1, width, height - half - 1], [0, 0, width, half - 1]];
}

function draw() {
  drawing = false;
  renderer.setScissorTest(true);
  viewports().forEach(([left, bottom, width, height], k) => {
    if (width < 1 || height < 1) return;
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    renderer.setViewport(left, bottom, width, height);
    renderer.setScissor(left, bottom, width, height);
    renderer.render(runs[k].scene, camera);
  });
}

function redraw() {
  if (drawing) return;
  drawing = true;
  requestAnimationFrame(draw);
}

function resize() {
  const stage = byId("stage");
  renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, 2));
  renderer.setSize(stage.clientWidth, stage.clientHeight, false);
  const labels = byId("names").children;
  viewports().forEach(([left, bottom, , height], k) => {
    if (!labels[k]) return;
    labels[k].style.left = left + "px";
    labels[k].style.top = stage.clientHeight - bottom - height + "px";
  });
  drawStrips();
  redraw();
}

// -------------------------------------------------------------------------------------- the player
let times = [];      // of the frames of all runs
let at = 0;          // place among times
let clock = 0;       // [s] of the playing run
let playing = false;
let lastTick = 0;
let pointed = null;  // {run, step} under the cursor

function look() { return byId("colour").value; }

function showFrame(place) {
  at = Math.min(Math.max(place, 0), times.length - 1);
  byId("scrub").value = at;
  for (const run of runs) run.show(run.frameAt(times[at]), look(), origin);
  const first = runs[0].frames[runs[0].frameAt(times[at])];
  byId("clock").textContent = `${times[at].toFixed(3)} s, frame ${first.number}`;
  showFacts();
  drawStrips();
  redraw();
}

function setPlaying(on) {
  playing = on && times.length > 1;
  byId("play").textContent = playing ? "Pause" : "Play";
  if (!playing) return;
  if (at === times.length - 1) showFrame(0);
  clock = times[at];
  lastTick = performance.now();
  requestAnimationFrame(tick);
}

function tick(now) {
  if (!playing) return;
  // A tab in the background gets no frames; it goes on where it was.
  clock += Math.min(Math.max(now - lastTick, 0) / 1000, 0.25) * Number(byId("speed").value);
  lastTick = now;
  const last = times.length - 1;
  const pause = times[last] - times[last - 1];  // the last frame is seen as long as the others
  if (clock >= times[last] + pause) {
    if (!byId("loop").checked) {
      showFrame(last);
      return setPlaying(false);
    }
    clock = times[0];
  }
  let place = clock < times[at] ? 0 : at;
  while (place < last && times[place + 1] <= clock + 1e-9) ++place;
  if (place !== at) showFrame(place);
  requestAnimationFrame(tick);
}

function move(steps) {
  setPlaying(false);
  showFrame(at + steps);
}

// ------------------------------------------------------------------------------------------- facts
function sum(steps, field) { return steps.reduce((total, step) => total + (step[field] || 0), 0); }
function most(steps, field) { return steps.reduce((top, step) => Math.max(top, step[field] || 0), 0); }

/// Name and value of each line of the table, for steps that belong together.
function lines(steps) {
  const last = steps[steps.length - 1];
  const number = steps.length === 1 ? String(last.number) : `${steps[0].number} to ${last.number}`;
  return [["step", number], ["time", last.time.toFixed(4) + " s"], ["solves", sum(steps, "solves")],
          ["iterations", sum(steps, "iterations")], ["contacts", last.contacts],
          ["impacts", sum(steps, "impacts")], ["zones", sum(steps, "zones")],
          ["retries", sum(steps, "retries")], ["fallback", fallbacks[most(steps, "fallback_level")]],
          ["compliance", short(1000 * most(steps, "compliance_distance")) + " mm"],
          ["wall time", seconds(sum(steps, "wall_s"))]];
}

function showFacts() {
  const columns = runs.map((run, k) => {
    if (pointed && pointed.run === k) return lines([pointed.step]);
    const steps = run.stepsOf(run.frameAt(times[at]));
    return steps.length ? lines(steps) : [];
  });
  const longest = columns.reduce((a, b) => b.length > a.length ? b : a);
  const head = make("tr");
  head.append(make("th", pointed ? "this step" : "this frame"), ...runs.map((run, k) =>
    make("th", runs.length > 1 ? ["first", "second"][k] : "")));
  const rows = longest.map(([name], k) => {
    const row = make("tr");
    row.append(make("td", name), ...columns.map(c => make("td", c[k] ? c[k][1] : "")));
    return row;
  });
  if (!rows.length) {
    const row = make("tr");
    row.append(make("td", runs.some(run => run.steps.length) ? "no step yet" : "no steps.jsonl"));
    rows.push(row);
  }
  byId("facts").replaceChildren(head, ...rows);
}

/// Wall time of the steps, as bars over time, which change only with the width.
function drawBars(run, width, height, ratio, x) {
  const bars = make("canvas");
  bars.width = width;
  bars.height = height;
  const pen = bars.getContext("2d");
  const top = most(run.steps, "wall_s") || 1;
  for (const step of run.steps) {
    const left = x(step.time - step.step), wide = x(step.time) - left;
    const tall = Math.max(ratio, (step.wall_s || 0) / top * height);
    pen.fillStyle = fallbackColours[step.fallback_level] || "#888888";
    pen.fillRect(left, height - tall, Math.max(ratio, wide > 4 ? wide - 1 : wide), tall);
  }
  return bars;
}

function drawStrips() {
  document.querySelectorAll("#strips canvas").forEach(canvas => {
    const run = runs[canvas.run], ratio = window.devicePixelRatio || 1;
    const width = Math.max(1, Math.round(canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(canvas.clientHeight * ratio));
    const end = Math.max(times[times.length - 1], 1e-9), begin = Math.min(times[0], 0);
    const x = time => (time - begin) / (end - begin) * width;
    if (!canvas.bars || canvas.width !== width || canvas.height !== height) {
      canvas.width = width;
      canvas.height = height;
      canvas.bars = drawBars(run, width, height, ratio, x);
    }
    const pen = canvas.getContext("2d");
    pen.clearRect(0, 0, width, height);
    pen.drawImage(canvas.bars, 0, 0);
    pen.fillStyle = getComputedStyle(document.body).color;
    pen.fillRect(Math.min(x(times[at]), width - 2 * ratio), 0, 2 * ratio, height);
  });
}

function makeStrip(run, k) {
  if (!run.steps.length) return;
  const figure = make("figure"), canvas = make("canvas");
  const used = fallbacks.filter((name, level) => level > 0 && run.steps.some(s => s.fallback_level === level));
  figure.append(make("figcaption", (runs.length > 1 ? ["First: ", "Second: "][k] : "") +
    `wall time per step, up to ${seconds(most(run.steps, "wall_s"))}` +
    (used.length ? `; coloured: ${used.join(", ")}` : "")), canvas);
  canvas.run = k;
  byId("strips").append(figure);
  const stepUnder = event => {
    const box = canvas.getBoundingClientRect();
    const end = times[times.length - 1], begin = Math.min(times[0], 0);
    const time = begin + (event.clientX - box.left) / box.width * (end - begin);
    return run.steps.find(step => step.time >= time) || run.steps[run.steps.length - 1];
  };
  canvas.addEventListener("pointermove", event => { pointed = { run: k, step: stepUnder(event) }; showFacts(); });
  canvas.addEventListener("pointerleave", () => { pointed = null; showFacts(); });
  canvas.addEventListener("pointerdown", event => {
    setPlaying(false);
    const time = stepUnder(event).time;
    const place = times.findIndex(t => t >= time - 1e-9);
    showFrame(place < 0 ? times.length - 1 : place);
  });
}

// ------------------------------------------------------------------------------------------- looks
function showLegend() {
  const legend = byId("legend"), scales = runs.map(run => run.scales);
  const high = name => Math.max(...scales.map(s => s[name]));
  const scale = { strain: ["strain (%)", 0, 100 * high("strain"), true],
                  height: ["height (m)", heights[0], heights[1], false],
                  contact: ["gap / thickness", 0, high("contact"), true],
                  compliance: ["displacement (mm)", 0, 1000 * high("compliance"), false] }[look()];
  byId("meaning").textContent = meanings[look()];
  hide(legend, !scale);
  if (!scale) return;
  const [title, low, top, more] = scale;
  legend.querySelector("figcaption").textContent = title;
  const numbers = legend.querySelectorAll("span");
  numbers[0].textContent = short(low);
  numbers[1].textContent = short((low + top) / 2);
  numbers[2].textContent = (more ? "\u2265 " : "") + short(top);
}

function paintScale() {
  const pen = byId("legend").querySelector("canvas").getContext("2d");
  colours.forEach((c, k) => { pen.fillStyle = `rgb(${c.join(",")})`; pen.fillRect(k, 0, 1, 1); });
}

function showLooks() {
  for (const run of runs) {
    run.clothSurface.group.visible = byId("cloths").checked;
    run.bodySurface.group.visible = byId("obstacles").checked;
    for (const surface of [run.clothSurface, run.bodySurface]) surface.drawWires(byId("wires").checked);
  }
  showLegend();
  showFrame(at);
}

function limitLooks() {
  const has = { plain: true, height: data.runs.some(run => run.cloth_box) };
  for (const name of ["strain", "contact", "compliance"])
    has[name] = data.runs.some(run => run.scales[name] > 0);
  for (const option of byId("colour").options) {
    option.disabled = !has[option.value];
    if (option.disabled) option.textContent += " (not in this run)";
  }
}

// ------------------------------------------------------------------------------------------- words
function nameOf(run) { return run.facts.scene || run.facts.folder || "a run"; }

function describe(run) {
  const f = run.facts, words = [];
  if (f.method) words.push(f.method + (f.device ? " on " + f.device : ""));
  words.push(`${run.frames.length} frame${run.frames.length === 1 ? "" : "s"}`);
  const counts = run.topologies.map(t => t.cloths.reduce((n, part) => n + part.triangles, 0));
  const least = Math.min(...counts).toLocaleString("en"), greatest = Math.max(...counts).toLocaleString("en");
  words.push((least === greatest ? least : `${least} to ${greatest}`) + " triangles of cloth");
  if (f.wall_s !== undefined) words.push(`computed in ${seconds(f.wall_s)}`);
  if (f.intersections !== undefined) words.push(`${f.intersections} intersections at the end`);
  if (f.failure) words.push("failed: " + f.failure);
  return words.join(" \u00b7 ");
}

function showWords() {
  const title = runs.map(nameOf).filter((name, k, all) => all.indexOf(name) === k).join(" and ");
  document.title = title + " \u2013 weft";
  byId("title").textContent = title;
  byId("about").replaceChildren(...runs.map((run, k) =>
    make("span", (runs.length > 1 ? ["First: ", "Second: "][k] : "") + describe(run))));
  byId("names").replaceChildren();
  if (runs.length > 1)
    runs.forEach(run => byId("names").append(make("span", [run.facts.folder, run.facts.method]
      .filter(Boolean).join(" \u00b7 "))));
  const swatch = (name, colour) => {
    const item = make("li"), square = make("canvas");
    square.width = square.height = 1;
    const pen = square.getContext("2d");
    pen.fillStyle = `rgb(${colour.join(",")})`;
    pen.fillRect(0, 0, 1, 1);
    item.append(square, name || "unnamed");
    return item;
  };
  const most = 12, first = runs[0].topologies[0];
  const items = first.cloths.map((part, k) => swatch(part.name, hues[k % hues.length][0]))
    .concat(first.obstacles.map(part => swatch(part.name || "obstacle", bodyHue)));
  const hidden = items.length - most;
  byId("parts").replaceChildren(...items.slice(0, most));
  if (hidden > 0) byId("parts").append(make("li", `and ${hidden} more`));
  const error = Math.max(...runs.map(run => run.position_error));
  byId("precision").textContent = `Positions are rounded to 16 bits, by at most ${short(1000 * error)} mm. ` +
    "Strain and distances were computed before that." +
    (runs[0].facts.commit ? ` The run was made by commit ${runs[0].facts.commit}.` : "");
}

function listen() {
  byId("play").addEventListener("click", () => setPlaying(!playing));
  byId("back").addEventListener("click", () => move(-1));
  byId("forth").addEventListener("click", () => move(1));
  byId("reset").addEventListener("click", () => { findHome(); goHome(); });
  byId("scrub").addEventListener("input", () => { setPlaying(false); showFrame(Number(byId("scrub").value)); });
  for (const id of ["colour", "cloths", "obstacles", "wires"]) byId(id).addEventListener("change", showLooks);
  document.addEventListener("keydown", event => {
    if (/^(INPUT|SELECT|BUTTON|SUMMARY)$/.test(event.target.tagName) || event.ctrlKey || event.metaKey) return;
    const action = { " ": () => setPlaying(!playing), ArrowLeft: () => move(-1), ArrowRight: () => move(1),
                     Home: () => move(-at), End: () => move(times.length) }[event.key];
    if (!action) return;
    event.preventDefault();
    action();
  });
  controls.addEventListener("change", redraw);
  new ResizeObserver(resize).observe(byId("stage"));
}

/// Times, heights and the slider, from the frames so far.
function findTimes() {
  const z = united(runs.map(run => run.cloth_box)).map(end => end[2]);
  heights = z[1] > z[0] ? z : [z[0], z[0] + 1e-6];
  times = runs.flatMap(run => run.frames.map(frame => frame.time)).sort((a, b) => a - b)
    .filter((time, k, all) => k === 0 || time > all[k - 1] + 1e-9);
  byId("scrub").max = times.length - 1;
}

// -------------------------------------------------------------------------------- a run that goes on
function takeNews(news) {
  const run = runs[0];
  const following = at === times.length - 1 && !playing;
  blobs.late.push(...news.blobs);
  run.topologies.push(...news.topologies);
  run.steps.push(...news.steps.map(values => run.stepOf(values)));
  run.frames.push(...news.frames);
  run.cloth_box = news.cloth_box;
  run.obstacle_box = news.obstacle_box;
  if (news.steps.length && !byId("strips").children.length) makeStrip(run, 0);
  if (!news.frames.length && !news.steps.length) return;
  document.querySelectorAll("#strips canvas").forEach(canvas => { canvas.bars = null; });
  findTimes();
  showWords();
  showLegend();
  showFrame(following ? times.length - 1 : at);
}

function showState(text, over) {
  byId("state").textContent = text;
  for (const id of ["pause", "stop"]) hide(byId(id), over);
}

/// Asks for news until the run has ended, or nobody answers.
async function follow() {
  const run = runs[0];
  let news;
  try {
    const asked = `news?frames=${run.frames.length}&topologies=${run.topologies.length}` +
      `&blobs=${blobs.early + blobs.late.length}&steps=${run.steps.length}`;
    news = await (await fetch(asked)).json();
  } catch (problem) {
    return showState("The program has ended or does not answer.", true);
  }
  takeNews(news);
  if (news.ended !== null) return showState(`The run has ended: ${news.ended}.`, true);
  byId("pause").textContent = news.paused ? "Continue the run" : "Pause the run";
  byId("pause").value = news.paused ? "continue" : "pause";
  showState((news.paused ? "Paused" : "Running") + (news.full ? "; later frames are not shown" : ""), false);
  setTimeout(follow, 400);
}

function followLive() {
  hide(byId("live"), false);
  byId("pause").addEventListener("click", () => fetch(byId("pause").value || "pause", { method: "POST" }));
  byId("stop").addEventListener("click", () => fetch("stop", { method: "POST" }));
  showFrame(times.length - 1);
  follow();
}

function start() {
  const canvas = byId("scene");
  const wanted = { antialias: true, alpha: true };
  const context = canvas.getContext("webgl2", wanted) || canvas.getContext("webgl", wanted);
  if (!context) {
    byId("message").textContent = "This page needs WebGL, which the browser does not offer here.";
    hide(byId("message"), false);
    return;
  }
  renderer = new THREE.WebGLRenderer({ canvas, context, alpha: true });
  renderer.setClearColor(0, 0);
  camera = new THREE.PerspectiveCamera(35, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  controls = new THREE.OrbitControls(camera, canvas);
  controls.enableKeys = false;
  controls.screenSpacePanning = true;
  data.runs.forEach((content, k) => runs.push(new Run(k, content)));
  findTimes();
  findHome();
  limitLooks();
  showWords();
  runs.forEach(makeStrip);
  paintScale();
  listen();
  showLooks();
  resize();
  goHome();
  if (data.live) followLive();
}

start();
}());
