// Follows the session's stream (emg2vsa/session/views.py) and sends what the operator asks for.
import { draw, lastSeconds, ticksBetween } from "./plot.js";
import {
  askedBy, cellsOf, countOf, intervalOf, messageOf, microvolts, nameOf, primaryOf, shownPress, upcoming, verdictOf,
} from "./state.js";

const WINDOW_S = 10;
const TOO_SOON_MS = 400; // a presenter's key that bounces must not do the next thing as well
const REFUSED_MS = 6000, NEWS_MS = 12000;
const DEVICE_MARKS = { good: "✓", doubtful: "!", lost: "✕" };
const TOKEN = location.pathname.split("/")[1];
const $ = (selector) => document.querySelector(selector);

let state = null, seen = null, traces = null, chosen = null;
let heardMs = performance.now(), askedMs = -1e9, refusedMs = -1e9, refused = "";
let warned = [], news = "", newsMs = -1e9;

function listen() {
  const source = new EventSource("stream");
  source.onopen = () => { traces = null; };
  const on = (name, take) => source.addEventListener(name, (event) => {
    heardMs = performance.now();
    take(JSON.parse(event.data));
    requestAnimationFrame(show);
  });
  on("state", (content) => {
    state = content;
    const fresh = state.warnings.filter((text) => !warned.includes(text));
    if (fresh.length) [news, newsMs] = [fresh.at(-1), performance.now()];
    warned = state.warnings;
  });
  on("participant", (content) => { seen = content; });
  on("traces", append);
  on("alive", () => {});
  source.onerror = () => {
    if (source.readyState === EventSource.CLOSED) setTimeout(listen, 1000);
  };
}

function append(fresh) {
  const last = traces?.time_s.at(-1) ?? -Infinity, from = fresh.time_s.findIndex((t) => t > last);
  if (from < 0) return;
  const every = (each) => ({
    time_s: each("time_s", fresh.time_s), force_n: each("force_n", fresh.force_n),
    ...Object.fromEntries(["envelopes_v", "low_v", "high_v"].map((name) => [
      name, Object.fromEntries(Object.entries(fresh[name]).map(([muscle, values]) => [muscle, each(name, values, muscle)])),
    ])),
  });
  const old = (name, muscle) => (muscle ? traces?.[name][muscle] : traces?.[name]) ?? [];
  const end = fresh.time_s.at(-1), first = Math.max(0, old("time_s").findIndex((t) => t >= end - WINDOW_S));
  traces = every((name, values, muscle) => [...old(name, muscle).slice(first), ...values.slice(from)]);
}

let due = false;
function show() {
  if (due) return;
  due = true;
  queueMicrotask(() => { due = false; render(); });
}

function render() {
  const nowMs = performance.now();
  if (nowMs - refusedMs > REFUSED_MS) refused = "";
  const told = nowMs - newsMs < NEWS_MS && warned.includes(news) ? news : "";
  const message = messageOf(state, (nowMs - heardMs) / 1000, refused, told);
  $("#message").hidden = message === null;
  document.body.classList.toggle("stale", message?.stale ?? false);
  if (message) {
    $("#message").className = message.kind;
    write("#message", message.text);
  }
  if (state !== null) showState();
  if (traces !== null) showTraces();
}

let shownState = null, shownChosen = null, shownSeen = null;
function showState() {
  if (shownState === state && shownChosen === chosen && shownSeen === seen) return;
  [shownState, shownChosen, shownSeen] = [state, chosen, seen];
  const { participant, study, specimen, awaits, commands, saved } = state;
  document.title = `${participant}: ${state.message || state.command}`;
  write("#who", participant);
  write("#study", study);
  write("#saved", saved.slice(saved.indexOf(": ") + 1).trim() || "\u00a0"); // without the folder, which the end tells
  $("#saved").title = saved;
  write("#count", countOf(state));
  const placed = measuring() ? "" : specimen;
  write("#label", awaits === "specimen" ? "Place this specimen" : placed ? "On the sensor" : "");
  write("#specimen", placed);
  $("#specimen").classList.toggle("long", specimen.length > 6);
  $("#now").classList.toggle("place", awaits === "specimen");
  const next = upcoming(state);
  write("#then", next.length && placed ? `then ${next.join(", ")}` : "");
  write("#said", state.message);
  const primary = primaryOf(state);
  $("#primary").disabled = primary.name === "";
  $("#primary").classList.toggle("early", primary.name !== "" && !primary.ready);
  $("#primary").classList.toggle("go", primary.name === "start");
  write("#primary b", primary.label);
  for (const button of document.querySelectorAll("[data-ask]")) button.disabled = !commands.includes(button.dataset.ask);
  $('[data-ask="continue"]').hidden = !commands.includes("continue");
  $('[data-ask="continue"]').firstChild.data = measuring() ? "Go on without " : "Go on ";
  showMirror();
  showProgress();
  showChecks();
  showDevices();
  showSignals();
  showFits();
  showWarnings();
  showVerdict();
  showList();
}

