// What the operator's page makes of the state of the session. No page in here, only values.

const LOST_S = 2; // something comes at least twice a second
const MARKS = { ok: "✓", warned: "!", rejected: "✕" };
const VERDICTS = { ok: "Good", warned: "Usable, with a remark", rejected: "Not usable" };
const DECISIONS = { repeat: "to be repeated", accept: "accepted", skip: "left out", "": "" };
const PRIMARY = {
  "measure-rest": "Measure rest", "measure-contraction": "Measure contraction", placed: "Specimen is placed",
  start: "START", skip: "Leave press out", repeat: "Repeat press", end: "End session", continue: "Go on",
};

// What the large button, Space and a presenter's forward key do now: {name, item, label, ready}; name is "" for nothing.
// ready: the session would take it; asked for all the same, it says why not.
export function primaryOf(state) {
  const { awaits, commands, checklist } = state;
  const item = Object.keys(checklist).find((one) => !checklist[one]) ?? "";
  const wanted = {
    quality: "measure-rest", contraction: "measure-contraction", checklist: item && "check", specimen: "placed",
    start: "start", verdict: commands.includes("repeat") ? "repeat" : "skip", end: "end",
  }[awaits] ?? (paused(state) ? "continue" : "");
  const label = wanted === "check" ? `Tick: ${item}` : wanted === "" ? waitingFor(state) : PRIMARY[wanted];
  return { name: wanted, item: wanted === "check" ? item : "", label, ready: commands.includes(wanted) };
}

// "continue" alone is also there to leave something out
const paused = ({ commands }) => commands.includes("continue") && !commands.includes("pause");

function waitingFor({ command, ended }) {
  if (ended) return "Session is over";
  return { start: "START is shown", press: "Pressing", stop: "STOP is shown" }[command] ?? "Please wait";
}

// What a key asks for: {name, press, item}, or null. shown: the press that decisions are about.
export function askedBy(key, state, shown) {
  const press = shown?.number ?? null;
  const { name, item } = primaryOf(state);
  const plain = (name) => ({ name, press: null, item: "" }), about = (name) => ({ name, press, item: "" });
  const asked = {
    " ": { name, item, press: null }, PageUp: about("repeat"), Escape: plain("abort"), a: about("accept"), r: about("repeat"),
    s: about("skip"), n: about("note"), p: plain(paused(state) ? "continue" : "pause"), c: plain("continue"), e: plain("end"),
  };
  const same = { PageDown: " ", ".": "p", b: "p" };
  const wanted = asked[same[key] ?? key] ?? checkedBy(key, state);
  if (!wanted || wanted.name === "") return null;
  // some presenters send Escape now and then
  return wanted.name === "abort" && !state.commands.includes("abort") ? null : wanted;
}

function checkedBy(key, { checklist }) {
  const item = Object.keys(checklist)[Number(key) - 1];
  return item === undefined ? null : { name: "check", press: null, item };
}

// {kind, text, stale} or null. news: a warning that has just come.
export function messageOf(state, silentS, refused, news) {
  if (state?.ended) return { kind: "good", stale: false, text: `The session is over: ${state.ended}.\n${state.saved}` };
  if (silentS > LOST_S) return { kind: "danger", stale: true, text: "No connection. If the session was started again, open its new address." };
  if (state === null) return { kind: "wait", stale: false, text: "Connecting." };
  const lost = state.devices.filter((device) => device.state === "lost").map((device) => device.text);
  if (lost.length) return { kind: "danger", stale: false, text: lost.join("\n") };
  if (refused) return { kind: "warn", stale: false, text: refused };
  return news ? { kind: "warn", stale: false, text: news } : null;
}

export const nameOf = ({ number, attempt }) => (attempt > 1 ? `${number}, attempt ${attempt}` : String(number));

const last = (presses, number) => presses.findLast((one) => one.number === number);

const isDone = ({ verdict, decision }) => ["accept", "skip"].includes(decision) || (decision === "" && ["ok", "warned"].includes(verdict));

// {press, last}: the attempt that the verdict shows, the chosen one, else the last that was judged; last: decisions are
// about it, and not about a later attempt. Null before the first.
export function shownPress({ presses }, chosen) {
  const judged = presses.filter((one) => one.verdict !== "");
  const waiting = judged.findLast((one) => one.verdict === "rejected" && one.decision === "" && last(presses, one.number) === one);
  const press = judged.find((one) => nameOf(one) === chosen) ?? waiting ?? judged.at(-1);
  return press ? { ...press, last: last(judged, press.number) === press } : null;
}

// {mark, text, kind}
export function verdictOf({ verdict, decision }) {
  const also = DECISIONS[decision] ? `, ${DECISIONS[decision]}` : "";
  return { kind: verdict, mark: MARKS[verdict] ?? "", text: `${VERDICTS[verdict] ?? ""}${also}` };
}

// Specimens after the present one, in their order.
export function upcoming({ presses, specimen }) {
  const names = presses.filter((one) => one.verdict === "" && one.decision === "").map((one) => one.specimen);
  return names.filter((name, i) => name !== (i ? names[i - 1] : specimen)).slice(0, 6);
}

const numbersOf = ({ presses, phase }) => [...new Set(presses.filter((one) => one.phase === phase).map((one) => one.number))];

// Cells of the bar, one a press: {kind, first}; first: of its specimen. Now is what runs, else what comes next.
export function cellsOf(state) {
  const some = numbersOf(state).map((number) => last(state.presses, number));
  const now = state.press?.number ?? some.find((one) => one.verdict === "")?.number;
  return some.map((one, i) => ({
    kind: `${one.decision === "skip" ? "skipped" : one.verdict}${one.number === now ? " now" : ""}`.trim(),
    first: i > 0 && one.specimen !== some[i - 1].specimen,
  }));
}

export function countOf(state) {
  if (state.phase === "quality") return "Signal quality";
  const numbers = numbersOf(state), done = numbers.filter((number) => isDone(last(state.presses, number))).length;
  return `${state.phase === "training" ? "Training: " : ""}${done} of ${numbers.length} presses`;
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
