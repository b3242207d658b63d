const MARGIN = {left: 62, right: 10, top: 8, bottom: 24};

/** Makes a panel of histories in an element of the page: `draw` draws it in the size that the page gives it, so many pixels of the
 *  canvas a pixel of the page, `mark` moves the line that marks a frame. */
function makeChart(box, {title, steps, series}, clicked) {
  box.innerHTML = `<h3></h3><div class="plot"><canvas></canvas><div class="now"></div></div><p class="legend"></p>`;
  box.querySelector("h3").textContent = title;
  const canvas = box.querySelector("canvas"), now = box.querySelector(".now"), legend = box.querySelector(".legend");
  const pen = canvas.getContext("2d"), xs = ends([steps]), ys = ends(series.map(one => one.values)), inX = words(xs), inY = words(ys);
  let right = 0, bottom = 0, marked = xs[0];
  const toX = t => MARGIN.left + (t - xs[0]) / (xs[1] - xs[0]) * (right - MARGIN.left);
  const toY = value => bottom - (value - ys[0]) / (ys[1] - ys[0]) * (bottom - MARGIN.top);

  function draw(ratio) {
    const wide = canvas.clientWidth, tall = canvas.clientHeight;
    [right, bottom] = [wide - MARGIN.right, tall - MARGIN.bottom];
    [canvas.width, canvas.height] = [Math.round(wide * ratio), Math.round(tall * ratio)];
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.font = "11px system-ui, sans-serif";
    pen.lineWidth = 1;
    for (const value of ticks(ys)) {
      pen.strokeStyle = "#e4e4e4";
      line(pen, [[MARGIN.left, toY(value)], [right, toY(value)]]);
      pen.textAlign = "right";
      pen.fillText(inY(value), MARGIN.left - 6, toY(value) + 4);
    }
    for (const value of ticks(xs)) {
      pen.textAlign = "center";
      pen.fillText(inX(value), toX(value), tall - 6);
      pen.strokeStyle = "#e4e4e4";
      line(pen, [[toX(value), MARGIN.top], [toX(value), bottom]]);
    }
    series.forEach((one, i) => {
      pen.strokeStyle = LOOK.lines[i % LOOK.lines.length];
      pen.lineWidth = 1.4;
      line(pen, one.values.map((value, k) => [toX(steps[k]), toY(value)]));
    });
    mark(marked);
  }

  function mark(step) {
    marked = step;
    now.style.left = `${toX(step)}px`;
  }

  if (series.length > 1) series.forEach((one, i) => legend.append(entry(one.name, LOOK.lines[i % LOOK.lines.length], 2)));
  canvas.addEventListener("click", event => clicked(xs[0] + (event.offsetX - MARGIN.left) / (right - MARGIN.left) * (xs[1] - xs[0])));
  return {draw, mark};
}

/** Least and largest number of lists, apart in any case. */
function ends(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) for (const value of list) [low, high] = [Math.min(low, value), Math.max(high, value)];
  return high > low ? [low, high] : [low - (Math.abs(low) || 1) / 2, high + (Math.abs(low) || 1) / 2];
}

/** Round numbers between two. */
function ticks([low, high]) {
  const step = roundBelow((high - low) / 3), found = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + 1e-9 * step; i++) found.push(i * step);
  return found;
}

/** What says numbers between two with as many digits as tell them apart. */
function words([low, high]) {
  const largest = Math.max(Math.abs(low), Math.abs(high)), own = Math.floor(Math.log10(largest));
  const power = own >= 5 || own < -3 ? own : 0, apart = Math.max(0, power - Math.floor(Math.log10((high - low) / 3)));
  return value => (value / 10 ** power).toFixed(Math.min(apart, 12)) + (power && value ? `e${power}` : "");
}

function line(pen, places) {
  pen.beginPath();
  for (const [x, y] of places) pen.lineTo(x, y);
  pen.stroke();
}

/** An entry of a legend: a piece of a line and its name. */
function entry(name, colour, width, dashed = false) {
  const words = document.createElement("span"), piece = document.createElement("i");
  piece.style.borderTop = `${Math.max(2, width)}px ${dashed ? "dotted" : "solid"} ${colour}`;
  words.append(piece, name);
  return words;
}
