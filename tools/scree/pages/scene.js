/** The frames of a run: where its blocks are, what they feel, what their joints do. Places are relative to an origin. */
class Scene {
  constructor(facts, array) {
    Object.assign(this, facts);
    this.frames = facts.steps.length;
    for (const name of ["corners", "count", "block", "material", "gone", "was", "edge_drawn", "edge_face", "edge_block", "against_edge"]) this[name] = array(name);
    this.againstShares = Float64Array.from(array("against_shares"), q => q / 2 ** 30);
    const start = array("start"), edges = array("edges"), edgeCount = this.edge_face.length;
    this.start = Float64Array.from(start, q => q * facts.size / 2 ** 30);
    this.vertices = start.length / 2;
    this.edgeFrom = edges.subarray(0, edgeCount);
    this.edgeTo = edges.subarray(edgeCount);
    this.elements = this.count.length;
    this.first = startsOf(this.count);
    this.meshed = this.blocks.length < this.elements;
    this.motion = byFrame(array("motion"), this.frames, Int16Array);
    this.stress = byFrame(array("stress"), this.frames, Int16Array);
    this.velocity = byFrame(array("velocity"), this.frames, Int16Array);
    this.factor = new Float64Array(this.vertices);
    for (let e = 0; e < this.elements; e++)
      for (let i = this.first[e]; i < this.first[e + 1]; i++) this.factor[this.corners[i]] = this.motion_factor[this.block[e]];
    this.takeContacts(array);
  }

  /** Whether no stage has removed a block. */
  isThere(frame, block) {
    return frame < this.gone[block];
  }

  /** The block in a frame of one of the end, which may be a part that breaks off later. */
  blockIn(frame, block) {
    return this.was[frame * this.blocks.length + block];
  }

  /** Whether an edge is a line of the mesh in a frame, or one of joints and boundary; it is neither before a crack makes it. */
  isMeshLine(frame, edge) {
    return this.edge_drawn[edge] <= frame && frame < this.edge_face[edge];
  }

  isFace(frame, edge) {
    return this.edge_face[edge] <= frame;
  }

  /** Edges of joints and boundary of each block in a frame. */
  facesOf(frame) {
    const found = Array.from(this.blocks, () => []);
    for (let i = 0; i < this.edge_face.length; i++) if (this.isFace(frame, i)) found[this.blockIn(frame, this.edge_block[i])].push(i);
    return found;
  }

  /** x of all vertices, then y; displacements as they are or magnified, from the frame that they count from. */
  positions(frame, magnified) {
    const n = this.vertices, at = 2 * n * frame, before = 2 * n * this.since[frame], found = Float64Array.from(this.start);
    for (let v = 0; v < n; v++) {
      for (let i = 0; i < 2; i++) {
        const from = this.motion[before + 2 * v + i];
        found[i * n + v] += this.factor[v] * (from + magnified * (this.motion[at + 2 * v + i] - from));
      }
    }
    return found;
  }

  /** x of the centroids of all elements, then y. */
  centroids(places) {
    const n = this.vertices, found = new Float64Array(2 * this.elements);
    for (let e = 0; e < this.elements; e++) {
      const begin = this.first[e], end = this.first[e + 1], x0 = places[this.corners[begin]], y0 = places[n + this.corners[begin]];
      let area = 0, x = 0, y = 0;
      for (let i = begin + 1; i < end - 1; i++) {
        const v = this.corners[i], w = this.corners[i + 1];
        const ax = places[v] - x0, ay = places[n + v] - y0, bx = places[w] - x0, by = places[n + w] - y0, twice = ax * by - ay * bx;
        area += twice;
        x += twice * (ax + bx);
        y += twice * (ay + by);
      }
      found[e] = x0 + x / (3 * area);
      found[this.elements + e] = y0 + y / (3 * area);
    }
    return found;
  }

  /** Stress xx, yy, xy of an element. */
  stressOf(frame, e) {
    const at = 3 * (this.elements * frame + e), factor = this.stress_factor[e];
    return [factor * this.stress[at], factor * this.stress[at + 1], factor * this.stress[at + 2]];
  }

  velocityOf(frame, e) {
    const at = 2 * (this.elements * frame + e), factor = this.velocity_factor[e];
    return [factor * this.velocity[at], factor * this.velocity[at + 1]];
  }

  /** Mean over the corners of an element of how far they have come. */
  displacementOf(frame, e) {
    const at = 2 * this.vertices * frame, before = 2 * this.vertices * this.since[frame], {motion} = this;
    let sum = 0;
    for (let i = this.first[e]; i < this.first[e + 1]; i++) {
      const v = 2 * this.corners[i];
      sum += this.factor[v / 2] * Math.hypot(motion[at + v] - motion[before + v], motion[at + v + 1] - motion[before + v + 1]);
    }
    return sum / this.count[e];
  }

