// One plot: axes with ticks, lines and marks, zoom, values under the pointer, saving as SVG or PNG.

/** Marks that distinguish series without colour: circle, square, triangle, diamond, cross, plus, triangle upside down. */
const MARKS = ['M-4 0a4 4 0 1 0 8 0a4 4 0 1 0 -8 0Z', 'M-3.6 -3.6h7.2v7.2h-7.2Z', 'M0 -4.6L4.3 3.4H-4.3Z', 'M0 -5L5 0L0 5L-5 0Z', 'M-3.5 -3.5L3.5 3.5M3.5 -3.5L-3.5 3.5', 'M0 -4.6V4.6M-4.6 0H4.6', 'M0 4.6L4.3 -3.4H-4.3Z'];

const MARGIN = { left: 72, right: 22, top: 10, bottom: 40 };

/** Ticks of a linear axis: steps of 1, 2 or 5 powers of ten. Numbers are in units of a power of ten, which the label of the axis states. */
function linearTicks(lo, hi, count, unit = 0) {
  const raw = (hi - lo) / Math.max(1, count);
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= raw * 0.85) || 10);
  const decimals = Math.max(0, unit - Math.floor(Math.log10(step) + 1e-9));
  const ticks = [];
  for (let n = Math.ceil(lo / step - 1e-9); n * step <= hi + 1e-9 * step; n++) {
    const value = n * step * 10 ** -unit;
    ticks.push({ at: n * step, text: (n === 0 ? 0 : value).toFixed(Math.min(12, decimals)).replace('-', '−'), main: true });
  }
  return ticks;
}

/** The common power of ten of the numbers of a linear axis: 0 where they are short without one. */
function commonPower(lo, hi) {
  const largest = Math.max(Math.abs(lo), Math.abs(hi));
  if (!(largest > 0) || (largest >= 1e-2 && largest < 1e5)) return 0;
  return Math.floor(Math.log10(largest) + 1e-9);
}

const raised = (n) => String(n).replace(/./g, (c) => '⁰¹²³⁴⁵⁶⁷⁸⁹⁻'['0123456789-'.indexOf(c)]);

/** The label of an axis with the power of ten of its numbers before the unit. */
function labelWith(label, power) {
  if (!power) return label;
  const ten = `10${raised(power)}`;
  const unit = label.match(/ \((.*)\)$/);
  return unit ? `${label.slice(0, unit.index)} (${ten} ${unit[1]})` : `${label} (${ten})`;
}

/** Ticks of a logarithmic axis: powers of ten, and 2 to 9 between them, labelled where there is room. */
function logTicks(lo, hi) {
  const [first, last] = [Math.floor(Math.log10(lo)), Math.ceil(Math.log10(hi))];
  const decades = Math.log10(hi / lo);
  const every = Math.max(1, Math.ceil(decades / 7));
  const ticks = [];
  for (let n = first; n <= last; n++) {
    for (let m = 1; m < 10; m++) {
      const at = m * 10 ** n;
      if (at < lo * (1 - 1e-9) || at > hi * (1 + 1e-9)) continue;
      const main = m === 1;
      const labelled = main ? n % every === 0 : decades < 1.2 || (decades < 2.2 && (m === 2 || m === 5));
      if (main || decades < 8) ticks.push({ at, main, text: labelled ? power(m, n) : '' });
    }
  }
  if (decades > 0.7 && ticks.filter((tick) => tick.text).length > 1) return ticks;
  return linearTicks(lo, hi, 5).map((tick) => ({ ...tick, text: digits(tick.at, 3) }));
}

function power(m, n) {
  if (n >= -3 && n <= 5) return Number((m * 10 ** n).toPrecision(3)).toString();
  return `${m === 1 ? '' : `${m}·`}10${raised(n)}`;
}

/**
 * A plot in an element. Options: `x`, `y` = {label, log, min, max}; `series` = [{name, x, y, kind: 'line' | 'points' | 'bars', color,
 * dash, size, hidden, error, edge, mark, dots, rim, bold, legend}]; `marks` = vertical lines [{x, text}]; `band` = [lo, hi] that is not shaded; `height`; `name` for files;
 * `link` shares the range of x with other plots; `equal` gives both axes one scale; `under(plot, group)` and `over` draw more;
 * `pick(nearest)` is called with a point that was clicked; `tell(nearest)` gives the lines of the tooltip, `at(x, y)` those where no point
 * is within `reach` pixels. A colour is a number of the palette, a name in it, or as it is.
 */
