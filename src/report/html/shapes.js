// Animated mode shapes of the test at its points, with the shapes of the paired modes of the theory
// next to them or over them.

function drawShapes(host) {
  const tests = figures.tests.filter((test) => test.shapes);
  const names = tests.map((test) => test.name);
  if (figures.theory) names.push(T('theory alone'));
  const body = el('div');
  const show = (index) => {
    body.replaceChildren(...onPaper(T('Test'), names, index));
    if (tests[index]) body.append(...madeUp(tests[index]));
    new ShapeViewer(body, tests[index] || null);
  };
  // The test with the most readings, unless the user selected another.
  const count = (test) => test.shapes.readings.length;
  const chosen = tests.findIndex((test) => test.name === chosenTest);
  const most = tests.findIndex((test) => count(test) === Math.max(...tests.map(count)));
  const first = Math.max(0, chosen >= 0 ? chosen : most);
  if (names.length > 1) {
    const select = choice(T('Test'), names, show);
    select.querySelector('select').selectedIndex = first;
    host.append(bar(select));
  }
  host.append(body);
  show(first);
}

/** Points and readings of a test, or none for the theory alone. */
const NO_SHAPES = { points: [], lines: [], readings: [], test: [], theory: [], partners: [], in_a_row: false, not_drawn: 0 };

class ShapeViewer {
  constructor(host, test) {
    this.test = test;
    this.shapes = test ? test.shapes : NO_SHAPES;
    this.bodies = this.shapes.in_a_row ? null : figures.theory;
    this.state = { mode: 0, sideBySide: false, bodies: true, amplitude: 0.16, speed: 1, phase: 0, play: !matchMedia('(prefers-reduced-motion: reduce)').matches };
    this.list = this.modes();
    this.frame();
    this.views = [];
    this.host = el('div');
    this.description = el('p', { class: 'description', 'aria-live': 'polite' });
    host.append(this.controls(), this.description, this.host, hint(T('drag to rotate, wheel to zoom; with the keyboard the arrows and + −')), el('p', { class: 'note' }, this.notes()));
    this.layout();
    this.pick(0);
    this.animate();
  }

  /** Modes of the test, then those of the theory without a partner. */
  modes() {
    const list = this.shapes.test.map((mode, k) => ({ test: k, hz: mode.hz, partner: this.shapes.partners[k] }));
    const taken = new Set(list.flatMap((entry) => (entry.partner ? entry.partner.modes.map((part) => part[0]) : [])));
    const theory = this.bodies ? this.bodies.hz : this.shapes.theory.map((mode) => mode.hz);
    theory.forEach((hz, j) => {
      if (!taken.has(j)) list.push({ test: null, hz, partner: { modes: [[j, 1, 0]], mac: null, error_percent: null } });
    });
    return list;
  }

  /** Whether the page has modes of the theory to pair with. */
  compared() {
    return this.shapes.theory.length > 0 || this.bodies !== null;
  }

  label(entry) {
    if (entry.test === null) return `${T('theory')}: ${digits(entry.hz, 5)} Hz`;
    return `${entry.test + 1}: ${digits(entry.hz, 5)} Hz${entry.partner || !this.compared() ? '' : ` (${T('without a partner')})`}`;
  }

  controls() {
    const { state } = this;
    const select = choice(T('Mode'), this.list.map((entry) => this.label(entry)), (index) => this.pick(index));
    this.select = select.querySelector('select');
    this.player = button(state.play ? T('Pause') : T('Play'), () => this.toggle(), { class: 'main' });
    const slider = (label, min, max, value, change) => el('label', { class: 'choice' }, el('span', {}, label), el('input', { type: 'range', min, max, step: 'any', value, oninput: (event) => change(Number(event.target.value)) }));
    const step = (by) => () => this.pick((state.mode + by + this.list.length) % this.list.length);
    const look = (name, yaw, pitch) => button(name, () => {
      this.views[0].look(yaw, pitch);
      this.views.forEach((view) => view.fill(this.corners()));
      this.draw();
    });
    const arrangement = button(T('side by side'), () => {
      state.sideBySide = !state.sideBySide;
      arrangement.textContent = state.sideBySide ? T('over each other') : T('side by side');
      this.layout();
    });
    const parts = [select, button('‹', step(-1), { 'aria-label': '‹' }), button('›', step(1), { 'aria-label': '›' }), this.player,
      slider(T('Amplitude'), 0, 0.5, state.amplitude, (value) => { state.amplitude = value; this.draw(); }),
      slider(T('Speed'), 0.1, 3, state.speed, (value) => { state.speed = value; })];
    if (this.shapes.theory.length) parts.push(arrangement);
    if (this.bodies) parts.push(tick(T('bodies'), true, (on) => { state.bodies = on; this.draw(); }));
    parts.push(look(T('Front'), 0, 0), look(T('Side'), Math.PI / 2, 0), look(T('Top'), 0, Math.PI / 2), look(T('Oblique'), -0.6, 0.35), button('PNG', () => this.views.forEach((view, n) => view.save(`${this.test ? this.test.name : 'theory'}-shape-${state.mode + 1}${n ? '-theory' : ''}.png`))));
    return bar(...parts);
  }

