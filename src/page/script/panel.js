// The span of time that all charts show, and what charts have in common: a canvas that can be moved and zoomed, and
// that says what is under the pointer.

const duration = Math.max(...runs.map((run) => run.duration));
const kMin = 50; // microseconds
const view = { from: 0, to: duration };
const panels = [];
let colours = {};
let scheduled = false;

function readColours() {
  const style = getComputedStyle(document.documentElement);
  for (const name of ['ink', 'muted', 'line', 'card', 'track', 'accent', 'run-b', 'bound', 'promised', 'expected',
    'late', 'mark', 'warn']) colours[name] = style.getPropertyValue('--' + name).trim();
}

function show(from, to) {
  const length = Math.min(Math.max(to - from, kMin), duration);
  view.from = Math.min(Math.max(from, 0), duration - length);
  view.to = view.from + length;
  redraw();
}

function zoom(factor, around = (view.from + view.to) / 2) {
  show(around - (around - view.from) * factor, around + (view.to - around) * factor);
}

function move(part) {
  const by = (view.to - view.from) * part;
  show(view.from + by, view.to + by);
}

function redraw() {
  if (scheduled) return;
  scheduled = true;
  requestAnimationFrame(() => {
    scheduled = false;
    for (const panel of panels) if (panel.seen) panel.paint();
    tellRange();
  });
}

let rangeTimer = 0;
function tellRange() {
  clearTimeout(rangeTimer);
  rangeTimer = setTimeout(() => {
    const parts = [timeText(view.from, view.to - view.from) + ' to ' + timeText(view.to, view.to - view.from)];
    document.getElementById('range').textContent = parts.concat(runs.length === 1 ? busyText(runs[0]) : []).join('; ');
  }, 150);
}

function busyText(run) {
  const texts = [];
  for (let core = 0; core < Math.min(run.cores, 4); core++) {
    let busy = 0;
    for (let lane = 0; lane < run.lanes.length; lane++) {
      for (const [from, to] of stretches(run, lane, core, view.from, Math.min(view.to, run.duration))) {
        busy += meanShare(run, lane, from, to) * (to - from);
      }
    }
    texts.push('core ' + core + ' ' + Math.min(100, Math.round((100 * busy) / (view.to - view.from))) + ' % busy');
  }
  return texts;
}

function meanShare(run, lane, from, to) {
  const fine = run.share[lane][0];
  const step = run.duration / fine.length;
  const first = Math.floor(from / step);
  const last = Math.max(first + 1, Math.min(fine.length, Math.ceil(to / step)));
  let sum = 0;
  for (let i = first; i < last; i++) sum += fine[i] || 0;
  return sum / 255 / (last - first);
}

// ---- Text

function timeText(at, span) {
  const decimals = span > 5e7 ? 1 : span > 5e6 ? 2 : span > 5e5 ? 3 : span > 5e4 ? 4 : span > 5e3 ? 5 : 6;
  return (at / 1e6).toFixed(decimals) + ' s';
}
const msText = (ms) => (ms >= 100 ? ms.toFixed(1) : ms >= 1 ? ms.toFixed(2) : ms.toFixed(3)) + ' ms';

function niceStep(span, count) {
  const rough = span / count;
  const power = Math.pow(10, Math.floor(Math.log10(rough)));
  for (const factor of [1, 2, 5]) if (factor * power >= rough) return factor * power;
  return 10 * power;
}

// ---- Panels: a canvas that can be moved, zoomed and asked what is under the pointer

const kFont = '12px Inter, "Segoe UI", Roboto, "Helvetica Neue", Arial, "Liberation Sans", sans-serif';

class Panel {
  constructor(place) {
    this.place = place;
    this.canvas = document.createElement('canvas');
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('role', 'application'); // so that readers of screens pass the keys on
    this.canvas.setAttribute('aria-roledescription', 'chart');
    this.canvas.setAttribute('aria-label', place.dataset.label +
      '. Arrow keys move, plus and minus zoom, Home shows everything, n and p go to events.');
    this.tip = document.createElement('div');
    this.tip.className = 'tip';
    this.tip.hidden = true;
    place.append(this.canvas, this.tip);
    this.seen = false;
    this.pointers = new Map();
    this.listen();
    new IntersectionObserver((entries) => {
      this.seen = entries[entries.length - 1].isIntersecting;
      if (this.seen) redraw();
    }, { rootMargin: '100px' }).observe(this.canvas);
    new ResizeObserver(redraw).observe(place);
  }

  get left() { return this.width < 560 ? 58 : 104; }
  get right() { return this.width - 4; }
  x(at) { return this.left + ((at - view.from) / (view.to - view.from)) * (this.right - this.left); }
  time(x) { return view.from + ((x - this.left) / (this.right - this.left)) * (view.to - view.from); }

