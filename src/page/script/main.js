// Makes the charts, and connects the controls outside them.

function around(at, length) {
  show(at - length / 2, at + length / 2);
}

function nextEvent(direction) {
  const middle = (view.from + view.to) / 2;
  const times = runs.flatMap((run) => run.events.map((event) => event.at)).sort((a, b) => a - b);
  const next = direction > 0 ? times.find((at) => at > middle + 1) : times.reverse().find((at) => at < middle - 1);
  if (next === undefined) return;
  const length = Math.min(view.to - view.from, duration / 20);
  view.from = next - length / 2; // not clamped, so that it is in the middle and the one after it is next
  view.to = next + length / 2;
  redraw();
}

function fillGoto() {
  const select = document.getElementById('goto');
  const option = (text, from, to, group) => {
    const element = document.createElement('option');
    element.textContent = text;
    element.value = from + ' ' + to;
    (group || select).append(element);
  };
  option('Go to …', 0, duration);
  option('the beginning', 0, Math.min(duration, 1e6));
  runs.forEach((run) => {
    const of = runs.length > 1 ? run.name + ': ' : '';
    for (const chain of run.chains) {
      if (!chain.worst.length) continue;
      const group = document.createElement('optgroup');
      group.label = of + 'worst of ' + chain.name;
      for (const [end, ms] of chain.worst) {
        option(msText(ms) + ' at ' + timeText(end, 1e7), end - ms * 1000 * 1.25, end + ms * 250, group);
      }
      select.append(group);
    }
    const plans = run.events.filter((event) => event.kind === 'plan');
    if (!plans.length) return;
    const group = document.createElement('optgroup');
    group.label = of + 'changes of plan';
    for (const event of plans.slice(0, 30)) {
      const reason = event.text.replace('plan: ', '');
      option(reason + ' at ' + timeText(event.at, 1e7), event.at - 2e5, event.at + 2e5, group);
    }
    select.append(group);
  });
  select.addEventListener('change', () => {
    const [from, to] = select.value.split(' ').map(Number);
    show(from, to);
    select.selectedIndex = 0;
  });
}

const kinds = { cores: Cores, response: Responses, compute: Compute };
readColours();
for (const place of document.querySelectorAll('.panel')) panels.push(new kinds[place.dataset.kind](place));
fillGoto();
const actions = { in: () => zoom(0.5), out: () => zoom(2), left: () => move(-0.3), right: () => move(0.3),
  all: () => show(0, duration) };
for (const button of document.querySelectorAll('[data-do]')) {
  button.addEventListener('click', actions[button.dataset.do]);
}
for (const button of document.querySelectorAll('[data-from]')) {
  button.addEventListener('click', () => {
    show(Number(button.dataset.from), Number(button.dataset.to));
    document.getElementById('cores').scrollIntoView();
  });
}
matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => { readColours(); redraw(); });
for (const details of document.querySelectorAll('details')) details.addEventListener('toggle', redraw);
for (const panel of panels) panel.paint();
redraw();
