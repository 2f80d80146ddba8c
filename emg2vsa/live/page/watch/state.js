// What a moment means: the message over the page, and the state of the stop button. No page in here, only values.

const SILENT_S = 0.5; // a row comes every 5 ms
const LOST_S = 1.5;
const ANSWER_S = 3; // retracting 15 mm at 20 mm/s and settling takes about 1 s

// {kind, title, text, stale} or null; stale: what is shown is not the present.
export function messageOf({ now, silentS }) {
  if (silentS > LOST_S) {
    const text = "The page is not up to date, and STOP may not get through. If emg2vsa rig watch was started again, open its new address.";
    return { kind: "danger", title: `No connection for ${duration(silentS)}.`, text, stale: true };
  }
  if (now === null) return { kind: "wait", title: "Connecting.", text: "", stale: false };
  if (now.trouble) return { kind: "guard", title: "Cannot be shown.", text: now.trouble, stale: true };
  if (now.run === null) return { kind: "wait", title: "Waiting for a run.", text: `It will be shown as soon as it begins in ${now.folder}.`, stale: false };
  if (now.ended) return { ...now.ended, stale: false };
  const ageS = (now.age_s ?? 0) + silentS;
  if (ageS > SILENT_S) {
    const held = "The run is held up, or its program was killed. Be ready to cut the power.";
    return { kind: ageS < 2 ? "warn" : "danger", title: `No data for ${duration(ageS)}.`, text: held, stale: true };
  }
  return null;
}

// The frame to ask the server for, "" for none: the newest of the run also where the log says none at the moment,
// after its end and between presses, if nothing of it is shown yet.
export function frameToAsk(run, frame, shown) {
  if (!run) return "";
  const asked = `${run.name}/${frame}`;
  return asked !== shown && (frame !== "" || !shown.startsWith(`${run.name}/`)) ? asked : "";
}

// Largest forces, how late the control loop was, and what the last press tells of the specimen.
export function healthOf({ largest_n: along, largest_across_n: across, turns, late_turns: late, latest_ms: latest, weighed }) {
  const percent = turns ? (100 * late) / turns : 0;
  const loop = turns ? ` · loop late in ${percent.toFixed(percent < 1 ? 2 : 0)} % of turns, by up to ${latest.toFixed(1)} ms` : "";
  const specimen = weighed ? ` · ${weighed}` : "";
  return `largest force ${along.toFixed(2)} N, across ${across.toFixed(2)} N${percent > 1 ? `${loop}: the computer is busy` : loop}${specimen}`;
}

// Kinds of the parts of the bar: one for each press, or one for each hundredth of many.
export function pressesOf(repetitions, done, pressing) {
  const parts = Math.min(repetitions, 100), filled = Math.floor((parts * Math.min(done, repetitions)) / Math.max(1, repetitions));
  return Array.from({ length: parts }, (_, i) => (i < filled ? "done" : i === filled && pressing ? "now" : ""));
}

// Kappa of the press that was judged last, in words.
export function kappaOf(kappa) {
  const last = kappa.kappa_n_per_mm.length - 1;
  if (last < 0) return { big: "–", interval: "", judged: kappa.note || "not determined yet" };
  const number = (v) => (v >= 100 ? v.toFixed(0) : v.toPrecision(3));
  const high = kappa.high_n_per_mm[last] === null ? "rigid" : number(kappa.high_n_per_mm[last]);
  const width = kappa.half_width === null ? "" : ` (±${(100 * kappa.half_width).toFixed(0)} %)`;
  const parts = [`press ${kappa.repetition}`, kappa.presses === 1 ? "1 press counts" : `${kappa.presses} presses count`];
  if (kappa.stop) parts.push(`seen enough at ${kappa.stop_n.toFixed(2)} N: ${kappa.stop}`);
  if (kappa.note) parts.push(kappa.note);
  return {
    big: `${number(kappa.kappa_n_per_mm[last])} N/mm`,
    interval: `${number(kappa.low_n_per_mm[last])} to ${high} N/mm${width}`,
    judged: parts.join(" · "),
  };
}

// The plot of kappa over force: its height, the upper ends of the intervals within it, and the axis of force.
export function kappaAxisOf(kappa, fMaxN) {
  const last = kappa.kappa_n_per_mm.length - 1;
  const newest = last < 0 ? 1 : Math.max(kappa.kappa_n_per_mm[last], 0.1);
  const high = Math.max(2 * newest, Math.min(4 * newest, 1.1 * (kappa.high_n_per_mm[last] ?? 4 * newest)));
  const labels = Array.from({ length: Math.floor(fMaxN) + 1 }, (_, n) => ({ at: n, text: n ? `${n} N` : "0", align: "center" }));
  return { high, tops: kappa.high_n_per_mm.map((v) => v ?? 10 * high), axis: { from: 0, to: 1.05 * fMaxN, labels } };
}

// The newest interval, which a press that stops at its first one has no band for.
export function newestBarOf(kappa, tops) {
  const last = kappa.kappa_n_per_mm.length - 1;
  if (last < 0) return [];
  return [{ at: kappa.force_n[last], value: kappa.kappa_n_per_mm[last], low: kappa.low_n_per_mm[last], high: tops[last], colour: "--blue" }];
}

// {kind, title, hint, enabled}
export function stopStateOf({ now, silentS }, { askedS, failure }, nowS) {
  if (!now?.run || now.ended) return { kind: "", title: "STOP", hint: now?.ended ? "the run is over" : "nothing is running", enabled: false };
  if (failure) return { kind: "failed", title: "NOT STOPPED", hint: `${failure}. Try again, or cut the power.`, enabled: true };
  if (askedS !== null && nowS - askedS > ANSWER_S) {
    const hint = `The rig has not confirmed for ${duration(nowS - askedS)}. Cut the power.`;
    return { kind: "failed", title: "NO ANSWER", hint, enabled: true };
  }
  if (askedS !== null || now.stop_requested) {
    const hint = now.stop_requested ? "The request is with the rig; it retracts the probe." : "Sending the request.";
    return { kind: "asked", title: "Stopping", hint, enabled: true };
  }
  return { kind: "", title: "STOP", hint: "one click, or the Space key", enabled: true };
}

function duration(s) {
  if (s < 2) return `${s.toFixed(1)} s`;
  if (s < 120) return `${Math.round(s)} s`;
  return s < 7200 ? `${Math.round(s / 60)} min` : `${Math.round(s / 3600)} h`;
}