class Plot {
  constructor(host, options) {
    this.o = { height: 260, series: [], marks: [], reach: 40, ...options };
    this.host = host;
    this.range = { x: null, y: null };
    this.hidden = new Set(this.o.series.filter((series) => series.hidden).map((series) => series.name));
    this.frame = el('div', { class: 'plot' });
    this.svg = svg('svg', { tabindex: '0', role: 'img', 'aria-label': `${this.o.label || this.o.y.label}. ${T('drag to zoom, double-click to reset; with the keyboard + − 0 and the arrows')}` });
    this.legend = el('div', { class: 'legend' });
    this.frame.append(this.svg);
    host.append(this.frame);
    if (this.o.legend !== false) host.append(this.tools());
    this.listen();
    if (this.o.link) this.o.link.add(this);
    drawings.add(this);
    this.draw();
  }

  tools() {
    const name = this.o.name || 'figure';
    const zoom = (factor) => () => this.zoom(factor);
    return el('div', { class: 'under' }, this.legend, el('span', { class: 'tools' },
      button('+', zoom(0.6), { title: T('Zoom in'), 'aria-label': T('Zoom in') }),
      button('−', zoom(1 / 0.6), { title: T('Zoom out'), 'aria-label': T('Zoom out') }),
      button('⟲', () => this.reset(), { title: T('Reset'), 'aria-label': T('Reset') }),
      button('SVG', () => save(`${name}.svg`, 'image/svg+xml', this.text())),
      button('PNG', () => this.png(`${name}.png`))));
  }

  shown() {
    return this.o.series.filter((series) => !this.hidden.has(series.name));
  }

  /** The whole range of an axis. */
  whole(axis) {
    const options = this.o[axis];
    if (options.min !== undefined && options.max !== undefined) return [options.min, options.max];
    let [lo, hi] = [Infinity, -Infinity];
    for (const series of this.shown()) {
      const inX = axis === 'y' && this.range.x;
      series[axis].forEach((value, k) => {
        if (value === null || !Number.isFinite(value) || (options.log && value <= 0)) return;
        if (inX && (series.x[k] < this.range.x[0] || series.x[k] > this.range.x[1])) return;
        const spread = axis === 'y' && series.error && series.error[k] ? series.error[k] : 0;
        lo = Math.min(lo, value - spread);
        hi = Math.max(hi, value + spread);
      });
      if (series.kind === 'bars' && axis === 'y') [lo, hi] = [Math.min(lo, 0), Math.max(hi, 0)];
    }
    if (!(lo <= hi)) [lo, hi] = options.log ? [1, 10] : [0, 1];
    if (options.log) return [options.min ?? lo / 1.5, options.max ?? hi * 1.5];
    const pad = axis === 'y' || this.o.equal ? 0.06 * (hi - lo || Math.abs(hi) || 1) : 0;
    return [options.min ?? lo - pad, options.max ?? hi + pad];
  }

  /** The scale from values to pixels. */
  scale(axis) {
    const { log } = this.o[axis];
    const [lo, hi] = this.range[axis] || this.whole(axis);
    const f = log ? Math.log10 : (value) => value;
    const back = log ? (value) => 10 ** value : (value) => value;
    const [from, to] = axis === 'x' ? [MARGIN.left, this.width - MARGIN.right] : [this.o.height - MARGIN.bottom, MARGIN.top];
    const unit = (to - from) / (f(hi) - f(lo) || 1);
    const to_pixel = (value) => from + (f(value) - f(lo)) * unit;
    to_pixel.back = (pixel) => back(f(lo) + (pixel - from) / unit);
    to_pixel.range = [lo, hi];
    return to_pixel;
  }