  /** A field in an element. */
  value(frame, field, e) {
    if (field === "block") return this.blocks[this.blockIn(frame, this.block[e])];
    if (field === "material") return this.material[e];
    if (field === "displacement") return this.displacementOf(frame, e);
    if (field === "velocity") return Math.hypot(...this.velocityOf(frame, e));
    const stress = this.stressOf(frame, e);
    if (field === "major") return principal(stress)[0];
    if (field === "minor") return principal(stress)[1];
    return stress[["stress_xx", "stress_yy", "stress_xy"].indexOf(field)];
  }

  /** Displacement or velocity at the centroids, x then y. */
  vectors(frame, kind) {
    const n = this.elements, found = new Float64Array(2 * n);
    if (kind === "displacement") {
      const now = this.centroids(this.positions(frame, 1)), from = this.centroids(this.positions(this.since[frame], 1));
      for (let i = 0; i < 2 * n; i++) found[i] = now[i] - from[i];
    } else {
      for (let e = 0; e < n; e++) [found[e], found[n + e]] = this.velocityOf(frame, e);
    }
    return found;
  }

  /** Contacts by frames: where those of a frame begin, and their numbers, pairs of blocks together. */
  takeContacts(array) {
    if (this.force_factor === null) return;
    const names = ["vertex", "block", "frame", "state", "angle", "force"];
    [this.contactVertex, this.contactBlock, this.contactFrame, this.contactState, this.contactAngle, this.contactForce] =
      names.map(name => array(`contact_${name}`));
    const n = this.contactFrame.length, count = new Int32Array(this.frames);
    for (const k of this.contactFrame) count[k]++;
    this.contactFirst = startsOf(count);
    const next = this.contactFirst.slice();
    this.contactOrder = new Int32Array(n);
    for (let i = 0; i < n; i++) this.contactOrder[next[this.contactFrame[i]]++] = i;
    this.blockOf = new Int32Array(this.vertices);
    for (let e = 0; e < this.elements; e++)
      for (let i = this.first[e]; i < this.first[e + 1]; i++) this.blockOf[this.corners[i]] = this.block[e];
  }

  contactsOf(frame) {
    return this.contactOrder ? this.contactOrder.subarray(this.contactFirst[frame], this.contactFirst[frame + 1]) : [];
  }

  /** Force of a contact on the block of its vertex: x, y. Roots are kept. */
  forceOf(contact) {
    const angle = this.contactAngle[contact] * Math.PI / 128, across = this.contactForce[contact];
    const along = this.contactForce[this.contactFrame.length + contact], factor = this.force_factor;
    const p = factor * across * Math.abs(across), q = factor * along * Math.abs(along);
    return [p * Math.cos(angle) - q * Math.sin(angle), p * Math.sin(angle) + q * Math.cos(angle)];
  }

  /** What joints do, as overlays.py has it: parts as x1 y1 x2 y2. Slip and stick: what two edges have of each other, or a short
   *  piece where a corner touches an edge; slip wins. Open: of edges without contact what lay against others at the start.
   *  Places are those as drawn. */
  jointParts(frame, drawn) {
    const places = this.positions(frame, 1); // who touches whom is asked of these
    const n = this.vertices, faces = this.facesOf(frame), touched = new Uint8Array(this.edge_face.length), parts = {stick: [], slip: [], open: []};
    const name = sliding => sliding ? "slip" : "stick", own = [], others = [], pairs = [];
    let lastA = -1, lastB = -1;
    const addPairs = () => {
      for (let k = 0; k < pairs.length; k += 3) this.addCommonPart(pairs[k + 1], pairs[k], places, drawn, parts[name(pairs[k + 2])]);
      pairs.length = 0;
    };
    for (const contact of this.contactsOf(frame)) {
      const v = this.contactVertex[contact], x = places[v], y = places[n + v], angle = this.contactAngle[contact] * Math.PI / 128;
      const dx = -Math.sin(angle), dy = Math.cos(angle), sliding = this.contactState[contact] === LOOK.sliding;
      const a = this.blockIn(frame, this.blockOf[v]), b = this.contactBlock[contact];
      if ((a !== lastA || b !== lastB) && (a !== lastB || b !== lastA)) addPairs(); // contacts of two blocks are together
      [lastA, lastB] = [a, b];
      this.edgesAt(faces[a], x, y, dx, dy, places, own);
      this.edgesAt(faces[b], x, y, dx, dy, places, others);
      for (const i of own) touched[i] = 1;
      for (const i of others) touched[i] = 1;
      for (const i of own) for (const j of others) if (i !== j) addPair(pairs, i, j, sliding);
      if (!own.length && others.length) {
        const half = LOOK.corner * this.shortestEdge(faces[a], places) / 2, px = drawn[v], py = drawn[n + v];
        parts[name(sliding)].push(px - half * dx, py - half * dy, px + half * dx, py + half * dy);
      }
    }
    addPairs();
    const against = this.against_edge.length;
    for (let i = 0; i < against && frame > 0; i++) {
      const edge = this.against_edge[i];
      if (!touched[edge] && this.isFace(frame, edge) && this.isThere(frame, this.edge_block[edge]))
        this.addPart(edge, this.againstShares[i], this.againstShares[against + i], drawn, parts.open);
    }
    return parts;
  }

