// At the wheel: keys, buttons, touch, gamepad; the clock; and how the demonstration goes.
import { ask } from './link.js';

const $ = id => document.getElementById(id);
/** Keys of the five motor actions: three arrows and two others, as in the paper; the down arrow and digits serve, too. */
const KEYS = { ArrowUp: 0, m: 1, M: 1, s: 2, S: 2, ArrowDown: 2, ArrowRight: 3, ArrowLeft: 4, 1: 0, 2: 1, 3: 2, 4: 3, 5: 4 };
const HINTS = ['↑', 'M', '↓', '→', '←'];
const SPEEDS = [0.25, 0.5, 1, 2, 4, 8, 16, 0];
/** Least time between two steps of a key that is held down while the clock stands. */
const REPEAT_MS = 140;

let status = null;
const down = new Set();
let last = 0;
/** What the gamepad held when it was read last. */
let held = [];

export function begin(world) {
  world.actions.forEach((name, action) => $('pad').append(padButton(name, action)));
  for (const times of SPEEDS) $('speed').add(new Option(times ? `×${times}` : 'as fast as possible', times, false, times === 1));
  $('speed').onchange = () => ask('speed', { times: Number($('speed').value) });
  $('run').onclick = runOrPause;
  $('step').onclick = () => ask('step');
  $('brake').onclick = () => ask('brake');
  $('reset').onclick = () => ask('reset');
  $('undo').onclick = () => ask('undo');
  $('save').onclick = () => ask('save');
  $('demonstrate').onclick = () => {
    if (status?.demonstration) ask('watch', { driver: status.at_the_wheel[0] });
    else { ask('demonstrate'); $('demonstrate').blur(); }
  };
  addEventListener('keydown', press);
  addEventListener('keyup', event => { if (event.key in KEYS) lift(KEYS[event.key]); });
  addEventListener('blur', () => [...down].forEach(lift));
  setInterval(readGamepad, 50);
}

const watchesRun = () => status?.view === 'training';
const isRunning = () => (watchesRun() ? status.training?.state === 'running' : status?.running);

/** What is on the stage runs or stands: the studio's own drive, or the training run. */
function runOrPause() {
  ask((isRunning() ? 'pause' : 'resume') + (watchesRun() ? '_training' : ''));
}

function padButton(name, action) {
  const button = document.createElement('button');
  button.dataset.at = action;
  button.innerHTML = `<span></span> <kbd>${HINTS[action]}</kbd>`;
  button.firstChild.textContent = name;
  button.addEventListener('pointerdown', event => { event.preventDefault(); drive(action); });
  for (const end of ['pointerup', 'pointercancel', 'pointerleave']) button.addEventListener(end, () => lift(action));
  // Enter and Space press a button without a pointer.
  button.addEventListener('click', event => { if (event.detail === 0) { drive(action); lift(action); } });
  return button;
}

function typing(target) {
  return target.matches?.('select, textarea, input:not([type=checkbox]), [role=tab]');
}

function press(event) {
  if (event.altKey || event.ctrlKey || event.metaKey || event.shiftKey && event.key.startsWith('Arrow') || typing(event.target)) return;
  const onButton = event.target.matches?.('button, input, summary');
  if (event.key in KEYS && status?.demonstration) {
    event.preventDefault();
    if (!event.repeat || (!status.running && event.timeStamp - last > REPEAT_MS)) {
      last = event.timeStamp;
      drive(KEYS[event.key]);
    }
  } else if (event.key === ' ' && !onButton) {
    event.preventDefault();
    runOrPause();
  } else if (event.key === 'Escape' && status?.view === 'body') ask('brake');
  else if (event.key === '.') ask('step');
  else if (event.key === 'u' || event.key === 'U' || event.key === 'Backspace') ask('undo');
}

function drive(action) {
  if (!status?.demonstration) return;
  down.add(action);
  mark();
  ask('press', { action });
}

function lift(action) {
  if (!down.delete(action)) return;
  mark();
  if (status?.running && !down.size) ask('lift');
}

function mark() {
  for (const button of $('pad').children) button.classList.toggle('down', down.has(Number(button.dataset.at)));
}

/** Stick or cross turns, A is fast, X medium, B slow. */
function readGamepad() {
  const pad = status?.demonstration && navigator.getGamepads?.().find(p => p);
  if (!pad) return;
  const pressed = i => pad.buttons[i]?.pressed;
  const wishes = [pressed(0) || pressed(7) || pressed(12), pressed(2), pressed(1) || pressed(13),
    pad.axes[0] > 0.5 || pressed(15), pad.axes[0] < -0.5 || pressed(14)];
  wishes.forEach((wish, action) => {
    if (wish && !down.has(action)) drive(action);
    if (!wish && down.has(action) && held[action]) lift(action);
  });
  held = wishes;
}

/** Shows how things stand. */
export function show(news, mine) {
  status = news;
  const words = isRunning() ? ['▮▮', 'Pause'] : ['▶', 'Run'];
  $('run').children[0].textContent = words[0];
  $('run').children[1].textContent = words[1];
  $('speed').value = String(news.times);
  for (const control of ['step', 'reset', 'speed']) $(control).disabled = watchesRun();
  $('brake').hidden = news.view !== 'body';
  $('brake').disabled = news.braked;
  $('brake').textContent = news.braked ? 'Stopped for good' : 'Stop the wheels (Esc)';
  const shown = news.demonstration;
  $('demonstrate').textContent = shown ? 'Leave the wheel' : 'Take the wheel';
  for (const control of [$('undo'), $('save'), ...$('pad').children]) control.disabled = !shown || !mine;
  $('undo').disabled ||= !shown?.undoable;
  $('save').disabled ||= !shown?.unsaved;
  $('undo').textContent = shown?.undoable ? `Undo (${shown.undoable})` : 'Undo';
  const steps = shown?.quality.steps ?? 0, wanted = shown?.wanted ?? 200;
  const [, done, count, of] = $('ring').children;
  done.style.strokeDasharray = `${Math.min(100, 100 * steps / wanted)} 100`;
  count.textContent = steps;
  of.textContent = `of ${wanted}`;
  $('ring').setAttribute('aria-label', `${steps} of ${wanted} steps shown`);
  $('saved').textContent = news.saved ? `Saved: ${news.saved}` : 'Press a key for a step, or let the clock run.';
  quality(shown?.quality);
}

function quality(found) {
  const rows = found?.steps ? [
    ['accidents', `${found.accidents}`],
    ['unlike the expert', `${Math.round(100 * found.disagreement)} %`],
    ['reward per step', found.motor.toFixed(2).replace('-', '−')],
  ] : [];
  $('quality').replaceChildren(...rows.flatMap(([term, value]) => {
    const [dt, dd] = [document.createElement('dt'), document.createElement('dd')];
    [dt.textContent, dd.textContent] = [term, value];
    return [dt, dd];
  }));
}