  /** Widens one axis so that both have one scale. */
  equalise() {
    const spans = { x: this.width - MARGIN.left - MARGIN.right, y: this.o.height - MARGIN.top - MARGIN.bottom };
    const ranges = { x: this.range.x || this.whole('x'), y: this.range.y || this.whole('y') };
    const per = Math.max((ranges.x[1] - ranges.x[0]) / spans.x, (ranges.y[1] - ranges.y[0]) / spans.y);
    for (const axis of ['x', 'y']) {
      const middle = (ranges[axis][0] + ranges[axis][1]) / 2;
      this.range[axis] = [middle - (per * spans[axis]) / 2, middle + (per * spans[axis]) / 2];
    }
  }

  draw() {
    this.width = Math.max(260, this.frame.clientWidth || 640);
    if (this.o.equal) this.equalise();
    const { width } = this;
    const { height } = this.o;
    this.svg.replaceChildren();
    for (const [key, value] of Object.entries({ viewBox: `0 0 ${width} ${height}`, width, height, 'font-family': 'system-ui, sans-serif', 'font-size': 11 })) this.svg.setAttribute(key, value);
    this.sx = this.scale('x');
    this.sy = this.scale('y');
    this.svg.append(svg('rect', { width, height, fill: palette.paper }));
    this.shade();
    this.axes();
    const clip = `clip${Plot.count++}`;
    const defs = svg('clipPath', { id: clip });
    defs.append(svg('rect', { x: MARGIN.left, y: MARGIN.top, width: width - MARGIN.left - MARGIN.right, height: height - MARGIN.top - MARGIN.bottom }));
    const inside = svg('g', { 'clip-path': `url(#${clip})` });
    this.svg.append(defs, inside);
    if (this.o.under) this.o.under(this, inside);
    this.marks(inside);
    this.shown().forEach((series) => this.line(inside, series));
    if (this.o.over) this.o.over(this, inside);
    this.cursor = svg('g', { 'pointer-events': 'none' });
    this.svg.append(this.cursor);
    if (this.o.legend !== false) this.labels();
  }

  shade() {
    if (!this.o.band) return;
    const [left, right] = [MARGIN.left, this.width - MARGIN.right];
    const inside = (pixel) => Math.max(left, Math.min(right, pixel));
    const [a, b] = this.o.band.map((hz) => inside(this.sx(Math.max(hz, this.sx.range[0]))));
    for (const [from, to] of [[left, a], [b, right]]) {
      if (to > from) this.svg.append(svg('rect', { x: from, y: MARGIN.top, width: to - from, height: this.o.height - MARGIN.top - MARGIN.bottom, fill: palette.band }));
    }
  }

  axes() {
    const { height } = this.o;
    const [left, right, top, bottom] = [MARGIN.left, this.width - MARGIN.right, MARGIN.top, height - MARGIN.bottom];
    const ticks = (axis, count) => {
      const [lo, hi] = this[`s${axis}`].range;
      if (this.o[axis].ticks) return this.o[axis].ticks.filter((tick) => tick.at >= lo && tick.at <= hi);
      return this.o[axis].log ? logTicks(lo, hi) : linearTicks(lo, hi, count, unit(axis));
    };
    const unit = (axis) => (this.o[axis].log || this.o[axis].ticks ? 0 : commonPower(...this[`s${axis}`].range));
    const label = (axis) => labelWith(this.o[axis].label, unit(axis));
    const edge = (attributes) => this.svg.append(svg('line', attributes));
    for (const tick of ticks('x', this.width / (this.width < 500 ? 65 : 90))) {
      const x = this.sx(tick.at);
      edge({ x1: x, x2: x, y1: top, y2: bottom, stroke: palette.grid, 'stroke-width': tick.main ? 1 : 0.5 });
      if (tick.text) this.svg.append(svg('text', { x, y: bottom + 15, fill: palette.faint, 'text-anchor': 'middle' }, tick.text));
    }
    for (const tick of ticks('y', height / 45)) {
      const y = this.sy(tick.at);
      edge({ x1: left, x2: right, y1: y, y2: y, stroke: palette.grid, 'stroke-width': tick.main ? 1 : 0.5 });
      if (tick.text) this.svg.append(svg('text', { x: left - 6, y: y + 4, fill: palette.faint, 'text-anchor': 'end' }, tick.text));
    }
    this.svg.append(svg('rect', { x: left, y: top, width: right - left, height: bottom - top, fill: 'none', stroke: palette.axis }));
    this.svg.append(svg('text', { x: (left + right) / 2, y: height - 6, fill: palette.ink, 'text-anchor': 'middle', 'font-size': 12 }, label('x')));
    const middle = (top + bottom) / 2;
    this.svg.append(svg('text', { x: 13, y: middle, fill: palette.ink, 'text-anchor': 'middle', 'font-size': 12, transform: `rotate(-90 13 ${middle})` }, label('y')));
  }

