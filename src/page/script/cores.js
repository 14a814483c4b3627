// The timeline of cores: which lane had each core, and each lane's runs; zoomed out, busy shares.

const kAxis = 20;
const kMarks = 20;
const kRowHeights = { core: 34, lane: 20, title: 20 };

function inDetail(run, from, to) {
  const windows = run.detail; // begins and ends in turn
  const result = [];
  for (let i = 0; i < windows.length; i += 2) {
    const begin = Math.max(from, windows[i]);
    const end = Math.min(to, windows[i + 1]);
    if (end > begin) result.push([begin, end]);
  }
  return result;
}

class Cores extends Panel {
  constructor(place) {
    super(place);
    this.run = runs[Number(place.dataset.run)];
  }

  height() {
    let height = kAxis + kMarks;
    for (const row of this.run.rows) height += kRowHeights[row.kind];
    return height + 4;
  }

  *places() {
    let y = kAxis + kMarks;
    for (const row of this.run.rows) {
      yield [row, y, kRowHeights[row.kind]];
      y += kRowHeights[row.kind];
    }
  }

  draw(g, height) {
    const run = this.run;
    this.timeAxis(g, kAxis / 2, kAxis, height);
    const to = Math.min(view.to, run.duration);
    const detail = inDetail(run, view.from, to);
    const counts = run.lanes.map((lane) => lane.nodes.reduce((sum, id) => {
      const begins = run.nodes[id].runs.begin;
      return sum + above(begins, view.to) - above(begins, view.from);
    }, 0));
    // Runs that are too close for the screen to separate would look like one that is busy all the time.
    const room = (this.right - this.left) / 3;
    const shown = (row) => {
      const lanes = row.kind === 'core' ? row.lanes : [row.lane];
      return lanes.reduce((sum, lane) => sum + counts[lane], 0) <= room ? detail : [];
    };
    this.labels(g);
    this.clip(g, height);
    this.warmUp(g, run, kAxis, height);
    for (const [row, y, tall] of this.places()) {
      if (row.kind === 'title') continue;
      g.fillStyle = colours.track;
      const there = row.kind === 'core' ? [[view.from, to]] : stretches(run, row.lane, row.core, view.from, to);
      for (const [from, until] of there) g.fillRect(this.x(from), y + 1, this.x(until) - this.x(from), tall - 2);
      const single = shown(row);
      this.shares(g, row, y + 1, tall - 2, single, to);
      for (const [from, until] of single) {
        if (row.kind === 'core') this.had(g, row, y + 1, tall - 2, from, until);
        else this.lane(g, row, y + 1, tall - 2, from, until);
      }
    }
    this.marks(g, height);
    g.restore();
  }

  labels(g) {
    for (const [row, y, tall] of this.places()) {
      g.fillStyle = row.kind === 'lane' ? colours.muted : colours.ink;
      g.font = row.kind === 'lane' ? kFont : 'bold ' + kFont;
      g.textAlign = row.kind === 'title' ? 'left' : 'right';
      if (row.kind === 'title') g.fillText(row.label, 4, y + tall / 2);
      else g.fillText(fitted(g, row.label, this.left - 8), this.left - 6, y + tall / 2);
    }
    g.font = kFont;
  }

  // Busy shares as areas where there is no detail; those of one core are stacked.
  shares(g, row, y, tall, detail, to) {
    const lanes = row.kind === 'core' ? row.lanes : [row.lane];
    const gaps = [];
    let from = view.from;
    for (const [begin, end] of detail) {
      if (begin > from) gaps.push([from, begin]);
      from = end;
    }
    if (from < to) gaps.push([from, to]);
    if (!gaps.length || !lanes.length) return;
    const pixels = this.right - this.left;
    const levels = this.run.share[0];
    let level = 0;
    const step = () => this.run.duration / levels[level].length;
    while (level + 1 < levels.length && (step() / (view.to - view.from)) * pixels < 1.5) level++;
    const size = step();
    for (const [begin, end] of gaps) {
      const first = Math.floor(begin / size);
      const last = Math.min(levels[level].length, Math.ceil(end / size));
      const base = new Float32Array(last - first);
      for (const lane of lanes) {
        const share = this.run.share[lane][level];
        g.fillStyle = this.run.lanes[lane].colour;
        for (const [f, t] of stretches(this.run, lane, row.core, begin, end)) {
          const one = Math.floor(f / size);
          for (let i = one; i < last && i * size < t; i++) {
            if (!share[i]) continue;
            const high = Math.max((share[i] / 255) * tall, row.kind === 'core' ? 0 : 1);
            const x0 = Math.round(this.x(Math.max(f, i * size))); // to whole pixels: no seams
            const x1 = Math.round(this.x(Math.min(t, (i + 1) * size)));
            const low = row.kind === 'core' ? base[i - first] : 0;
            const up = Math.min(tall, low + high); // evenly spread, several may come to more than all
            g.fillRect(x0, y + tall - up, x1 - x0, up - low); // one path of them all takes longer
            base[i - first] = up;
          }
        }
      }
    }
  }

