// The stabilisation diagram over the CMIF, and the choice of poles by hand.

const STATUS = ['alone', 'stable', 'chosen'];

function drawPoles(host) {
  ofTests(host, (test) => test.stabilization, (body, test) => new PolePicker(body, test));
}

class PolePicker {
  constructor(host, test) {
    this.test = test;
    this.own = test.stabilization;
    this.picked = new Set();
    this.at = null;
    this.indicator = [];
    this.plotHost = el('div');
    this.count = el('b', { class: 'count' });
    this.list = el('div', { class: 'scroll' });
    const command = el('code', {}, this.command());
    host.append(
      el('p', { class: 'note' }, this.source()),
      bar(button(T('Pick the chosen'), () => this.pickChosen()), button(T('Drop all'), () => this.change(() => this.picked.clear())),
        button(T('Save selection.json'), () => save('selection.json', 'application/json', this.json()), { class: 'main' }), this.count),
      this.plotHost,
      el('p', { class: 'note hint' }, T('Click a pole to pick it or to drop it. With the keyboard: arrows move, Enter picks.'), ' ', T('Save selection.json'), ', ', T('then'), ' ', command),
      this.list);
    this.plot = this.draw();
    this.told();
  }

  source() {
    const { own } = this;
    const text = `${T('Poles of')} ${own.method}, ${T('functions')}: ${own.functions}`;
    return own.own_method ? text : `${text}. ${T('The modes of the run, dotted, come from a method without model orders.')}`;
  }

  command() {
    const [lo, hi] = this.own.band_hz;
    const order = this.own.max_order ? ` --order ${this.own.max_order}` : '';
    return `modalign identify ${this.test.frf_file || 'FRF'} --method ${this.own.method}${order} --band ${lo}:${hi} --selection selection.json -o modes.json`;
  }

  draw() {
    const { own } = this;
    const series = STATUS.map((name, status) => {
      const index = own.status.map((value, k) => k).filter((k) => own.status[k] === status);
      return { name: T(name), status, kind: 'points', index, x: index.map((k) => own.hz[k]), y: index.map((k) => own.order[k]), color: [6, 0, 2][status], open: status === 0, size: [2, 3, 4][status], ...(status === 2 ? { rim: 'ink', bold: 1.6 } : {}) };
    });
    const orders = own.order.length ? [Math.min(...own.order), Math.max(...own.order)] : [0, 1];
    const pad = Math.max(1, 0.06 * (orders[1] - orders[0]));
    return new Plot(this.plotHost, {
      name: `${this.test.name}-stabilisation`, height: 460, series, marks: modeMarks(this.test), band: own.band_hz,
      label: T('Stabilisation'),
      x: { label: T('Frequency (Hz)'), min: own.band_hz[0], max: own.band_hz[1] },
      y: { label: T('Model order'), min: orders[0] - pad, max: orders[1] + pad },
      under: (plot, group) => this.under(plot, group),
      over: (plot, group) => this.over(plot, group),
      pick: (near) => { if (near && near.distance < 12) this.flip(near.series.index[near.k]); },
      key: (event) => this.key(event),
      tell: (near) => this.words(near.series.index[near.k]),
    });
  }

  words(k) {
    const { own } = this;
    return [`${digits(own.hz[k], 7)} Hz`, `${T('damping')} ${percent(own.damping[k])}`, `${T('order')} ${own.order[k]}, ${T(STATUS[own.status[k]])}`, this.picked.has(k) ? T('picked by hand') : ''].filter(Boolean);
  }

  /** The indicator behind the poles, on a logarithmic axis of its own at the right. */
  under(plot, group) {
    const { hz, values } = this.own.cmif;
    const all = values.flat().filter((value) => value > 0);
    if (!all.length) return;
    let [lo, hi] = [Infinity, -Infinity];
    for (const value of all) [lo, hi] = [Math.min(lo, value), Math.max(hi, value)];
    lo = Math.max(lo, hi * 1e-6);
    const [top, bottom] = [MARGIN.top, plot.o.height - MARGIN.bottom];
    const y = (value) => bottom - ((Math.log10(Math.max(value, lo)) - Math.log10(lo)) / (Math.log10(hi / lo) || 1)) * (bottom - top - 6);
    values.forEach((course, j) => {
      const path = course.map((value, k) => `${k ? 'L' : 'M'}${plot.sx(hz[k]).toFixed(1)} ${y(value).toFixed(1)}`).join('');
      group.append(svg('path', { d: path, fill: 'none', stroke: palette.axis, 'stroke-width': j ? 0.8 : 1.4, opacity: j ? 0.6 : 1 }));
    });
    // Numbers of modes are at the top, the name of the axis at the bottom; both are legible over
    // poles and curve.
    const told = logTicks(lo, hi).filter((tick) => tick.text).map((own) => [y(own.at) + 3, own.text]);
    this.indicator = [...told.filter(([at]) => at < bottom - 18), [bottom - 6, T('CMIF (m/(N s))')]];
  }