  marks(group) {
    let before = -Infinity;
    for (const mark of this.o.marks) {
      const x = this.sx(mark.x);
      group.append(svg('line', { x1: x, x2: x, y1: MARGIN.top, y2: this.o.height - MARGIN.bottom, stroke: palette.faint, 'stroke-width': 0.8, 'stroke-dasharray': '2 3' }));
      if (mark.text && x - before > 14 && x > MARGIN.left) {
        group.append(svg('text', { x: x + 3, y: MARGIN.top + 11, fill: palette.faint }, mark.text));
        before = x;
      }
    }
  }

  color(series) {
    return typeof series.color === 'string' ? palette[series.color] || series.color : palette.series[(series.color ?? this.o.series.indexOf(series)) % palette.series.length];
  }

  line(group, series) {
    const { sx, sy } = this;
    const color = this.color(series);
    if (series.kind === 'points' || series.kind === 'bars') return this.points(group, series, color);
    let path = '';
    let open = false;
    series.x.forEach((value, k) => {
      const y = series.y[k];
      const legal = y !== null && Number.isFinite(y) && !(this.o.y.log && y <= 0) && !(this.o.x.log && value <= 0);
      const jump = series.wraps && open && Math.abs(y - series.y[k - 1]) > 180;
      if (legal) path += `${open && !jump ? 'L' : 'M'}${sx(value).toFixed(1)} ${sy(y).toFixed(1)}`;
      open = legal;
    });
    const attributes = { d: path, fill: 'none', stroke: color, 'stroke-width': series.width || 1.4, 'stroke-linejoin': 'round' };
    if (series.dash) attributes['stroke-dasharray'] = series.dash;
    group.append(svg('path', attributes));
    return null;
  }

  /** Pixel of a value; a mark of `edge` stands on the lower edge of the frame, whatever its value. */
  high(series, y) {
    return series.edge ? this.o.height - MARGIN.bottom - 6 : this.sy(y);
  }

  /** Whether a value can be drawn; a logarithmic axis has no 0. */
  drawable(y) {
    return y !== null && Number.isFinite(y) && !(this.o.y.log && y <= 0);
  }

  points(group, series, color) {
    const { sx, sy } = this;
    const bars = series.kind === 'bars';
    const zero = bars ? sy(Math.max(0, this.sy.range[0])) : 0;
    series.x.forEach((value, k) => {
      const y = series.y[k];
      if (!this.drawable(y)) return;
      const [px, py] = [sx(value), this.high(series, y)];
      if (bars) {
        const half = Math.min(22, (series.wide * (sx(1) - sx(0))) / 2);
        group.append(svg('rect', { x: px - half, width: Math.max(1, 2 * half), y: Math.min(py, zero), height: Math.max(1, Math.abs(py - zero)), fill: color, rx: 1.5 }));
      } else if (series.edge) {
        group.append(svg('path', { d: `M${px - 4} ${py - 4}l8 8M${px + 4} ${py - 4}l-8 8`, fill: 'none', stroke: color, 'stroke-width': 1.5 }));
      } else if (series.mark !== undefined) {
        group.append(svg('path', { d: MARKS[series.mark % MARKS.length], transform: `translate(${px} ${py})`, fill: palette.paper, stroke: color, 'stroke-width': 1.6 }));
        if (series.dots && series.dots[k]) group.append(svg('circle', { cx: px, cy: py, r: 1.9, fill: color }));
      } else {
        group.append(svg('circle', { cx: px, cy: py, ...this.dot(series, color) }));
      }
      if (series.error && series.error[k]) {
        const [a, b] = [sy(y - series.error[k]), sy(y + series.error[k])];
        group.append(svg('path', { d: `M${px} ${a}V${b}M${px - 3} ${a}h6M${px - 3} ${b}h6`, stroke: palette.ink, 'stroke-width': 1, fill: 'none' }));
      }
    });
    return null;
  }

