// Draws the newest force on every frame, and tells the server once a second how well that went.
import { FRESH, commandAt, offsetOf, remembered, reportOf, sceneOf } from "./state.js";

const TOKEN = location.pathname.split("/")[1], PAGE = Math.random().toString(36).slice(2);
const PRESENTER_KEYS = [" ", "PageDown", "PageUp", "Escape", ".", "b", "F5"];
const TONES_HZ = { start: 880, stop: 440 };
const $ = (selector) => document.querySelector(selector);

let state = null, force = null, memory = FRESH;
let answers = [], offsetMs = null;
let frames = [], ages = [], messages = 0;
let given = null, drawn = null, commandMs = []; // when the command was given that is to be drawn, or has just been
let shown = {}, audio = null, lock = null;

function listen() {
  const source = new EventSource(`stream?page=${PAGE}`);
  source.addEventListener("state", (event) => {
    state = JSON.parse(event.data);
    document.documentElement.lang = state.language;
    document.documentElement.dataset.palette = state.palette;
    if (state.sound) audio ??= new AudioContext(); // it runs at once where the browser was started with sound allowed
    layMarks();
  });
  source.onmessage = (event) => {
    const before = force?.command;
    force = { ...JSON.parse(event.data), receivedMs: performance.now() };
    memory = remembered(memory, force, state);
    messages += 1;
    if (before !== undefined && before !== force.command) {
      tone(TONES_HZ[force.command]);
      if (offsetMs !== null && !document.hidden) given = commandAt(force, sentMs());
    }
  };
  source.onerror = () => {
    if (source.readyState === EventSource.CLOSED) setTimeout(listen, 1000);
  };
}

// when the newest message was sent, on this page's clock
const sentMs = () => (offsetMs === null ? force.receivedMs : Math.min(force.receivedMs, 1000 * force.sent_s + offsetMs));

// frameMs: when the frame began; what was drawn in the frame before has been presented by then
function draw(frameMs) {
  const nowMs = performance.now();
  if (drawn !== null) commandMs.push(Math.max(0, frameMs - drawn));
  [drawn, given] = [given, null];
  const ageMs = force === null ? 0 : Math.max(0, 1000 * force.age_s + nowMs - sentMs());
  show(sceneOf(state, force, memory, ageMs));
  frames.push(nowMs);
  if (force !== null && offsetMs !== null) ages.push(ageMs);
  requestAnimationFrame(draw);
}

function show({ look, word, hint, phase, pause, value, share, over, zone }) {
  change("look", look, () => { document.body.dataset.look = look; });
  change("word", word, () => {
    $("#word").textContent = word;
    fit();
  });
  change("hint", hint, () => { $("#hint").textContent = hint; });
  change("phase", phase, () => { $("#phase").textContent = phase; });
  change("pause", pause, () => { $("#pause").textContent = pause; });
  change("over", over, () => { $("#over").hidden = !over; });
  change("value", value.toFixed(2), () => $("#bar").setAttribute("aria-valuenow", value.toFixed(2)));
  change("share", share, () => { $("#fill").style.transform = `translateY(${100 * (1 - share)}%)`; });
  change("zone", zone?.join() ?? "", () => {
    $("#zone").hidden = zone === null;
    if (zone) Object.assign($("#zone").style, { bottom: `${100 * zone[0]}%`, height: `${100 * (zone[1] - zone[0])}%` });
  });
}

// whole words, as large as they fit beside the bar
function fit() {
  const heading = $("h1"), word = $("#word");
  heading.className = word.textContent.length > 14 ? "long" : "";
  for (let percent = 100; percent >= 40; percent -= 5) {
    heading.style.setProperty("--fit", percent / 100);
    if (word.scrollWidth <= word.clientWidth) return;
  }
}

function change(name, value, apply) {
  if (shown[name] === value) return;
  shown[name] = value;
  apply();
}

function layMarks() {
  const [lower, upper] = state.force_n, number = new Intl.NumberFormat(state.language);
  $("#bar").setAttribute("aria-valuemax", state.bar_n);
  for (const [name, at] of [["#lower", lower], ["#upper", upper]]) {
    $(name).style.top = `${100 * (1 - at / state.bar_n)}%`;
    $(`${name} span`).textContent = `${number.format(at)} N`;
  }
}

async function askClock() {
  const sentMs = performance.now();
  try {
    const { server_s: serverS } = await (await fetch("clock")).json();
    answers = [...answers.slice(-19), { sentMs, receivedMs: performance.now(), serverMs: 1000 * serverS }];
    offsetMs = offsetOf(answers);
  } catch {
    answers = []; // another server may answer next
  }
}

async function report() {
  const content = {
    ...reportOf(frames, ages, document.hidden, commandMs),
    more: {
      width: innerWidth, height: innerHeight, pixel_ratio: devicePixelRatio, messages,
      full_screen: document.fullscreenElement !== null,
    },
  };
  frames = frames.slice(-1);
  ages = [];
  commandMs = [];
  messages = 0;
  const headers = { "x-emg2vsa-token": TOKEN, "content-type": "application/json" };
  try {
    await fetch(`screen?page=${PAGE}`, { method: "POST", headers, body: JSON.stringify(content), keepalive: true });
  } catch {
    // the stream says that the connection is lost
  }
}

function tone(hz) {
  if (hz === undefined || audio?.state !== "running") return;
  const oscillator = audio.createOscillator(), volume = audio.createGain();
  oscillator.frequency.value = hz;
  volume.gain.value = 0.3;
  oscillator.connect(volume).connect(audio.destination);
  oscillator.start();
  oscillator.stop(audio.currentTime + 0.1);
}

// browsers allow a full screen and sound only after a click or a key on the page
async function fill() {
  audio?.resume();
  stayAwake();
  try {
    await document.documentElement.requestFullscreen();
    await navigator.keyboard?.lock?.(["Escape"]); // a presenter sends it; held down it still leaves the full screen
  } catch {
    // the page works in a window as well
  }
}

async function stayAwake() {
  try {
    if (document.visibilityState === "visible" && (lock === null || lock.released)) lock = await navigator.wakeLock?.request("screen") ?? null;
  } catch {
    lock = null; // refused to save power, or not a secure page
  }
}

$("#full").addEventListener("click", (event) => { event.target.blur(); fill(); });
addEventListener("resize", fit);
document.addEventListener("fullscreenchange", () => document.body.classList.toggle("full", document.fullscreenElement !== null));
if (matchMedia("(display-mode: fullscreen)").matches) document.body.classList.add("full");
document.addEventListener("visibilitychange", () => { stayAwake(); report(); });

// The participant commands nothing. Keys of a presenter go to the operator's page if that is open in this browser.
const channel = new BroadcastChannel("emg2vsa-session-keys");
addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  if (event.key === "f" && !event.repeat) fill();
  if (!PRESENTER_KEYS.includes(event.key)) return;
  event.preventDefault(); // F5 does not load the page again, Space presses no button
  if (!event.repeat) channel.postMessage(event.key);
});

document.body.classList.toggle("light", location.hash === "#light");
listen();
stayAwake();
for (let turn = 0; turn < 5; turn++) setTimeout(askClock, 60 * turn);
setInterval(() => { askClock(); report(); }, 1000);
requestAnimationFrame(draw);
