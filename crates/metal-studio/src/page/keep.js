// Keeping what is on the stage: a drawing, a picture, a clip of ten seconds.

const $ = id => document.getElementById(id);
const CLIP_SECS = 10;

const dark = () => {
  const theme = document.documentElement.dataset.theme;
  return theme ? theme === 'dark' : matchMedia('(prefers-color-scheme: dark)').matches;
};

function hand(blob, name) {
  const link = document.createElement('a');
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
  window.studio.kept = { name, bytes: blob.size };
}

async function drawing(address) {
  const answer = await fetch(`${address}${address.includes('?') ? '&' : '?'}file=1&theme=${dark() ? 'dark' : 'light'}`);
  if (!answer.ok) throw new Error('there is nothing to keep yet');
  return answer.text();
}

/** Saves a drawing of the studio as a file of its own. */
export async function download(address, name) {
  hand(new Blob([await drawing(address)], { type: 'image/svg+xml' }), name);
}

async function picture(text, name) {
  const image = new Image();
  const [, , width, height] = text.match(/viewBox="0 0 ([\d.]+) ([\d.]+)"/) ? ['', '', ...text.match(/viewBox="0 0 ([\d.]+) ([\d.]+)"/).slice(1)] : ['', '', 960, 560];
  const sized = text.replace('<svg ', `<svg width="${2 * width}" height="${2 * height}" `);
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(sized)}`;
  await image.decode();
  const canvas = Object.assign(document.createElement('canvas'), { width: 2 * width, height: 2 * height });
  canvas.getContext('2d').drawImage(image, 0, 0, canvas.width, canvas.height);
  canvas.toBlob(blob => hand(blob, name), 'image/png');
}

/** One beside the other in the room there is: two, while two minds are compared. */
function share(what, [x, y, w, h], fit) {
  const all = [...document.querySelectorAll(what)], part = w / all.length;
  all.forEach((source, i) => fit(source, [x + i * part, y, part, h]));
}

/** Road and camera side by side, thirty pictures a second, for ten seconds. */
function film(button) {
  const canvas = Object.assign(document.createElement('canvas'), { width: 1280, height: 560 });
  const pen = canvas.getContext('2d');
  const ground = getComputedStyle(document.body).backgroundColor;
  const paint = () => {
    pen.fillStyle = ground;
    pen.fillRect(0, 0, 1280, 560);
    const fit = (source, [x, y, w, h]) => {
      if (!source?.width) return;
      const k = Math.min(w / source.width, h / source.height);
      pen.drawImage(source, x + (w - k * source.width) / 2, y + (h - k * source.height) / 2, k * source.width, k * source.height);
    };
    share('.lane canvas', [10, 10, 720, 540], fit);
    share('.eye .picture', [750, 10, 520, 390], fit);
    fit(document.querySelector('.eye .ring'), [750, 410, 140, 140]);
    pen.fillStyle = getComputedStyle(document.body).color;
    pen.font = '600 20px system-ui';
    [document.querySelector('.lane .name'), $('looks'), $('facts')].forEach((text, i) => pen.fillText(text?.textContent ?? '', 910, 440 + 34 * i, 360));
  };
  const kind = ['video/webm;codecs=vp9', 'video/webm;codecs=vp8', 'video/webm'].find(k => MediaRecorder.isTypeSupported(k));
  const recorder = new MediaRecorder(canvas.captureStream(30), { mimeType: kind, videoBitsPerSecond: 4e6 });
  const parts = [];
  const started = performance.now();
  const ticking = setInterval(() => {
    paint();
    button.textContent = `${Math.max(0, Math.ceil(CLIP_SECS - (performance.now() - started) / 1000))} s …`;
  }, 33);
  recorder.ondataavailable = event => parts.push(event.data);
  recorder.onstop = () => {
    clearInterval(ticking);
    [button.disabled, button.textContent] = [false, '10 s clip'];
    hand(new Blob(parts, { type: 'video/webm' }), 'metal-clip.webm');
  };
  button.disabled = true;
  paint();
  recorder.start(1000);
  setTimeout(() => recorder.stop(), 1000 * CLIP_SECS);
}

export function begin(complain) {
  const stage = () => `draw/stage?${$('scrub').dataset.past ? `n=${$('scrub').value}` : ''}`;
  const trying = act => async () => { try { await act(); } catch (error) { complain(error.message); } };
  $('svg').onclick = trying(() => download(stage(), 'metal-stage.svg'));
  $('png').onclick = trying(async () => picture(await drawing(stage()), 'metal-stage.png'));
  $('clip').onclick = trying(async () => film($('clip')));
}