  labels() {
    const item = (series) => {
      const on = !this.hidden.has(series.name);
      const flip = () => {
        if (on) this.hidden.add(series.name);
        else this.hidden.delete(series.name);
        this.draw();
      };
      return el('button', { type: 'button', class: 'series', 'aria-pressed': String(on), onclick: flip }, this.swatch(series), series.name);
    };
    this.legend.replaceChildren(...this.o.series.filter((series) => series.name && series.legend !== false).map(item));
  }

  /** The sample of a series in the legend: a piece of its line, or its mark. */
  swatch(series) {
    const color = this.color(series);
    if (series.kind !== 'points') return el('i', { style: `border-color:${color};border-style:${!series.dash ? 'solid' : series.dash.startsWith('2') ? 'dotted' : 'dashed'}` });
    const icon = svg('svg', { viewBox: '-7 -7 14 14', width: 14, height: 14 });
    const mark = series.edge ? MARKS[4] : MARKS[series.mark % MARKS.length];
    if (mark) icon.append(svg('path', { d: mark, fill: 'none', stroke: color, 'stroke-width': 1.6 }));
    else icon.append(svg('circle', this.dot(series, color)));
    return icon;
  }

  /** A dot of a series. */
  dot(series, color) {
    return { r: series.size || 2.5, fill: series.open ? 'none' : color, stroke: series.rim ? palette[series.rim] : color, 'stroke-width': series.bold || 1 };
  }

  /** The point nearest to a pixel: by x alone, or by distance for points. */
  nearest(px, py) {
    let best = null;
    for (const series of this.shown()) {
      if (series.quiet) continue;
      const flat = series.kind === 'points' || this.o.equal;
      series.x.forEach((value, k) => {
        const y = series.y[k];
        if (!this.drawable(y)) return;
        const [dx, dy] = [this.sx(value) - px, this.high(series, y) - py];
        const distance = flat ? Math.hypot(dx, dy) : Math.abs(dx) + 0.02 * Math.abs(dy);
        if (!best || distance < best.distance) best = { distance, series, k, x: value, y };
      });
    }
    return best && best.distance < this.o.reach ? best : null;
  }

  hover(px, py, clientX, clientY) {
    const near = this.nearest(px, py);
    this.cursor.replaceChildren();
    if (!near) {
      const inside = px > MARGIN.left && px < this.width - MARGIN.right && py > MARGIN.top && py < this.o.height - MARGIN.bottom;
      return inside && this.o.at ? tip.show(clientX, clientY, this.o.at(this.sx.back(px), this.sy.back(py))) : tip.hide();
    }
    const [x, y] = [this.sx(near.x), this.high(near.series, near.y)];
    if (!this.o.equal && near.series.kind !== 'points') this.cursor.append(svg('line', { x1: x, x2: x, y1: MARGIN.top, y2: this.o.height - MARGIN.bottom, stroke: palette.faint, 'stroke-width': 0.7 }));
    this.cursor.append(svg('circle', { cx: x, cy: y, r: 4.5, fill: 'none', stroke: palette.ink, 'stroke-width': 1.5 }));
    return tip.show(clientX, clientY, this.o.tell ? this.o.tell(near) : this.seriesValues(near));
  }

  /** The values of all lines at the x of the nearest point. */
  seriesValues(near) {
    const lines = [`${this.o.x.label}: ${digits(near.x, 7)}`];
    for (const series of this.shown()) {
      const k = series === near.series ? near.k : series.x.indexOf(near.x);
      if (k >= 0 && series.y[k] !== null && series.name) lines.push(`${series.name}: ${digits(series.y[k], 4)}`);
    }
    return lines;
  }

  place(event) {
    const box = this.svg.getBoundingClientRect();
    return [((event.clientX - box.left) * this.width) / box.width, ((event.clientY - box.top) * this.o.height) / box.height];
  }

