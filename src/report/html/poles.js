// The stabilization diagram over the CMIF, and the selection of poles by hand.

const STATUS = ['unstable', 'stable', 'selected'];

function drawPoles(host) {
  ofTests(host, (test) => test.stabilization, (body, test) => new PolePicker(body, test));
}

class PolePicker {
  constructor(host, test) {
    this.test = test;
    this.diagram = test.stabilization;
    this.picked = new Set();
    this.at = null;
    this.indicator = [];
    this.plotHost = el('div');
    this.count = el('b', { class: 'count' });
    this.list = el('div', { class: 'scroll' });
    const command = el('code', {}, this.command());
    host.append(
      el('p', { class: 'note' }, this.source()),
      bar(button(T('Pick the selected poles'), () => this.pickSelected()), button(T('Drop all'), () => this.change(() => this.picked.clear())),
        button(T('Save selection.json'), () => save('selection.json', 'application/json', this.json()), { class: 'main' }), this.count),
      this.plotHost,
      el('p', { class: 'note hint' }, T('Click a pole to pick it or to drop it. With the keyboard: arrows move, Enter picks.'), ' ', T('Save selection.json'), ', ', T('then'), ' ', command),
      this.list);
    this.plot = this.draw();
    this.showPicked();
  }

  source() {
    const { diagram } = this;
    const text = `${T('Poles of')} ${diagram.method}, ${T('FRFs')}: ${diagram.functions}`;
    return diagram.own_method ? text : `${text}. ${T('The modes of the run, dotted, come from a method without model orders.')}`;
  }

  command() {
    const [lo, hi] = this.diagram.band_hz;
    const order = this.diagram.max_order ? ` --order ${this.diagram.max_order}` : '';
    return `modalign identify ${this.test.frf_file || 'FRF'} --method ${this.diagram.method}${order} --band ${lo}:${hi} --selection selection.json -o modes.json`;
  }

  draw() {
    const { diagram } = this;
    const series = STATUS.map((name, status) => {
      const index = diagram.status.map((value, k) => k).filter((k) => diagram.status[k] === status);
      return { name: T(name), status, kind: 'points', index, x: index.map((k) => diagram.hz[k]), y: index.map((k) => diagram.order[k]), color: [6, 0, 2][status], open: status === 0, size: [2, 3, 4][status], ...(status === 2 ? { rim: 'ink', bold: 1.6 } : {}) };
    });
    const orders = diagram.order.length ? [Math.min(...diagram.order), Math.max(...diagram.order)] : [0, 1];
    const pad = Math.max(1, 0.06 * (orders[1] - orders[0]));
    return new Plot(this.plotHost, {
      name: `${this.test.name}-stabilization`, height: 460, series, marks: modeMarks(this.test), band: diagram.band_hz,
      label: T('Stabilization diagram'),
      x: { label: T('Frequency (Hz)'), min: diagram.band_hz[0], max: diagram.band_hz[1] },
      y: { label: T('Model order'), min: orders[0] - pad, max: orders[1] + pad },
      under: (plot, group) => this.under(plot, group),
      over: (plot, group) => this.over(plot, group),
      pick: (near) => { if (near && near.distance < 12) this.flip(near.series.index[near.k]); },
      key: (event) => this.key(event),
      tell: (near) => this.words(near.series.index[near.k]),
    });
  }

  words(k) {
    const { diagram } = this;
    return [`${digits(diagram.hz[k], 7)} Hz`, `${T('damping')} ${percent(diagram.damping[k])}`, `${T('order')} ${diagram.order[k]}, ${T(STATUS[diagram.status[k]])}`, this.picked.has(k) ? T('picked by hand') : ''].filter(Boolean);
  }

  /** The CMIF behind the poles, with a logarithmic axis at the right. */
  under(plot, group) {
    const { hz, values } = this.diagram.cmif;
    const all = values.flat().filter((value) => value > 0);
    if (!all.length) return;
    let [lo, hi] = [Infinity, -Infinity];
    for (const value of all) [lo, hi] = [Math.min(lo, value), Math.max(hi, value)];
    lo = Math.max(lo, hi * 1e-6);
    const [top, bottom] = [MARGIN.top, plot.o.height - MARGIN.bottom];
    const y = (value) => bottom - ((Math.log10(Math.max(value, lo)) - Math.log10(lo)) / (Math.log10(hi / lo) || 1)) * (bottom - top - 6);
    values.forEach((curve, j) => {
      const path = curve.map((value, k) => `${k ? 'L' : 'M'}${plot.sx(hz[k]).toFixed(1)} ${y(value).toFixed(1)}`).join('');
      group.append(svg('path', { d: path, fill: 'none', stroke: palette.axis, 'stroke-width': j ? 0.8 : 1.4, opacity: j ? 0.6 : 1 }));
    });
    // The numbers of modes are at the top and the name of the axis at the bottom, legible over
    // poles and curves.
    const labels = logTicks(lo, hi).filter((tick) => tick.text).map((tick) => [y(tick.at) + 3, tick.text]);
    this.indicator = [...labels.filter(([at]) => at < bottom - 18), [bottom - 6, T('CMIF (m/(N s))')]];
  }

