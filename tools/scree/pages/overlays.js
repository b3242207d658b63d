// What is drawn over the blocks, in the manner of overlays.py, whose colours and sizes it has.

const LEAST = 0.5; // pixels: what is shorter is not seen

function drawOver(player) {
  player.bars = 0;
  drawBolts(player);
  if (player.joints) drawJoints(player);
  if (player.joints === "forces") drawForces(player);
  if (player.crosses) drawCrosses(player);
  if (player.points) drawPoints(player);
  if (player.numbers) drawNumbers(player);
  if (player.vectors) drawVectors(player);
  drawTips(player);
}

/** Segments, x1 y1 x2 y2 each, or points, in pixels. */
function asPixels(player, places) {
  const found = new Float64Array(places.length);
  for (let i = 0; i < places.length; i += 2) {
    found[i] = (places[i] - player.left) * player.scale;
    found[i + 1] = player.tall - (places[i + 1] - player.below) * player.scale;
  }
  return found;
}

/** What lines of many blocks are thinner by. */
function thinner(player) {
  return Math.min(1, (LOOK.many_blocks / player.scene.blocks.length) ** 0.3);
}

function drawJoints(player) {
  const parts = player.scene.jointParts(player.frame, player.places);
  for (const [name, {colour, width, dash}] of Object.entries(LOOK.states))
    player.stroke(asPixels(player, parts[name]), colour, width * thinner(player), dash.map(length => length * width));
}

/** Pixels that one of what is measured has, so that the large values of all frames have a share of the picture. */
function pixelsFor(player, what, share) {
  const {large} = LOOK.scales[what];
  return large > 0 ? share * Math.max(player.wide, player.tall) / large : 0;
}

function drawForces(player) {
  const {scene} = player, n = scene.vertices, {colour, width} = LOOK.force, segments = [];
  const factor = pixelsFor(player, "force", LOOK.longest * thinner(player) ** 2);
  for (const contact of scene.contactsOf(player.frame)) {
    const [fx, fy] = scene.forceOf(contact), v = scene.contactVertex[contact], x = player.pixels[v], y = player.pixels[n + v];
    const dx = factor * fx / 2, dy = factor * fy / 2;
    if (dx * dx + dy * dy > LEAST ** 2) segments.push(x - dx, y + dy, x + dx, y - dy);
  }
  player.stroke(segments, colour, width * thinner(player));
  drawScale(player, factor, "force", colour);
}

/** Elements that vectors or crosses are drawn in: in each cell of a lattice over the picture that nearest to its middle. */
function spreadOut(player, pixels) {
  const n = player.scene.elements, side = Math.max(player.wide, player.tall) / LOOK.cells, nearest = new Map();
  for (let e = 0; e < n; e++) {
    if (!player.scene.isThere(player.frame, player.scene.block[e])) continue;
    const x = pixels[e], y = pixels[n + e];
    if (x < 0 || x > player.wide || y < 0 || y > player.tall) continue;
    const i = Math.floor(x / side), j = Math.floor(y / side), cell = i * 1e4 + j;
    const off = (x / side - i - 0.5) ** 2 + (y / side - j - 0.5) ** 2;
    if (!nearest.has(cell) || off < nearest.get(cell)[0]) nearest.set(cell, [off, e]);
  }
  return [...nearest.values()].map(([, e]) => e);
}

function drawCrosses(player) {
  const {scene} = player, pixels = player.toPixels(scene.centroids(player.places)), factor = pixelsFor(player, "stress", LOOK.cross);
  const segments = {compression: [], tension: []};
  for (const e of spreadOut(player, pixels)) {
    const x = pixels[e], y = pixels[scene.elements + e], [major, minor, angle] = principal(scene.stressOf(player.frame, e));
    for (const [value, turned] of [[major, angle], [minor, angle + Math.PI / 2]]) {
      const dx = factor * Math.abs(value) / 2 * Math.cos(turned), dy = factor * Math.abs(value) / 2 * Math.sin(turned);
      segments[value < 0 ? "compression" : "tension"].push(x - dx, y + dy, x + dx, y - dy);
    }
  }
  for (const name of ["compression", "tension"]) player.stroke(segments[name], LOOK[name].colour, LOOK[name].width);
  drawScale(player, factor, "stress", LOOK.compression.colour);
}

function drawVectors(player) {
  const {scene, pen} = player, pixels = player.toPixels(scene.centroids(player.places)), n = scene.elements;
  const vectors = scene.vectors(player.frame, player.vectors), factor = pixelsFor(player, player.vectors, LOOK.longest);
  for (const [colour, width] of [["white", 4], ["black", 2]]) { // black with a white rim
    pen.strokeStyle = pen.fillStyle = colour;
    for (const e of spreadOut(player, pixels)) {
      const dx = factor * vectors[e], dy = -factor * vectors[n + e], length = Math.hypot(dx, dy);
      if (length < 1) continue;
      drawArrow(pen, pixels[e], pixels[n + e], dx, dy, length, width);
    }
  }
  drawScale(player, factor, player.vectors, "black");
}

