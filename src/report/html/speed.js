// Speed and accuracy: time and error of every method, and errors over their Cramér-Rao bound
// against noise.

/** Replaces each `{}` of a sentence by a value, in order. */
function fill(text, ...values) {
  let next = 0;
  return text.replace(/\{\}/g, () => values[next++]);
}

/** Errors below this fraction of the accuracy limit are drawn at it: differences between them carry no information. */
const MIN_ERROR_OVER_LIMIT = 0.1;

const QUANTITIES = ['frequency', 'damping', 'shape'];

function drawSpeed(host) {
  const study = page.studies.speed;
  const body = el('div');
  const show = (index) => {
    const test = study.tests[index];
    body.replaceChildren(...madeUp(figures.tests.find((other) => other.name === test.name) || {}));
    choices(body, [T('Data'), [T('measured FRFs, against the refined solution'), T('synthetic twin, against its truth')]], [T('Error of'), [T('frequency'), T('damping'), T('shape')]], [T('Cost'), [T('CPU time'), T('Peak memory')]])
      .draw((place, picked) => costPlot(place, study, test, picked));
    body.append(el('p', { class: 'note' }, T('A dot in a mark: all observable modes found, no spurious mode. A ring: on the Pareto front of the results with the fewest missed and spurious modes. CPU time of one machine, all threads.')));
    const rows = study.rows.filter((row) => row.test === test.name && row.data.startsWith('twin, '));
    const conditions = CONDITIONS.filter((name) => rows.some((row) => row.data === `twin, ${name}`));
    if (!conditions.length) return;
    body.append(el('h4', {}, T('Error of the twin over its Cramér-Rao bound')));
    choices(body, [T('Data'), conditions.map((name) => T(name))], [T('Error of'), [T('frequency'), T('damping')]])
      .draw((place, [condition, quantity]) => boundPlot(place, rows.filter((row) => row.data === `twin, ${conditions[condition]}`), quantity));
    body.append(el('p', { class: 'note' }, T('Shaded: within 20 % of the bound. A dot in a mark: no missed and no spurious mode in any draw.')));
  };
  if (study.tests.length > 1) host.append(bar(choice(T('Test'), study.tests.map((test) => test.name), show)));
  host.append(body);
  if (study.tests.length) show(0);
}

/** The disturbances of the synthetic twins. */
const CONDITIONS = ['white noise', 'modes outside the band', 'record ends early'];

/** A row of labelled drop-down lists over a figure, which each selection redraws. */
function choices(host, ...lists) {
  const picked = lists.map(() => 0);
  const place = el('div');
  let paint = () => {};
  const again = () => {
    place.replaceChildren();
    paint(place, picked);
  };
  const select = ([label, items], k) => choice(label, items, (index) => {
    picked[k] = index;
    again();
  });
  host.append(bar(...lists.map(select)), place);
  return {
    draw(how) {
      paint = how;
      again();
    },
  };
}

/** Names of the methods with the number of their colour and mark. */
const numbered = (rows) => [...new Set(rows.map((row) => row.method))].map((name, number) => ({ name, number }));

const mistakes = (row) => row.observable - row.found + row.spurious;

/** Rows of one test with their times, on the data of the test or on the twin at the noise level at which costs are compared. */
function withTimes(study, test, onTwin) {
  const data = onTwin ? 'twin, white noise' : 'data';
  const rows = study.rows.filter((row) => row.test === test.name && row.data === data && (!onTwin || row.snr_db === study.snr_db));
  const times = study.times.filter((time) => time.test === test.name && time.data === (onTwin ? 'twin' : 'data'));
  const same = (row) => (time) => ['method', 'order', 'estimator', ...(onTwin ? [] : ['step_hz'])].every((key) => row[key] === time[key]);
  const limit = (name) => (times.find((time) => time.method === name) || {}).cpu_s;
  return { rows: rows.map((row) => ({ ...row, ...times.find(same(row)) })), transform: limit('one transform'), pass: limit('one pass') };
}