  over(plot, group) {
    const style = { x: plot.width - MARGIN.right - 4, 'text-anchor': 'end', fill: palette.faint, stroke: palette.paper, 'stroke-width': 3, 'paint-order': 'stroke', 'font-size': 10 };
    for (const [y, text] of this.indicator) group.append(svg('text', { ...style, y }, text));
    const ring = (k, attributes) => group.append(svg('circle', { cx: plot.sx(this.diagram.hz[k]), cy: plot.sy(this.diagram.order[k]), fill: 'none', ...attributes }));
    for (const k of this.picked) ring(k, { r: 6.5, stroke: palette.series[1], 'stroke-width': 2.2 });
    if (this.at !== null) ring(this.at, { r: 9, stroke: palette.ink, 'stroke-width': 1, 'stroke-dasharray': '2 2' });
  }

  /** Keyboard: the arrows move along the visible stable and selected poles, by frequency or by model order. */
  key(event) {
    const { diagram } = this;
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    const up = { ArrowUp: 1, ArrowDown: -1 }[event.key];
    if (!step && !up && event.key !== 'Enter' && event.key !== ' ') return false;
    if (event.key === 'Enter' || event.key === ' ') {
      if (this.at !== null) this.flip(this.at);
      return true;
    }
    const all = diagram.hz.map((value, k) => k).filter((k) => diagram.status[k] > 0 && !this.plot.hidden.has(T(STATUS[diagram.status[k]])));
    if (!all.length) return true;
    if (this.at === null) this.at = all.reduce((a, b) => (diagram.hz[b] < diagram.hz[a] ? b : a));
    else if (step) this.at = this.neighbour(all, step);
    else this.at = this.above(all, up);
    this.plot.draw();
    return true;
  }

  neighbour(all, step) {
    const { diagram } = this;
    const place = (k) => diagram.hz[k] + 1e-9 * diagram.order[k];
    const further = all.filter((k) => step * (place(k) - place(this.at)) > 1e-3 * diagram.damping[this.at] * diagram.hz[this.at] + 1e-12);
    return further.length ? further.reduce((a, b) => (step * (place(b) - place(a)) < 0 ? b : a)) : this.at;
  }

  above(all, up) {
    const { diagram } = this;
    const near = (k) => Math.abs(diagram.hz[k] - diagram.hz[this.at]) + 0.02 * diagram.hz[this.at] * Math.abs(diagram.order[k] - diagram.order[this.at]);
    const further = all.filter((k) => up * (diagram.order[k] - diagram.order[this.at]) > 0);
    return further.length ? further.reduce((a, b) => (near(b) < near(a) ? b : a)) : this.at;
  }

  flip(k) {
    this.change(() => {
      if (!this.picked.delete(k)) this.picked.add(k);
    });
  }

  /** Picks the selected pole of the highest model order of each mode. */
  pickSelected() {
    const { diagram } = this;
    this.change(() => {
      const selected = diagram.hz.map((value, k) => k).filter((k) => diagram.status[k] === 2).sort((a, b) => diagram.order[b] - diagram.order[a]);
      const taken = [];
      for (const k of selected) {
        const width = Math.max(2 * diagram.damping[k] * diagram.hz[k], 1e-6 * diagram.hz[k]);
        if (!taken.some((other) => Math.abs(diagram.hz[other] - diagram.hz[k]) < width)) taken.push(k);
      }
      taken.forEach((k) => this.picked.add(k));
    });
  }

  change(act) {
    act();
    this.plot.draw();
    this.showPicked();
  }

  sorted() {
    return [...this.picked].sort((a, b) => this.diagram.hz[a] - this.diagram.hz[b]);
  }

  showPicked() {
    this.count.textContent = `${this.picked.size} ${T('poles picked')}`;
    const { diagram } = this;
    const cell = (text) => el('td', { class: 'n' }, text);
    const rows = this.sorted().map((k) => el('tr', {}, cell(digits(diagram.hz[k], 7)), cell(percent(diagram.damping[k])), cell(String(diagram.order[k])), el('td', {}, button('×', () => this.flip(k), { 'aria-label': T('Drop all') }))));
    const head = [T('Frequency (Hz)'), T('damping'), T('order'), ''].map((text) => el('th', { class: 'n' }, text));
    this.list.replaceChildren(...(rows.length ? [el('table', {}, el('thead', {}, el('tr', {}, ...head)), el('tbody', {}, ...rows))] : []));
  }

  json() {
    const { diagram } = this;
    const poles = this.sorted().map((k) => ({ frequency_hz: diagram.hz[k], damping_ratio: diagram.damping[k], order: diagram.order[k] }));
    return `${JSON.stringify({ schema: 'modalign-selection/1', poles }, null, 2)}\n`;
  }
}
