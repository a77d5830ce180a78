// A motion as a film. Each frame shows its own moment, even if the browser draws slowly.

import { painted } from "./picture.js";
import { webm } from "./webm.js";

const BITS = 0.2; // for each pixel of a frame
const ALONE = 1; // s between frames that can be sought
const WAITING = 4; // frames that may wait for the encoder

// A WebM of `duration` s. `act` holds begin(), show(time), which brings a moment into view, tell(share), which hears of
// the progress, and stopped(), which ends it without a film.
export async function film(view, { width, height, rate, duration }, { begin, show, report, stopped }) {
  const count = Math.max(2, Math.ceil(duration * rate - 1e-9));
  const config = { codec: "vp8", width, height, framerate: count / duration, bitrate: Math.ceil(BITS * width * height * rate) };
  const able = globalThis.VideoEncoder && (await VideoEncoder.isConfigSupported(config)).supported;
  if (!able) throw new Error(`This browser cannot record a WebM of ${width} × ${height} pixels. Open the page in Chrome, Edge or Firefox on this computer.`);
  await begin();
  const frames = [];
  let wrong = null;
  const encoder = new VideoEncoder({
    output(chunk) {
      const data = new Uint8Array(chunk.byteLength);
      chunk.copyTo(data);
      frames.push({ data, time: Math.round(chunk.timestamp / 1000), key: chunk.type === "key" });
    },
    error: (error) => { wrong = error; },
  });
  encoder.configure(config);
  while (view.soon !== null) await pause(); // the view finishes what it has received
  for (let i = 0, key = 0; i < count && !stopped() && !wrong; i++) {
    const time = (i * duration) / count;
    await show(i === count - 1 ? duration : time); // the last shows the end
    const frame = new VideoFrame(painted(view, width, height), { timestamp: 1e6 * time });
    encoder.encode(frame, { keyFrame: time >= key });
    frame.close();
    if (time >= key) key += ALONE;
    report((i + 1) / count);
    do await pause(); while (encoder.encodeQueueSize > WAITING);
  }
  if (!wrong) await encoder.flush();
  if (wrong) throw wrong;
  encoder.close();
  return stopped() ? null : webm(frames, { width, height, duration: 1000 * duration });
}

const pause = () => new Promise((resolve) => setTimeout(resolve));
