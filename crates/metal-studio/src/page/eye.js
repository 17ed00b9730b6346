// What the camera and the infra-red ring show: attended parts lit, the rest dark, because nobody looked there.

const css = name => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const CLASSES = ['--px-road', '--px-line', '--px-car', '--px-side'];
/** Directions of ps0 … ps7 in degrees, left positive, 0 ahead. */
const AZIMUTHS = [-17.23, -45.88, -90, -151.49, 151.22, 90, 45.79, 17.14];

export class Eye {
  constructor(world) {
    this.world = world;
    this.figure = document.createElement('figure');
    this.figure.className = 'eye';
    this.figure.innerHTML = '<canvas class="picture" role="img"></canvas><canvas class="ring" role="img"></canvas><figcaption></figcaption>';
    this.picture = this.figure.querySelector('.picture');
    this.ring = this.figure.querySelector('.ring');
  }

  /** Draws what was seen after the first `count` looks. */
  draw(lane, { count, unseen, faults, named }) {
    const sensors = new Map();
    lane.asked.slice(0, count).forEach((member, i) => {
      for (const sensor of this.world.members[member].sensors) if (!sensors.has(sensor)) sensors.set(sensor, i + 1);
    });
    this.figure.querySelector('figcaption').textContent = named ? lane.driver : '';
    this.figure.querySelector('figcaption').hidden = !named;
    this.drawPicture(lane, sensors, unseen, faults);
    this.drawRing(lane, sensors.get(6), unseen, faults[6]);
    const names = [...sensors.keys()].map(s => this.world.sensors[s].name).join(', ') || 'nothing';
    this.picture.setAttribute('aria-label', `The camera's picture; looked at ${names}`);
  }

  pen(canvas, width, height) {
    const dense = window.devicePixelRatio || 1;
    const [w, h] = [Math.round(canvas.clientWidth * dense), Math.round(canvas.clientWidth * dense * height / width)];
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    const pen = canvas.getContext('2d');
    pen.setTransform(w / width, 0, 0, w / width, 0, 0);
    pen.clearRect(0, 0, width, height);
    return pen;
  }

  drawPicture(lane, sensors, unseen, faults) {
    const pen = this.pen(this.picture, 52, 39);
    pen.imageSmoothingEnabled = false;
    pen.drawImage(this.develop(lane.image), 0, 0);
    this.world.regions.forEach((r, sensor) => {
      const box = [r.left, r.top, r.right - r.left, r.bottom - r.top];
      const order = sensors.get(sensor);
      if (faults[sensor] !== 'fine' && order) this.spoil(pen, box, faults[sensor]);
      if (!order) {
        pen.fillStyle = css('--px-shade');
        pen.globalAlpha = unseen ? 0.6 : 0.93;
        pen.fillRect(...box);
        pen.globalAlpha = 1;
      }
      this.frame(pen, box, r.name, order);
    });
  }

  /** The picture at its own size, one pixel each. */
  develop(image) {
    this.film ??= Object.assign(document.createElement('canvas'), { width: 52, height: 39 });
    const pen = this.film.getContext('2d');
    const colours = CLASSES.map(css);
    image.forEach((row, y) => [...row].forEach((digit, x) => {
      pen.fillStyle = colours[digit];
      pen.fillRect(x, y, 1, 1);
    }));
    return this.film;
  }

  /** A covered or dead region shows nothing; a noisy one is crossed out. */
  spoil(pen, [x, y, w, h], fault) {
    pen.fillStyle = fault === 'noisy' ? 'rgba(255,255,255,.45)' : '#000';
    pen.fillRect(x, y, w, h);
  }

  frame(pen, [x, y, w, h], name, order) {
    pen.lineWidth = order ? 0.55 : 0.18;
    pen.strokeStyle = order ? css('--px-mark') : 'rgba(244,244,240,.5)';
    pen.strokeRect(x + pen.lineWidth / 2, y + pen.lineWidth / 2, w - pen.lineWidth, h - pen.lineWidth);
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.font = '600 2.3px system-ui';
    pen.lineWidth = 0.5;
    pen.strokeStyle = '#000';
    pen.fillStyle = order ? '#fff' : 'rgba(255,255,255,.72)';
    pen.strokeText(name, x + w / 2, y + h / 2);
    pen.fillText(name, x + w / 2, y + h / 2);
    if (!order) return;
    pen.beginPath();
    pen.arc(x + 2.6, y + 2.6, 1.75, 0, 2 * Math.PI);
    pen.fillStyle = css('--px-mark');
    pen.fill();
    pen.fillStyle = '#000';
    pen.font = '700 2.3px system-ui';
    pen.fillText(order, x + 2.6, y + 2.75);
  }

  /** Eight rays around the body; longer means nearer. */
  drawRing(lane, order, unseen, fault) {
    const pen = this.pen(this.ring, 100, 100);
    const lit = Boolean(order), said = (lit || unseen) && lane.infrared.length > 0;
    pen.globalAlpha = lit ? 1 : unseen ? 0.5 : 0.28;
    pen.beginPath();
    pen.arc(50, 50, 16, 0, 2 * Math.PI);
    pen.fillStyle = lit ? css('--px-mark') : css('--grid');
    pen.fill();
    pen.strokeStyle = css('--muted');
    pen.lineWidth = 1;
    pen.stroke();
    AZIMUTHS.forEach((azimuth, i) => this.ray(pen, azimuth, said ? lane.infrared[i] : 0, { lit, said }));
    pen.globalAlpha = 1;
    pen.fillStyle = lit ? '#000' : css('--muted');
    pen.font = '600 9px system-ui';
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillText(lit ? `${order} IR` : 'IR', 50, 50);
    const near = Math.max(0, ...(lit ? lane.infrared : []));
    const words = fault === 'fine' ? `nearest ${Math.round(100 * near)} %` : fault;
    this.ring.setAttribute('aria-label', lit ? `Infra-red ring, ${words}; in per cent, clockwise: ${lane.infrared.map(x => Math.round(100 * x)).join(', ')}` : 'Infra-red ring, not asked');
  }

  ray(pen, azimuth, reading, { lit, said }) {
    // Ahead is up.
    const angle = -(azimuth + 90) * Math.PI / 180;
    const at = radius => [50 + radius * Math.cos(angle), 50 + radius * Math.sin(angle)];
    const line = (from, to, colour, width) => {
      pen.beginPath();
      pen.moveTo(...at(from));
      pen.lineTo(...at(to));
      [pen.strokeStyle, pen.lineWidth, pen.lineCap] = [colour, width, 'round'];
      pen.stroke();
    };
    line(20, 36, css('--grid'), 5);
    if (reading > 0.02) line(20, 20 + 16 * reading, lit ? css('--car') : css('--muted'), 5);
    if (!said) return;
    pen.fillStyle = css('--text');
    pen.font = '7px system-ui';
    pen.textAlign = 'center';
    pen.textBaseline = 'middle';
    pen.fillText(Math.round(100 * reading), ...at(45));
  }
}
