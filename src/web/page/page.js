// The live page of an app. The server sends events: `live`, twice a second, what `catan top --once --json` prints;
// `timeline`, once a second, which lanes had the CPUs in the last 30 s; `trouble`, why there is neither. All that the
// server sends is put into the page as text, never as HTML.
(() => {
  const kWindow = 30; // seconds of the timeline
  const kAgain = 3000; // ms until the next try, if the browser has given up
  const kBusy = 1000; // ms until the next try, if another question is being answered
  const kMaxTries = 10;

  const at = (id) => document.getElementById(id);
  let live = null;
  let timeline = null;
  let source = null;
  let paused = false;
  let colours = {};
  let again = 0;

  // ---- Text and elements

  const known = (value) => value !== null && value !== undefined;
  function figure(value, unit = '') {
    if (!known(value)) return '-';
    const text = Math.abs(value) >= 1000 ? value.toFixed(0) : String(Number(value.toPrecision(4)));
    return unit ? text + ' ' + unit : text;
  }
  const percent = (value) => (known(value) ? Math.round(value * 100) + ' %' : '-');
  const summary = (value, key) => (value ? figure(value[key]) : '-');
  function duration(seconds) {
    if (seconds < 60) return seconds.toFixed(0) + ' s';
    if (seconds < 3600) return Math.floor(seconds / 60) + ' min ' + Math.floor(seconds % 60) + ' s';
    return Math.floor(seconds / 3600) + ' h ' + Math.floor((seconds % 3600) / 60) + ' min';
  }

  function element(tag, text, type) {
    const made = document.createElement(tag);
    if (text !== undefined) made.textContent = text;
    if (type) made.className = type;
    return made;
  }
  // Text that stays the same is not replaced: it may be selected, or being read out.
  function setText(place, text) {
    if (place.textContent !== text) place.textContent = text;
  }
  function setClass(place, type) {
    if (place.className !== type) place.className = type;
  }
  function children(place, count, make) {
    while (place.children.length > count) place.lastElementChild.remove();
    while (place.children.length < count) place.append(make(place.children.length));
    return place.children;
  }

  // columns: [title, is a number]; rows: cells, of which the first is a heading; a cell is text, or [text, class].
  function table(place, columns, rows) {
    if (!place.tHead) {
      const row = place.createTHead().insertRow();
      for (const [title, number] of columns) {
        const cell = element('th', title, number ? 'number' : '');
        cell.scope = 'col';
        row.append(cell);
      }
      place.createTBody();
    }
    const body = place.tBodies[0];
    children(body, rows.length, () => element('tr'));
    rows.forEach((row, index) => {
      const cells = children(body.rows[index], row.length, (column) => {
        const cell = element(column === 0 ? 'th' : 'td');
        if (column === 0) cell.scope = 'row';
        return cell;
      });
      row.forEach((content, column) => {
        const [text, type] = Array.isArray(content) ? content : [content, ''];
        setText(cells[column], text);
        setClass(cells[column], [columns[column][1] ? 'number' : '', type].filter(Boolean).join(' '));
      });
    });
  }

  // ---- Canvases

  function readColours() {
    const style = getComputedStyle(document.documentElement);
    for (const name of ['ink', 'muted', 'line', 'track', 'accent', 'bound', 'promised', 'expected', 'mark']) {
      colours[name] = style.getPropertyValue('--' + name).trim();
    }
  }

  // Ready to be drawn on, in CSS pixels.
  function prepare(canvas, height) {
    const width = canvas.clientWidth;
    const scale = window.devicePixelRatio || 1;
    const wide = Math.round(width * scale);
    const high = Math.round(height * scale);
    if (canvas.width !== wide || canvas.height !== high) {
      canvas.width = wide;
      canvas.height = high;
      canvas.style.height = height + 'px';
    }
    const g = canvas.getContext('2d');
    g.setTransform(scale, 0, 0, scale, 0, 0);
    g.clearRect(0, 0, width, height);
    g.font = '12px Inter, "Segoe UI", Roboto, Arial, sans-serif';
    g.textBaseline = 'middle';
    return [g, width];
  }

  function label(canvas, text) {
    if (canvas.getAttribute('aria-label') !== text) canvas.setAttribute('aria-label', text);
  }

  function level(g, y, width, colour, dash) {
    g.strokeStyle = colour;
    g.lineWidth = 1.4;
    g.setLineDash(dash);
    g.beginPath();
    g.moveTo(0, y);
    g.lineTo(width, y);
    g.stroke();
    g.setLineDash([]);
  }

  // The worst response of each of the last 60 s, beside what was asked and promised.
  function drawChain(canvas, chain) {
    const height = 84;
    const [g, width] = prepare(canvas, height);
    const axis = 34;
    const levels = [chain.bound_ms, chain.promised_ms, chain.expected_ms].filter(known);
    const top = Math.max(1e-6, ...chain.worst_ms.filter(known), ...levels) * 1.1;
    const y = (value) => height - 4 - (value / top) * (height - 10);
    g.fillStyle = colours.muted;
    g.textAlign = 'left';
    g.fillText(figure(top / 1.1), 0, Math.max(8, y(top / 1.1)));
    g.fillText('0', 0, height - 8);
    g.save();
    g.translate(axis, 0);
    const room = width - axis;
    if (known(chain.bound_ms)) level(g, y(chain.bound_ms), room, colours.bound, []);
    if (known(chain.promised_ms)) level(g, y(chain.promised_ms), room, colours.promised, [7, 4]);
    if (known(chain.expected_ms)) level(g, y(chain.expected_ms), room, colours.expected, [2, 3]);
    const step = room / chain.worst_ms.length;
    g.fillStyle = colours.accent;
    chain.worst_ms.forEach((value, index) => {
      if (!known(value)) return;
      g.fillStyle = known(chain.bound_ms) && value > chain.bound_ms ? colours.bound : colours.accent;
      g.fillRect(index * step + 0.5, y(value), Math.max(1, step - 1), height - 4 - y(value));
    });
    g.restore();
    label(canvas, 'Worst response time of each of the last 60 seconds, up to ' + figure(top / 1.1, 'ms'));
  }

  function drawTimeline() {
    if (!timeline) return;
    const canvas = at('timeline');
    const row = 46;
    const head = 20;
    const cpus = timeline.cpus;
    const height = head + Math.max(1, cpus.length) * row;
    const [g, width] = prepare(canvas, height);
    const left = width < 500 ? 44 : 64;
    const steps = kWindow * 1000 / timeline.step_ms;
    const wide = (width - left) / steps;
    const x = (seconds) => width - (timeline.until_s - seconds) / kWindow * (width - left);
    g.fillStyle = colours.muted;
    g.textAlign = 'center';
    for (let second = 0; second <= kWindow; second += 5) {
      const place = x(timeline.until_s - second);
      g.textAlign = second === 0 ? 'right' : second === kWindow ? 'left' : 'center';
      g.fillText(second === 0 ? 'now' : '-' + second + ' s', place, 8);
      g.fillStyle = colours.line;
      g.fillRect(place, head - 3, 1, height);
      g.fillStyle = colours.muted;
    }
    cpus.forEach((cpu, index) => {
      const low = head + (index + 1) * row - 6;
      const tall = row - 10;
      g.fillStyle = colours.track;
      g.fillRect(left, low - tall, width - left, tall);
      g.fillStyle = colours.ink;
      g.textAlign = 'left';
      g.fillText(known(cpu.cpu) ? 'CPU ' + cpu.cpu : 'CPU ?', 0, low - tall / 2);
      const base = new Float64Array(steps);
      for (const { lane, permille } of cpu.busy) {
        g.fillStyle = colourOf(lane);
        const first = steps - permille.length;
        permille.forEach((share, step) => {
          if (share === 0) return;
          const from = base[first + step];
          const to = Math.min(1, from + share / 1000);
          base[first + step] = to;
          const x0 = Math.round(left + (first + step) * wide);
          const x1 = Math.round(left + (first + step + 1) * wide);
          g.fillRect(x0, low - to * tall, Math.max(1, x1 - x0), (to - from) * tall);
        });
      }
    });
    g.strokeStyle = colours.mark;
    g.setLineDash([4, 3]);
    for (const notice of live ? live.notices : []) {
      if (notice.kind !== 'plan' || notice.at_s < timeline.until_s - kWindow) continue;
      g.beginPath();
      g.moveTo(x(notice.at_s), head);
      g.lineTo(x(notice.at_s), height);
      g.stroke();
    }
    g.setLineDash([]);
    label(canvas, 'Busy shares of ' + cpus.length + ' CPUs in the last 30 seconds; the table below has them as figures');
    const seen = new Set();
    for (const cpu of cpus) for (const { lane } of cpu.busy) seen.add(lane);
    const lanes = [...seen].sort((a, b) => a - b);
    const items = children(at('lanes'), lanes.length, () => {
      const item = element('span');
      item.append(element('span', '', 'swatch'), document.createTextNode(''));
      return item;
    });
    lanes.forEach((lane, index) => {
      const [swatch, name] = items[index].childNodes;
      swatch.style.background = colourOf(lane);
      if (name.data !== timeline.lanes[lane]) name.data = timeline.lanes[lane];
    });
  }

  // ---- The parts of the page

  function facts() {
    const plan = live.plan;
    const all = [
      ['Scheduler', live.scheduler + (live.real_time ? '' : ', rates only')],
      ['Up', duration(live.up_s)],
      ['CPUs', live.cpus.join(', ')],
      ['Objective, measured', figure(live.objective, 'ms')],
      ['Objective, planned', plan ? figure(plan.objective, 'ms') : '-'],
      ['Plan', plan ? plan.reason + ', ' + duration(Math.max(0, live.up_s - plan.at_s)) + ' ago' : 'none'],
      ['Plans made', figure(live.plans_made) + ' in ' + figure(live.planning_ms, 'ms')],
      ['CPUs kept from it', live.starved ? live.starved + ' times, ' + figure(live.starved_ms, 'ms') : 'never'],
    ];
    if (plan && plan.relax_factor !== 1) all.push(['Bounds relaxed by', figure(plan.relax_factor)]);
    const tiles = children(at('facts'), all.length, () => {
      const tile = element('div');
      tile.append(element('dt'), element('dd'));
      return tile;
    });
    all.forEach(([name, value], index) => {
      setText(tiles[index].children[0], name);
      setText(tiles[index].children[1], value);
    });
  }

  function chains() {
    setText(at('chains-caption'), 'Figures of the last ' + figure(live.window_s) + ' s, in ms; bars: the worst of each ' +
      'second of the last minute. Solid line: the bound; dashes: promised; dots: expected.');
    const cards = children(at('chains'), live.chains.length, () => {
      const card = element('article', undefined, 'card');
      const body = element('div', undefined, 'card-body');
      const text = element('p');
      text.append(element('strong'), document.createTextNode(''));
      const canvas = element('canvas');
      canvas.setAttribute('role', 'img');
      body.append(text, canvas);
      card.append(element('h3'), body);
      return card;
    });
    live.chains.forEach((chain, index) => {
      const card = cards[index];
      setText(card.children[0], chain.path);
      const [text, canvas] = card.children[1].children;
      setText(text.firstChild, figure(chain.newest_ms, 'ms'));
      setClass(text.firstChild, known(chain.bound_ms) && chain.newest_ms > chain.bound_ms ? 'bad' : '');
      const parts = [];
      if (chain.response_ms) {
        parts.push('mean ' + summary(chain.response_ms, 'mean') + ', p95 ' + summary(chain.response_ms, 'p95') +
          ', p99 ' + summary(chain.response_ms, 'p99') + ', max ' + summary(chain.response_ms, 'max'));
      } else {
        parts.push('no response');
      }
      if (known(chain.expected_ms)) parts.push('expected ' + figure(chain.expected_ms));
      if (known(chain.promised_ms)) parts.push('promised ' + figure(chain.promised_ms));
      if (known(chain.bound_ms)) parts.push('bound ' + figure(chain.bound_ms) + ', ' + chain.over_bound + ' over it');
      parts.push('weight ' + figure(chain.weight));
      const causes = Object.entries(chain.late_by).map(([cause, count]) => cause + ' ' + count);
      if (causes.length) parts.push('why late: ' + causes.join(', '));
      const line = ' now; ' + parts.join('; ');
      if (text.lastChild.data !== line) text.lastChild.data = line;
      drawChain(canvas, chain);
    });
  }

  function tables() {
    table(at('cores'), [['CPU'], ['Shared'], ['Frame ms', true], ['Busy', true], ['For']], live.cores.map((core) => [
      known(core.cpu) ? String(core.cpu) : '?', core.sharing, figure(core.frame_ms), percent(core.busy),
      core.uses.map((use) => use.name + ' ' + percent(use.cores)).join(', ') || '-',
    ]));
    table(at('subchains'), [['Subchain'], ['Cores'], ['Priority', true], ['Runs', true], ['Period ms', true],
      ['expected', true], ['CPU time ms', true], ['p95', true], ['budget', true], ['Execution p95 ms', true],
      ['promised', true], ['Late', true], ['Over budget', true], ['Stole', true]],
    live.subchains.map((one) => [
      one.subchain, one.cores.join(', ') || '-',
      figure(one.priority), figure(one.runs), summary(one.period_ms, 'mean'), figure(one.expected_period_ms),
      summary(one.used_ms, 'mean'), summary(one.used_ms, 'p95'), figure(one.budget_ms),
      summary(one.execution_ms, 'p95'), figure(one.promised_execution_ms),
      [figure(one.late), one.late > 0 ? 'bad' : ''], [figure(one.overruns), one.overruns > 0 ? 'bad' : ''],
      figure(one.stole),
    ]));
    table(at('nodes'), [['Node'], ['Subchain'], ['Hz', true], ['expected', true], ['CPU time ms', true], ['p95', true],
      ['Waits ms', true], ['Cores', true]],
    live.nodes.map((node) => [
      node.node, node.subchain === null ? 'unscheduled' : node.subchain, figure(node.rate_hz), figure(node.expected_hz),
      summary(node.compute_ms, 'mean'), summary(node.compute_ms, 'p95'), summary(node.wait_ms, 'mean'),
      figure(node.cores),
    ]));
    const newest = live.notices.slice(-40).reverse();
    table(at('notices'), [['At s', true], ['Kind'], ['What']],
      newest.length ? newest.map((notice) => [notice.at_s.toFixed(2), notice.kind, notice.detail])
        : [['-', '-', 'no notices']]);
  }

  function status() {
    const place = at('status');
    const running = live.state === 'running';
    setText(place, running ? 'It runs' + (live.note ? '; ' + live.note : '') + '.'
      : { stalled: 'Its scheduler has shown no sign of life for ' + figure(live.silent_ms / 1000, 's') + '.',
        ended: 'It has ended. The figures are of its last seconds.',
        killed: 'Its scheduler was killed. The figures are of its last seconds.' }[live.state] || live.state);
    setClass(place, running ? '' : 'trouble');
  }

  function show() {
    if (!live || paused || document.hidden) return;
    document.body.classList.remove('stale');
    at('shown').hidden = false;
    setText(at('app'), live.app);
    document.title = live.app + ' - Catan';
    status();
    facts();
    chains();
    tables();
    changing.refresh();
    supposing.refresh();
    drawTimeline();
  }

  function trouble(text) {
    setText(at('status'), text);
    setClass(at('status'), 'trouble');
    document.body.classList.add('stale');
  }

  // ---- Changes

  const kinds = [
    { name: 'Weight of a response time', unit: 'Weight', from: () => live.chains.map((chain) => chain.path),
      now: (name) => live.chains.find((chain) => chain.path === name).weight,
      change: (name, value) => ({ weights: [[name, value]] }) },
    { name: 'Bound of a response time', unit: 'ms, or none', none: true,
      from: () => live.chains.map((chain) => chain.path),
      now: (name) => live.chains.find((chain) => chain.path === name).bound_ms,
      change: (name, value) => ({ maxes: [[name, value]] }) },
    { name: 'Weight of a period', unit: 'Weight',
      from: () => live.nodes.filter((node) => known(node.weight)).map((node) => node.node),
      now: (name) => live.nodes.find((node) => node.node === name).weight,
      change: (name, value) => ({ weights: [[name, value]] }) },
    { name: 'Lowest rate of a node', unit: 'Hz, or none', none: true,
      from: () => live.nodes.filter((node) => node.subchain !== null).map((node) => node.node),
      now: () => '', change: (name, value) => ({ min_rates: [[name, value]] }) },
    { name: 'CPUs', unit: 'such as 0,1', list: true, from: () => ['all nodes'], now: () => live.cpus.join(','),
      change: (name, value) => ({ cpus: value }) },
  ];
  // What can be supposed, but not changed; then all that can be changed.
  const suppositions = [
    { name: 'Compute time of a node', unit: 'such as x2, or 5ms', text: true, only: true,
      from: () => live.nodes.map((node) => node.node), now: () => 'x2',
      change: (name, value) => ({ costs: { [name]: value } }) },
    { name: 'Number of cores', unit: 'such as 4', only: true, from: () => ['all nodes'],
      now: () => live.cpus.length, change: (name, value) => ({ cores: value }) },
    ...kinds,
  ];

  // Three fields, whose ids begin alike: what to change, of which subject, and the new value.
  class Chooser {
    constructor(begin, choices) {
      [this.what, this.subject, this.value, this.valueName] = ['what', 'subject', 'value', 'value-name']
        .map((id) => at(begin + id));
      this.choices = choices;
      this.what.append(...choices.map((choice) => new Option(choice.name)));
      this.what.addEventListener('change', () => {
        this.subject.replaceChildren();
        this.refresh();
      });
      this.subject.addEventListener('change', () => this.present());
    }
    get kind() {
      return this.choices[this.what.selectedIndex];
    }
    // Brings the list of subjects up to date.
    refresh() {
      if (!live) return;
      const names = this.kind.from();
      const place = this.subject;
      if (place.options.length === names.length && names.every((name, i) => place.options[i].text === name)) return;
      const before = place.value;
      place.replaceChildren(...names.map((name) => new Option(name)));
      if (names.includes(before)) place.value = before;
      this.present();
    }
    // Shows the present value.
    present() {
      setText(this.valueName, this.kind.unit);
      const name = this.subject.value;
      const value = name && live ? this.kind.now(name) : '';
      this.value.value = known(value) ? value : 'none';
    }
    // The value in the field; undefined: it is not valid.
    chosen() {
      const text = this.value.value.trim();
      const value = this.kind.none && text === 'none' ? null
        : this.kind.text ? text
          : this.kind.list ? text.split(',').map((one) => (/^\s*\d+\s*$/.test(one) ? Number(one) : NaN))
            : text === '' ? NaN : Number(text);
      return text === '' || [value].flat().some(Number.isNaN) ? undefined : value;
    }
  }
  const changing = new Chooser('', kinds);
  const supposing = new Chooser('if-', suppositions);

  function answer(place, text, bad) {
    setText(place, text);
    setClass(place, bad ? 'trouble' : '');
  }

  // The server's answer; if it refuses, why.
  async function post(path, body, headers) {
    try {
      const response = await fetch(path, {
        method: 'POST',
        headers: { ...headers, 'Content-Type': 'application/json' },
        body: JSON.stringify(body),
      });
      const said = await response.json();
      if (response.ok) return { said };
      return { why: said.error + '; ' + said.hint + '.', busy: response.status === 429 };
    } catch {
      return { why: 'The server of this page does not answer.' };
    }
  }

  async function change(body, place, done = 'Done.') {
    sessionStorage.setItem('token', at('token').value);
    answer(place, 'Asking.', false);
    const { why } = await post('control/change', body, { 'Authorization': 'Bearer ' + at('token').value.trim() });
    answer(place, why || done, Boolean(why));
  }

  async function apply(event) {
    event.preventDefault();
    const value = changing.chosen();
    if (value === undefined) return answer(at('answer'), 'That is not a valid value (' + changing.kind.unit + ').', true);
    await change(changing.kind.change(changing.subject.value, value), at('answer'));
  }

  async function prepareChanges() {
    const response = await fetch('control');
    if (!(await response.json()).allowed) return;
    at('token').value = sessionStorage.getItem('token') || '';
    at('form').addEventListener('submit', apply);
    at('change').hidden = false;
    at('if-apply').addEventListener('click', () => change(asked(supposed.filter((one) => !one.kind.only)),
      at('if-answer'), supposed.some((one) => one.kind.only)
        ? 'Done, except for compute times and the number of cores, which cannot be changed.' : 'Done.'));
    showSupposed();
  }

  // ---- What if

  let supposed = []; // kind, subject, value
  let asking = 0; // how many questions were asked: only the answer to the last one counts

  // All that is supposed, as one question.
  function asked(list) {
    const all = {};
    for (const { kind, subject, value } of list) {
      for (const [key, part] of Object.entries(kind.change(subject, value))) {
        if (key === 'costs') all[key] = { ...all[key], ...part };
        else if (Array.isArray(part) && key !== 'cpus') all[key] = [...(all[key] || []), ...part];
        else all[key] = part;
      }
    }
    return all;
  }

  function showSupposed() {
    at('supposed').replaceChildren(...supposed.map((one) => {
      const item = element('li');
      const value = one.value === null ? 'none' : [one.value].flat().join(',');
      const text = one.kind.name + (one.subject === 'all nodes' ? '' : ' ' + one.subject) + ': ' + value;
      const remove = element('button', 'Remove');
      remove.type = 'button';
      remove.setAttribute('aria-label', 'Remove: ' + text);
      remove.addEventListener('click', () => {
        supposed = supposed.filter((other) => other !== one);
        showSupposed();
        supposing.value.focus();
        if (supposed.length) ask();
        else forgetAnswer();
      });
      item.append(element('span', text), remove);
      return item;
    }));
    at('if-apply').hidden = at('change').hidden || supposed.every((one) => one.kind.only);
  }

  function forgetAnswer() {
    ++asking;
    at('if-shown').hidden = true;
    answer(at('if-answer'), '', false);
  }

  const place = (one) => (one.cores.length ? one.cores.join(', ') : '-');
  const turn = (one) => (known(one.priority) ? 'p' + one.priority : known(one.share) ? 'x' + figure(one.share) : 'own');

  function showAnswer(said) {
    const { now, then } = said;
    const parts = [then.feasible ? 'All bounds hold as promised' : 'Bounds do not hold: they are relaxed by ' +
      figure(then.relax_factor) + ' (' + then.relaxed.map((bound) => bound.bound + ' ' + figure(bound.asked_ms) +
      ' to ' + figure(bound.planned_ms, 'ms')).join(', ') + ')'];
    parts.push('planned for ' + (then.cores === 1 ? 'one core' : then.cores + ' cores') + ', objective ' + figure(then.objective, 'ms') +
      (now ? ', now ' + figure(now.objective, 'ms') : ''));
    if (said.assumed.length) parts.push('have not run, so that their costs are a guess: ' + said.assumed.join(', '));
    answer(at('if-answer'), parts.join('; ') + '.', !then.feasible);
    const of = (one, key) => (one ? figure(one[key]) : '-');
    table(at('if-chains'), [['Response time'], ['Expected ms, now', true], ['expected, then', true],
      ['Promised ms, now', true], ['promised, then', true], ['Bound ms', true]],
    said.chains.map((chain) => [
      chain.path, of(chain.now, 'expected_ms'), of(chain.then, 'expected_ms'), of(chain.now, 'promised_ms'),
      [of(chain.then, 'promised_ms'), known(chain.bound_ms) && chain.then.promised_ms > chain.bound_ms ? 'bad' : ''],
      figure(chain.bound_ms),
    ]));
    table(at('if-subchains'), [['Subchain'], ['Period ms, now', true], ['period, then', true], ['Core, now', true],
      ['core, then', true], ['Priority or share, now', true], ['priority or share, then', true]],
    said.subchains.map((one) => [
      one.subchain, of(one.now, 'period_ms'), of(one.then, 'period_ms'), one.now ? place(one.now) : '-',
      place(one.then), one.now ? turn(one.now) : '-', turn(one.then),
    ]));
    at('if-shown').hidden = false;
  }

  async function ask() {
    const mine = ++asking;
    answer(at('if-answer'), 'Planning.', false);
    at('if-shown').hidden = true;
    for (let tries = 0; mine === asking; ++tries) {
      const { said, why, busy } = await post('whatif', asked(supposed), {});
      if (mine !== asking) return;
      if (said) return showAnswer(said);
      if (!busy || tries === kMaxTries) return answer(at('if-answer'), why, true);
      await new Promise((resolve) => setTimeout(resolve, kBusy));
    }
  }

  at('whatif').addEventListener('submit', (event) => {
    event.preventDefault();
    const kind = supposing.kind;
    const subject = supposing.subject.value;
    const value = supposing.chosen();
    if (value === undefined) return answer(at('if-answer'), 'That is not a valid value (' + kind.unit + ').', true);
    supposed = supposed.filter((one) => one.kind !== kind || one.subject !== subject);
    supposed.push({ kind, subject, value });
    showSupposed();
    ask();
  });

  // ---- Events

  function disconnect() {
    clearTimeout(again);
    if (source) source.close();
    source = null;
  }

  function connect() {
    disconnect();
    source = new EventSource('events');
    source.addEventListener('live', (event) => {
      live = JSON.parse(event.data);
      requestAnimationFrame(show);
    });
    source.addEventListener('timeline', (event) => {
      timeline = JSON.parse(event.data);
    });
    source.addEventListener('trouble', (event) => {
      const said = JSON.parse(event.data);
      trouble(said.error + '; ' + said.hint + '.');
    });
    source.addEventListener('error', () => {
      trouble('The server of this page does not answer; trying again.');
      if (source && source.readyState === EventSource.CLOSED) again = setTimeout(connect, kAgain);
    });
  }

  readColours();
  window.matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => {
    readColours();
    show();
  });
  window.addEventListener('resize', () => requestAnimationFrame(show));
  at('pause').addEventListener('click', () => {
    paused = !paused;
    at('pause').setAttribute('aria-pressed', String(paused));
    show();
  });
  // A page that is not visible costs nothing: it closes the stream.
  document.addEventListener('visibilitychange', () => {
    if (document.hidden) disconnect();
    else connect();
  });
  prepareChanges().catch(() => {});
  connect();
})();
