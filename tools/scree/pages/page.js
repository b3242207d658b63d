const byId = id => document.getElementById(id);
const FRAMES_A_SECOND = 20;
const PRINTED = 3;     // pixels of a canvas a pixel of the page, for paper

/** Makes the page alive: unpacks the frames, draws histories, listens. */
async function begin() {
  const facts = JSON.parse(byId("facts").textContent), bytes = await unzipped(byId("frames").textContent);
  const scene = new Scene(facts.scene, name => facts.arrays[name] && unfolded(bytes, facts.arrays[name]));
  const player = new Player(byId("scene"), scene);
  const charts = facts.charts.map(chart => {
    const box = document.createElement("section");
    box.className = "chart";
    byId(chart.solver ? "solver_charts" : "charts").append(box);
    return makeChart(box, chart, step => show(nearestFrame(scene.steps, step)));
  });
  let pointed = -1, playing = 0;

  function show(frame) {
    player.frame = frame;
    byId("frame").value = frame;
    byId("time").textContent = `${scene.moments[frame]}, frame ${frame} of ${scene.frames - 1}`;
    for (const chart of charts) chart.mark(scene.steps[frame]);
    player.draw();
    say();
  }

  /** What the element that is pointed at has. */
  function say() {
    if (pointed < 0) {
      byId("pointed").textContent = "";
      return;
    }
    const stress = scene.stressOf(player.frame, pointed), [major, minor] = principal(stress);
    const words = (what, value) => digits(value / LOOK.scales[what].factor) + LOOK.scales[what].unit;
    byId("pointed").textContent = [`block ${scene.value(player.frame, "block", pointed)}`, `material ${scene.material[pointed]}`,
      `displacement ${words("displacement", scene.displacementOf(player.frame, pointed))}`,
      `velocity ${words("velocity", Math.hypot(...scene.velocityOf(player.frame, pointed)))}`,
      `principal stresses ${words("stress", major)}, ${words("stress", minor)}`].join(" · ");
  }

  function redraw() {
    for (const name of ["field", "joints", "vectors"]) player[name] = byId(name).value;
    for (const name of ["crosses", "mesh", "points", "numbers"]) player[name] = byId(name).checked;
    player.magnified = Number(byId("magnify").value) || 1;
    drawColours(player);
    drawLegend(player);
    show(player.frame);
  }

  /** Draws all anew in the size that the page gives it, with at least so many pixels of a canvas a pixel of the page. */
  function drawAll(finest) {
    player.finest = finest;
    player.draw();
    for (const chart of charts) chart.draw(Math.max(finest, window.devicePixelRatio || 1));
  }

  function step(stamp) {
    if (!playing) return;
    if (stamp - playing >= 1000 / FRAMES_A_SECOND - 4) { // a screen shows at its own times
      playing = stamp;
      show((player.frame + 1) % scene.frames);
    }
    requestAnimationFrame(step);
  }

  function play(on) {
    playing = on ? performance.now() : 0;
    byId("play").textContent = on ? "❚❚" : "►";
    if (on) requestAnimationFrame(step);
  }

  player.pointed = element => { pointed = element; say(); };
  byId("play").addEventListener("click", () => play(!playing));
  byId("frame").max = scene.frames - 1;
  byId("frame").addEventListener("input", () => { play(false); show(Number(byId("frame").value)); });
  for (const name of ["field", "joints", "vectors", "crosses", "mesh", "points", "numbers", "magnify"])
    byId(name).addEventListener("input", redraw);
  byId("fit").addEventListener("click", () => { player.fit(); player.draw(); });
  window.addEventListener("resize", () => drawAll(1));
  byId("solver").addEventListener("toggle", () => drawAll(1));  // what is folded has no size
  window.addEventListener("beforeprint", () => drawAll(PRINTED));
  window.addEventListener("afterprint", () => drawAll(1));
  document.addEventListener("keydown", event => {
    if (event.target.tagName === "INPUT" && event.target.type === "number") return;
    const moves = {ArrowRight: 1, ArrowLeft: -1};
    if (event.key === " ") play(!playing);
    else if (event.key in moves) show((player.frame + moves[event.key] + scene.frames) % scene.frames);
    else return;
    event.preventDefault();
  });
  for (const [id, needed] of [["mesh", scene.meshed], ["joints", scene.contactOrder], ["points", scene.points.length]])
    byId(id).closest("label").hidden = !needed;
  Object.assign(window, {player, show});
  player.frame = scene.frames - 1;
  redraw();
  drawAll(1);
}

function nearestFrame(steps, step) {
  return steps.reduce((best, one, k) => Math.abs(one - step) < Math.abs(steps[best] - step) ? k : best, 0);
}

/** The bar of colours with its ends; rock has entries of the legend in its place. */
function drawColours(player) {
  byId("scale").hidden = isRock(player);
  const {limits: [low, high], colours} = player.colours, {label, factor} = LOOK.fields[player.field];
  byId("bar").style.background = `linear-gradient(to right, ${colours.join(",")})`;
  byId("low").textContent = digits(low / factor);
  byId("middle").textContent = label;
  byId("high").textContent = digits(high / factor);
}

function isRock(player) {
  return player.field === "material" && LOOK.rocks.length > 0;
}

function drawLegend(player) {
  const entries = isRock(player) ? LOOK.rocks.map(({name, colour}) => [name, colour, 10]) : [];
  if (player.joints) for (const [name, {colour, width, dash}] of Object.entries(LOOK.states)) entries.push([name, colour, width, dash.length]);
  if (player.joints === "forces") entries.push(["force of contact", LOOK.force.colour, LOOK.force.width]);
  if (player.crosses) for (const name of ["compression", "tension"]) entries.push([name, LOOK[name].colour, LOOK[name].width]);
  const kinds = new Set(player.scene.points.map(point => point.kind));
  if (player.points) for (const {kind, name, colour} of LOOK.points) if (kinds.has(kind)) entries.push([name, colour, 6]);
  const states = new Set(player.scene.bolts.flatMap(bolts => bolts.state));
  LOOK.bolts.forEach(({name, colour, dash}, k) => { if (states.has(k)) entries.push([name, colour, 2, dash.length]); });
  if (player.scene.tips.some(tips => tips.length)) entries.push([`crack tip, K ${LOOK.tip.label}`, LOOK.tip.colour, 6]);
  byId("legend").replaceChildren(...entries.map(words => entry(...words)));
}

begin().then(() => { document.documentElement.dataset.state = "ready"; }, problem => {
  byId("time").textContent = `This browser cannot draw the frames: ${problem.message}`;
  document.documentElement.dataset.state = "failed";
});