  /** x1 y1 x2 y2 of an edge. */
  edgeOf(i, places) {
    const v = this.edgeFrom[i], w = this.edgeTo[i], n = this.vertices;
    return [places[v], places[n + v], places[w], places[n + w]];
  }

  shortestEdge(edges, places) {
    return Math.min(...edges.map(i => {
      const [x1, y1, x2, y2] = this.edgeOf(i, places);
      return Math.hypot(x2 - x1, y2 - y1);
    }));
  }

  /** Finds those of some edges that a place lies on and that run along a direction. */
  edgesAt(edges, x, y, alongX, alongY, places, found) {
    const n = this.vertices;
    found.length = 0;
    for (const i of edges) {
      const v = this.edgeFrom[i], w = this.edgeTo[i], x1 = places[v], y1 = places[n + v], dx = places[w] - x1, dy = places[n + w] - y1;
      const square = dx * dx + dy * dy, across = dx * alongY - dy * alongX;
      if (across * across > LOOK.parallel ** 2 * square) continue;
      const share = Math.min(1, Math.max(0, ((x - x1) * dx + (y - y1) * dy) / square));
      const offX = x - x1 - share * dx, offY = y - y1 - share * dy;
      if (offX * offX + offY * offY < LOOK.beside ** 2 * square) found.push(i);
    }
  }

  /** Adds what an edge has of another one that lies on it. */
  addCommonPart(edge, other, places, drawn, parts) {
    const [x1, y1, x2, y2] = this.edgeOf(edge, places), dx = x2 - x1, dy = y2 - y1, [u1, v1, u2, v2] = this.edgeOf(other, places);
    const square = dx * dx + dy * dy, first = ((u1 - x1) * dx + (v1 - y1) * dy) / square;
    const second = ((u2 - x1) * dx + (v2 - y1) * dy) / square;
    const low = Math.max(Math.min(first, second), 0), high = Math.min(Math.max(first, second), 1);
    if (low >= high) return;
    this.addPart(edge, low, high, drawn, parts);
  }

  /** Adds a part of an edge, from where to where along it, in shares. */
  addPart(edge, low, high, drawn, parts) {
    const [px, py, qx, qy] = this.edgeOf(edge, drawn);
    for (const share of [low, high]) parts.push(px + share * (qx - px), py + share * (qy - py));
  }

  /** Places of the points of a kind. */
  pointsOf(kind, places) {
    return this.points.filter(point => point.kind === kind).map(point => this.placeOf(point, places));
  }

  /** The place of a point or a tip. */
  placeOf({vertices, weights}, places) {
    return [0, this.vertices].map(shift => vertices.reduce((sum, v, i) => sum + weights[i] * places[v + shift], 0));
  }

  /** The element at a place in a frame, -1 where there is none. */
  elementAt(x, y, places, frame) {
    const n = this.vertices;
    for (let e = 0; e < this.elements; e++) {
      if (!this.isThere(frame, this.block[e])) continue;
      let inside = false, last = this.corners[this.first[e + 1] - 1];
      for (let i = this.first[e]; i < this.first[e + 1]; i++) {
        const v = this.corners[i], vy = places[n + v], ly = places[n + last];
        if (vy > y !== ly > y && x < places[v] + (places[last] - places[v]) * (y - vy) / (ly - vy)) inside = !inside;
        last = v;
      }
      if (inside) return e;
    }
    return -1;
  }
}

/** Where the items of each of several lists begin, and where all end. */
function startsOf(counts) {
  const starts = new Int32Array(counts.length + 1);
  counts.forEach((count, i) => { starts[i + 1] = starts[i] + count; });
  return starts;
}

/** Adds two edges to a list of pairs and whether each slides, three numbers each; one that slides stays so. */
function addPair(pairs, i, j, sliding) {
  for (let k = 0; k < pairs.length; k += 3) {
    if (pairs[k] !== i || pairs[k + 1] !== j) continue;
    pairs[k + 2] = pairs[k + 2] || sliding;
    return;
  }
  pairs.push(i, j, sliding);
}

/** Larger and smaller principal stress, and the angle of the larger with x. */
function principal([xx, yy, xy]) {
  const mean = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy);
  return [mean + half, mean - half, Math.atan2(2 * xy, xx - yy) / 2];
}
