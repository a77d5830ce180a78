// The socket to the process: reconnects by itself, and has at most one request under way, so that the latest wins.

const RETRY = 1000; // ms
const PROBE = 5000; // ms that a process has to answer whether it knows this page
const PATIENCE = 10000; // ms after which a request without an answer holds up the others no longer
const EACH = ["record", "reorder", "delete", "undo", "redo", "press"]; // requests that add up: none stands for an earlier one

export class Link {
  /** @type {WebSocket} */ socket;
  kind = "live";

  // `on` holds message(object), object(bytes), status("live" | "offline"), idle(), refused().
  constructor(on) {
    this.on = on;
    this.pending = new Map();
    this.number = 0;
    this.underway = 0;
    this.connect();
  }

  connect() {
    const address = new URL("socket", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    let opened = false;
    this.socket.onopen = () => {
      opened = true;
      this.reset();
      this.on.status("live");
    };
    this.socket.onmessage = ({ data }) => this.receive(data);
    this.socket.onclose = () => this.lose(opened);
  }

  // Whatever was asked, or waits, is nobody's any more.
  reset() {
    this.pending.clear();
    this.answered();
  }

  // A token that is refused stays wrong: each start of a view has another.
  async lose(opened) {
    this.reset();
    this.on.status("offline");
    if (!opened && (await refuses())) return this.on.refused();
    setTimeout(() => this.connect(), RETRY);
  }

  receive(data) {
    if (data instanceof ArrayBuffer) return this.on.object(new Uint8Array(data));
    const message = JSON.parse(data);
    if (message.type !== "done") return this.on.message(message);
    // Requests are answered in their order, and of two answers that wait the process keeps the later.
    if (message.number >= this.underway) this.answered();
    this.proceed();
  }

  answered() {
    this.underway = 0;
    clearTimeout(this.patience);
  }

  proceed() {
    this.flush();
    if (!this.underway) this.on.idle();
  }

  // A request of the same kind about the same thing that still waits is replaced. False where there is nobody to ask.
  send(request) {
    if (this.socket.readyState !== WebSocket.OPEN) return false;
    const place = EACH.includes(request.type) ? Symbol(request.type) : key(request);
    this.pending.delete(place); // what is asked last is done last
    this.pending.set(place, request);
    this.flush();
    return true;
  }

  // At once, ahead of whatever waits and without waiting for what is under way; what it calls off is not sent any more.
  interrupt(request, ...calledOff) {
    for (const old of calledOff) this.pending.delete(key(old));
    if (this.socket.readyState === WebSocket.OPEN) this.transmit(request);
  }

  flush() {
    if (this.underway || this.socket.readyState !== WebSocket.OPEN || this.pending.size === 0) return;
    const [[place, request]] = this.pending;
    this.pending.delete(place);
    this.underway = this.transmit(request);
    this.patience = setTimeout(() => {
      this.answered();
      this.proceed();
    }, PATIENCE);
  }

  transmit(request) {
    this.number += 1;
    this.socket.send(JSON.stringify({ ...request, number: this.number }));
    return this.number;
  }
}

// Whether a process answers that does not know this page: it has another token.
async function refuses() {
  try {
    return (await fetch("schema.json", { cache: "no-store", signal: AbortSignal.timeout(PROBE) })).status === 403;
  } catch {
    return false; // nobody answers
  }
}

const key = (request) => [request.type, request.id ?? request.name ?? request.what].join(":");