  notes() {
    const notes = [];
    if (this.shapes.in_a_row) notes.push(T('No point has coordinates: the points are drawn in a row.'));
    if (this.shapes.not_drawn) notes.push(`${this.shapes.not_drawn} ${T('degrees of freedom without position or direction are not drawn')}`);
    if (this.bodies && this.bodies.nodes.some((node) => node.radius_m)) notes.push(T('Discs have the radius of gyration of their body.'));
    if (this.bodies && this.bodies.nodes.some((node) => node.arc)) notes.push(T('The radii of discs that turn by an arc are not known: their rims move by the arc.'));
    return notes.join(' · ');
  }

  /** Centre and half size of the structure, and the direction of view that shows the motion. */
  frame() {
    const nodes = this.bodies ? this.bodies.nodes : [];
    const all = [...this.shapes.points.map((point) => point.at_m), ...nodes.map((node) => node.at_m)];
    const bounds = [0, 1, 2].map((k) => [Math.min(...all.map((at) => at[k])), Math.max(...all.map((at) => at[k]))]);
    this.center = bounds.map(([lo, hi]) => (lo + hi) / 2);
    const radius = Math.max(0, ...nodes.map((node) => node.radius_m || 0));
    const half = Math.max(...bounds.map(([lo, hi]) => (hi - lo) / 2), radius);
    this.size = half > 0 ? half : 1;
    this.radii = nodes.map((node, n) => this.radius(node, n, nodes));
    const flat = bounds[2][1] - bounds[2][0] <= 1e-6 * this.size;
    const inPlane = this.shapes.readings.every((reading) => Math.abs(reading.direction[2]) < 0.01) && (!this.bodies || this.bodies.modes.every((mode) => mode.every((value, k) => k % 6 !== 2 || Math.abs(value) < 1e-9)));
    this.turn = flat && inPlane ? [0, Math.PI / 2] : [-0.35, 0.3];
  }

  /** Radius of a body's disc, none for the nodes of a beam. */
  radius(node, n, nodes) {
    if (nodes.filter((other) => other.body === node.body).length > 1) return 0;
    if (node.radius_m) return node.radius_m;
    const alone = nodes.every((other) => other.at_m.every((x, k) => Math.abs(x - node.at_m[k]) < 1e-9));
    return alone && nodes.length > 1 ? this.size * (0.25 + (0.75 * (n + 1)) / nodes.length) : 0.045 * this.size;
  }

  /** Radius at which a rotation is drawn; 1 for an arc, which is the motion of the rim. */
  lever(node, n) {
    return node.arc ? 1 : this.radii[n] || 0;
  }

  layout() {
    this.host.replaceChildren();
    const count = this.state.sideBySide ? 2 : 1;
    this.host.className = count > 1 ? 'halves' : '';
    this.views = [];
    for (let n = 0; n < count; n++) {
      const part = el('div', { class: 'plot' });
      this.host.append(part);
      const view = new View3d(part, { height: innerWidth < 600 ? 320 : 460, label: T('Mode'), turn: this.turn });
      view.scene = (pen) => this.scene(pen, count === 1 ? 'both' : ['test', 'theory'][n]);
      view.fill(this.corners());
      this.views.push(view);
    }
    if (count > 1) this.views[0].join(this.views[1]);
    this.draw();
  }

  /** Points that the view has to contain: points and nodes at rest, with room for their motion. */
  corners() {
    const nodes = this.bodies ? this.bodies.nodes : [];
    const places = [...this.shapes.points, ...nodes].map((point) => this.moved(point.at_m, null, 0, 0));
    const radius = Math.max(0.15, ...this.radii.map((value) => value / this.size));
    const offsets = [0, 1, 2].flatMap((axis) => [-radius, radius].map((by) => (at) => at.map((x, k) => (k === axis ? x + by : x))));
    const far = this.radii.some((value) => value > 0) ? places.flatMap((at) => offsets.map((move) => move(at))) : places;
    return far;
  }

