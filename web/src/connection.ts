// The one connection to the server: frames in, commands out, and back again after a break.

import { decodeFrame, type Command, type Frame, type Notice, type State } from "./protocol";

interface Listener {
  frame(frame: Frame): void;
  state(state: State): void;
  connected(connected: boolean, reason: string): void;
  /** The server does not know this browser. */
  refused(): void;
}

const FIRST_WAIT_MS = 300;
const LONGEST_WAIT_MS = 5000;
const REFUSED = 4401; // the server's close code where the session is unknown

export class Connection {
  private socket: WebSocket | null = null;
  private wait = FIRST_WAIT_MS;
  private next = 1;
  private readonly waiting = new Map<number, (error: string | null) => void>();
  private latest: Frame | null = null;
  private overtaken = 0; // frames that came but were replaced before they could be drawn

  constructor(private readonly listener: Listener) {}

  /** Sends a command; resolves to null, or to one sentence that says what went wrong. */
  ask(command: Command): Promise<string | null> {
    const socket = this.socket;
    if (socket?.readyState !== WebSocket.OPEN) return Promise.resolve("There is no connection.");
    const id = this.next++;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      socket.send(JSON.stringify({ id, ...command }));
    });
  }

  open(): void {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    const path = new URL("live/socket", location.href).pathname;
    const socket = new WebSocket(`${scheme}//${location.host}${path}`);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.wait = FIRST_WAIT_MS;
      this.listener.connected(true, "");
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") this.notice(JSON.parse(data) as Notice);
      else this.show(decodeFrame(data as ArrayBuffer));
    };
    socket.onclose = ({ code }) => this.closed(code);
    this.socket = socket;
  }

  private notice(notice: Notice): void {
    if ("state" in notice) this.listener.state(notice.state);
    else {
      this.waiting.get(notice.reply)?.(notice.error);
      this.waiting.delete(notice.reply);
    }
  }

  // A frame is acknowledged when it has been drawn: the server sends no faster than this page
  // can show, and counts what it leaves out.
  private show(frame: Frame): void {
    const idle = this.latest === null;
    this.latest = frame;
    if (!idle) {
      this.overtaken += 1;
      return;
    }
    const draw = () => {
      const shown = this.latest;
      this.latest = null;
      if (!shown) return;
      this.listener.frame({ ...shown, missed: shown.missed + this.overtaken });
      if (this.socket?.readyState === WebSocket.OPEN) {
        this.socket.send(JSON.stringify({ seen: shown.frame }));
      }
    };
    // A hidden page is given no animation frames; it still keeps its decisions up to date.
    if (document.hidden) setTimeout(draw, 250);
    else requestAnimationFrame(draw);
  }

  private closed(code: number): void {
    for (const answer of this.waiting.values()) answer("The connection was lost.");
    this.waiting.clear();
    if (code === REFUSED) {
      this.listener.refused();
      return;
    }
    this.listener.connected(false, "Connection lost. Trying again …");
    setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(2 * this.wait, LONGEST_WAIT_MS);
  }
}
