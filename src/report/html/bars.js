// Frequency errors by mode, modal energies, and the history of a model update.

/** Frequency error of each paired mode with its standard deviation, grouped by test; unmatched model modes as crosses on the lower edge. */
function drawErrors(host) {
  const { overview } = figures;
  if (!overview) return;
  const names = overview.tests.map((test) => test.test);
  const rows = overview.rows.filter((row) => row.theory_hz !== null && row.cells.some((cell) => cell.status !== 'outside-band'));
  if (!rows.length) return;
  const wide = 0.8 / names.length;
  const series = names.map((name, n) => {
    const cells = rows.map((row) => row.cells.find((cell) => cell.test === name));
    return {
      name, kind: 'bars', wide: 0.92 * wide, color: n, cells,
      x: rows.map((row, k) => k + 1 + (n - (names.length - 1) / 2) * wide),
      y: cells.map((cell) => (cell ? cell.error_percent : null)),
      error: cells.map((cell) => cell && cell.error_std_percent),
    };
  });
  const missed = { name: T('unmatched model mode'), kind: 'points', color: 7, edge: true, x: [], y: [], cells: [] };
  rows.forEach((row, k) => row.cells.forEach((cell) => {
    const n = names.indexOf(cell.test);
    if (cell.error_percent !== null || !['missed-expected', 'missed-unexpected'].includes(cell.status)) return;
    missed.x.push(k + 1 + (n - (names.length - 1) / 2) * wide);
    missed.y.push(0);
    missed.cells.push(cell);
  }));
  if (missed.x.length) series.push(missed);
  const every = Math.ceil(rows.length / (window.innerWidth < 600 ? 9 : 22));
  const ticks = rows.map((row, k) => ({ at: k + 1, main: true, text: k % every === 0 ? row.label : '' }));
  const label = overview.of_theory ? T('(test−theory)/theory (%), line ±1 std') : T('(theory−test)/test (%), line ±1 std');
  host.append(el('h3', {}, T('Frequency error by mode')));
  new Plot(host, {
    name: 'errors', height: 300, series, x: { label: T('Mode'), min: 0.4, max: rows.length + 0.6, ticks }, y: { label },
    over: (plot, group) => group.append(svg('line', { x1: MARGIN.left, x2: plot.width - MARGIN.right, y1: plot.sy(0), y2: plot.sy(0), stroke: palette.ink })),
    tell: (near) => {
      const row = rows[Math.round(near.x) - 1];
      const cell = near.series.cells[near.k];
      const lines = [`${row.label} · ${cell.test}`, `${T('theory')} ${digits(row.theory_hz, 6)} Hz`];
      if (cell.hz !== null) lines.push(`${T('test')} ${digits(cell.hz, 6)} Hz, ${signed(cell.error_percent)} %`);
      if (cell.mac !== null) lines.push(`MAC ${cell.mac.toFixed(3)}`);
      return lines.concat(cell.reasons.slice(0, 2));
    },
  });
}

/** Distribution of the energy of each mode over the components: one bar for kinetic, one for strain energy. */
function drawEnergies(host) {
  for (const [part, title] of [['kinetic', T('Kinetic energy')], ['strain', T('Strain energy')]]) {
    const modes = figures.energies.filter((mode) => mode[part].length);
    if (!modes.length) continue;
    const totals = new Map();
    modes.forEach((mode) => mode[part].forEach(([name, share]) => totals.set(name, (totals.get(name) || 0) + share)));
    const names = [...totals].sort((a, b) => b[1] - a[1]).map(([name]) => name);
    const shown = names.slice(0, 7);
    host.append(el('h3', {}, title));
    const color = (name) => (shown.includes(name) ? palette.series[shown.indexOf(name)] : palette.axis);
    const legend = [...shown, ...(names.length > 7 ? [T('other')] : [])];
    const key = el('div', { class: 'legend' });
    const list = el('div', { class: 'shares' });
    const fill = () => {
      key.replaceChildren(...legend.map((name) => el('span', { class: 'series' }, el('i', { style: `border-color:${color(name)}` }), name)));
      list.replaceChildren(...modes.map((mode) => {
        const row = el('div', { class: 'share', tabindex: '0', role: 'img', 'aria-label': `${digits(mode.hz, 5)} Hz: ${mode[part].map(([name, share]) => `${name} ${percent(share)}`).join(', ')}` });
        const sorted = [...mode[part]].sort((a, b) => names.indexOf(a[0]) - names.indexOf(b[0]));
        for (const [name, share] of sorted) {
          row.append(el('i', { class: share > 0.14 ? 'named' : null, style: `width:${100 * share}%;background:${color(name)};color:${inkOver(color(name))}`, onpointermove: (event) => tip.show(event.clientX, event.clientY, [name, percent(share)]), onpointerleave: () => tip.hide() }, share > 0.14 ? name : ''));
        }
        const label = mode.hz > 0 ? `${digits(mode.hz, 5)} Hz${mode.multiplicity > 1 ? ` (${mode.multiplicity}${T('-fold')})` : ''}` : T('rigid-body mode');
        return el('div', { class: 'root' }, el('span', { class: 'n' }, label), row, el('small', {}, mode.class || ''));
      }));
      // The tooltip alone shows a name that does not fit.
      for (const part of list.querySelectorAll('.named')) if (part.scrollWidth > part.clientWidth) part.textContent = '';
    };
    host.append(key, list);
    fill();
    drawings.add({ host: list, draw: fill });
  }
}