  pick(index) {
    this.state.mode = index;
    this.select.selectedIndex = index;
    const entry = this.list[index];
    this.shape = this.motion(entry);
    const parts = entry.test === null ? [] : [`${T('test')} ${digits(entry.hz, 5)} Hz, ${T('damping')} ${percent(this.test.modes[entry.test].damping_ratio)}`];
    if (entry.partner) {
      const theory = this.bodies ? this.bodies.hz : this.shapes.theory.map((mode) => mode.hz);
      const count = entry.partner.modes.length;
      const hz = [...new Set(entry.partner.modes.map((part) => digits(theory[part[0]], 5)))];
      parts.push(`${T('theory')} ${hz.join(', ')} Hz${count > hz.length ? ` (${count}${T('-fold')})` : ''}`);
      if (entry.partner.error_percent !== null) parts.push(`${T('error')} ${signed(entry.partner.error_percent)} %`);
      if (entry.partner.mac !== null) parts.push(`MAC ${entry.partner.mac.toFixed(3)}`);
    } else if (this.compared()) parts.push(T('without a partner'));
    this.description.textContent = parts.join(' · ');
    this.draw();
  }

  /** Complex displacements of the test and of the theory at the points of the test, and of the bodies, in one scale. */
  motion(entry) {
    const empty = () => this.shapes.points.map(() => ({ re: [0, 0, 0], im: [0, 0, 0], known: false }));
    const points = (values) => {
      const all = empty();
      this.shapes.readings.forEach((reading, k) => {
        if (values.re[k] === null) return;
        const point = all[reading.point];
        point.known = true;
        for (let axis = 0; axis < 3; axis++) {
          point.re[axis] += values.re[k] * reading.direction[axis];
          point.im[axis] += (values.im[k] || 0) * reading.direction[axis];
        }
      });
      return all;
    };
    const sum = (parts, of) => {
      let total = null;
      for (const [j, re, im] of parts) {
        const one = of(j);
        if (!one) return null;
        total = total || { re: one.re.map(() => 0), im: one.re.map(() => 0) };
        one.re.forEach((value, k) => {
          if (value === null) { total.re[k] = null; return; }
          const imaginary = one.im[k] || 0;
          if (total.re[k] !== null) total.re[k] += re * value - im * imaginary;
          total.im[k] += im * value + re * imaginary;
        });
      }
      return total;
    };
    const test = entry.test === null ? null : points(this.shapes.test[entry.test]);
    const atSensors = entry.partner && sum(entry.partner.modes, (j) => this.shapes.theory[j]);
    const theory = atSensors ? points(atSensors) : null;
    const bodies = entry.partner && this.bodies ? sum(entry.partner.modes, (j) => this.bodies.modes[j] && { re: this.bodies.modes[j], im: [] }) : null;
    const size = (all) => Math.max(0, ...(all || []).map((point) => Math.hypot(...point.re, ...point.im)));
    let largest = Math.max(size(test), size(theory));
    if (bodies) {
      let moved = 0;
      this.bodies.nodes.forEach((node, n) => {
        const part = (k) => Math.hypot(bodies.re[6 * n + k], bodies.im[6 * n + k]);
        const turning = Math.hypot(part(3), part(4), part(5)) * this.lever(node, n);
        moved = Math.max(moved, Math.hypot(part(0), part(1), part(2)) + turning);
      });
      largest = Math.max(largest, largest > 0 ? 0.4 * moved : moved);
    }
    return { test, theory, bodies, unit: largest > 0 ? 1 / largest : 0 };
  }

  toggle() {
    this.state.play = !this.state.play;
    this.player.textContent = this.state.play ? T('Pause') : T('Play');
    this.animate();
  }

  animate() {
    let before = null;
    const step = (now) => {
      if (!this.host.isConnected || !this.state.play) return;
      if (this.host.offsetParent !== null) {
        if (before !== null) this.state.phase += 0.0045 * this.state.speed * Math.min(60, now - before);
        this.draw();
      }
      before = now;
      requestAnimationFrame(step);
    };
    if (this.state.play) requestAnimationFrame(step);
  }

  draw() {
    for (const view of this.views) view.draw();
  }

  /** A point in the coordinates of the view, displaced by the motion at the present phase. */
  moved(at, motion, n, k) {
    const scale = motion ? this.state.amplitude * this.shape.unit * this.size : 0;
    const [c, s] = [Math.cos(this.state.phase), Math.sin(this.state.phase)];
    return at.map((x, axis) => {
      const moved = motion ? motion.re[6 * n + k + axis] * c - motion.im[6 * n + k + axis] * s : 0;
      return (x + scale * moved - this.center[axis]) / this.size;
    });
  }

