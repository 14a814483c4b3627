// Values over time: response times of a chain, compute times of a node.

// Joins at least `together` neighbouring bands into one, so that bands are no narrower than the screen can show. The
// p95 of a joined band is the mean of theirs. `size`: the length of a band.
function joinedBands(series, together) {
  const { run, band } = series;
  const stride = 2 ** Math.max(0, Math.ceil(Math.log2(together)));
  series.joined = series.joined || new Map();
  if (!series.joined.has(stride)) {
    const joined = { bucket: [], min: [], mean: [], p95: [], max: [] };
    let sum = 0;
    let count = 0;
    for (let i = 0; i < band.bucket.length; i++) {
      const bucket = Math.floor(band.bucket[i] / stride);
      const at = joined.bucket.length - 1;
      if (joined.bucket[at] !== bucket) {
        joined.bucket.push(bucket);
        for (const name of ['min', 'mean', 'p95', 'max']) joined[name].push(band[name][i]);
        [sum, count] = [band.mean[i], 1];
        continue;
      }
      sum += band.mean[i];
      joined.mean[at] = sum / ++count;
      joined.p95[at] += (band.p95[i] - joined.p95[at]) / count;
      joined.min[at] = Math.min(joined.min[at], band.min[i]);
      joined.max[at] = Math.max(joined.max[at], band.max[i]);
    }
    series.joined.set(stride, joined);
  }
  return { band: series.joined.get(stride), size: (run.duration / band.buckets) * stride };
}

class Values extends Panel {
  // series: { run, colour, band, points: (from, to) => [[at, ms], ...] or null where there are too many }
  get left() { return 66; }
  height() { return this.width < 560 ? 150 : 190; }

  draw(g, height) {
    const top = 8;
    const bottom = height - 22;
    const drawn = this.series.map((series) => {
      const pixels = ((this.right - this.left) * series.run.duration) / (view.to - view.from) / series.band.buckets;
      const one = { ...series, ...joinedBands(series, Math.ceil(2 / pixels)) };
      const points = one.points(view.from, view.to);
      const first = Math.max(0, above(one.band.bucket, view.from / one.size) - 2);
      const last = Math.min(one.band.bucket.length, above(one.band.bucket, view.to / one.size) + 1);
      return { one, points, first, last };
    });
    let max = 0;
    for (const { one, points, first, last } of drawn) {
      if (points) for (const point of points) max = Math.max(max, point[1]);
      else for (let i = first; i < last; i++) max = Math.max(max, one.band.max[i]);
    }
    for (const level of this.levels()) if (level.max < 1.8 * max) max = Math.max(max, level.max);
    max = max > 0 ? 1.08 * max : 1;
    this.y = (ms) => bottom - (ms / max) * (bottom - top);
    this.timeAxis(g, height - 9, top, bottom);
    const step = niceStep(max, 4);
    g.textAlign = 'right';
    for (let value = 0; value <= max; value += step) {
      const y = Math.round(this.y(value)) + 0.5;
      g.strokeStyle = colours.line;
      g.beginPath();
      g.moveTo(this.left, y);
      g.lineTo(this.right, y);
      g.stroke();
      g.fillStyle = colours.muted;
      g.fillText(Number(value.toPrecision(6)) + ' ms', this.left - 6, Math.max(y, 8));
    }
    this.clip(g, height);
    this.warmUp(g, this.series[0].run, top, bottom);
    this.drawn = [];
    for (const { one, points, first, last } of drawn) {
      if (points) this.dots(g, one, points);
      else this.band(g, one, first, last);
    }
    for (const level of this.levels()) this.level(g, level, top);
    this.extras(g, top, bottom);
    g.restore();
  }

  levels() { return []; }
  extras() {}

  dots(g, one, points) {
    g.fillStyle = g.strokeStyle = one.colour();
    g.lineWidth = 1;
    if (this.joined) {
      g.globalAlpha = 0.5;
      g.beginPath();
      for (const [at, ms] of points) g.lineTo(this.x(at), this.y(ms));
      g.stroke();
      g.globalAlpha = 1;
    }
    const size = points.length > 400 ? 1.2 : 2.4;
    for (const [at, ms] of points) g.fillRect(this.x(at) - size, this.y(ms) - size, 2 * size, 2 * size);
    this.drawn.push(...points.map(([at, ms]) => [at, ms, one]));
  }

  band(g, one, first, last) {
    const { band, size } = one;
    g.fillStyle = g.strokeStyle = one.colour();
    const middle = (i) => this.x((band.bucket[i] + 0.5) * size);
    g.globalAlpha = 0.25;
    g.beginPath();
    for (let i = first; i < last; i++) g.lineTo(middle(i), this.y(band.p95[i]));
    for (let i = last - 1; i >= first; i--) g.lineTo(middle(i), this.y(band.min[i]));
    g.fill();
    g.globalAlpha = 0.55;
    for (let i = first; i < last; i++) g.fillRect(middle(i) - 1, this.y(band.max[i]) - 1, 2, 2);
    g.globalAlpha = 1;
    g.lineWidth = 1.6;
    g.beginPath();
    for (let i = first; i < last; i++) g.lineTo(middle(i), this.y(band.mean[i]));
    g.stroke();
    for (let i = first; i < last; i++) this.drawn.push([(band.bucket[i] + 0.5) * size, band.max[i], one, i]);
  }

