// The colour scale of depth: near is light and warm, far is dark and blue; its lightness falls
// steadily, so that it reads the same in grey and for every kind of colour vision.

const NEAR_TO_FAR: readonly [number, number, number][] = [
  [255, 247, 224],
  [246, 216, 150],
  [158, 196, 139],
  [62, 154, 145],
  [33, 103, 130],
  [26, 58, 98],
  [14, 24, 50],
];

const ENTRIES = 256;

function entry(place: number): [number, number, number] {
  const at = place * (NEAR_TO_FAR.length - 1);
  const k = Math.min(Math.floor(at), NEAR_TO_FAR.length - 2);
  const [a, b] = [NEAR_TO_FAR[k]!, NEAR_TO_FAR[k + 1]!];
  const mix = (i: 0 | 1 | 2) => Math.round(a[i] + (at - k) * (b[i] - a[i]));
  return [mix(0), mix(1), mix(2)];
}

/** RGBA words (little-endian) of the scale, nearest first. */
export const SCALE = Uint32Array.from({ length: ENTRIES }, (_, i) => {
  const [r, g, b] = entry(i / (ENTRIES - 1));
  return (255 << 24) | (b << 16) | (g << 8) | r;
});

/** Draws the scale from top (near) to bottom (far). */
export function drawScale(canvas: HTMLCanvasElement): void {
  canvas.width = 1;
  canvas.height = ENTRIES;
  const context = canvas.getContext("2d")!;
  const image = context.createImageData(1, ENTRIES);
  new Uint32Array(image.data.buffer).set(SCALE);
  context.putImageData(image, 0, 0);
}
