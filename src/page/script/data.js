// The runs that the page has, unpacked from the data embedded in it (data.cpp), and how to search in them. The files
// of this folder become the body of one function, in the order of CMakeLists.txt.
//
// Units: microseconds since a run's start, unless a name says otherwise. Packed numbers: pack.h.

const source = document.getElementById('catan-data');
const runs = JSON.parse(source.textContent);
source.remove(); // its text is no longer needed
document.documentElement.classList.add('live');

// ---- Unpacking

function bytesOf(text) {
  const raw = atob(text);
  const bytes = new Uint8Array(raw.length);
  for (let i = 0; i < raw.length; i++) bytes[i] = raw.charCodeAt(i);
  return bytes;
}

function reader(text) {
  const bytes = bytesOf(text);
  let at = 0;
  return {
    more: () => at < bytes.length,
    next() {
      if (bytes[at] < 128) return bytes[at++];
      let value = 0;
      let scale = 1;
      for (;;) {
        const byte = bytes[at++];
        value += (byte & 127) * scale;
        if (!(byte & 128)) return value;
        scale *= 128;
      }
    },
  };
}

const kTenths = 1e4; // of a microsecond in a millisecond

function unpackRuns(node) {
  const count = node.count || 0;
  const runs = {
    count, begin: new Float64Array(count), end: new Float64Array(count), cpu: new Float64Array(count),
    wait: new Float64Array(count), number: new Float64Array(count), mode: new Uint16Array(count),
    losses: new Map(), // by index: begin, end, lane of each in turn
  };
  const data = reader(node.runs || '');
  let begin = 0;
  let number = 0;
  for (let i = 0; i < count; i++) {
    begin += data.next();
    runs.begin[i] = begin;
    runs.end[i] = begin + data.next();
    runs.cpu[i] = data.next() / kTenths;
    runs.wait[i] = data.next() / kTenths;
    number += data.next();
    runs.number[i] = number;
    runs.mode[i] = data.next();
    const losses = data.next();
    if (!losses) continue;
    const list = [];
    let from = begin;
    for (let k = 0; k < losses; k++) {
      const lost = from + data.next();
      from = lost + data.next();
      list.push(lost, from, data.next());
    }
    runs.losses.set(i, list);
  }
  return runs;
}

function unpackBands(text) {
  const bands = { bucket: [], min: [], mean: [], p95: [], max: [] };
  const data = reader(text);
  bands.buckets = data.next();
  let bucket = 0;
  while (data.more()) {
    bucket += data.next();
    bands.bucket.push(bucket);
    for (const name of ['min', 'mean', 'p95', 'max']) bands[name].push(data.next() / kTenths);
  }
  return bands;
}

function unpackPoints(text) {
  const points = { at: [], ms: [] };
  const data = reader(text);
  let at = 0;
  while (data.more()) {
    at += data.next();
    points.at.push(at);
    points.ms.push(data.next() / kTenths);
  }
  return points;
}

function unpackSlots(text, steals) {
  const slots = { begin: [], end: [], core: [], lane: [], victim: [] };
  const data = reader(text);
  let begin = 0;
  while (data.more()) {
    begin += data.next();
    slots.begin.push(begin);
    slots.end.push(begin + data.next());
    slots.core.push(data.next());
    slots.lane.push(data.next());
    if (steals) slots.victim.push(data.next());
  }
  return slots;
}

// Busy shares at ever coarser levels, each of half as many buckets.
function pyramid(text) {
  const levels = [bytesOf(text)];
  while (levels[levels.length - 1].length > 64) {
    const fine = levels[levels.length - 1];
    const coarse = new Uint8Array(fine.length / 2);
    for (let i = 0; i < coarse.length; i++) coarse[i] = (fine[2 * i] + fine[2 * i + 1] + 1) >> 1;
    levels.push(coarse);
  }
  return levels;
}

for (const run of runs) {
  for (const node of run.nodes) {
    if (node.lane === undefined) continue;
    node.runs = unpackRuns(node);
    node.compute = node.compute.map(unpackBands);
  }
  for (const chain of run.chains) {
    chain.band = unpackBands(chain.band);
    chain.points = unpackPoints(chain.points);
  }
  run.share = run.share.map(pyramid);
  run.slots = unpackSlots(run.slots, false);
  run.steals = unpackSlots(run.steals, true);
  run.triggers = run.triggers.map((text) => {
    const triggers = { sent: [], late: [] };
    const data = reader(text);
    let sent = 0;
    while (data.more()) {
      sent += data.next();
      triggers.sent.push(sent);
      triggers.late.push(data.next());
    }
    return triggers;
  });
  // For each plan: core of each lane ('lane,core' is in the set where it may run there).
  for (const plan of run.plans) plan.places = new Set(plan.on.map(([lane, core]) => lane + ',' + core));
  run.rows = rowsOf(run);
}

// The rows of a timeline: each core with the lanes that were ever on it below, then lanes that had no core.
function rowsOf(run) {
  const on = new Map();
  const add = (lane, core) => {
    if (!on.has(core)) on.set(core, []);
    if (!on.get(core).includes(lane)) on.get(core).push(lane);
  };
  for (const plan of run.plans) for (const [lane, core] of plan.on) add(lane, core);
  for (let i = 0; i < run.slots.lane.length; i++) add(run.slots.lane[i], run.slots.core[i]);
  const rows = [];
  const placed = new Set();
  for (let core = 0; core < run.cores; core++) {
    const lanes = on.get(core) || [];
    rows.push({ kind: 'core', core, lanes, label: 'core ' + core });
    for (const lane of lanes) {
      rows.push({ kind: 'lane', core, lane, label: run.lanes[lane].name });
      placed.add(lane);
    }
  }
  const rest = run.lanes.map((_, lane) => lane).filter((lane) => !placed.has(lane));
  for (const scheduled of [true, false]) {
    const lanes = rest.filter((lane) => run.lanes[lane].scheduled === scheduled);
    if (!lanes.length) continue;
    rows.push({ kind: 'title', label: scheduled ? 'on any core' : 'unscheduled' });
    for (const lane of lanes) rows.push({ kind: 'lane', lane, label: run.lanes[lane].name });
  }
  return rows;
}

// ---- Searching

// The first index whose value is above x.
function above(values, x, count = values.length) {
  let low = 0;
  let high = count;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] > x) high = middle;
    else low = middle + 1;
  }
  return low;
}

function planAt(run, at) {
  let low = 0;
  let high = run.plans.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (run.plans[middle].at > at) high = middle;
    else low = middle + 1;
  }
  return low ? run.plans[low - 1] : null;
}

function isOn(run, lane, core, at) {
  if (core === undefined) return true;
  const plan = planAt(run, at);
  return plan !== null && plan.places.has(lane + ',' + core);
}

// The stretches of [from, to) in which a lane is on a core, by the plans.
function stretches(run, lane, core, from, to) {
  if (core === undefined) return [[from, to]];
  const result = [];
  for (let i = 0; i < run.plans.length; i++) {
    const begin = Math.max(from, run.plans[i].at);
    const end = Math.min(to, i + 1 < run.plans.length ? run.plans[i + 1].at : run.duration);
    if (end <= begin || !run.plans[i].places.has(lane + ',' + core)) continue;
    if (result.length && result[result.length - 1][1] === begin) result[result.length - 1][1] = end;
    else result.push([begin, end]);
  }
  return result;
}