const measuring = () => ["quality", "contraction"].includes(state.awaits); // no specimen yet

function showMirror() {
  $("#mirror").replaceChildren(...(seen ? ["The participant reads: ", node("b", seen.text)] : []));
}

function showProgress() {
  const cells = cellsOf(state);
  $("#progress").replaceChildren(...cells.map(({ kind, first }) => node("i", "", `${kind}${first ? " first" : ""}`)));
  $("#progress").setAttribute("aria-label", countOf(state));
}

function showChecks() {
  const items = Object.entries(state.checklist);
  $("#checks").hidden = items.length === 0 || measuring() || state.ended !== "";
  $("#checks").classList.toggle("done", items.every(([, done]) => done));
  fill("#checks ol", items.map(([item, done], i) => {
    const box = Object.assign(document.createElement("input"), { type: "checkbox", checked: done });
    box.disabled = !state.commands.includes("check");
    box.addEventListener("click", (event) => { event.preventDefault(); ask({ name: "check", item }); });
    const label = node("label");
    label.append(box, item, ...(i < 9 ? [node("kbd", String(i + 1))] : []));
    return wrap("li", label);
  }));
}

function showDevices() {
  const { devices } = state;
  $("#chips").replaceChildren(...devices.map((device) => {
    const chip = node("li", `${DEVICE_MARKS[device.state]} ${device.name}`, device.state);
    chip.title = device.text;
    return chip;
  }));
  $("#devices").hidden = devices.length === 0;
  fill("#devices tbody", devices.map((device) => row(
    device.name, [`${DEVICE_MARKS[device.state]} ${device.text}`, device.state],
    device.measured_hz === null ? `${device.fs_hz} Hz` : `${device.measured_hz.toFixed(2)} of ${+device.fs_hz.toFixed(3)} Hz`,
    device.clock_se_s === null ? "–" : `± ${(1000 * device.clock_se_s).toFixed(2)} ms`, `${device.lost} of ${device.samples}`,
  )));
}

function showSignals() {
  const { signals } = state;
  const doubtful = signals.some((signal) => signal.problems.length);
  $("#signals").hidden = !(state.phase === "quality" || doubtful || state.commands.includes("measure-rest"));
  fill("#signals tbody", signals.map((signal) => row(
    signal.muscle, microvolts(signal.rest_v), microvolts(signal.contraction_v),
    signal.snr_db === null ? "–" : `${signal.snr_db.toFixed(0)} dB`,
    signal.problems.length ? [signal.problems.map(([found, remedy]) => `${found}: ${remedy}`).join("; "), "warned"] : "",
  )));
}

function showFits() {
  const { fits } = state;
  $("#fits").hidden = fits.length === 0;
  fill("#fits tbody", fits.map((fit) => {
    const { from, to, middle } = intervalOf(fit, fits), span = node("div", "", "interval");
    span.append(node("i"), node("i"));
    Object.assign(span.children[0].style, { left: `${100 * from}%`, width: `${100 * (to - from)}%` });
    span.children[1].style.left = `${100 * middle}%`;
    const text = [fit.b_v, fit.low_v, fit.high_v].map((v) => (1e6 * v).toFixed(1));
    const line = row(fit.specimen, fit.presses, `${text[0]} (${text[1]} to ${text[2]})`, "");
    line.lastChild.append(span, fit.suggestion);
    return line;
  }));
}

function showWarnings() {
  $("#warnings").hidden = state.warnings.length === 0;
  fill("#warnings ul", state.warnings.toReversed().map((text) => node("li", text)));
}

