// Follows the server's stream of moments (emg2vsa/live/snapshot.py) and shows them; sends the stop.
import { draw, lastSeconds, ticksBetween } from "./plot.js";
import { frameToAsk, healthOf, kappaAxisOf, kappaOf, messageOf, newestBarOf, pressesOf, stopStateOf } from "./state.js";

const WINDOW_S = 15;
const TOKEN = location.pathname.split("/")[1];
const PHASES = {
  home: "Going home", approach: "Approach", contact: "Contact", load: "Loading", retract: "Retract", pause: "Pause",
  done: "Done", escape: "Taking away",
};
const $ = (selector) => document.querySelector(selector);
const seconds = () => performance.now() / 1000;

let now = null;
let heardS = seconds();
let curves = null;
let frameShown = "";
let stop = { askedS: null, failure: "" };

const source = new EventSource("stream");
source.onopen = () => { curves = null; };
source.onmessage = (event) => {
  const before = now;
  now = JSON.parse(event.data);
  heardS = seconds();
  if (now.run?.name !== before?.run?.name) {
    curves = null;
    stop = { askedS: null, failure: "" };
    $("#frame").hidden = true;
  }
  if (now.stop_requested) stop.askedS ??= seconds(); // perhaps on another page
  if (now.anew) curves = null;
  append(now.curves);
  requestAnimationFrame(show);
};
setInterval(show, 250); // a silent stream has to be seen as well
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", show);
addEventListener("resize", show);

function append(fresh) {
  if (curves === null) { curves = fresh; return; }
  for (const [name, values] of Object.entries(fresh)) curves[name].push(...values);
  const time = curves.time_s, first = time.findIndex((t) => t >= time[time.length - 1] - WINDOW_S);
  if (first > 0) for (const values of Object.values(curves)) values.splice(0, first);
}

function show() {
  const moment = { now, silentS: seconds() - heardS };
  const message = messageOf(moment);
  $("#message").hidden = message === null;
  document.body.classList.toggle("dim", message?.stale ?? false);
  document.body.classList.toggle("over", Boolean(now?.ended)); // the last values are not the present ones
  if (message) {
    $("#message").className = message.kind;
    write("#title", message.title);
    write("#text", message.text);
  }
  showStop(stopStateOf(moment, stop, seconds()));
  if (now) showRun(now);
}

function showRun({ run, phase, repetition, frame, ended, presses_done: done, ...rest }) {
  write("#name", run?.name ?? "Rig");
  write("#facts", run ? factsOf(run) : "\u00a0");
  write("#phase", run && !ended ? PHASES[phase] ?? phase : "");
  write("#count", run ? `Press ${Math.max(repetition, 1)} of ${run.repetitions}` : "");
  document.title = run ? `${run.name}: ${ended ? ended.title : phase}` : "Rig";
  write("#health", run ? healthOf(rest) : "");
  showPresses(run?.repetitions ?? 0, done, Boolean(repetition > done && !ended));
  $("#curves").hidden = $("#camera").hidden = !run;
  if (run && curves) showCurves(run);
  $("#kappa").hidden = !(run && rest.kappa);
  if (run && rest.kappa) showKappa(run, rest.kappa);
  showFrame(run, frame);
}

function factsOf(run) {
  const emulated = !run.emulated ? "" : run.over_bytes ? " · emulated, no hardware" : " · emulated, not over bytes";
  return `${run.specimen} at ${run.angle_deg}° · ${run.condition} · to ${run.f_max_n} N${emulated}`;
}

function showPresses(repetitions, done, pressing) {
  const bar = $("#presses"), parts = pressesOf(repetitions, done, pressing);
  while (bar.children.length < parts.length) bar.append(document.createElement("i"));
  while (bar.children.length > parts.length) bar.lastChild.remove();
  parts.forEach((kind, i) => { bar.children[i].className = kind; });
}

function stiffnessAt(run, percent) {
  const table = run.stiffness_nm_per_rad, at = Math.max(0, Math.min(table.length - 1, percent)), before = Math.floor(at);
  const after = Math.min(before + 1, table.length - 1);
  return table[before] + (at - before) * (table[after] - table[before]);
}