  // Calls use(begin, end, index, node) for the runs of a lane there, in detail.
  eachRun(lane, core, from, until, use) {
    const run = this.run;
    for (const id of run.lanes[lane].nodes) {
      const node = run.nodes[id];
      const data = node.runs;
      let i = Math.max(0, above(data.begin, from) - 1);
      let last = -1e9;
      for (; i < data.count && data.begin[i] < until; i++) {
        if (data.end[i] < from) continue;
        const x1 = this.x(data.end[i]);
        if (x1 - last < 0.4) continue;
        last = x1;
        if (core !== undefined && !isOn(run, lane, core, data.begin[i])) continue;
        use(data, i, node);
      }
    }
  }

  // The pieces of a run in which it had its core.
  pieces(data, i, use) {
    const losses = data.losses.get(i);
    let from = data.begin[i];
    if (losses) {
      for (let k = 0; k < losses.length; k += 3) {
        use(from, losses[k]);
        from = losses[k + 1];
      }
    }
    use(from, data.end[i]);
  }

  had(g, row, y, tall, from, until) {
    for (const lane of row.lanes) {
      g.fillStyle = this.run.lanes[lane].colour;
      const names = [];
      this.eachRun(lane, row.core, from, until, (data, i, node) => {
        this.pieces(data, i, (begin, end) => {
          const x0 = this.x(begin);
          const wide = Math.max(0.7, this.x(end) - x0 - 0.4);
          g.fillRect(x0, y + 2, wide, tall - 5);
          if (wide > 36) names.push([x0, wide, node.name]);
        });
      });
      this.names(g, names, y + (tall - 1) / 2);
    }
    const { slots, steals } = this.run;
    for (let i = Math.max(0, above(slots.begin, from) - 64); i < slots.begin.length && slots.begin[i] < until; i++) {
      if (slots.core[i] !== row.core || slots.end[i] < from) continue;
      const x0 = this.x(slots.begin[i]);
      g.fillStyle = this.run.lanes[slots.lane[i]].colour;
      g.fillRect(x0, y + tall - 2, Math.max(0.7, this.x(slots.end[i]) - x0 - 0.5), 2);
    }
    for (let i = Math.max(0, above(steals.begin, from) - 64); i < steals.begin.length && steals.begin[i] < until; i++) {
      if (steals.core[i] !== row.core || steals.end[i] < from) continue;
      this.hatch(g, this.x(steals.begin[i]), y, this.x(steals.end[i]), 6);
    }
  }

  names(g, names, y) {
    if (!names.length) return;
    g.fillStyle = '#10151a';
    g.textAlign = 'left';
    for (const [x0, wide, name] of names) {
      const begin = Math.max(x0, this.left);
      const room = Math.min(x0 + wide, this.right) - begin - 6;
      if (room > 24) g.fillText(fitted(g, name, room), begin + 3, y);
    }
  }

  hatch(g, x0, y, x1, tall) {
    g.strokeStyle = colours.ink;
    g.lineWidth = 1;
    g.beginPath();
    const end = Math.min(Math.max(x1, x0 + 2), this.right);
    for (let x = Math.max(x0, this.left); x < end; x += 4) {
      g.moveTo(x, y + tall);
      g.lineTo(Math.min(x + 4, end), y);
    }
    g.rect(x0, y, Math.max(x1 - x0, 2), tall);
    g.stroke();
  }

  lane(g, row, y, tall, from, until) {
    const run = this.run;
    const names = [];
    const solid = [];
    g.fillStyle = run.lanes[row.lane].colour;
    g.globalAlpha = 0.35;
    this.eachRun(row.lane, row.core, from, until, (data, i, node) => {
      const x0 = this.x(data.begin[i]);
      const wide = Math.max(0.7, this.x(data.end[i]) - x0 - 0.4);
      if (data.losses.has(i)) g.fillRect(x0, y + 2, wide, tall - 5);
      this.pieces(data, i, (begin, end) => solid.push(this.x(begin), this.x(end)));
      if (wide > 36) names.push([x0, wide, node.name]);
    });
    g.globalAlpha = 1;
    for (let i = 0; i < solid.length; i += 2) {
      g.fillRect(solid[i], y + 2, Math.max(0.7, solid[i + 1] - solid[i] - 0.4), tall - 5);
    }
    this.names(g, names, y + 2 + (tall - 5) / 2);
    const triggers = run.triggers[row.lane];
    const first = above(triggers.sent, from);
    const last = above(triggers.sent, until);
    if (last - first > (this.right - this.left) / 3) return;
    for (let i = first; i < last; i++) {
      if (row.core !== undefined && !isOn(run, row.lane, row.core, triggers.sent[i])) continue;
      g.fillStyle = triggers.late[i] > 1000 ? colours.late : colours.ink;
      g.fillRect(this.x(triggers.sent[i]) - 0.5, y + tall - 4, 1.2, 4);
    }
  }