function showVerdict() {
  const press = shownPress(state, chosen);
  $("#verdict").hidden = press === null;
  if (press === null) return;
  const { kind, mark, text } = verdictOf(press);
  write("#verdict h2", `Press ${nameOf(press)} · ${press.specimen}`);
  $("#judged").className = kind;
  write("#judged", `${mark} ${text}`);
  for (const button of document.querySelectorAll("#verdict [data-ask]")) button.disabled ||= !press.last;
  fill("#problems", [
    ...press.problems.map(([found, remedy]) => {
      const item = node("li");
      item.append(node("b", sentence(found)), remedy ? `→ ${sentence(remedy)}` : "");
      return item;
    }),
    ...(press.note ? [node("li", `Note: ${press.note}`)] : []),
  ]);
}

function showList() {
  const done = state.presses.filter((one) => one.verdict !== "").reverse(), about = shownPress(state, chosen);
  $("#list").hidden = done.length === 0;
  fill("#list tbody", done.flatMap((press) => {
    const name = nameOf(press), { kind, mark } = verdictOf(press), pick = node("button", name.replace(", attempt ", "."));
    const here = about !== null && nameOf(about) === name;
    pick.type = "button";
    pick.setAttribute("aria-label", `Show press ${pick.textContent}`);
    pick.addEventListener("click", () => { chosen = name; show(); });
    const said = press.decision ? `, ${press.decision}` : "";
    const line = row("", press.specimen, [`${mark} ${press.verdict}${said}`, kind], number(press.peak_n, 2, "N"), number(press.load_s, 2, "s"));
    line.firstChild.append(pick);
    line.classList.toggle("chosen", here);
    const remark = [...press.problems.map(([found]) => found), press.note].filter(Boolean).join("; ");
    if (!remark) return [line];
    line.classList.add("has-remark");
    const cell = node("td", remark);
    cell.colSpan = 5;
    const below = wrap("tr", cell);
    below.className = `remark${here ? " chosen" : ""}`;
    return [line, below];
  }));
}

function showTraces() {
  const muscles = Object.keys(traces.envelopes_v), section = $("#traces");
  if (section.children.length !== muscles.length + 1) {
    section.replaceChildren(figure("Force", ["filtered, N"]), ...muscles.map((muscle) => figure(muscle, ["envelope, µV", "raw"])));
  }
  const [lower, upper] = seen?.force_n ?? [0, 7];
  const top = Math.max(1.4 * upper, ...traces.force_n.map((v) => 1.05 * v)), bottom = Math.min(-0.3, ...traces.force_n);
  plot(section.children[0], bottom, top, [[traces.force_n, 3]], [], [{ at: lower, text: `${lower} N` }, { at: upper, text: `${upper} N` }]);
  section.children[0].querySelector("output").textContent = number(traces.force_n.at(-1) ?? null, 2, "N");
  muscles.forEach((muscle, i) => {
    const scaled = (values) => values.map((v) => (v === null ? null : 1e6 * v));
    const [low, high, level] = [traces.low_v, traces.high_v, traces.envelopes_v].map((one) => scaled(one[muscle]));
    const most = Math.max(25, ...high.map((v) => 1.1 * v), ...low.map((v) => -1.1 * v), ...level.map((v) => 1.1 * v));
    plot(section.children[i + 1], -most, most, [[level, 3]], [{ low, high, colour: "--raw" }], []);
    section.children[i + 1].querySelector("output").textContent = microvolts(traces.envelopes_v[muscle].at(-1));
  });
}

function figure(name, keys) {
  const made = document.createElement("figure"), caption = document.createElement("figcaption"), canvas = document.createElement("canvas");
  caption.append(node("h2", name), document.createElement("output"), ...keys.map((key) => node("span", key, `key ${key === "raw" ? key : ""}`)));
  canvas.setAttribute("role", "img");
  canvas.setAttribute("aria-label", `${name} over time`);
  made.append(caption, canvas);
  return made;
}

function plot(where, low, high, lines, areas, levels) {
  const canvas = where.querySelector("canvas");
  draw(canvas, {
    low, high, levels, areas, over: traces.time_s,
    axis: lastSeconds(traces.time_s, WINDOW_S, state?.ended || document.body.matches(".stale") ? "last" : "now"),
    ticks: ticksBetween(low, high, Math.max(4, canvas.clientHeight / 35)),
    curves: lines.map(([values, width]) => ({ values, colour: "--blue", width })),
  });
}

