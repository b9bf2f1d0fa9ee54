// Failure boundaries of the methods: maps over two factors with contours and the modes of the run;
// and digits lost by model order.

/** Minimum percentage of the draws in which a method has to meet the stated error. */
const MIN_SUCCESS_PERCENT = 95;
/** The darkest shade of a map, as a fraction of the heat scale: contours and points remain visible on it. */
const DARKEST = { all: 0.42, one: 0.8 };
const DASHES = ['', '8 3', '2 2.5', '9 3 2 3', '14 4', '5 2 1.5 2 1.5 2', '4 5'];
/** Maximum number of modes with a sentence under the map. */
const MAX_LISTED_MODES = 8;

function drawMaps(host) {
  const { slices } = page.studies.breakdown;
  if (!slices.length) return;
  const state = { slice: slices[0], method: null };
  const body = el('div');
  const methods = el('span');
  const show = () => {
    body.replaceChildren();
    drawMap(body, state.slice, state.method);
  };
  const pickSlice = (index) => {
    const before = state.slice.methods[state.method];
    state.slice = slices[index];
    const kept = state.slice.methods.indexOf(before);
    state.method = kept < 0 ? null : kept;
    const select = choice(T('Method'), [T('all methods'), ...state.slice.methods], (k) => {
      state.method = k ? k - 1 : null;
      show();
    });
    select.querySelector('select').selectedIndex = kept + 1;
    methods.replaceChildren(select);
    show();
  };
  host.append(bar(choice(T('Map'), slices.map((slice) => slice.name), pickSlice), methods), body);
  pickSlice(0);
}

/** From a fraction of an axis to its value, and back. */
const valueAt = (axis, share) => (axis.log ? axis.lo * (axis.hi / axis.lo) ** share : axis.lo + share * (axis.hi - axis.lo));
const shareOf = (axis, value) => (axis.log ? Math.log(value / axis.lo) / Math.log(axis.hi / axis.lo) : (value - axis.lo) / (axis.hi - axis.lo));

/** The detection rate at a location, linear between the nodes of the grid. */
function shareAt(grid, [x, y]) {
  const part = (share, count) => {
    const at = Math.max(0, Math.min(1, share)) * (count - 1);
    const first = Math.min(count - 2, Math.floor(at));
    return [first, at - first];
  };
  const [[i, u], [j, v]] = [part(x, grid.length), part(y, grid[0].length)];
  const row = (k) => (1 - u) * grid[i][k] + u * grid[i + 1][k];
  return (1 - v) * row(j) + v * row(j + 1);
}

function drawMap(host, slice, method) {
  const chosen = method === null ? slice.methods.map((name, k) => k) : [method];
  const series = chosen.map((k) => contourSeries(slice, k));
  const modeSeries = { name: T('modes of this run'), kind: 'points', color: 'ink', rim: 'paper', size: 4, points: slice.points, x: slice.points.map((point) => valueAt(slice.x, point.place[0])), y: slice.points.map((point) => valueAt(slice.y, point.place[1])) };
  if (slice.points.length) series.push(modeSeries);
  const axis = (range) => ({ label: range.label, log: range.log, min: range.lo, max: range.hi, ...(range.whole && range.hi - range.lo <= 10 && !range.log ? { ticks: wholeTicks(range) } : {}) });
  new Plot(host, {
    name: slice.name, height: 420, series, reach: 10, x: axis(slice.x), y: axis(slice.y), label: `${slice.name}: ${slice.x.label}, ${slice.y.label}`,
    under: (plot, group) => shade(plot, group, slice, method),
    over: (plot, group) => { if (!plot.hidden.has(modeSeries.name)) modeLabels(plot, group, slice.points); },
    tell: (near) => modeWords(slice, near.series.points[near.k], method),
    at: (x, y) => placeWords(slice, [x, y]),
  });
  host.append(shadeKey(method), el('p', { class: 'note' }, fill(T('{} draws for each cell; the contour is where 95 % of them meet the stated error.'), slice.draws)), modeList(slice, method));
}

function wholeTicks(axis) {
  const ticks = [];
  for (let at = Math.ceil(axis.lo); at <= axis.hi; at++) ticks.push({ at, main: true, text: String(at) });
  return ticks;
}

