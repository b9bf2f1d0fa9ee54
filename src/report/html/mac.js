// The MAC as a labelled heat map.

function drawMac(host) {
  ofTests(host, (test) => test.mac, (body, test) => new MacMap(body, test));
}

/** A MAC below 1 is not written as 1. */
function macText(value, decimals) {
  return (value < 1 ? Math.min(value, 1 - 10 ** -decimals) : value).toFixed(decimals);
}

class MacMap {
  constructor(host, test) {
    this.test = test;
    this.matrix = test.mac;
    this.host = el('div', { class: 'plot' });
    this.svg = svg('svg', { role: 'img', tabindex: '0', 'aria-label': `MAC: ${T('test')} × ${T('theory')}` });
    this.host.append(this.svg);
    host.append(this.host, el('div', { class: 'under' },
      el('span', { class: 'note' }, `MAC = |a^H b|²/(a^H a · b^H b), ${this.matrix.dofs} ${T('degrees of freedom')}; □ ${T('pair')}${this.matrix.still ? `; ${this.matrix.still} ${T('modes of the theory without motion at the sensors are not shown')}` : ''}`),
      el('span', { class: 'tools' }, button('SVG', () => save(`${test.name}-mac.svg`, 'image/svg+xml', this.text())), button('PNG', () => this.png(`${test.name}-mac.png`)))));
    const notes = [];
    if (this.matrix.pairs.some(([i]) => this.repeated(i))) notes.push(T('a box of a repeated root has the MAC of one of its vectors; the comparison has that of their subspace'));
    if (this.matrix.mac.some((row) => row.includes(null))) notes.push(T('crossed out: no MAC, because no common degree of freedom moves'));
    if (notes.length) host.append(el('p', { class: 'note' }, notes.join('; ')));
    this.svg.addEventListener('pointermove', (event) => this.hover(event));
    this.svg.addEventListener('pointerleave', () => tip.hide());
    this.svg.addEventListener('keydown', (event) => this.key(event));
    this.at = null;
    drawings.add(this);
    this.draw();
  }

  /** Whether a test mode is paired with several modes of the theory. */
  repeated(i) {
    return this.matrix.pairs.filter((pair) => pair[0] === i).length > 1;
  }

  draw() {
    const { mac, test_hz: rows, theory_hz: columns } = this.matrix;
    const margin = { left: 86, top: 12, right: 74, bottom: 76 };
    const room = Math.max(240, (this.host.clientWidth || 700) - margin.left - margin.right);
    const cell = Math.max(9, Math.min(64, room / columns.length));
    const high = Math.max(20, Math.min(46, cell));
    this.cell = { margin, cell, high };
    const [width, height] = [margin.left + margin.right + cell * columns.length, margin.top + margin.bottom + high * rows.length];
    this.width = width;
    this.height = height;
    this.svg.replaceChildren(svg('rect', { width, height, fill: palette.paper }));
    for (const [key, value] of Object.entries({ viewBox: `0 0 ${width} ${height}`, width, height, 'font-family': 'system-ui, sans-serif', 'font-size': 10.5 })) this.svg.setAttribute(key, value);
    const labelled = cell >= 26;
    mac.forEach((row, i) => row.forEach((value, j) => {
      const [x, y] = [margin.left + j * cell, margin.top + i * high];
      const fill = value === null ? palette.band : heat(value);
      this.svg.append(svg('rect', { x, y, width: cell, height: high, fill, stroke: palette.grid, 'stroke-width': 0.5 }));
      if (value === null) this.svg.append(svg('path', { d: `M${x} ${y + high}L${x + cell} ${y}`, stroke: palette.grid }));
      else if (labelled && value >= 0.05) this.svg.append(svg('text', { x: x + cell / 2, y: y + high / 2 + 4, 'text-anchor': 'middle', fill: inkOn(value), 'font-size': Math.min(11, cell / 3) }, macText(value, 2)));
    }));
    for (const [i, j] of this.matrix.pairs) {
      this.svg.append(svg('rect', { x: margin.left + j * cell + 1, y: margin.top + i * high + 1, width: cell - 2, height: high - 2, fill: 'none', stroke: palette.series[1], 'stroke-width': 2 }));
    }
    this.names(rows, columns);
    this.key_scale();
    this.ring = svg('rect', { fill: 'none', stroke: palette.ink, 'stroke-width': 2, 'pointer-events': 'none', visibility: 'hidden' });
    this.svg.append(this.ring);
  }

