// What the operator's page makes of the state of the session. No page in here, only values.

const LOST_S = 2; // something comes at least twice a second
const MARKS = { ok: "✓", warned: "!", rejected: "✕" };
const VERDICTS = { ok: "Good", warned: "Usable, with a remark", rejected: "Not usable" };
const DECISIONS = { repeat: "to be repeated", accept: "accepted", skip: "left out", "": "" };
const PRIMARY = {
  "measure-rest": "Measure rest", "measure-contraction": "Measure contraction", placed: "Specimen is placed",
  start: "START", accept: "Accept press", repeat: "Repeat press", end: "End session", continue: "Go on",
};

// What the large button, Space and a presenter's forward key do now: {name, item, label}; name is "" for nothing.
export function primaryOf(state) {
  const { awaits, commands, checklist, press } = state;
  const item = Object.keys(checklist).find((one) => !checklist[one]) ?? "";
  const wanted = {
    quality: ["measure-rest"], contraction: ["measure-contraction"], checklist: item ? ["check"] : [], specimen: ["placed"],
    start: ["start"], verdict: press?.verdict === "rejected" ? ["repeat", "skip"] : ["accept"], end: ["end"],
  }[awaits] ?? [];
  const name = [...wanted, ...(state.command === "pause" ? ["continue"] : [])].find((one) => commands.includes(one)) ?? "";
  const label = name === "check" ? `Tick: ${item}` : name === "" ? waitingFor(state) : PRIMARY[name] ?? name;
  return { name, item: name === "check" ? item : "", label };
}

function waitingFor({ command, ended }) {
  if (ended) return "Session is over";
  return { start: "START is shown", press: "Pressing", stop: "STOP is shown" }[command] ?? "Please wait";
}

// What a key asks for: {name, press, item}, {name: "note"}, or null. shown: the press that decisions are about.
export function askedBy(key, state, shown) {
  const press = shown?.number ?? null;
  const { name, item } = primaryOf(state);
  const asked = {
    " ": { name, item, press: DECISIONS[name] ? press : null }, PageUp: { name: "repeat", press }, Escape: { name: "abort", press: null },
    a: { name: "accept", press }, r: { name: "repeat", press }, s: { name: "skip", press }, n: { name: "note", press },
    p: { name: state.commands.includes("continue") ? "continue" : "pause", press: null }, e: { name: "end", press: null },
  };
  const same = { PageDown: " ", ".": "p", b: "p" };
  const wanted = asked[same[key] ?? key] ?? checkedBy(key, state);
  return wanted && state.commands.includes(wanted.name) ? { item: "", ...wanted } : null;
}

function checkedBy(key, { checklist }) {
  const item = Object.keys(checklist)[Number(key) - 1];
  return item === undefined ? null : { name: "check", press: null, item };
}

// {kind, text} or null
export function messageOf(state, silentS, refused) {
  if (silentS > LOST_S) return { kind: "danger", stale: true, text: "No connection. If the session was started again, open its new address." };
  if (state === null) return { kind: "wait", stale: false, text: "Connecting." };
  const lost = state.devices.filter((device) => device.state === "lost").map((device) => device.text);
  if (lost.length) return { kind: "danger", stale: false, text: lost.join("\n") };
  if (refused) return { kind: "warn", stale: false, text: refused };
  if (state.ended) return { kind: "good", stale: false, text: state.ended };
  return state.warnings.length ? { kind: "warn", stale: false, text: state.warnings.join("\n") } : null;
}

// The press that the verdict shows and decisions are about: the chosen one, else the last that was judged.
export function shownPress({ presses, press }, chosen) {
  const judged = presses.filter((one) => one.verdict !== "");
  return judged.find((one) => one.number === chosen) ?? (press?.verdict ? press : judged.at(-1)) ?? null;
}

// {mark, text, kind}
export function verdictOf({ verdict, decision, attempt }) {
  const also = [DECISIONS[decision], attempt > 1 ? `attempt ${attempt}` : ""].filter(Boolean).join(", ");
  return { kind: verdict, mark: MARKS[verdict] ?? "", text: `${VERDICTS[verdict] ?? ""}${also ? ` (${also})` : ""}` };
}

// Specimens after the present one, in their order, without what lies on the table now.
export function upcoming({ presses, specimen }) {
  const names = presses.filter((one) => one.verdict === "" && one.decision === "").map((one) => one.specimen);
  return names.filter((name, i) => name !== (i ? names[i - 1] : specimen)).slice(0, 6);
}

// Kinds of the cells of the bar, one a press: {kind, first}; first: of its specimen.
export function cellsOf({ presses, press, phase }) {
  const some = presses.filter((one) => one.phase === phase);
  return some.map((one, i) => ({
    kind: one.verdict || (press?.number === one.number ? "now" : ""), first: i > 0 && one.specimen !== some[i - 1].specimen,
  }));
}

export function countOf(state) {
  if (state.phase === "quality") return "Signal quality";
  const some = state.presses.filter((one) => one.phase === state.phase && one.decision !== "repeat");
  const done = some.filter((one) => one.verdict !== "").length;
  return `${state.phase === "training" ? "Training: " : ""}${done} of ${some.length} presses`;
}

export function microvolts(volts) {
  if (volts === null || volts === undefined) return "–";
  const uv = 1e6 * volts;
  return `${uv.toFixed(Math.abs(uv) < 10 ? 1 : 0)} µV`;
}

// Shares of the width, from 0 to the largest upper end of all.
export function intervalOf({ low_v: low, high_v: high, b_v: b }, fits) {
  const bottom = Math.min(0, ...fits.map((fit) => fit.low_v)), top = Math.max(1e-9, ...fits.map((fit) => fit.high_v));
  const at = (v) => (v - bottom) / (top - bottom);
  return { from: at(low), to: at(high), middle: at(b) };
}