  over(plot, group) {
    const beside = { x: plot.width - MARGIN.right - 4, 'text-anchor': 'end', fill: palette.faint, stroke: palette.paper, 'stroke-width': 3, 'paint-order': 'stroke', 'font-size': 10 };
    for (const [y, text] of this.indicator) group.append(svg('text', { ...beside, y }, text));
    const ring = (k, attributes) => group.append(svg('circle', { cx: plot.sx(this.own.hz[k]), cy: plot.sy(this.own.order[k]), fill: 'none', ...attributes }));
    for (const k of this.picked) ring(k, { r: 6.5, stroke: palette.series[1], 'stroke-width': 2.2 });
    if (this.at !== null) ring(this.at, { r: 9, stroke: palette.ink, 'stroke-width': 1, 'stroke-dasharray': '2 2' });
  }

  /** Poles in the order of frequency, for the keyboard; those that stay before the others where there are some. */
  key(event) {
    const { own } = this;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const up = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!step && !up && event.key !== 'Enter' && event.key !== ' ') return false;
    if (event.key === 'Enter' || event.key === ' ') {
      if (this.at !== null) this.flip(this.at);
      return true;
    }
    const all = own.hz.map((value, k) => k).filter((k) => own.status[k] > 0 && !this.plot.hidden.has(T(STATUS[own.status[k]])));
    if (!all.length) return true;
    if (this.at === null) this.at = all.reduce((a, b) => (own.hz[b] < own.hz[a] ? b : a));
    else if (step) this.at = this.beside(all, step);
    else this.at = this.above(all, up);
    this.plot.draw();
    return true;
  }

  beside(all, step) {
    const { own } = this;
    const place = (k) => own.hz[k] + 1e-9 * own.order[k];
    const further = all.filter((k) => step * (place(k) - place(this.at)) > 1e-3 * own.damping[this.at] * own.hz[this.at] + 1e-12);
    return further.length ? further.reduce((a, b) => (step * (place(b) - place(a)) < 0 ? b : a)) : this.at;
  }

  above(all, up) {
    const { own } = this;
    const near = (k) => Math.abs(own.hz[k] - own.hz[this.at]) + 0.02 * own.hz[this.at] * Math.abs(own.order[k] - own.order[this.at]);
    const further = all.filter((k) => up * (own.order[k] - own.order[this.at]) > 0);
    return further.length ? further.reduce((a, b) => (near(b) < near(a) ? b : a)) : this.at;
  }

  flip(k) {
    this.change(() => {
      if (!this.picked.delete(k)) this.picked.add(k);
    });
  }

  /** Of each chosen mode the pole of the highest order. */
  pickChosen() {
    const { own } = this;
    this.change(() => {
      const chosen = own.hz.map((value, k) => k).filter((k) => own.status[k] === 2).sort((a, b) => own.order[b] - own.order[a]);
      const taken = [];
      for (const k of chosen) {
        const width = Math.max(2 * own.damping[k] * own.hz[k], 1e-6 * own.hz[k]);
        if (!taken.some((other) => Math.abs(own.hz[other] - own.hz[k]) < width)) taken.push(k);
      }
      taken.forEach((k) => this.picked.add(k));
    });
  }

  change(act) {
    act();
    this.plot.draw();
    this.told();
  }

  sorted() {
    return [...this.picked].sort((a, b) => this.own.hz[a] - this.own.hz[b]);
  }

  told() {
    this.count.textContent = `${this.picked.size} ${T('poles picked')}`;
    const { own } = this;
    const cell = (text) => el('td', { class: 'n' }, text);
    const rows = this.sorted().map((k) => el('tr', {}, cell(digits(own.hz[k], 7)), cell(percent(own.damping[k])), cell(String(own.order[k])), el('td', {}, button('×', () => this.flip(k), { 'aria-label': T('Drop all') }))));
    const head = [T('Frequency (Hz)'), T('damping'), T('order'), ''].map((text) => el('th', { class: 'n' }, text));
    this.list.replaceChildren(...(rows.length ? [el('table', {}, el('thead', {}, el('tr', {}, ...head)), el('tbody', {}, ...rows))] : []));
  }

  json() {
    const { own } = this;
    const poles = this.sorted().map((k) => ({ frequency_hz: own.hz[k], damping_ratio: own.damping[k], order: own.order[k] }));
    return `${JSON.stringify({ schema: 'modalign-selection/1', poles }, null, 2)}\n`;
  }
}
