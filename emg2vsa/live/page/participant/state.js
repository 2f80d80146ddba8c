// What the participant sees, as plain values. No page in here.

const MOST_MS = 5000; // the session believes no more
export const LOST_MS = 200; // 40 messages; a frozen bar must not look like steady force
const DONE_WORDS = { wait: "wait", ready: "wait", start: "start", press: "press", stop: "stop", rest: "rest", pause: "pause", done: "done" };

export const FRESH = { colour: "plain", begunS: null };

// What one message of force leaves behind for the next: the colour, and when the force entered the range.
export function remembered(memory, force, state) {
  if (force.command !== "press" && force.command !== "start") return FRESH;
  const entered = state !== null && force.force_n >= state.force_n[0] ? force.time_s : null;
  const colours = { rising: "rise", falling: "fall", steady: memory.colour, none: "plain" };
  return { colour: colours[force.direction], begunS: memory.begunS ?? entered };
}

// {look, word, hint, phase, pause, value, share, over, zone}; share: of the bar's height; zone: two shares or null.
// ageMs: of the newest force.
export function sceneOf(state, force, memory, ageMs) {
  if (state === null || force === null || (ageMs > LOST_MS && force.command !== "done")) {
    const value = force === null ? 0 : Math.max(0, force.force_n);
    const share = state === null ? 0 : Math.min(1, value / state.bar_n);
    return { look: "lost", word: state?.texts.lost ?? "…", hint: "", phase: "", pause: "", value, share, over: false, zone: null };
  }
  const value = Math.max(0, force.force_n), nowS = force.time_s + ageMs / 1000;
  const look = lookOf(force.command, memory.colour);
  return {
    look, value, share: Math.min(1, value / state.bar_n), over: value > 1.005 * state.bar_n,
    word: force.command === state.command ? state.text : state.texts[DONE_WORDS[force.command]] ?? "",
    hint: hintOf(look, force, state.texts),
    phase: phaseOf(state),
    pause: force.command === "pause" && state.pause_until_s !== null ? clockOf(state.pause_until_s - nowS) : "",
    zone: force.command === "press" && memory.begunS !== null ? zoneOf(nowS - memory.begunS, state) : null,
  };
}

function lookOf(command, colour) {
  if (command === "press") return colour;
  return { start: "start", stop: "stop", wait: "wait", pause: "pause", done: "wait" }[command] ?? "plain";
}

function hintOf(look, force, texts) {
  if (force.command !== "press") return "";
  if (look === "fall") return texts.falling ?? "";
  return { "too fast": texts.too_fast, "too slow": texts.too_slow }[force.speed] ?? "";
}

function phaseOf({ phase, press, presses, texts }) {
  const count = press > 0 && presses > 0 ? `${press} / ${presses}` : "";
  return phase === "training" ? `${texts.training ?? ""}  ${count}`.trim() : phase === "main" ? count : "";
}

// Where the force should be so long after it entered the range: between the slowest and the fastest straight way up.
export function zoneOf(elapsedS, { force_n: [lower, upper], load_s: [shortest, longest], bar_n: top }) {
  const at = (durationS) => Math.min(upper, lower + ((upper - lower) * elapsedS) / durationS) / top;
  return [Math.min(1, at(longest)), Math.min(1, at(shortest))];
}

function clockOf(leftS) {
  const s = Math.max(0, Math.ceil(leftS));
  return `${Math.floor(s / 60)}:${String(s % 60).padStart(2, "0")}`;
}

// Milliseconds from the server's clock to this page's: by the answer that was the quickest of the last twenty.
export function offsetOf(answers) {
  const { sentMs, receivedMs, serverMs } = answers.reduce((a, b) => (b.receivedMs - b.sentMs < a.receivedMs - a.sentMs ? b : a));
  return (sentMs + receivedMs) / 2 - serverMs;
}

// When the command of a message was given, on this page's clock; sentMs: when the message was sent.
export const commandAt = ({ age_s: ageS, time_s: timeS, command_s: commandS }, sentMs) => sentMs - 1000 * (ageS + timeS - commandS);

// What the page says of itself. frames: when each was drawn; ages: of the force then; commands: delays; all in ms.
export function reportOf(frames, ages, hidden, commands) {
  const told = (ms) => Math.min(ms, MOST_MS);
  const gaps = frames.slice(1).map((at, i) => at - frames[i]), spanMs = frames.at(-1) - frames[0];
  const sorted = ages.toSorted((a, b) => a - b);
  const at = (share) => sorted[Math.min(sorted.length - 1, Math.floor(share * sorted.length))] ?? 0;
  return {
    frames_per_s: gaps.length ? (1000 * gaps.length) / spanMs : 0,
    age_p50_ms: told(at(0.5)), age_p95_ms: told(at(0.95)), longest_frame_ms: told(Math.max(0, ...gaps)), hidden,
    command_ms: commands.slice(-20).map(told),
  };
}