function costPlot(host, study, test, [onTwin, quantity, memory]) {
  const { rows, transform, pass } = withTimes(study, test, onTwin);
  const key = `${QUANTITIES[quantity]}_rms`;
  const cost = (row) => (memory ? row.peak_bytes / 2 ** 20 : 1e3 * row.cpu_s);
  const bounds = rows.map((row) => row[`${QUANTITIES[quantity]}_bound_rms`]).filter((value) => value > 0);
  const bound = onTwin ? Math.max(...bounds) : test[`refined_${QUANTITIES[quantity]}_std`];
  const limit = bound > 0 && Number.isFinite(bound) ? 100 * bound : null;
  // The refined solution has no error against itself.
  const shown = rows.filter((row) => row.refined !== 'yes' && cost(row) > 0 && row[key] !== undefined);
  const least = Math.min(...shown.map((row) => 100 * row[key]).filter((value) => value > 0), limit || Infinity);
  const floor = limit ? Math.max(least, MIN_ERROR_OVER_LIMIT * limit) : least;
  const y = (row) => Math.max(floor, 100 * row[key]);
  if (!shown.length || !Number.isFinite(floor)) {
    host.append(el('p', { class: 'note' }, T('Nothing was measured.')));
    return;
  }
  const times = memory ? [] : [transform, pass].filter((time) => time > 0).map((time) => 1e3 * time);
  const range = (values, wide) => [Math.min(...values) / wide, Math.max(...values) * wide];
  const xs = range([...shown.map(cost), ...times], 1.8);
  const ys = range([...shown.map(y), ...(limit ? [limit] : [])], 1.8);
  const series = numbered(study.rows).map(({ name, number }) => {
    const mine = shown.filter((row) => row.method === name);
    return { name, kind: 'points', mark: number, color: number, rows: mine, x: mine.map(cost), y: mine.map(y), dots: mine.map((row) => mistakes(row) === 0) };
  }).filter((entry) => entry.rows.length);
  const line = (name, x, y, style) => series.push({ name, quiet: true, color: 'ink', width: 1.2, x, y, ...style });
  const front = shown.filter((row) => row.on_front === 'yes').sort((a, b) => cost(a) - cost(b));
  // The Pareto front is computed from time and frequency error.
  const isFront = !memory && quantity === 0;
  if (isFront) line(T('Pareto front'), front.map(cost), front.map(y));
  const far = 1e4;
  if (limit) line(onTwin ? T('Cramér-Rao bound') : T('standard deviation of the refined solution'), [xs[0] / far, xs[1] * far], [limit, limit], { dash: '7 4' });
  if (!memory && transform) line(T('one transform'), [1e3 * transform, 1e3 * transform], [ys[0] / far, ys[1] * far], { dash: '2 3' });
  if (!memory && pass) line(T('one pass over the data'), [1e3 * pass, 1e3 * pass], [ys[0] / far, ys[1] * far], { dash: '2 3', color: 'faint' });
  new Plot(host, {
    name: `speed-accuracy-${test.name}`, height: 400, series, reach: 20,
    x: { label: memory ? T('Peak memory (MiB)') : T('CPU time (ms)'), log: true, min: xs[0], max: xs[1] },
    y: { label: [T('Frequency error, rms (%)'), T('Damping error, rms (%)'), T('Shape error √(1−MAC), rms (%)')][quantity], log: true, min: ys[0], max: ys[1] },
    over: (plot, group) => {
      for (const row of isFront ? front : []) {
        if (!plot.hidden.has(row.method)) group.append(svg('circle', { cx: plot.sx(cost(row)), cy: plot.sy(y(row)), r: 9, fill: 'none', stroke: palette.ink }));
      }
    },
    tell: (near) => costWords(near.series.rows[near.k], onTwin),
  });
  if (onTwin) host.append(el('p', { class: 'note' }, fill(T('The twin in white noise of {} dB.'), study.snr_db)));
}

const methodName = (row) => (row.order === undefined ? row.method : `${row.method} ${row.order}`);

function costWords(row, onTwin) {
  const from = onTwin ? [] : [fill(T('FRFs: {}, lines {} Hz apart'), row.estimator || '—', digits(row.step_hz, 4))];
  const errors = [['frequency', T('frequency')], ['damping', T('damping')], ['shape', T('shape')]].filter(([key]) => row[`${key}_rms`] !== undefined);
  return [
    methodName(row) + (row.on_front === 'yes' ? ` · ${T('Pareto front')}` : ''),
    ...from,
    `${T('CPU time')} ${digits(1e3 * row.cpu_s, 3)}${row.spread_s > 0 ? ` ± ${digits(1e3 * row.spread_s, 2)}` : ''} ms`,
    row.peak_bytes === undefined ? '' : `${T('Peak memory')} ${digits(row.peak_bytes / 2 ** 20, 3)} MiB`,
    `${T('error')}: ${errors.map(([key, name]) => `${name} ${percent(row[`${key}_rms`])}`).join(', ')}`,
    fill(T('{} of {} modes found, {} spurious'), row.found, row.observable, row.spurious),
  ].filter(Boolean);
}

function boundPlot(host, rows, quantity) {
  const key = `${QUANTITIES[quantity]}_over_bound`;
  const levels = rows.map((row) => row.snr_db);
  const series = [];
  for (const { name, number } of numbered(rows)) {
    const mine = rows.filter((row) => row.method === name).sort((a, b) => a.snr_db - b.snr_db);
    const [x, y] = [mine.map((row) => row.snr_db), mine.map((row) => row[key] ?? null)];
    series.push({ name, legend: false, quiet: true, color: number, x, y }, { name, kind: 'points', mark: number, color: number, rows: mine, x, y, dots: mine.map((row) => mistakes(row) === 0) });
  }
  const most = Math.max(10, ...rows.map((row) => row[key] ?? 0));
  new Plot(host, {
    name: `over-bound-${QUANTITIES[quantity]}`, height: 340, series, reach: 20,
    x: { label: T('Signal-to-noise ratio (dB)'), min: Math.min(...levels) - 2, max: Math.max(...levels) + 2 },
    y: { label: [T('Frequency error / bound'), T('Damping error / bound')][quantity], log: true, min: 0.4, max: 1.6 * most },
    under: (plot, group) => {
      const wide = plot.width - MARGIN.left - MARGIN.right;
      const [top, middle, bottom] = [1.2, 1, 0.8].map(plot.sy);
      group.append(svg('rect', { x: MARGIN.left, y: top, width: wide, height: bottom - top, fill: palette.grid }));
      group.append(svg('line', { x1: MARGIN.left, x2: MARGIN.left + wide, y1: middle, y2: middle, stroke: palette.ink, 'stroke-width': 0.8 }));
    },
    tell: (near) => {
      const row = near.series.rows[near.k];
      return [`${methodName(row)}, ${row.snr_db} dB`, fill(T('{} times the bound'), digits(row[key], 3)), fill(T('{} of {} modes found, {} spurious'), row.found, row.observable, row.spurious)];
    },
  });
}