function drawArrow(pen, x, y, dx, dy, length, width) {
  const head = Math.min(9, 0.6 * length), ux = dx / length, uy = dy / length, foot = length - head;
  pen.lineWidth = width;
  pen.beginPath();
  pen.moveTo(x, y);
  pen.lineTo(x + foot * ux, y + foot * uy);
  pen.stroke();
  pen.lineWidth = width - 1;
  pen.beginPath();
  pen.moveTo(x + dx, y + dy);
  pen.lineTo(x + foot * ux - 0.4 * head * uy, y + foot * uy + 0.4 * head * ux);
  pen.lineTo(x + foot * ux + 0.4 * head * uy, y + foot * uy - 0.4 * head * ux);
  pen.closePath();
  pen.stroke();
  pen.fill();
}

/** A bar with its value below those that are there. */
function drawScale(player, pixels, what, colour) {
  if (!(pixels > 0)) return;
  const {large, label, factor} = LOOK.scales[what];
  const {pen} = player, value = roundBelow(large / factor), end = 14 + pixels * value * factor, y = 18 + 20 * player.bars++;
  pen.font = "12px system-ui, sans-serif";
  pen.textBaseline = "middle";
  player.stroke([14, y, end, y], colour, 3);
  writeBeside(player, `${digits(value)} ${label}`, end + 8, y);
}

/** The largest of 1, 2 and 5 times a power of ten up to a value. */
function roundBelow(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return power * Math.max(...[1, 2, 5].filter(digit => digit * power <= value * (1 + 1e-9)));
}

/** A number in few digits. */
function digits(value) {
  const size = Math.abs(value), short = Number(value.toPrecision(4));
  return size >= 1e5 || (size > 0 && size < 1e-3) ? short.toExponential().replace("e+", "e") : String(short);
}

function drawBolts(player) {
  const {scene} = player;
  if (!scene.bolts.length) return;
  const {ends, state} = scene.bolts[player.frame], start = scene.bolts[scene.since[player.frame]].ends;
  const place = i => start[i] + player.magnified * (ends[i] - start[i]) - scene.origin[i % 2];
  LOOK.bolts.forEach(({colour, dash}, k) => {
    const segments = state.flatMap((now, i) => now === k ? [0, 1, 2, 3].map(j => place(4 * i + j)) : []);
    player.stroke(asPixels(player, segments), colour, 2, dash);
  });
}

function drawPoints(player) {
  const {pen} = player, size = 5;
  pen.strokeStyle = "black";
  pen.lineWidth = 0.8;
  for (const {kind, colour} of LOOK.points) {
    pen.fillStyle = colour;
    for (const place of player.scene.pointsOf(kind, player.places)) {
      const [x, y] = asPixels(player, place), up = kind === 1 ? -1 : 1;
      pen.beginPath();
      if (kind === 3) pen.arc(x, y, size, 0, 2 * Math.PI);
      else for (const [dx, dy] of [[0, size], [size, -size], [-size, -size]]) pen.lineTo(x + dx, y + up * dy);
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
  }
}

/** A mark at each tip of a crack, with its stress intensity factors where the tips are few. */
function drawTips(player) {
  const {pen, scene} = player, tips = scene.tips[player.frame];
  pen.font = "11px system-ui, sans-serif";
  pen.textBaseline = "middle";
  for (const tip of tips) {
    const [x, y] = asPixels(player, scene.placeOf(tip, player.places)), [opening, shear] = tip.intensity.map(value => value / LOOK.tip.factor);
    pen.lineWidth = 0.8;
    pen.strokeStyle = "black";
    pen.fillStyle = LOOK.tip.colour;
    pen.beginPath();
    pen.arc(x, y, 3.5, 0, 2 * Math.PI);
    pen.fill();
    pen.stroke();
    if (tips.length > LOOK.tip.most) continue;
    const right = x > player.wide / 2;
    pen.textAlign = right ? "right" : "left";
    writeBeside(player, opening || shear ? `K_I ${digits(opening)}, K_II ${digits(shear)}` : "not measured", x + (right ? -6 : 6), y - 9);
  }
  pen.textAlign = "left";
}

/** Words with a white rim that begin at a place. */
function writeBeside({pen}, words, x, y) {
  pen.lineWidth = 3;
  pen.strokeStyle = "white";
  pen.strokeText(words, x, y);
  pen.fillStyle = "black";
  pen.fillText(words, x, y);
}

/** Numbers of blocks, as many as there is room for. */
function drawNumbers(player) {
  const {scene, pen} = player, n = scene.elements, pixels = player.toPixels(scene.centroids(player.places)), done = new Set();
  pen.font = "11px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  for (const e of spreadOut(player, pixels)) {
    const number = scene.value(player.frame, "block", e);
    if (done.has(number)) continue;
    done.add(number);
    writeBeside(player, number, pixels[e], pixels[n + e]);
  }
  pen.textAlign = "left";
}