  place(point, displacement) {
    return this.moved(point.at_m, displacement && { re: displacement.re, im: displacement.im }, 0, 0);
  }

  scene(pen, what) {
    if (!this.shape) return;
    const { shapes, shape } = this;
    const still = shapes.points.map((point) => this.place(point, null));
    const joined = (places, color, width, dash) => shapes.lines.forEach(([a, b]) => pen.lines([places[a], places[b]], color, width, dash));
    joined(still, palette.axis, 1);
    still.forEach((at) => pen.dot(at, palette.axis, 2));
    if (this.state.bodies && this.bodies && what !== 'test') this.drawBodies(pen);
    const part = (displacements, color, dash, square) => {
      const places = shapes.points.map((point, k) => this.place(point, displacements[k].known ? displacements[k] : null));
      joined(places, color, 2, dash);
      places.forEach((at, k) => {
        if (!displacements[k].known) return;
        pen.lines([still[k], at], color, 0.8);
        pen.dot(at, color, square ? 3 : 4, square);
      });
    };
    if (shape.theory && what !== 'test') part(shape.theory, palette.series[1], [6, 4], true);
    if (shape.test && what !== 'theory') part(shape.test, palette.series[0], [], false);
    this.key(pen, what);
  }

  key(pen, what) {
    const names = [];
    if (what !== 'theory' && this.shape.test) names.push([T('test'), palette.series[0]]);
    if (what !== 'test' && (this.shape.theory || this.shape.bodies)) names.push([T('theory'), palette.series[1]]);
    names.push([T('undeformed'), palette.axis]);
    names.forEach(([text, color], n) => {
      pen.pen.fillStyle = color;
      pen.pen.fillRect(14, 14 + 18 * n, 14, 4);
      pen.pen.fillStyle = palette.ink;
      pen.pen.font = '12px system-ui, sans-serif';
      pen.pen.textAlign = 'left';
      pen.pen.fillText(text, 34, 20 + 18 * n);
    });
  }

  /** Discs of rigid bodies with a mark that shows their rotation; beams as lines through their nodes. */
  drawBodies(pen) {
    const { nodes } = this.bodies;
    const motion = this.shape.bodies;
    nodes.forEach((node, n) => {
      const next = nodes[n + 1];
      const color = palette.series[1];
      if (!this.radii[n]) {
        if (next && next.body === node.body) {
          pen.lines([this.moved(node.at_m, null, n, 0), this.moved(next.at_m, null, n, 0)], palette.grid, 3);
          pen.pen.globalAlpha = 0.45;
          pen.lines([this.moved(node.at_m, motion, n, 0), this.moved(next.at_m, motion, n + 1, 0)], color, 7);
          pen.pen.globalAlpha = 1;
        }
        return;
      }
      const axes = node.axes.length ? node.axes : [[0, 0, 1]];
      for (const axis of axes) {
        pen.lines(this.ring(node, n, axis, null), palette.grid, 1);
        const ring = this.ring(node, n, axis, motion);
        pen.fill(ring, color, 0.1);
        pen.lines(ring, color, 1.2);
        pen.lines([this.moved(node.at_m, motion, n, 0), ring[0]], color, 1);
      }
    });
  }

  ring(node, n, axis, motion) {
    const helper = Math.abs(axis[0]) < 0.9 ? [1, 0, 0] : [0, 1, 0];
    const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    const unit = (v) => v.map((x) => x / Math.hypot(...v));
    const u = unit(cross(axis, helper));
    const v = cross(unit(axis), u);
    const radius = this.radii[n];
    const points = [];
    for (let k = 0; k <= 40; k++) {
      const t = (k * Math.PI) / 20;
      const arm = [0, 1, 2].map((i) => radius * (Math.cos(t) * u[i] + Math.sin(t) * v[i]));
      const at = node.at_m.map((x, i) => x + arm[i]);
      if (!motion) {
        points.push(this.moved(at, null, 0, 0));
        continue;
      }
      const of = (values, from) => [0, 1, 2].map((i) => values[6 * n + from + i]);
      const moved = (values) => {
        const turned = cross(of(values, 3), arm).map((x) => (x * this.lever(node, n)) / radius);
        return of(values, 0).map((x, i) => x + turned[i]);
      };
      points.push(this.moved(at, { re: moved(motion.re), im: moved(motion.im) }, 0, 0));
    }
    return points;
  }
}