function showCurves(run) {
  const top = run.full_preset;
  const percent = (preset) => (preset === null ? null : (100 * preset) / top);
  const finite = [...curves.raw_n, ...curves.filtered_n].filter((v) => v !== null);
  const low = Math.min(-0.3, ...finite.map((v) => v - 0.2)), high = Math.max(1.2 * run.f_max_n, ...finite.map((v) => 1.05 * v));
  const levels = [{ at: run.f_contact_n, text: `contact ${run.f_contact_n} N` }, { at: run.f_max_n, text: `F max ${run.f_max_n} N` }];
  if (run.force_limit_n < high) levels.push({ at: run.force_limit_n, text: `limit ${run.force_limit_n} N` });
  plot("#force", { low, high, levels }, [[curves.raw_n, "--raw", 1.5], [curves.filtered_n, "--blue", 3]]);
  read("#force", last(curves.filtered_n), last(curves.raw_n), (v) => `${fixed(v, 2)} N`);

  const rigid = run.condition === "high-stiffness";
  $("#stiffness").hidden = rigid;
  if (!rigid) {
    const preset = curves.preset.map(percent), measured = curves.measured_preset.map(percent);
    plot("#stiffness", { low: 0, high: 100, band: run.stiffness_percent }, [[measured, "--blue", 3], [preset, "--ink", 2, [6, 4]]]);
    read("#stiffness", last(measured) ?? last(preset), last(preset), (v) => `${fixed(v, 1)} % (${fixed(stiffnessAt(run, v), 2)} N·m/rad)`);
  }
  const depthsMm = [...curves.depth_mm, ...curves.shaft_mm].filter((v) => v !== null);
  plot("#depth", { low: Math.min(0, ...depthsMm), high: 1.08 * Math.max(run.travel_mm / 2, ...depthsMm) },
    [[curves.shaft_mm, "--blue", 3], [curves.depth_mm, "--ink", 2, [6, 4]]]);
  read("#depth", last(curves.shaft_mm), last(curves.depth_mm), (v) => `${fixed(v, 2)} mm`);
}

function showKappa(run, kappa) {
  const { big, interval, judged } = kappaOf(kappa);
  write("#kappa .big", big);
  write("#kappa .key b", interval);
  write("#judged", judged);
  $("#judged").className = kappa.stop ? "stopped" : "";
  const canvas = $("#kappa canvas"), { high, tops, axis } = kappaAxisOf(kappa, run.f_max_n);
  draw(canvas, {
    over: kappa.force_n, axis, low: 0, high, ticks: ticksBetween(0, high, Math.max(2, canvas.clientHeight / 45)),
    marks: kappa.stop ? [{ at: kappa.stop_n, text: "seen enough" }] : [],
    areas: [{ low: kappa.low_n_per_mm, high: tops, colour: "--band" }],
    curves: [{ values: kappa.kappa_n_per_mm, colour: "--blue", width: 3 }],
    bars: newestBarOf(kappa, tops),
  });
}

function plot(where, axis, lines) {
  const canvas = $(`${where} canvas`);
  const ticks = ticksBetween(axis.low, axis.high, Math.max(2, canvas.clientHeight / 45));
  draw(canvas, {
    ...axis, ticks, over: curves.time_s,
    axis: lastSeconds(curves.time_s, WINDOW_S, document.body.matches(".dim, .over") ? "last" : "now"),
    curves: lines.map(([values, colour, width, dash]) => ({ values, colour, width, dash })),
  });
}

function read(where, main, beside, text) {
  write(`${where} .big`, main === null ? "–" : text(main).replace(/ \(.*/, ""));
  write(`${where} .key b`, beside === null ? "–" : text(beside));
}

function fixed(value, digits) {
  return value.toFixed(digits).replace(/^-(?=0\.0*$)/, "").replace("-", "\u2212");
}

function last(values) {
  for (let i = values.length - 1; i >= Math.max(0, values.length - 20); i--) if (values[i] !== null) return values[i];
  return null;
}

function showFrame(run, frame) {
  const image = $("#frame"), asked = frameToAsk(run, frame, frameShown);
  image.classList.toggle("old", frame === ""); // frames are kept while loading only
  if (asked === "" || !image.complete) return;
  frameShown = asked;
  image.src = `frame?${asked}`;
}

$("#frame").addEventListener("load", (event) => { event.target.hidden = false; });
$("#frame").addEventListener("error", (event) => { event.target.hidden = true; }); // there is none yet

function showStop({ kind, title, hint, enabled }) {
  const button = $("#stop");
  button.disabled = !enabled;
  button.className = kind;
  write("#stop b", title);
  write("#hint", hint);
}

async function askToStop() {
  if ($("#stop").disabled) return;
  stop = { askedS: stop.askedS ?? seconds(), failure: "" };
  show();
  try {
    const answer = await fetch("stop", {
      method: "POST", headers: { "x-emg2vsa-token": TOKEN }, signal: AbortSignal.timeout(2000),
    });
    if (!answer.ok) stop = { askedS: null, failure: `Refused: ${await answer.text()}` };
  } catch {
    stop = { askedS: null, failure: "No connection" };
  }
  show();
}

$("#stop").addEventListener("click", askToStop);
addEventListener("keydown", (event) => {
  if (event.key !== " ") return;
  event.preventDefault(); // neither scroll nor click
  askToStop();
});

function write(selector, text) {
  const element = $(selector);
  if (element.textContent !== text) element.textContent = text;
}
