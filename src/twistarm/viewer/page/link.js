// The socket to the process: reconnects by itself, and has at most one request under way, so that the latest wins.

const RETRY = 1000; // ms

export class Link {
  // `on` holds message(object), object(bytes), status("live" | "offline"), idle().
  constructor(on) {
    this.on = on;
    this.pending = new Map();
    this.number = 0;
    this.connect();
  }

  connect() {
    const address = new URL("socket", location.href);
    address.protocol = address.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(address);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => {
      this.pending.clear();
      this.underway = 0;
      this.on.status("live");
    };
    this.socket.onmessage = ({ data }) => this.receive(data);
    this.socket.onclose = () => {
      this.on.status("offline");
      setTimeout(() => this.connect(), RETRY);
    };
  }

  receive(data) {
    if (data instanceof ArrayBuffer) return this.on.object(new Uint8Array(data));
    const message = JSON.parse(data);
    if (message.type !== "done") return this.on.message(message);
    // Requests are answered in their order, and of two answers that wait the process keeps the later.
    if (message.number >= this.underway) this.underway = 0;
    this.flush();
    if (this.underway === 0) this.on.idle();
  }

  // A request of the same kind about the same thing that still waits is replaced.
  send(request) {
    this.pending.set(key(request), request);
    this.flush();
  }

  // At once, ahead of whatever waits and without waiting for what is under way; what it calls off is not sent any more.
  interrupt(request, ...calledOff) {
    for (const each of calledOff) this.pending.delete(key(each));
    if (this.socket.readyState === WebSocket.OPEN) this.transmit(request);
  }

  flush() {
    if (this.underway || this.socket.readyState !== WebSocket.OPEN || this.pending.size === 0) return;
    const request = this.pending.values().next().value;
    this.pending.delete(key(request));
    this.underway = this.transmit(request);
  }

  transmit(request) {
    this.number += 1;
    this.socket.send(JSON.stringify({ ...request, number: this.number }));
    return this.number;
  }
}

function key(request) {
  return [request.type, request.id ?? request.name ?? request.what].join(":");
}
