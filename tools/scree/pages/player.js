const CHUNK = 64;      // shapes of a path: what a browser takes for one grows faster than their number
const EMPTY = 0.04;    // of the picture, left free at each side of the scene
const AWAY = 0.25;     // of the size of the scene, beyond which what has moved out of it is not looked for
const DARK = "#262626", GREY = "#b3b3b3", MESH = "#59595940";

/** Draws a frame of a scene on a canvas, where one can zoom and pan. */
class Player {
  constructor(canvas, scene) {
    Object.assign(this, {canvas, scene, pen: canvas.getContext("2d"), frame: 0, magnified: 1, field: "block", joints: "", vectors: "", finest: 1,
      crosses: false, mesh: true, points: false, numbers: false});
    this.bins = new Int32Array(scene.elements);
    this.fit();
    this.watchPointer();
  }

  /** Takes the size that the page gives the canvas. */
  resize() {
    this.ratio = Math.max(this.finest, window.devicePixelRatio || 1);
    this.wide = this.canvas.clientWidth;
    this.tall = this.canvas.clientHeight;
    const size = [this.wide, this.tall].map(length => Math.round(length * this.ratio));
    if (this.canvas.width !== size[0] || this.canvas.height !== size[1]) [this.canvas.width, this.canvas.height] = size;
  }

  /** Shows all that there is at the start, and in the last frame what has not gone too far away. */
  fit() {
    this.resize();
    const n = this.scene.vertices, {start, size} = this.scene, last = this.scene.positions(this.scene.frames - 1, 1);
    const [[x0, x1], [y0, y1]] = [0, n].map(shift => {
      const [low, high] = ends([start.subarray(shift, shift + n)]), near = AWAY * size;
      return ends([[low, high], last.subarray(shift, shift + n).filter(value => value > low - near && value < high + near)]);
    });
    const {wide, tall} = this, room = 1 - 2 * EMPTY;
    this.scale = Math.min(room * wide / (x1 - x0), room * tall / (y1 - y0)); // pixels a length
    this.left = (x0 + x1) / 2 - wide / 2 / this.scale; // x and y of the corner at the lower left
    this.below = (y0 + y1) / 2 - tall / 2 / this.scale;
  }

  zoom(px, py, factor) {
    const [x, y] = this.placeOf(px, py);
    this.scale *= factor;
    this.left = x - px / this.scale;
    this.below = y - (this.tall - py) / this.scale;
  }

  /** The place below a pixel. */
  placeOf(px, py) {
    return [this.left + px / this.scale, this.below + (this.tall - py) / this.scale];
  }

  watchPointer() {
    let from = null;
    const here = event => [event.offsetX, event.offsetY];
    this.canvas.addEventListener("wheel", event => {
      event.preventDefault();
      this.zoom(...here(event), Math.exp(-event.deltaY * 0.0015));
      this.draw();
    }, {passive: false});
    this.canvas.addEventListener("pointerdown", event => { from = here(event); this.canvas.setPointerCapture(event.pointerId); });
    this.canvas.addEventListener("pointerup", () => { from = null; });
    this.canvas.addEventListener("pointermove", event => {
      const to = here(event);
      if (from) {
        this.left -= (to[0] - from[0]) / this.scale;
        this.below += (to[1] - from[1]) / this.scale;
        from = to;
        this.draw();
      } else if (this.pointed) {
        this.pointed(this.scene.elementAt(...this.placeOf(...to), this.places, this.frame));
      }
    });
    this.canvas.addEventListener("dblclick", () => { this.fit(); this.draw(); });
  }

  draw() {
    this.resize();
    const {pen, scene} = this;
    this.places = scene.positions(this.frame, this.magnified);
    this.pixels = this.toPixels(this.places);
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.fillStyle = "white";
    pen.fillRect(0, 0, this.wide, this.tall);
    pen.lineJoin = "round";
    const since = scene.since[this.frame];
    if (this.frame > 0) this.strokeEdges(this.toPixels(scene.positions(since, 1)), since, false, GREY, 0.8);
    this.fill();
    if (scene.meshed && this.mesh) this.strokeEdges(this.pixels, this.frame, true, MESH, 0.5);
    this.strokeEdges(this.pixels, this.frame, false, DARK, this.joints ? 0.4 : 0.7);
    drawOver(this);
  }

