// The road from above: everybody's place drawn smoothly, the learner's path behind it, cars that can be dragged.
import { ask } from './link.js';

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const still = matchMedia('(prefers-reduced-motion: reduce)');
/** Robots are drawn larger than they are, or they would hardly be seen. */
const LARGER = 1.6;
const PATH = 400;
/** Farther than this nobody drives in one step, in metres. */
const FARTHEST = 0.08;

export class Road {
  constructor(world, lane) {
    this.world = world;
    this.figure = document.createElement('figure');
    this.figure.className = 'lane';
    this.figure.innerHTML = '<canvas tabindex="0" role="img"></canvas><figcaption><span class="name"></span><span class="cost"></span></figcaption>';
    this.canvas = this.figure.querySelector('canvas');
    this.lane = lane;
    this.path = [];
    this.sum = { motor: 0, looks: 0 };
    this.listen();
  }

  /** Takes in a new decision of this lane. */
  show(frame, secs) {
    const now = frame.lanes[this.lane];
    if (!now) return;
    const jumped = this.now && frame.done
      && (frame.episode !== this.episode || frame.source !== this.source || frame.step < this.step);
    if (!this.now || jumped || !frame.done) { this.path = []; this.sum = { motor: 0, looks: 0 }; }
    if (frame.done && !frame.past) {
      this.sum.motor += now.motor;
      this.sum.looks += now.look_price;
      if (now.from.length) this.path.push(now.from[0]);
      if (this.path.length > PATH) this.path.shift();
    }
    [this.now, this.began, this.secs] = [now, performance.now(), still.matches ? 0 : secs];
    [this.episode, this.source, this.step] = [frame.episode, frame.source, frame.step];
    this.figure.querySelector('.name').textContent = now.driver;
    this.figure.querySelector('.cost').textContent = this.cost(frame);
    this.canvas.setAttribute('aria-label', this.words(frame));
  }

  words({ source }) {
    const others = `${Math.max(0, this.now.from.length - 1)} other cars`;
    if (source === 'body') return `${this.now.driver} drives a body${this.now.from.length ? `, ${others}` : ''}`;
    return `${this.now.driver} on the road, ${others}; arrow keys with Shift move the car`;
  }

  cost(frame) {
    if (frame.source === 'training' || !frame.done) return frame.done ? '' : 'not carried out';
    const text = value => value.toFixed(1).replace('-', '−');
    return `this episode ${text(this.sum.motor - this.sum.looks)}`;
  }

  /** Where everybody is at this moment between two steps. */
  poses() {
    const share = this.secs > 0 ? Math.min(1, (performance.now() - this.began) / (1000 * this.secs)) : 1;
    return this.now.from.map((from, i) => {
      const to = this.now.to[i] ?? from;
      const turn = Math.atan2(Math.sin(to.heading_rad - from.heading_rad), Math.cos(to.heading_rad - from.heading_rad));
      return { x: from.x + share * (to.x - from.x), y: from.y + share * (to.y - from.y), heading: from.heading_rad + share * turn };
    });
  }

  /** Where body `i` is on the screen. */
  where(i) {
    if (!this.now?.from.length) return null;
    const [box, scale, pose] = [this.canvas.getBoundingClientRect(), this.scale(), this.poses()[i]];
    return [box.x + scale.x(pose.x), box.y + scale.y(pose.y)];
  }

  scale() {
    const road = this.world.roads[this.now.road];
    if (!road.bounds) {
      const xs = road.middle.map(p => p[0]), ys = road.middle.map(p => p[1]), room = 0.75 * road.width_m;
      road.bounds = [Math.min(...xs) - room, Math.max(...xs) + room, Math.min(...ys) - room, Math.max(...ys) + room];
    }
    const [left, right, low, high] = road.bounds;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const k = Math.min(w / (right - left), h / (high - low));
    return { k, x: x => w / 2 + (x - (left + right) / 2) * k, y: y => h / 2 - (y - (low + high) / 2) * k,
      back: (px, py) => [(px - w / 2) / k + (left + right) / 2, (h / 2 - py) / k + (low + high) / 2] };
  }

