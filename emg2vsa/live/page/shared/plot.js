// Curves over the last seconds, or over another quantity, on a canvas. A curve is {values, colour, width, dash}; a
// level, or a mark on the axis, is {at, text}; a bar is {at, value, low, high, colour}; an area is {low, high, colour};
// an axis from left to right is {from, to, labels: [{at, text, align}]}.

const FONT = '15px system-ui, "Segoe UI", "DejaVu Sans", Arial, sans-serif';
const LEFT = 46, RIGHT = 8, TOP = 8, BOTTOM = 22;

// The axis of the last windowS seconds.
export function lastSeconds(time, windowS, lastLabel) {
  const end = time.length ? time[time.length - 1] : 0, labels = [];
  for (let back = 0; back < windowS; back += 5) {
    labels.push({ at: end - back, text: back ? `−${back} s` : lastLabel, align: back ? "center" : "right" });
  }
  return { from: end - windowS, to: end, labels };
}

// over: where each value of a curve lies on the axis.
export function draw(canvas, { over, axis, low, high, ticks, levels = [], marks = [], bars = [], band = null, areas = [], curves }) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(name);
  const context = fitted(canvas);
  const width = canvas.clientWidth - LEFT - RIGHT, height = canvas.clientHeight - TOP - BOTTOM;
  const x = (at) => LEFT + (width * (at - axis.from)) / (axis.to - axis.from);
  const y = (v) => TOP + height * (1 - (v - low) / (high - low));

  context.font = FONT;
  if (band) {
    context.fillStyle = colour("--soft");
    context.fillRect(LEFT, y(band[1]), width, y(band[0]) - y(band[1]));
  }
  context.lineWidth = 1;
  context.strokeStyle = colour("--line");
  context.fillStyle = colour("--muted");
  context.textBaseline = "middle";
  context.textAlign = "right";
  for (const tick of ticks) {
    line(context, LEFT, y(tick), LEFT + width, y(tick));
    context.fillText(String(tick), LEFT - 7, y(tick));
  }
  context.textBaseline = "bottom";
  for (const { at, text, align } of axis.labels) {
    context.textAlign = align;
    context.fillText(text, x(at), canvas.clientHeight);
  }
  drawLevels(context, levels, y, width, colour);
  context.save();
  context.beginPath();
  context.rect(LEFT, 0, width, canvas.clientHeight - BOTTOM);
  context.clip();
  for (const one of areas) area(context, over, one, x, y, colour);
  for (const curve of curves) trace(context, over, curve, x, y, colour);
  for (const one of bars) bar(context, one, x, y, colour);
  context.restore();
  drawMarks(context, marks, x, height, colour);
}

export function ticksBetween(low, high, count) {
  const rough = (high - low) / count, ten = 10 ** Math.floor(Math.log10(rough));
  const step = ten * [1, 2, 5, 10].find((factor) => ten * factor >= rough);
  const ticks = [];
  for (let tick = Math.ceil(low / step) * step; tick <= high + step / 1e6; tick += step) ticks.push(Number(tick.toFixed(6)));
  return ticks;
}

function fitted(canvas) {
  const scale = window.devicePixelRatio || 1;
  const width = Math.round(canvas.clientWidth * scale), height = Math.round(canvas.clientHeight * scale);
  if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
  const context = canvas.getContext("2d");
  context.setTransform(scale, 0, 0, scale, 0, 0);
  context.clearRect(0, 0, canvas.clientWidth, canvas.clientHeight);
  return context;
}

function drawLevels(context, levels, y, width, colour) {
  context.strokeStyle = context.fillStyle = colour("--orange");
  context.textAlign = "left";
  for (const { at, text } of levels) {
    context.setLineDash([7, 5]);
    line(context, LEFT, y(at), LEFT + width, y(at));
    context.setLineDash([]);
    context.fillText(text, LEFT + 6, y(at) - 2);
  }
}

function drawMarks(context, marks, x, height, colour) {
  context.strokeStyle = context.fillStyle = colour("--orange");
  context.lineWidth = 1;
  context.textAlign = "left";
  context.textBaseline = "top";
  for (const { at, text } of marks) {
    context.setLineDash([7, 5]);
    line(context, x(at), TOP, x(at), TOP + height);
    context.setLineDash([]);
    context.fillText(text, x(at) + 5, TOP);
  }
}

function trace(context, over, { values, colour: name, width, dash = [] }, x, y, colour) {
  context.strokeStyle = colour(name);
  context.lineWidth = width;
  context.lineJoin = "round";
  context.setLineDash(dash);
  context.beginPath();
  let pen = false;
  for (let i = 0; i < over.length; i++) {
    if (values[i] === null) { pen = false; continue; }
    if (pen) context.lineTo(x(over[i]), y(values[i])); else context.moveTo(x(over[i]), y(values[i]));
    pen = true;
  }
  context.stroke();
  context.setLineDash([]);
}

function bar(context, { at, value, low, high, colour: name }, x, y, colour) {
  context.strokeStyle = context.fillStyle = colour(name);
  context.lineWidth = 2;
  line(context, x(at), y(low), x(at), y(high));
  for (const end of [low, high]) line(context, x(at) - 6, y(end), x(at) + 6, y(end));
  context.beginPath();
  context.arc(x(at), y(value), 5, 0, 2 * Math.PI);
  context.fill();
}

function area(context, over, { low, high, colour: name }, x, y, colour) {
  context.fillStyle = colour(name);
  context.beginPath();
  for (let i = 0; i < over.length; i++) context.lineTo(x(over[i]), y(high[i]));
  for (let i = over.length - 1; i >= 0; i--) context.lineTo(x(over[i]), y(low[i]));
  context.fill();
}

function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}
