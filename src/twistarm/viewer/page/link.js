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
    if (message.number === this.underway) this.underway = 0;
    this.flush();
    if (this.underway === 0) this.on.idle();
  }

  // A request of the same kind about the same thing that still waits is replaced.
  send(request) {
    this.pending.set([request.type, request.name ?? request.what].join(":"), request);
    this.flush();
  }

  flush() {
    if (this.underway || this.socket.readyState !== WebSocket.OPEN || this.pending.size === 0) return;
    const [key, request] = this.pending.entries().next().value;
    this.pending.delete(key);
    this.underway = ++this.number;
    this.socket.send(JSON.stringify({ ...request, number: this.underway }));
  }
}