  level(g, level, top) {
    g.strokeStyle = g.fillStyle = colours[level.name];
    g.lineWidth = 1.4;
    g.setLineDash({ bound: [], promised: [7, 4], expected: [2, 3] }[level.name]);
    g.beginPath();
    let label = null;
    for (const [from, to, ms] of level.steps) {
      if (to < view.from || from > view.to) continue;
      const y = this.y(ms);
      g.moveTo(Math.max(this.left, this.x(from)), y);
      g.lineTo(Math.min(this.right, this.x(to)), y);
      label = y;
    }
    g.stroke();
    g.setLineDash([]);
    g.textAlign = 'right';
    if (label === null || label < top + 4) return;
    g.strokeStyle = colours.card;
    g.lineWidth = 4;
    const at = [this.right - (level.name === 'bound' ? 80 : 4), label + (level.name === 'expected' ? 9 : -8)];
    g.strokeText(level.name, ...at);
    g.fillText(level.name, ...at);
  }

  what(x, y) {
    let best = null;
    let min = 30 * 30;
    for (const point of this.drawn || []) {
      const dx = this.x(point[0]) - x;
      const dy = (this.y(point[1]) - y) / 3;
      const apart = dx * dx + dy * dy;
      if (apart < min) [min, best] = [apart, point];
    }
    if (!best) return '';
    const [at, ms, one, i] = best;
    const name = runs.length > 1 ? one.run.name + '\n' : '';
    const note = one.note ? '\n' + one.note : '';
    if (i === undefined) return name + msText(ms) + ', ended at ' + timeText(at, 1e4) + note;
    return name + 'around ' + timeText(at, 1e6) + '\nmean ' + msText(one.band.mean[i]) + ', p95 ' +
      msText(one.band.p95[i]) + '\nfrom ' + msText(one.band.min[i]) + ' to ' + msText(ms) + note;
  }
}

const runColour = (index) => () => colours[index ? 'run-b' : 'accent'];
const kMaxPoints = 2500;

class Responses extends Values {
  constructor(place) {
    super(place);
    this.joined = true;
    this.series = [];
    [place.dataset.chain, place.dataset.other].forEach((index, which) => {
      if (index === undefined) return;
      const run = runs[which];
      const chain = run.chains[Number(index)];
      this.series.push({
        run, band: chain.band, colour: runColour(which), chain,
        points: (from, to) => {
          const { at, ms } = chain.points;
          const first = Math.max(0, above(at, from) - 1);
          const last = Math.min(at.length, above(at, to) + 1);
          const there = run.all_points || covered(run, from, Math.min(to, run.duration));
          if (!there || last - first > kMaxPoints) return null;
          const points = [];
          for (let i = first; i < last; i++) points.push([at[i], ms[i]]);
          return points;
        },
      });
    });
    this.index = Number(place.dataset.chain);
  }

  levels() {
    const { run, chain } = this.series[0];
    const levels = [];
    if (chain.bound !== null) {
      levels.push({ name: 'bound', max: chain.bound, steps: [[0, run.duration, chain.bound]] });
    }
    ['promised', 'expected'].forEach((name, which) => {
      const steps = [];
      let max = 0;
      run.plans.forEach((plan, i) => {
        const ms = plan.chains.length ? plan.chains[this.index][which] : null;
        if (ms === null) return;
        const end = i + 1 < run.plans.length ? run.plans[i + 1].at : run.duration;
        steps.push([plan.at, end, ms]);
        if (end >= view.from && plan.at <= view.to) max = Math.max(max, ms);
      });
      if (steps.length) levels.push({ name, max, steps });
    });
    return levels;
  }
}

function covered(run, from, to) {
  const windows = inDetail(run, from, to);
  return windows.length === 1 && windows[0][0] <= from && windows[0][1] >= to;
}

class Compute extends Values {
  constructor(place) {
    super(place);
    this.series = [];
    [place.dataset.node, place.dataset.other].forEach((index, which) => {
      if (index === undefined) return;
      const run = runs[which];
      const node = run.nodes[Number(index)];
      node.compute.forEach((band, mode) => {
        const several = node.compute.length > 1;
        this.series.push({
          run, band, note: several ? node.modes[mode] : '',
          colour: several && runs.length === 1 ? () => colourOf(mode) : runColour(which),
          points: (from, to) => {
            const data = node.runs;
            const first = Math.max(0, above(data.begin, from) - 1);
            const last = Math.min(data.count, above(data.begin, to) + 1);
            if (last - first > kMaxPoints || !covered(run, from, Math.min(to, run.duration))) return null;
            const points = [];
            for (let i = first; i < last; i++) {
              if (!several || data.mode[i] === mode) points.push([data.end[i], data.cpu[i]]);
            }
            return points;
          },
        });
      });
    });
    this.changes = runs[0].events.filter((event) => event.kind === 'cost' && event.node === Number(place.dataset.node));
  }

  height() { return this.width < 560 ? 130 : 150; }

  extras(g, top, bottom) {
    for (const change of this.changes) {
      const x = this.x(change.at);
      g.strokeStyle = colours.expected;
      g.setLineDash([1, 4]);
      g.beginPath();
      g.moveTo(x, top);
      g.lineTo(x, bottom);
      g.stroke();
      g.setLineDash([]);
      sign(g, 'cost', x, top + 5);
    }
  }
}