  marks(g, height) {
    const middle = kAxis + kMarks / 2;
    const plans = [];
    const first = Math.max(0, this.run.events.findIndex((event) => event.at >= view.from - 1));
    for (let i = first; i < this.run.events.length && this.run.events[i].at <= view.to; i++) {
      const event = this.run.events[i];
      if (event.at < view.from - 1) continue;
      const x = this.x(event.at);
      if (event.kind === 'overrun') {
        for (const [row, y] of this.places()) {
          if (row.lane === event.lane && isOn(this.run, row.lane, row.core, event.at)) triangle(g, x, y + 1);
        }
        continue;
      }
      if (event.kind === 'plan' || event.kind === 'cost') {
        g.strokeStyle = colours.mark;
        g.setLineDash(event.kind === 'plan' ? [4, 3] : [1, 4]);
        g.beginPath();
        g.moveTo(x, kAxis + 4);
        g.lineTo(x, height);
        g.stroke();
        g.setLineDash([]);
      }
      sign(g, event.kind, x, middle);
      if (event.kind === 'plan') plans.push([x, event.text.replace('plan: ', '')]);
    }
    g.textAlign = 'left';
    g.fillStyle = colours.ink;
    plans.forEach(([x, label], i) => { // where there is room up to the next
      const room = i + 1 < plans.length ? plans[i + 1][0] - x : this.right;
      if (g.measureText(label).width + 8 < room) g.fillText(label, x + 5, middle);
    });
  }

  what(x, y) {
    const run = this.run;
    const at = this.time(x);
    const near = (4 * (view.to - view.from)) / (this.right - this.left);
    if (y < kAxis + kMarks) {
      return run.events.filter((event) => event.kind !== 'overrun' && Math.abs(event.at - at) < 2 * near).slice(0, 4)
        .map((event) => timeText(event.at, 1e6) + '  ' + event.text).join('\n');
    }
    for (const [row, top, tall] of this.places()) {
      if (y < top || y >= top + tall || row.kind === 'title') continue;
      const known = inDetail(run, at, at + 1).length > 0;
      return this.under(row, at, near / 4) ||
        timeText(at, view.to - view.from) + '\n' + (known ? 'no run' : this.shareText(row, at));
    }
    return '';
  }

  shareText(row, at) {
    const step = this.run.duration / this.run.buckets;
    const lanes = row.kind === 'core' ? row.lanes : [row.lane];
    return lanes.filter((lane) => isOn(this.run, lane, row.core, at)).map((lane) =>
      this.run.lanes[lane].name + ' ' + Math.round(100 * meanShare(this.run, lane, at, at + step / 2)) + ' %')
      .join('\n');
  }

  // The run at an instant; in the row of a core, the one that had the core.
  under(row, at, near) {
    const run = this.run;
    for (const lane of row.kind === 'core' ? row.lanes : [row.lane]) {
      if (!isOn(run, lane, row.core, at)) continue;
      for (const id of run.lanes[lane].nodes) {
        const node = run.nodes[id];
        const data = node.runs;
        const i = above(data.begin, at + near) - 1;
        if (i < 0 || data.end[i] < at - near) continue;
        let lost = 0;
        let has = false;
        this.pieces(data, i, (begin, end) => { has = has || (at >= begin - near && at <= end + near); });
        if (row.kind === 'core' && !has) continue;
        const losses = data.losses.get(i) || [];
        const who = new Set();
        for (let k = 0; k < losses.length; k += 3) {
          lost += losses[k + 1] - losses[k];
          who.add(run.lanes[losses[k + 2]].name);
        }
        const lines = [
          node.name + ', run ' + data.number[i] + (node.modes.length ? ' (' + node.modes[data.mode[i]] + ')' : ''),
          'from ' + timeText(data.begin[i], 1e3) + ', ' + msText((data.end[i] - data.begin[i]) / 1e3),
          'computed ' + msText(data.cpu[i]),
        ];
        if (data.wait[i] > 0) lines.push('waited ' + msText(data.wait[i]));
        if (lost > 0) lines.push('pre-empted ' + msText(lost / 1e3) + ' by ' + [...who].join(', '));
        return lines.join('\n');
      }
    }
    return '';
  }
}

function triangle(g, x, y) {
  g.fillStyle = colours.late;
  g.beginPath();
  g.moveTo(x - 4, y);
  g.lineTo(x + 4, y);
  g.lineTo(x, y + 7);
  g.fill();
}

function sign(g, kind, x, y) {
  if (kind === 'plan') return;
  g.fillStyle = kind === 'notice' ? colours.warn : kind === 'cost' ? colours.expected : colours.promised;
  g.beginPath();
  if (kind === 'cost') g.arc(x, y, 4, 0, 7);
  else if (kind === 'notice') {
    g.moveTo(x, y - 5);
    g.lineTo(x + 5, y);
    g.lineTo(x, y + 5);
    g.lineTo(x - 5, y);
  } else g.rect(x - 4, y - 4, 8, 8);
  g.fill();
}

function fitted(g, text, room) {
  if (g.measureText(text).width <= room) return text;
  let short = text;
  while (short.length > 1 && g.measureText(short + '…').width > room) short = short.slice(0, -1);
  return short + '…';
}