  paint() {
    this.width = this.place.clientWidth;
    if (!this.width) return;
    const height = this.height();
    const ratio = window.devicePixelRatio || 1;
    const pixels = [Math.round(this.width * ratio), Math.round(height * ratio)];
    if (this.canvas.width !== pixels[0] || this.canvas.height !== pixels[1]) {
      [this.canvas.width, this.canvas.height] = pixels;
      this.canvas.style.height = height + 'px';
    }
    const g = this.canvas.getContext('2d');
    g.setTransform(ratio, 0, 0, ratio, 0, 0);
    g.clearRect(0, 0, this.width, height);
    g.font = kFont;
    g.textBaseline = 'middle';
    this.draw(g, height);
  }

  timeAxis(g, y, top, bottom) {
    const span = view.to - view.from;
    const step = niceStep(span, Math.max(4, (this.right - this.left) / 100));
    g.fillStyle = colours.muted;
    g.strokeStyle = colours.line;
    g.textAlign = 'center';
    g.lineWidth = 1;
    for (let at = Math.ceil(view.from / step) * step; at <= view.to; at += step) {
      const x = Math.round(this.x(at)) + 0.5;
      g.beginPath();
      g.moveTo(x, top);
      g.lineTo(x, bottom);
      g.stroke();
      if (x > this.left + 20 && x < this.right - 22) g.fillText(timeText(at, 4 * step), x, y);
    }
  }

  clip(g, height) {
    g.save();
    g.beginPath();
    g.rect(this.left, 0, this.right - this.left, height);
    g.clip();
  }

  warmUp(g, run, top, bottom) {
    if (run.from <= view.from) return;
    g.fillStyle = colours.muted;
    g.globalAlpha = 0.1;
    g.fillRect(this.left, top, Math.min(this.right, this.x(run.from)) - this.left, bottom - top);
    g.globalAlpha = 1;
  }

  listen() {
    const canvas = this.canvas;
    const local = (event) => {
      const box = canvas.getBoundingClientRect();
      return [event.clientX - box.left, event.clientY - box.top];
    };
    canvas.addEventListener('wheel', (event) => {
      const whole = view.to - view.from >= duration;
      if (event.deltaX && Math.abs(event.deltaX) > Math.abs(event.deltaY)) {
        event.preventDefault();
        move(event.deltaX / 800);
      } else if (event.deltaY < 0 || !whole) { // scrolls the page where there is nothing more to show
        event.preventDefault();
        const unit = event.deltaMode === 1 ? 30 : 1;
        zoom(Math.pow(1.0016, event.deltaY * unit), this.time(local(event)[0]));
      }
    }, { passive: false });
    canvas.addEventListener('pointerdown', (event) => {
      canvas.setPointerCapture(event.pointerId);
      this.pointers.set(event.pointerId, local(event));
    });
    canvas.addEventListener('pointermove', (event) => {
      const now = local(event);
      const before = this.pointers.get(event.pointerId);
      if (!before) {
        this.point(now[0], now[1]);
        return;
      }
      const scale = (view.to - view.from) / (this.right - this.left);
      if (this.pointers.size === 1) {
        if (now[0] !== before[0]) {
          show(view.from - (now[0] - before[0]) * scale, view.to - (now[0] - before[0]) * scale);
          this.tip.hidden = true;
        }
      } else {
        const other = [...this.pointers].find(([id]) => id !== event.pointerId)[1];
        const apart = Math.max(20, Math.abs(before[0] - other[0]));
        zoom(apart / Math.max(20, Math.abs(now[0] - other[0])), this.time(other[0]));
      }
      this.pointers.set(event.pointerId, now);
    });
    const release = (event) => {
      const at = local(event);
      this.pointers.delete(event.pointerId);
      if (event.type === 'pointerup' && event.pointerType !== 'mouse') this.point(at[0], at[1]);
    };
    canvas.addEventListener('pointerup', release);
    canvas.addEventListener('pointercancel', release);
    canvas.addEventListener('pointerleave', () => { this.tip.hidden = true; });
    canvas.addEventListener('blur', () => { this.tip.hidden = true; });
    canvas.addEventListener('dblclick', (event) => zoom(0.25, this.time(local(event)[0])));
    canvas.addEventListener('keydown', (event) => {
      if (event.ctrlKey || event.metaKey || event.altKey) return;
      const actions = {
        ArrowLeft: () => move(-0.2), ArrowRight: () => move(0.2), '+': () => zoom(0.6), '=': () => zoom(0.6),
        '-': () => zoom(1 / 0.6), Home: () => show(0, duration), n: () => nextEvent(1), p: () => nextEvent(-1),
        Escape: () => { this.tip.hidden = true; },
      };
      if (!actions[event.key]) return;
      event.preventDefault();
      actions[event.key]();
    });
  }

  point(x, y) {
    const text = x >= this.left && x <= this.right ? this.what(x, y) : '';
    this.tip.hidden = !text;
    if (!text) return;
    this.tip.textContent = text;
    const tip = this.tip.getBoundingClientRect();
    this.tip.style.left = Math.max(0, Math.min(x + 14, this.width - tip.width)) + 'px';
    this.tip.style.top = y + 16 + 'px';
  }
}