/** The objective of the update by iteration, and the frequency errors before and after. */
function drawUpdate(host) {
  const { update } = page;
  const history = update.history || [];
  if (history.length) {
    const steps = history.map((step, k) => ({ ...step, k: k + 1 }));
    const taken = steps.filter((step) => step.accepted);
    const rejected = steps.filter((step) => !step.accepted);
    const of = (all, key) => all.map((step) => step[key]);
    host.append(el('h3', {}, T('Objective of the update by iteration')));
    const series = [{ name: T('Objective'), x: of(taken, 'k'), y: of(taken, 'objective'), color: 0, width: 2 }, { name: 'χ²', x: of(taken, 'k'), y: of(taken, 'chi_square'), color: 1, dash: '5 3' }];
    const { chi_square: first } = update.before || {};
    if (first > 0) series.push({ name: T('χ² of the initial model'), x: [0.5, steps.length + 0.5], y: [first, first], color: 'faint', dash: '2 3', quiet: true });
    if (rejected.length) series.push({ name: T('rejected step'), kind: 'points', open: true, x: of(rejected, 'k'), y: of(rejected, 'objective'), color: 6 });
    new Plot(host, { name: 'update-history', height: 240, series, x: { label: T('Iteration'), min: 0.5, max: steps.length + 0.5, ticks: steps.filter((step, k) => k % Math.ceil(steps.length / 20) === 0).map((step) => ({ at: step.k, text: String(step.k), main: true })) }, y: { label: T('Objective'), log: true } });
  }
  const before = (update.before && update.before.rows) || [];
  const after = (update.after && update.after.rows) || [];
  if (!before.length) return;
  const bars = (name, rows, shift, color) => ({ name, kind: 'bars', wide: 0.36, color, x: rows.map((row, k) => k + 1 + shift), y: rows.map((row) => row.error_percent) });
  const { ticks, marks } = modesByTest(before.map((row) => row.label), host.clientWidth || 700);
  host.append(el('h3', {}, T('Frequency error by mode')));
  new Plot(host, {
    name: 'update-errors', height: 240, marks, series: [bars(T('before'), before, -0.2, 6), bars(T('after'), after, 0.2, 0)],
    x: { label: T('Mode'), min: 0.4, max: before.length + 0.6, ticks }, y: { label: T('Error (%)') },
    tell: (near) => {
      const k = Math.round(near.x) - 1;
      const errorLine = (name, row) => (row ? [`${name}: ${signed(row.error_percent, 3)} %`] : []);
      return [before[k].label, ...errorLine(T('before'), before[k]), ...errorLine(T('after'), after[k])];
    },
  });
}

/** Labels `test f3` as ticks `f3`, as many as have room, and a line with its name where a test begins. */
function modesByTest(labels, width) {
  const parts = labels.map((label) => label.match(/^(.*) (\S+)$/) || [label, '', label]);
  const room = Math.max(160, width - MARGIN.left - MARGIN.right) / labels.length;
  const every = Math.ceil(26 / room);
  const ticks = parts.map(([, , mode], k) => ({ at: k + 1, main: true, text: k % every === 0 ? mode : '' }));
  const starts = parts.map((part, k) => k).filter((k) => k === 0 || parts[k][1] !== parts[k - 1][1]);
  const marks = starts.length < 2 ? [] : starts.map((k, n) => {
    const letters = Math.floor((((starts[n + 1] ?? labels.length) - k) * room - 6) / 6);
    const name = parts[k][1];
    return { x: k + 0.5, text: name.length <= letters ? name : `${name.slice(0, Math.max(0, letters - 1))}…` };
  });
  return { ticks, marks };
}
