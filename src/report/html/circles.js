// The circle of each mode in the complex plane, with its damping surface.

function drawCircles(host) {
  ofTests(host, (test) => test.circles.length, (body, test) => {
    const inner = el('div');
    const show = (index) => {
      inner.replaceChildren();
      drawCircle(inner, test, test.circles[index]);
    };
    body.append(bar(choice(T('Mode'), test.circles.map((circle) => `${circle.mode}: ${digits(circle.hz, 5)} Hz`), show)), inner);
    show(0);
  });
}

function drawCircle(host, test, fit) {
  const two = el('div', { class: 'wide' });
  const [left, right] = [el('div'), el('div')];
  two.append(left, right);
  host.append(two);
  const around = Array.from({ length: 121 }, (_, k) => (k * Math.PI) / 60);
  const circle = { x: around.map((t) => fit.center[0] + fit.radius * Math.cos(t)), y: around.map((t) => fit.center[1] + fit.radius * Math.sin(t)) };
  left.append(el('h4', {}, `${T('Mode')} ${fit.mode}, ${fit.function}: ${T('receptance with the other modes subtracted')}`));
  new Plot(left, {
    name: `${test.name}-circle-${fit.mode}`, height: 420, equal: true,
    x: { label: `${T('Real part')} (m/N)` }, y: { label: `${T('Imaginary part')} (m/N)` },
    series: [
      { name: T('circle'), ...circle, color: 1, quiet: true },
      { name: T('data'), kind: 'points', x: fit.re, y: fit.im, color: 0, size: 3 },
      { name: T('resonance'), kind: 'points', x: [fit.resonance[0]], y: [fit.resonance[1]], color: 2, size: 5 },
    ],
    tell: (near) => (near.series.name === T('data') ? [`${digits(fit.line_hz[near.k], 7)} Hz`, `${digits(near.x)} ${near.y < 0 ? '−' : '+'} ${digits(Math.abs(near.y))} i`] : [near.series.name, `${digits(fit.resonance_hz, 7)} Hz`]),
  });
  surface(right, test, fit);
}

/** The name of an axis with its ends. */
const span = (name, hz) => `${name}: ${digits(hz[0], 6)} … ${digits(hz[hz.length - 1], 6)} Hz`;

/** The damping surface over the frequency lines below and above the resonance, drawn obliquely; flat where the data lie on a circle. */
function surface(host, test, fit) {
  const values = fit.damping.flat().filter((value) => value !== null);
  if (!values.length) return;
  const sorted = [...values].sort((a, b) => a - b);
  const half = (sorted.length - 1) / 2;
  const median = (sorted[Math.floor(half)] + sorted[Math.ceil(half)]) / 2;
  const window = fit.window_damping ? `, ${T('of which the window')} ${percent(fit.window_damping)}` : '';
  host.append(el('h4', {}, T('Damping surface: damping ratio of each pair of lines')));
  const canvasHost = el('div', { class: 'plot' });
  host.append(canvasHost, el('p', { class: 'note' }, `${T('median')} ${percent(median)}, ${T('range')} ${percent(sorted[0])} … ${percent(sorted[sorted.length - 1])}${window}. ${span(T('below'), fit.below_hz)}, ${span(T('above'), fit.above_hz)}`));
  const view = new View3d(canvasHost, { height: 380, label: T('Damping surface: damping ratio of each pair of lines'), turn: [-0.7, 0.55], fit: 0.6, triad: false });
  const [rows, columns] = [fit.below_hz, fit.above_hz];
  const top = Math.max(...values, 1.5 * median);
  const spot = (i, j, value) => [(i / Math.max(1, rows.length - 1)) * 2 - 1, (j / Math.max(1, columns.length - 1)) * 2 - 1, (1.4 * value) / top - 0.7];
  const tiles = [];
  for (let i = 0; i + 1 < rows.length; i++) {
    for (let j = 0; j + 1 < columns.length; j++) {
      const corners = [[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]];
      const heights = corners.map(([a, b]) => fit.damping[a][b]);
      if (heights.some((value) => value === null || value < 0)) continue;
      const share = heights.reduce((a, b) => a + b, 0) / 4 / top;
      tiles.push({ points: corners.map(([a, b], k) => spot(a, b, heights[k])), share });
    }
  }
  const floor = [spot(0, 0, 0), spot(rows.length - 1, 0, 0), spot(rows.length - 1, columns.length - 1, 0), spot(0, columns.length - 1, 0)];
  view.scene = (pen) => {
    pen.lines([...floor, floor[0]], palette.axis, 1);
    pen.tiles(tiles, (tile) => heat(0.15 + 0.85 * tile.share));
    const edge = [floor[2], [floor[2][0], floor[2][1], spot(0, 0, top)[2]]];
    pen.lines(edge, palette.axis, 1);
    for (const share of [0, 0.5, 1]) pen.text([edge[0][0] + 0.08, edge[0][1] + 0.04, spot(0, 0, share * top)[2]], percent(share * top, 3), palette.faint, 'left');
    pen.text([0, -1.12, -0.75], T('below'), palette.ink, 'right');
    pen.text([-1.12, 0, -0.75], T('above'), palette.ink, 'right');
  };
  view.draw();
}