/** The failure boundary of a method; without one, the legend says whether the method succeeds everywhere or nowhere. */
function contourSeries(slice, k) {
  const lines = slice.contours[k];
  const [x, y] = [[], []];
  for (const line of lines) {
    for (const place of line) {
      x.push(valueAt(slice.x, place[0]));
      y.push(valueAt(slice.y, place[1]));
    }
    x.push(NaN);
    y.push(null);
  }
  const all = slice.shares[k].flat();
  let note = '';
  if (all.every((share) => share >= MIN_SUCCESS_PERCENT)) note = ` (${T('everywhere here')})`;
  else if (all.every((share) => share < MIN_SUCCESS_PERCENT)) note = ` (${T('nowhere here')})`;
  return { name: slice.methods[k] + note, quiet: true, color: k, width: 2, dash: DASHES[k % DASHES.length], x, y };
}

/** Shades the map: the darker, the more methods fail; with a single method, the more draws fail. Tiles are finer than the grid, so that shades end at the contours. */
function shade(plot, group, slice, method) {
  const finer = (count, minimum) => (count - 1) * Math.ceil(minimum / (count - 1));
  const [across, up] = [finer(slice.shares[0].length, 72), finer(slice.shares[0][0].length, 48)];
  const tone = (i, j) => {
    const middle = [(i + 0.5) / across, (j + 0.5) / up];
    if (method !== null) return DARKEST.one * Math.round(50 * (1 - shareAt(slice.shares[method], middle) / 100)) / 50;
    return DARKEST.all * slice.shares.filter((grid) => shareAt(grid, middle) < MIN_SUCCESS_PERCENT).length / slice.methods.length;
  };
  for (let j = 0; j < up; j++) {
    const [top, bottom] = [j + 1, j].map((k) => plot.sy(valueAt(slice.y, k / up)));
    for (let i = 0; i < across;) {
      const [from, depth] = [i, tone(i, j)];
      while (i < across && tone(i, j) === depth) i++;
      if (depth < 0.005) continue;
      const [left, right] = [from, i].map((k) => plot.sx(valueAt(slice.x, k / across)));
      group.append(svg('rect', { x: left, y: top, width: right - left, height: bottom - top, fill: heat(depth), 'shape-rendering': 'crispEdges' }));
    }
  }
}

/** The legend of the shades. */
function shadeKey(method) {
  const ends = method === null ? [T('no method fails'), T('every method fails')] : [T('no draw fails'), T('every draw fails')];
  const key = el('div', { class: 'legend' });
  const most = method === null ? DARKEST.all : DARKEST.one;
  const draw = () => key.replaceChildren(...ends.map((text, k) => el('span', { class: 'series' }, el('i', { class: 'shade', style: `background:${heat(k * most)}` }), text)));
  draw();
  drawings.add({ host: key, draw });
  return key;
}

/** `4`, `1, 2`, `1 – 6`; modes that overlap share a label. */
function modeLabels(plot, group, points) {
  const groups = [];
  points.forEach((point, k) => {
    const at = [plot.sx(plot.o.series.at(-1).x[k]), plot.sy(plot.o.series.at(-1).y[k])];
    const near = groups.find((cluster) => cluster.test === point.test && Math.hypot(cluster.at[0] - at[0], cluster.at[1] - at[1]) < 9);
    if (near) near.numbers.push(point.number);
    else groups.push({ at, test: point.test, numbers: [point.number] });
  });
  const taken = groups.map(({ at: [x, y] }) => [x - 5, y - 5, x + 5, y + 5]);
  const right = plot.width - MARGIN.right;
  for (const { at: [x, y], numbers } of groups) {
    const text = listed(numbers.sort((a, b) => a - b));
    const wide = 6.2 * text.length;
    const offers = [[7, 4], [-7 - wide, 4], [-wide / 2, -8], [-wide / 2, 17]].map(([dx, dy]) => [x + dx, y + dy]);
    const area = ([left, base]) => [left, base - 10, left + wide, base + 2];
    const free = (box) => box[0] > MARGIN.left && box[2] < right && box[1] > MARGIN.top && box[3] < plot.o.height - MARGIN.bottom && !taken.some((other) => box[0] < other[2] && other[0] < box[2] && box[1] < other[3] && other[1] < box[3]);
    const place = offers.find((offer) => free(area(offer)));
    if (!place) continue;
    taken.push(area(place));
    group.append(svg('text', { x: place[0], y: place[1], fill: palette.ink, stroke: palette.paper, 'stroke-width': 3, 'paint-order': 'stroke', 'font-weight': 600 }, text));
  }
}

