// Bode and Nyquist diagrams with the synthesized FRF of the identified modes and the coherence.

/** Vertical lines at the modes of a test. */
const modeMarks = (test) => test.modes.map((mode, k) => ({ x: mode.hz, text: String(k + 1) }));

/** Groups of plots that share the range of x. */
const linked = () => new Set();

function drawFrf(host) {
  ofTests(host, (test) => test.frfs, (body, test) => {
    const set = test.frfs;
    const state = { index: 0, log: false };
    const hz = (line) => set.start_hz + line * set.step_hz;
    const plots = el('div');
    const show = () => {
      plots.replaceChildren();
      drawCurve(plots, test, set.curves[state.index], hz, state);
    };
    const names = set.curves.map((curve) => `${curve.response}/${curve.reference}`);
    body.append(bar(
      choice(T('FRF (response/excitation)'), names, (index) => { state.index = index; show(); }),
      tick(T('logarithmic frequency'), state.log, (on) => { state.log = on; show(); })));
    body.append(plots);
    const notes = [];
    if (set.curves.length < set.functions) notes.push(`${set.curves.length} ${T('of')} ${set.functions} ${T('FRFs are shown; the file has all')}: ${test.frf_file || ''}`);
    const lines = set.curves[0].lines.length;
    if (lines < set.whole_lines) notes.push(`${lines} ${T('of')} ${set.whole_lines} ${T('lines of each curve are shown: the extremes of each segment')}`);
    body.append(el('p', { class: 'note' }, notes.join(' · ')), hint(T('drag to zoom, double-click to reset; with the keyboard + − 0 and the arrows')));
    show();
  });
}

function drawCurve(host, test, curve, hz, state) {
  const set = test.frfs;
  const unit = curve.unit.replace('/s2', '/s²');
  const x = curve.lines.map(hz);
  const fitted = curve.fit_magnitude.length > 0;
  const group = linked();
  const name = `${test.name} ${curve.response} ${curve.reference}`.replace(/[^A-Za-z0-9.]+/g, '-');
  const range = { label: T('Frequency (Hz)'), log: state.log, min: x[0], max: x[x.length - 1] };
  const marks = modeMarks(test);
  const shared = { link: group, band: set.band_hz, marks: marks.map(({ x: at }) => ({ x: at })) };
  const two = el('div', { class: 'wide' });
  const left = el('div');
  const right = el('div');
  two.append(left, right);
  host.append(two);
  const series = (measured, fit, more = {}) => {
    const all = [{ name: T('data'), x, y: measured, color: 0, ...more }];
    if (fitted) all.push({ name: T('fit'), x, y: fit, color: 1, width: 1.6, dash: '6 3', ...more });
    return all;
  };
  left.append(el('h4', {}, `${T('Bode')}: ${curve.response}/${curve.reference}`));
  new Plot(left, { ...shared, marks, name: `${name}-magnitude`, height: 300, x: range, y: { label: `${T('Magnitude')} (${unit})`, log: true }, series: series(curve.magnitude, curve.fit_magnitude) });
  const degrees = [-180, -90, 0, 90, 180].map((at) => ({ at, text: String(at).replace('-', '−'), main: true }));
  new Plot(left, { ...shared, name: `${name}-phase`, height: 190, x: range, y: { label: T('Phase (°)'), min: -190, max: 190, ticks: degrees }, series: series(curve.phase_deg, curve.fit_phase_deg, { wraps: true }) });
  if (curve.coherence.length) {
    new Plot(left, { ...shared, name: `${name}-coherence`, height: 140, x: range, y: { label: T('Coherence'), min: 0, max: 1.02 }, series: [{ name: T('Coherence'), x, y: curve.coherence, color: 2 }] });
  }
  if (fitted) left.append(el('p', { class: 'note' }, T('fit: identified modes and two residual terms')));
  right.append(el('h4', {}, T('Nyquist')));
  nyquist(right, { curve, x, fitted, group, name, unit, range: set.band_hz });
}

/** The Nyquist diagram over the frequency range that the Bode diagram shows. */
function nyquist(host, { curve, x, fitted, group, name, unit, range }) {
  const parts = (magnitude, degrees, keep) => {
    const [re, im, at] = [[], [], []];
    keep.forEach((k) => {
      if (magnitude[k] === null) return;
      const angle = (degrees[k] * Math.PI) / 180;
      re.push(magnitude[k] * Math.cos(angle));
      im.push(magnitude[k] * Math.sin(angle));
      at.push(x[k]);
    });
    return { x: re, y: im, at };
  };
  const body = el('div');
  host.append(body);
  const show = (shown) => {
    const [lo, hi] = shown || range;
    const keep = x.map((value, k) => k).filter((k) => x[k] >= lo && x[k] <= hi);
    const series = [{ name: T('data'), color: 0, kind: keep.length < 250 ? 'points' : 'line', size: 2, ...parts(curve.magnitude, curve.phase_deg, keep) }];
    if (fitted) series.push({ name: T('fit'), color: 1, dash: '6 3', ...parts(curve.fit_magnitude, curve.fit_phase_deg, keep) });
    body.replaceChildren();
    new Plot(body, {
      name: `${name}-nyquist`, height: 420, equal: true, series,
      x: { label: `${T('Real part')} (${unit})` }, y: { label: `${T('Imaginary part')} (${unit})` },
      tell: (near) => [near.series.name, `${T('frequency')}: ${digits(near.series.at[near.k], 7)} Hz`, `${digits(near.x)} ${near.y < 0 ? '−' : '+'} ${digits(Math.abs(near.y))} i`],
    });
  };
  group.add({ range: {}, draw: () => {}, o: { zoomed: show }, host });
  show(null);
}