  toPixels(places) {
    const n = places.length / 2, found = new Float32Array(2 * n), tall = this.tall;
    for (let v = 0; v < n; v++) {
      found[v] = (places[v] - this.left) * this.scale;
      found[n + v] = tall - (places[n + v] - this.below) * this.scale;
    }
    return found;
  }

  /** Whether something between two pixels may be seen. */
  seen(x0, y0, x1, y1) {
    const {wide, tall} = this;
    return Math.max(x0, x1) > 0 && Math.min(x0, x1) < wide && Math.max(y0, y1) > 0 && Math.min(y0, y1) < tall;
  }

  /** Ends and colours of the field; paler below what is drawn over. */
  get colours() {
    const {limits, map} = LOOK.fields[this.field], over = this.joints || this.vectors || this.crosses;
    return {limits, colours: LOOK.maps[map][over ? "paler" : "full"]};
  }

  /** Elements in the colours of the field, those of a colour together. */
  fill() {
    const {pen, scene, pixels, bins} = this, {limits: [low, high], colours} = this.colours, n = scene.vertices;
    const count = new Int32Array(colours.length), there = e => scene.isThere(this.frame, scene.block[e]);
    for (let e = 0; e < scene.elements; e++) {
      if (!there(e)) continue;
      const share = (scene.value(this.frame, this.field, e) - low) / (high - low);
      bins[e] = Math.min(colours.length - 1, Math.max(0, Math.floor(share * colours.length)));
      count[bins[e]]++;
    }
    const first = startsOf(count), next = first.slice(), order = new Int32Array(scene.elements);
    for (let e = 0; e < scene.elements; e++) if (there(e)) order[next[bins[e]]++] = e;
    for (let colour = 0; colour < colours.length; colour++) {
      pen.fillStyle = pen.strokeStyle = colours[colour];
      pen.lineWidth = 1;
      for (let at = first[colour]; at < first[colour + 1]; at += CHUNK) {
        pen.beginPath();
        for (let k = at; k < Math.min(at + CHUNK, first[colour + 1]); k++) this.trace(order[k], pixels, n);
        pen.fill();
        if (scene.meshed) pen.stroke(); // else white shines through between neighbours
      }
    }
  }

  trace(e, pixels, n) {
    const {scene, pen} = this, begin = scene.first[e], end = scene.first[e + 1];
    let x0 = Infinity, y0 = Infinity, x1 = -Infinity, y1 = -Infinity;
    for (let i = begin; i < end; i++) {
      const x = pixels[scene.corners[i]], y = pixels[n + scene.corners[i]];
      if (x < x0) x0 = x;
      if (x > x1) x1 = x;
      if (y < y0) y0 = y;
      if (y > y1) y1 = y;
    }
    if (!this.seen(x0, y0, x1, y1)) return;
    pen.moveTo(pixels[scene.corners[begin]], pixels[n + scene.corners[begin]]);
    for (let i = begin + 1; i < end; i++) pen.lineTo(pixels[scene.corners[i]], pixels[n + scene.corners[i]]);
    pen.closePath();
  }

  /** Strokes segments, four numbers each in pixels. */
  stroke(segments, colour, width, dash = []) {
    const {pen} = this;
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    for (let at = 0; at < segments.length; at += 4 * CHUNK) {
      pen.beginPath();
      for (let i = at; i < Math.min(at + 4 * CHUNK, segments.length); i += 4) {
        if (!this.seen(segments[i], segments[i + 1], segments[i + 2], segments[i + 3])) continue;
        pen.moveTo(segments[i], segments[i + 1]);
        pen.lineTo(segments[i + 2], segments[i + 3]);
      }
      pen.stroke();
    }
    pen.setLineDash([]);
  }

  /** Strokes the edges of the blocks that are there in a frame, or the lines of their mesh. */
  strokeEdges(pixels, frame, ofMesh, colour, width) {
    const {scene} = this, n = scene.vertices, segments = [];
    for (let i = 0; i < scene.edge_face.length; i++) {
      if (!(ofMesh ? scene.isMeshLine(frame, i) : scene.isFace(frame, i)) || !scene.isThere(frame, scene.edge_block[i])) continue;
      const v = scene.edgeFrom[i], w = scene.edgeTo[i];
      segments.push(pixels[v], pixels[n + v], pixels[w], pixels[n + w]);
    }
    this.stroke(segments, colour, width);
  }
}
