// A view of points in space on a canvas: parallel projection, z up, turned by pointer or keys.

class View3d {
  constructor(host, { height = 420, label = '', turn = [-0.6, 0.35], fit = 1, triad = true } = {}) {
    this.host = host;
    this.height = height;
    this.turn = [...turn];
    this.zoom = 1;
    this.size = fit;
    this.triad = triad;
    this.mates = [this];
    this.scene = () => {};
    this.canvas = el('canvas', { tabindex: '0', role: 'img', 'aria-label': `${label}. ${T('drag to rotate, wheel to zoom; with the keyboard the arrows and + −')}` });
    host.append(this.canvas);
    this.listen();
    drawings.add(this);
  }

  /** Both views turn and zoom together. */
  join(other) {
    this.mates = other.mates = [this, other];
  }

  all(change) {
    for (const view of this.mates) {
      change(view);
      view.draw();
    }
  }

  listen() {
    let from = null;
    const { canvas } = this;
    canvas.addEventListener('pointerdown', (event) => {
      from = [event.clientX, event.clientY];
      canvas.setPointerCapture(event.pointerId);
    });
    canvas.addEventListener('pointermove', (event) => {
      if (!from) return;
      const [dx, dy] = [event.clientX - from[0], event.clientY - from[1]];
      from = [event.clientX, event.clientY];
      this.all((view) => view.rotate(0.01 * dx, 0.01 * dy));
    });
    canvas.addEventListener('pointerup', () => { from = null; });
    canvas.addEventListener('wheel', (event) => {
      if (document.activeElement !== canvas && !event.ctrlKey) return;
      event.preventDefault();
      this.all((view) => { view.zoom = Math.max(0.2, Math.min(20, view.zoom * Math.exp(-0.0015 * event.deltaY))); });
    }, { passive: false });
    canvas.addEventListener('keydown', (event) => {
      const turn = { ArrowLeft: [-0.12, 0], ArrowRight: [0.12, 0], ArrowUp: [0, -0.12], ArrowDown: [0, 0.12] }[event.key];
      const zoom = { '+': 1.2, '=': 1.2, '-': 1 / 1.2 }[event.key];
      if (!turn && !zoom) return;
      event.preventDefault();
      this.all((view) => {
        if (turn) view.rotate(...turn);
        else view.zoom *= zoom;
      });
    });
  }

  rotate(yaw, pitch) {
    this.turn[0] += yaw;
    this.turn[1] = Math.max(-Math.PI / 2, Math.min(Math.PI / 2, this.turn[1] + pitch));
  }

  look(yaw, pitch) {
    this.all((view) => {
      view.turn = [yaw, pitch];
      view.zoom = 1;
    });
  }

  draw() {
    const { canvas } = this;
    const width = Math.max(240, this.host.clientWidth || 600);
    const dense = devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * dense) || canvas.height !== Math.round(this.height * dense)) {
      canvas.width = Math.round(width * dense);
      canvas.height = Math.round(this.height * dense);
      canvas.style.width = `${width}px`;
      canvas.style.height = `${this.height}px`;
    }
    const pen = canvas.getContext('2d');
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.fillStyle = palette.paper;
    pen.fillRect(0, 0, width, this.height);
    this.scene(new Pen(pen, this, width));
    if (this.triad) this.axes(pen);
  }

  /** Sets the scale at which these points fill the view in its present direction. */
  fill(points) {
    const width = Math.max(240, this.host.clientWidth || 600);
    this.size = 1;
    const spots = points.map((point) => this.project(point, width));
    const reach = (k, middle) => Math.max(1, ...spots.map((spot) => Math.abs(spot[k] - middle)));
    this.size = Math.min((0.41 * width) / reach(0, width / 2), (0.39 * this.height) / reach(1, this.height / 2), 3);
  }

  /** From space, about -1 to 1, to the screen: x, y, depth. */
  project([x, y, z], width) {
    const [yaw, pitch] = this.turn;
    const [c, s] = [Math.cos(yaw), Math.sin(yaw)];
    const [right, away] = [c * x - s * y, s * x + c * y];
    const unit = 0.36 * Math.min(width, 1.5 * this.height) * this.zoom * this.size;
    const up = z * Math.cos(pitch) + away * Math.sin(pitch);
    return [width / 2 + unit * right, this.height / 2 - unit * up, away * Math.cos(pitch) - z * Math.sin(pitch)];
  }

  /** The three axes, in the corner. */
  axes(pen) {
    const [x0, y0] = [34, this.height - 34];
    pen.font = '11px system-ui, sans-serif';
    pen.textAlign = 'center';
    [[1, 0, 0], [0, 1, 0], [0, 0, 1]].forEach((axis, k) => {
      const [yaw, pitch] = this.turn;
      const right = Math.cos(yaw) * axis[0] - Math.sin(yaw) * axis[1];
      const away = Math.sin(yaw) * axis[0] + Math.cos(yaw) * axis[1];
      const up = axis[2] * Math.cos(pitch) + away * Math.sin(pitch);
      pen.strokeStyle = palette.axis;
      pen.fillStyle = palette.faint;
      pen.beginPath();
      pen.moveTo(x0, y0);
      pen.lineTo(x0 + 20 * right, y0 - 20 * up);
      pen.stroke();
      if (Math.hypot(right, up) > 0.2) pen.fillText('xyz'[k], x0 + 28 * right, y0 - 28 * up + 4);
    });
  }

  save(name) {
    this.canvas.toBlob((blob) => save(name, 'image/png', blob));
  }
}

/** Draws in space. */
class Pen {
  constructor(pen, view, width) {
    this.pen = pen;
    this.at = (point) => view.project(point, width);
  }

  lines(points, color, width = 1.5, dash = []) {
    const { pen } = this;
    pen.strokeStyle = color;
    pen.lineWidth = width;
    pen.setLineDash(dash);
    pen.beginPath();
    points.forEach((point, k) => {
      const [x, y] = this.at(point);
      if (k) pen.lineTo(x, y);
      else pen.moveTo(x, y);
    });
    pen.stroke();
    pen.setLineDash([]);
  }

  fill(points, color, opacity) {
    const { pen } = this;
    pen.globalAlpha = opacity;
    pen.fillStyle = color;
    pen.beginPath();
    points.forEach((point, k) => {
      const [x, y] = this.at(point);
      if (k) pen.lineTo(x, y);
      else pen.moveTo(x, y);
    });
    pen.fill();
    pen.globalAlpha = 1;
  }

  dot(point, color, radius = 3.5, square = false) {
    const { pen } = this;
    const [x, y] = this.at(point);
    pen.fillStyle = color;
    pen.beginPath();
    if (square) pen.rect(x - radius, y - radius, 2 * radius, 2 * radius);
    else pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fill();
  }

  text(point, text, color, align = 'center') {
    const { pen } = this;
    const [x, y] = this.at(point);
    pen.font = '11px system-ui, sans-serif';
    pen.textAlign = align;
    pen.fillStyle = color;
    pen.fillText(text, x, y);
  }

  /** Draws tiles from far to near. */
  tiles(tiles, color) {
    const { pen } = this;
    const placed = tiles.map((tile) => {
      const points = tile.points.map((point) => this.at(point));
      return { tile, points, depth: points.reduce((sum, point) => sum + point[2], 0) };
    });
    placed.sort((a, b) => b.depth - a.depth);
    for (const { tile, points } of placed) {
      pen.fillStyle = color(tile);
      pen.strokeStyle = palette.axis;
      pen.lineWidth = 0.5;
      pen.beginPath();
      points.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
  }
}