  listen() {
    let from = null;
    let box = null;
    const node = this.svg;
    node.addEventListener('pointermove', (event) => {
      const [x, y] = this.place(event);
      if (!from) return this.hover(x, y, event.clientX, event.clientY);
      tip.hide();
      if (!box) this.svg.append((box = svg('rect', { fill: palette.series[0], opacity: 0.15 })));
      const whole = !this.o.equal && Math.abs(y - from[1]) < 25;
      const [y1, y2] = whole ? [MARGIN.top, this.o.height - MARGIN.bottom] : [from[1], y];
      for (const [key, value] of Object.entries({ x: Math.min(x, from[0]), y: Math.min(y1, y2), width: Math.abs(x - from[0]), height: Math.abs(y2 - y1) })) box.setAttribute(key, value);
      box.whole = whole;
      return null;
    });
    node.addEventListener('pointerdown', (event) => {
      if (event.pointerType === 'touch' || event.button !== 0) return;
      from = this.place(event);
      node.setPointerCapture(event.pointerId);
    });
    node.addEventListener('pointerup', (event) => {
      const to = this.place(event);
      const drawn = box;
      if (box) box.remove();
      [box, from] = [null, from && [...from]];
      const start = from;
      from = null;
      if (start && drawn && Math.abs(to[0] - start[0]) > 6) this.select(start, to, drawn.whole);
      else if (this.o.pick) this.o.pick(this.nearest(...to));
    });
    node.addEventListener('pointerleave', () => {
      tip.hide();
      this.cursor.replaceChildren();
    });
    node.addEventListener('dblclick', () => this.reset());
    node.addEventListener('keydown', (event) => this.key(event));
  }

  select(from, to, whole) {
    const sorted = (axis, a, b) => [this[`s${axis}`].back(a), this[`s${axis}`].back(b)].sort((p, q) => p - q);
    const x = sorted('x', from[0], to[0]);
    if (!whole) this.range.y = sorted('y', from[1], to[1]);
    this.setX(x);
  }

  /** Gives this plot and those linked with it a range of x; `null` is the whole. */
  setX(range) {
    const all = this.o.link ? [...this.o.link] : [this];
    for (const plot of all) {
      plot.range.x = range && [...range];
      if (!range) plot.range.y = null;
      plot.draw();
      if (plot.o.zoomed) plot.o.zoomed(range);
    }
  }

  reset() {
    this.range = { x: null, y: null };
    this.setX(null);
  }

  zoom(factor, shift = 0) {
    const { log } = this.o.x;
    const f = log ? Math.log10 : (value) => value;
    const back = log ? (value) => 10 ** value : (value) => value;
    const [lo, hi] = this.sx.range.map(f);
    const half = ((hi - lo) / 2) * factor;
    const middle = (lo + hi) / 2 + shift * (hi - lo);
    if (this.o.equal) {
      const [a, b] = this.sy.range;
      this.range.y = [(a + b) / 2 - ((b - a) / 2) * factor, (a + b) / 2 + ((b - a) / 2) * factor];
    }
    this.setX([back(middle - half), back(middle + half)]);
  }

  key(event) {
    if (this.o.key && this.o.key(event)) {
      event.preventDefault();
      return;
    }
    const acts = { '+': () => this.zoom(0.6), '=': () => this.zoom(0.6), '-': () => this.zoom(1 / 0.6), 0: () => this.reset(), Escape: () => this.reset(), ArrowLeft: () => this.zoom(1, -0.2), ArrowRight: () => this.zoom(1, 0.2) };
    if (acts[event.key] && !event.ctrlKey && !event.metaKey) {
      event.preventDefault();
      acts[event.key]();
    }
  }

  /** The figure as the text of an SVG file. */
  text() {
    const copy = this.svg.cloneNode(true);
    copy.setAttribute('xmlns', 'http://www.w3.org/2000/svg');
    return `<?xml version="1.0" encoding="UTF-8"?>\n${new XMLSerializer().serializeToString(copy)}\n`;
  }

  png(name) {
    const image = new Image();
    image.onload = () => {
      const canvas = el('canvas', { width: 3 * this.width, height: 3 * this.o.height });
      canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
      canvas.toBlob((blob) => save(name, 'image/png', blob));
    };
    image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(this.text())}`;
  }
}
Plot.count = 0;