function listed(numbers) {
  const [first, last] = [numbers[0], numbers.at(-1)];
  if (numbers.length > 2 && last - first + 1 === numbers.length) return `${first} – ${last}`;
  return numbers.length > 3 ? `${first} … ${last}` : numbers.join(', ');
}

function modeName(point) {
  const name = fill(T('mode {} ({} Hz)'), point.number, digits(point.hz, 5));
  return point.test ? `${point.test}, ${name}` : name;
}

/** A sentence on the distance of a mode from the failure boundary of a method. */
function marginWords(slice, point, k) {
  const { inside, distance } = point.margins[k];
  const [name, method] = [modeName(point), slice.methods[k]];
  if (inside) return distance ? fill(T('{} is {} from the failure boundary of {}'), name, distance, method) : fill(T('{}: {} holds along both axes'), name, method);
  return distance ? fill(T('{} lies in the failure region of {}, {} from its boundary'), name, method, distance) : fill(T('{} lies in the failure region of {}'), name, method);
}

function modeWords(slice, point, method) {
  if (method !== null) return [marginWords(slice, point, method)];
  const of = (k) => {
    const { inside, distance } = point.margins[k];
    return `${slice.methods[k]}: ${inside ? T('holds') : T('fails')}${distance ? `, ${distance}` : ''}`;
  };
  return [modeName(point), ...slice.methods.map((name, k) => of(k)), T('the distance is that to the contour of the method')];
}

/** The detection rate of each method at the pointer. */
function placeWords(slice, [x, y]) {
  const place = [shareOf(slice.x, x), shareOf(slice.y, y)];
  const shares = slice.methods.map((name, k) => [name, shareAt(slice.shares[k], place)]).sort((a, b) => b[1] - a[1]);
  return [`${slice.x.label}: ${digits(x, 3)}`, `${slice.y.label}: ${digits(y, 3)}`, ...shares.map(([name, share]) => `${name}: ${share.toFixed(0)} %`)];
}

/** Sentences on the modes nearest to the failure boundary of a method. */
function modeList(slice, method) {
  const ranked = method === null ? slice.points.filter((point) => point.nearest !== null) : slice.points;
  const sentences = ranked.slice(0, MAX_LISTED_MODES).map((point) => marginWords(slice, point, method === null ? point.nearest : method));
  const more = ranked.length - sentences.length;
  if (more > 0) sentences.push(fill(T('{} further modes are not listed.'), more));
  if (slice.outside) sentences.push(fill(T('{} further modes lie outside this map.'), slice.outside));
  return el('ul', { class: 'sentences' }, ...sentences.map((text) => el('li', {}, text)));
}

/** Digits that the equations of each method lose by order, and the error of poles in f64 and f32. */
function drawPrecision(host) {
  const { courses } = page.studies.breakdown;
  if (!courses) return;
  const link = new Set();
  const highest = Math.max(...courses.flatMap((result) => result.order));
  const x = { label: T('Model order'), min: 0, max: highest + 1 };
  const course = (result, k, y, more = {}) => ({ name: result.method, color: k, x: result.order, y, ...more });
  host.append(el('h3', {}, T('Digits lost by order')));
  const digitsLost = courses.flatMap((result, k) => [course(result, k, result.digits, { legend: false, quiet: true }), course(result, k, result.digits, { kind: 'points', mark: k })]);
  const tell = (near) => [`${near.series.name}, ${T('order')} ${near.x}`, `${near.series.precision || T('digits lost')}: ${digits(near.y, 3)}`];
  new Plot(host, { name: 'digits-lost', height: 280, series: digitsLost, link, reach: 20, x, y: { label: T('Digits lost (log₁₀ of the condition)'), min: 0, max: 18 }, tell });
  const kinds = [T('all in f64'), T('data in f32'), T('data and equations in f32')];
  const dashes = ['', '7 3', '2 3'];
  const errors = courses.flatMap((result, k) => result.errors.flatMap((values, kind) => [
    course(result, k, values, { legend: false, quiet: true, dash: dashes[kind] }),
    course(result, k, values, { kind: 'points', mark: k, precision: kinds[kind], legend: kind === 0 }),
  ]));
  new Plot(host, { name: 'errors-by-order', height: 300, series: errors, link, reach: 20, x, y: { label: T('Error of poles (half-power widths)'), log: true }, tell });
  host.append(el('p', { class: 'note' }, T('Solid: all in f64; dashed: data in f32; dotted: data and equations in f32.')));
}
