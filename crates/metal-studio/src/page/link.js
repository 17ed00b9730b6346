// The one connection to the studio: requests out, news in, and patience when it is lost.

const listeners = new Map();
let socket = null;
let delay = 250;

/** Calls `hear` with every piece of news of this kind: frame, past, status, hello, refused, link. */
export function on(kind, hear) {
  listeners.set(kind, [...(listeners.get(kind) ?? []), hear]);
}

function tell(kind, news) {
  for (const hear of listeners.get(kind) ?? []) hear(news);
}

/** Asks the studio for something; lost while there is no connection. */
export function ask(what, details = {}) {
  if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify({ do: what, ...details }));
}

/** Opens the connection, and opens it again whenever it is lost. */
export function connect() {
  const address = new URL('live', location.href);
  address.protocol = 'ws:';
  socket = new WebSocket(address);
  socket.onopen = () => { delay = 250; tell('link', true); };
  socket.onmessage = event => {
    stats.bytes += event.data.length;
    const news = JSON.parse(event.data);
    for (const kind of Object.keys(news)) tell(kind, news[kind]);
  };
  socket.onclose = () => {
    tell('link', false);
    setTimeout(connect, delay);
    delay = Math.min(delay * 2, 4000);
  };
}

/** What came over the wire so far; tests and the curious read it. */
export const stats = { bytes: 0, frames: 0, drawn: 0, drops: 0 };
on('frame', () => { stats.frames += 1; });
on('link', up => { if (!up) stats.drops += 1; });
window.studio = { stats, ask };