async function ask(request, pressedMs = performance.now()) {
  if (request.name === "note" && request.text === undefined) { openNote(); return; }
  if (request.name === "end" && state.awaits !== "end" && !request.sure) { openSure(); return; }
  askedMs = pressedMs;
  const { name, press = null, item = "", text = "" } = request;
  try {
    const answer = await fetch("request", {
      method: "POST", headers: { "x-emg2vsa-token": TOKEN, "content-type": "application/json" },
      body: JSON.stringify({ name, press, item, text }), signal: AbortSignal.timeout(3000),
    });
    refuse(answer.ok ? "" : sentence(await answer.text()));
  } catch {
    refuse("The request did not get through: no connection.");
  }
  if (["accept", "repeat", "skip", "start"].includes(name)) chosen = null;
  show();
}

function refuse(text) {
  refused = text;
  if (text) refusedMs = performance.now();
}

function press(key) {
  const request = state && askedBy(key, state, shownPress(state, chosen));
  const nowMs = performance.now();
  if (!request || (request.name !== "abort" && nowMs - askedMs < TOO_SOON_MS)) return false;
  ask(request, nowMs);
  return true;
}

function openNote() {
  const about = shownPress(state, chosen);
  if (!about?.last) return;
  $("#note").hidden = false;
  $("#note").dataset.press = about.number;
  $("#note input").value = "";
  $("#note input").focus();
}

function openSure() {
  write("#sure-text", `End the session now? ${countOf(state)} are done. It can be resumed later.`);
  $("#sure").showModal();
}

addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "Escape" && !$("#note").hidden) { $("#note").hidden = true; return; }
  if (event.target.matches("input:not([type=checkbox])") || $("#sure").open) return;
  if (event.key === "F5") { event.preventDefault(); return; } // a presenter's key; Ctrl+R loads the page again
  // a button reached by Tab keeps Space for itself
  if ((event.key === " " || event.key === "Enter") && event.target.matches("button, input")) return;
  if ([" ", "PageDown", "PageUp"].includes(event.key)) event.preventDefault();
  // what opens the note must not be its first letter
  if (!event.repeat && press(event.key.length === 1 ? event.key.toLowerCase() : event.key)) event.preventDefault();
});
addEventListener("click", (event) => {
  const button = event.target.closest("button");
  if (!button) return;
  if (event.detail > 0) button.blur(); // clicked with the mouse: Space is free again
  if (button.id === "primary") press(" ");
  if (button.dataset.ask) {
    const about = ["accept", "repeat", "skip"].includes(button.dataset.ask) ? shownPress(state, chosen)?.number ?? null : null;
    ask({ name: button.dataset.ask, press: about });
  }
  if (button.id === "yes") ask({ name: "end", sure: true });
  if (button.id === "yes" || button.id === "no") $("#sure").close();
});
$("#note").addEventListener("submit", (event) => {
  event.preventDefault();
  ask({ name: "note", press: Number(event.target.dataset.press), text: $("#note input").value });
  $("#note").hidden = true;
  document.activeElement.blur();
});
// keys that reach the participant's window while it has the focus
new BroadcastChannel("emg2vsa-session-keys").onmessage = (event) => press(event.data);

function node(tag, text = "", kind = "") {
  const made = document.createElement(tag);
  if (text) made.textContent = text;
  if (kind.trim()) made.className = kind.trim();
  return made;
}

function wrap(tag, child) {
  const made = document.createElement(tag);
  made.append(child);
  return made;
}

// a cell is a text, or a text and its class
function row(...cells) {
  const made = document.createElement("tr");
  made.append(...cells.map((cell) => (Array.isArray(cell) ? node("td", ...cell) : node("td", String(cell)))));
  return made;
}

function fill(where, children) {
  $(where).replaceChildren(...children);
}

function number(value, digits, unit) {
  return value === null ? "–" : `${value.toFixed(digits).replace(/^-(?=0\.0*$)/, "").replace("-", "\u2212")} ${unit}`;
}

function sentence(text) {
  const trimmed = text.trim();
  return trimmed && trimmed[0].toUpperCase() + trimmed.slice(1).replace(/\.?$/, ".");
}

function write(selector, text) {
  const element = $(selector);
  if (element.textContent !== text) element.textContent = text;
}

listen();
setInterval(show, 250); // a silent stream has to be seen as well
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
addEventListener("resize", show);
