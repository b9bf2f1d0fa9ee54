// Words, numbers, colours and elements that every figure needs.

/** The data of the page, read after the browser has painted it. */
let page = null;
let figures = null;
function readData() {
  if (page) return;
  page = JSON.parse(document.getElementById('data').textContent);
  figures = page.figures;
}

/** A word of the page in its language. */
const T = (text) => page.words[text] || text;

/** An HTML element with attributes and children; `on…` attributes are listeners. */
function el(name, attributes = {}, ...children) {
  const node = document.createElement(name);
  for (const [key, value] of Object.entries(attributes)) {
    if (key.startsWith('on')) node.addEventListener(key.slice(2), value);
    else if (value !== null && value !== undefined) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** An SVG element. */
function svg(name, attributes = {}, text = null) {
  const node = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
  if (text !== null) node.textContent = text;
  return node;
}

/** A number with `count` significant digits, with a power of ten where that is shorter. */
function digits(value, count = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '—';
  const size = Math.abs(value);
  if (size > 0 && (size < 1e-3 || size >= 1e6)) return value.toExponential(count - 1).replace('e+', 'e');
  const decimals = size > 0 ? count - 1 - Math.floor(Math.log10(size)) : 0;
  return value.toFixed(Math.max(0, Math.min(8, decimals)));
}

const percent = (fraction, count = 3) => (fraction === null || fraction === undefined ? '—' : `${digits(100 * fraction, count)} %`);
const signed = (value, decimals = 2) => (value === null || value === undefined ? '—' : `${value > 0 ? '+' : ''}${value.toFixed(decimals)}`);

/** Colours that people with red-green blindness distinguish (Okabe and Ito), for the light and the dark theme. */
const PALETTES = {
  light: {
    paper: '#ffffff', ink: '#1b2330', faint: '#69707d', grid: '#e4e7ec', axis: '#9aa1ad', band: '#f1f3f6',
    series: ['#0072b2', '#d55e00', '#009e73', '#aa4499', '#b8860b', '#3a9bc1', '#6b6b6b', '#882255'],
    heat: [[255, 255, 255], [198, 219, 239], [107, 174, 214], [33, 113, 181], [8, 48, 107]],
  },
  dark: {
    paper: '#171b22', ink: '#e6e9ee', faint: '#9aa3b0', grid: '#2a303a', axis: '#5b6472', band: '#1f252e',
    series: ['#56b4e9', '#f0894a', '#35c79a', '#dd88cc', '#e8c547', '#8fd0ef', '#a8adb5', '#d0729b'],
    heat: [[23, 27, 34], [24, 52, 88], [30, 94, 150], [76, 156, 214], [205, 231, 250]],
  },
};
let palette = PALETTES.light;

/** A colour of the heat scale, 0 to 1. */
function heat(share) {
  const place = Math.max(0, Math.min(1, share)) * (palette.heat.length - 1);
  const low = Math.min(palette.heat.length - 2, Math.floor(place));
  const mix = palette.heat[low].map((from, k) => Math.round(from + (place - low) * (palette.heat[low + 1][k] - from)));
  return `rgb(${mix.join(',')})`;
}

/** Dark or white, whichever has more contrast on a colour of the heat scale. */
function inkOn(share) {
  const rgb = heat(share).match(/\d+/g).map(Number);
  return 0.299 * rgb[0] + 0.587 * rgb[1] + 0.114 * rgb[2] > 140 ? '#111722' : '#ffffff';
}

/** Dark or white, whichever has more contrast on a colour `#rrggbb` (WCAG relative luminance). */
function inkOver(color) {
  const [r, g, b] = [1, 3, 5].map((k) => parseInt(color.slice(k, k + 2), 16) / 255).map((v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4));
  const luminance = 0.2126 * r + 0.7152 * g + 0.0722 * b;
  return luminance > 0.19 ? '#10131a' : '#ffffff';
}

/** The tooltip that all figures share. */
const tip = {
  node: null,
  show(x, y, lines) {
    if (!this.node) {
      this.node = el('div', { class: 'tip', role: 'status' });
      document.body.append(this.node);
    }
    this.node.replaceChildren(...lines.map((line) => el('div', {}, line)));
    this.node.hidden = false;
    const box = this.node.getBoundingClientRect();
    const left = x + 14 + box.width > innerWidth ? x - box.width - 14 : x + 14;
    const top = y + 14 + box.height > innerHeight ? y - box.height - 14 : y + 14;
    this.node.style.left = `${Math.max(4, left)}px`;
    this.node.style.top = `${Math.max(4, top)}px`;
  },
  hide() {
    if (this.node) this.node.hidden = true;
  },
};

/** Offers a file to the user as a download. */
function save(name, type, content) {
  const url = URL.createObjectURL(content instanceof Blob ? content : new Blob([content], { type }));
  const link = el('a', { href: url, download: name });
  document.body.append(link);
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(url), 1000);
}

/** A labelled drop-down list; `items` are texts, `pick` is called with the index. */
function choice(label, items, pick) {
  const select = el('select', { onchange: () => pick(select.selectedIndex) }, ...items.map((text) => el('option', {}, text)));
  return el('label', { class: 'choice' }, el('span', {}, label), select);
}

/** A labelled check box. */
function tick(label, on, change) {
  const box = el('input', { type: 'checkbox', onchange: () => change(box.checked) });
  box.checked = on;
  return el('label', { class: 'tick' }, box, el('span', {}, label));
}

const button = (label, click, more = {}) => el('button', { type: 'button', onclick: click, ...more }, label);
const bar = (...parts) => el('div', { class: 'bar' }, ...parts);

/** The test that the user selected last; other tabs open with it. */
let chosenTest = null;

/** The note over the figures of a synthetic test. */
const madeUp = (test) => (test.synthetic ? [el('p', { class: 'note' }, T('Synthetic test: computed from a model, not measured.'))] : []);

/** The selected one of several items as text for paper, where selections are not printed. */
const onPaper = (label, names, index) => (names.length > 1 ? [el('p', { class: 'paper' }, `${label}: ${names[index]} (${index + 1} / ${names.length})`)] : []);

/** How to operate a figure; not printed. */
const hint = (text) => el('p', { class: 'note hint' }, text);

/** Draws the figures of the selected test; the selection lists the tests that have these figures. */
function ofTests(host, has, draw) {
  const tests = figures.tests.filter(has);
  const body = el('div');
  const show = (index) => {
    body.replaceChildren();
    body.append(...onPaper(T('Test'), tests.map((test) => test.name), index), ...madeUp(tests[index]));
    draw(body, tests[index]);
  };
  const first = Math.max(0, tests.findIndex((test) => test.name === chosenTest));
  if (tests.length > 1) {
    const select = choice(T('Test'), tests.map((test) => test.name), (index) => {
      chosenTest = tests[index].name;
      show(index);
    });
    select.querySelector('select').selectedIndex = first;
    host.append(bar(select));
  }
  host.append(body);
  show(first);
}

/** Figures of the page that are redrawn when the theme or the width of the window changes. */
const drawings = new Set();
function redrawAll() {
  for (const drawing of drawings) {
    if (drawing.host.isConnected) drawing.draw();
    else drawings.delete(drawing);
  }
}