  names(rows, columns) {
    const { margin, cell, high } = this.cell;
    const every = (size) => Math.max(1, Math.ceil(11 / size));
    const bottom = margin.top + high * rows.length;
    rows.forEach((hz, i) => {
      if (i % every(high) === 0) this.svg.append(svg('text', { x: margin.left - 6, y: margin.top + (i + 0.5) * high + 4, 'text-anchor': 'end', fill: palette.faint }, digits(hz, 5)));
    });
    columns.forEach((hz, j) => {
      const x = margin.left + (j + 0.5) * cell + 4;
      if (j % every(cell) === 0) this.svg.append(svg('text', { x, y: bottom + 6, 'text-anchor': 'end', fill: palette.faint, transform: `rotate(-60 ${x} ${bottom + 6})` }, digits(hz, 5)));
    });
    const middle = margin.top + (high * rows.length) / 2;
    this.svg.append(svg('text', { x: 13, y: middle, 'text-anchor': 'middle', fill: palette.ink, 'font-size': 12, transform: `rotate(-90 13 ${middle})` }, `${T('Test')} (Hz)`));
    this.svg.append(svg('text', { x: margin.left + (cell * columns.length) / 2, y: this.height - 8, 'text-anchor': 'middle', fill: palette.ink, 'font-size': 12 }, T('Theory (Hz)')));
  }

  /** The scale of colours, at the right. */
  key_scale() {
    const { margin } = this.cell;
    const [x, top] = [this.width - margin.right + 22, margin.top];
    const length = Math.min(150, this.height - margin.top - 20);
    for (let k = 0; k < 40; k++) {
      this.svg.append(svg('rect', { x, y: top + length - ((k + 1) * length) / 40, width: 12, height: length / 40 + 0.5, fill: heat((k + 0.5) / 40) }));
    }
    this.svg.append(svg('rect', { x, y: top, width: 12, height: length, fill: 'none', stroke: palette.axis }));
    for (const at of [0, 0.5, 1]) this.svg.append(svg('text', { x: x + 17, y: top + length * (1 - at) + 4, fill: palette.faint }, at.toFixed(1)));
  }

  tell(i, j, x, y) {
    const { mac, test_hz: rows, theory_hz: columns } = this.matrix;
    const { margin, cell, high } = this.cell;
    for (const [key, value] of Object.entries({ x: margin.left + j * cell, y: margin.top + i * high, width: cell, height: high, visibility: 'visible' })) this.ring.setAttribute(key, value);
    const lines = [`MAC ${mac[i][j] === null ? '—' : macText(mac[i][j], 3)}`, `${T('test')} ${i + 1}: ${digits(rows[i], 6)} Hz`, `${T('theory')}: ${digits(columns[j], 6)} Hz`];
    if (this.matrix.pairs.some((pair) => pair[0] === i && pair[1] === j)) lines.push(this.repeated(i) ? T('pair with a repeated root: MAC of one of its vectors, not of their subspace') : T('pair'));
    tip.show(x, y, lines);
  }

  hover(event) {
    const box = this.svg.getBoundingClientRect();
    const { margin, cell, high } = this.cell;
    const j = Math.floor((((event.clientX - box.left) * this.width) / box.width - margin.left) / cell);
    const i = Math.floor((((event.clientY - box.top) * this.height) / box.height - margin.top) / high);
    if (i >= 0 && j >= 0 && i < this.matrix.mac.length && j < this.matrix.theory_hz.length) this.tell(i, j, event.clientX, event.clientY);
    else tip.hide();
  }

  key(event) {
    const move = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowUp: [-1, 0], ArrowDown: [1, 0] }[event.key];
    if (!move) return;
    event.preventDefault();
    const [i, j] = this.at || [0, 0];
    const inside = (value, count) => Math.max(0, Math.min(count - 1, value));
    this.at = [inside(i + move[0], this.matrix.mac.length), inside(j + move[1], this.matrix.theory_hz.length)];
    const box = this.svg.getBoundingClientRect();
    const { margin, cell, high } = this.cell;
    this.tell(...this.at, box.left + ((margin.left + (this.at[1] + 0.5) * cell) * box.width) / this.width, box.top + ((margin.top + (this.at[0] + 0.5) * high) * box.height) / this.height);
  }

  text() {
    return Plot.prototype.text.call(this);
  }

  png(name) {
    Plot.prototype.png.call({ text: () => this.text(), width: this.width, o: { height: this.height } }, name);
  }
}