  draw() {
    if (!this.now || !this.canvas.clientWidth) return;
    const dense = window.devicePixelRatio || 1;
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight].map(n => Math.round(n * dense));
    if (this.canvas.width !== w || this.canvas.height !== h) [this.canvas.width, this.canvas.height] = [w, h];
    const pen = this.canvas.getContext('2d');
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    if (!this.now.from.length) { this.drawNowhere(pen); return; }
    const scale = this.scale();
    this.drawRoad(pen, scale);
    const poses = this.poses();
    this.drawPath(pen, scale, poses[0]);
    poses.slice(1).forEach(pose => this.drawRobot(pen, scale, pose, css('--px-car')));
    this.drawRobot(pen, scale, poses[0], css('--px-mark'));
    if (this.now.accident) this.drawCrash(pen, scale, poses[0]);
  }

  /** A body on a floor: without a supervisor nobody knows where it is. */
  drawNowhere(pen) {
    const [w, h] = [this.canvas.clientWidth, this.canvas.clientHeight];
    pen.fillStyle = css('--panel');
    pen.fillRect(0, 0, w, h);
    pen.fillStyle = css('--muted');
    pen.textAlign = 'center';
    pen.font = '600 15px system-ui';
    pen.fillText('No view from above', w / 2, h / 2 - 8);
    pen.font = '13px system-ui';
    pen.fillText('Nobody watches this body from above, so nobody knows where it is.', w / 2, h / 2 + 14, w - 24);
  }

  drawRoad(pen, scale) {
    const road = this.world.roads[this.now.road];
    pen.fillStyle = css('--px-side');
    pen.fillRect(0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
    const line = new Path2D();
    road.middle.forEach(([x, y], i) => (i ? line.lineTo(scale.x(x), scale.y(y)) : line.moveTo(scale.x(x), scale.y(y))));
    line.closePath();
    pen.lineJoin = 'round';
    const stroke = (colour, width, dash = []) => {
      [pen.strokeStyle, pen.lineWidth] = [colour, width];
      pen.setLineDash(dash);
      pen.stroke(line);
    };
    const wide = road.width_m * scale.k;
    stroke(css('--px-line'), wide + 2);
    stroke(css('--px-road'), wide - 2);
    stroke(css('--px-line'), Math.max(1.2, 0.012 * scale.k), [0.06 * scale.k, 0.045 * scale.k]);
    pen.setLineDash([]);
  }

  drawPath(pen, scale, here) {
    pen.strokeStyle = css('--px-mark');
    pen.lineWidth = 2;
    pen.globalAlpha = 0.75;
    pen.beginPath();
    let last = null;
    for (const p of [...this.path, here]) {
      // Of a run only some steps are shown: what lies between them is not known.
      const known = last && Math.hypot(p.x - last.x, p.y - last.y) < FARTHEST;
      if (known) pen.lineTo(scale.x(p.x), scale.y(p.y));
      else pen.moveTo(scale.x(p.x), scale.y(p.y));
      last = p;
    }
    pen.stroke();
    pen.globalAlpha = 1;
  }

  drawRobot(pen, scale, { x, y, heading }, colour) {
    const radius = Math.max(6, LARGER * this.world.radius_m * scale.k);
    const [px, py] = [scale.x(x), scale.y(y)];
    pen.beginPath();
    pen.arc(px, py, radius, 0, 2 * Math.PI);
    [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = [colour, css('--px-line'), 2];
    pen.fill();
    pen.stroke();
    pen.beginPath();
    pen.moveTo(px, py);
    pen.lineTo(px + 1.7 * radius * Math.cos(heading), py - 1.7 * radius * Math.sin(heading));
    pen.strokeStyle = '#000';
    pen.lineWidth = 4;
    pen.stroke();
    pen.strokeStyle = css('--px-line');
    pen.lineWidth = 2;
    pen.stroke();
  }

  drawCrash(pen, scale, { x, y }) {
    pen.font = `700 ${Math.round(0.16 * scale.k)}px system-ui`;
    pen.textAlign = 'center';
    [pen.fillStyle, pen.strokeStyle, pen.lineWidth] = ['#fff', '#000', 4];
    pen.strokeText('✕', scale.x(x), scale.y(y) - 0.08 * scale.k);
    pen.fillText('✕', scale.x(x), scale.y(y) - 0.08 * scale.k);
  }

  /** A body is where it is; a car of the simulated world can be put elsewhere. */
  movable() { return Boolean(this.now?.from.length) && this.source !== 'body'; }

  /** Cars are dragged with any pointer, or moved with Shift and the arrow keys (Ctrl turns). */
  listen() {
    let held = null, last = 0;
    const spot = event => {
      const box = this.canvas.getBoundingClientRect();
      return this.scale().back(event.clientX - box.left, event.clientY - box.top);
    };
    this.canvas.addEventListener('pointerdown', event => {
      if (!this.movable()) return;
      const [x, y] = spot(event);
      const near = this.poses().map((p, i) => [Math.hypot(p.x - x, p.y - y), i]).sort((a, b) => a[0] - b[0])[0];
      held = near && near[0] < 0.12 ? near[1] : null;
      if (held !== null) this.canvas.setPointerCapture(event.pointerId);
    });
    this.canvas.addEventListener('pointermove', event => {
      if (held === null || event.timeStamp - last < 40) return;
      last = event.timeStamp;
      const [x, y] = spot(event);
      ask('place', { body: held, x, y });
    });
    this.canvas.addEventListener('pointerup', event => {
      if (held !== null) { const [x, y] = spot(event); ask('place', { body: held, x, y }); }
      held = null;
    });
    this.canvas.addEventListener('wheel', event => {
      if (held === null) return;
      event.preventDefault();
      this.turn(held, event.deltaY > 0 ? -0.1 : 0.1);
    }, { passive: false });
    this.canvas.addEventListener('keydown', event => this.nudge(event));
  }

  nudge(event) {
    const moves = { ArrowUp: [0, 1], ArrowDown: [0, -1], ArrowLeft: [-1, 0], ArrowRight: [1, 0] };
    const move = moves[event.key];
    if (!move || !this.movable() || !(event.shiftKey || event.ctrlKey)) return;
    event.preventDefault();
    event.stopPropagation();
    if (event.ctrlKey) return this.turn(0, -0.1 * move[0]);
    const at = this.poses()[0];
    return ask('place', { body: 0, x: at.x + 0.02 * move[0], y: at.y + 0.02 * move[1] });
  }

  turn(body, angle) {
    const at = this.poses()[body];
    ask('place', { body, x: at.x, y: at.y, heading: at.heading + angle });
  }
}
