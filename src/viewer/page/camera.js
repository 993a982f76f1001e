// Cameras as the command describes them: angles in degrees about the vertical axis, a centre and a projection. Turning works on axes, so that
// it does not stick at the poles.

/** @typedef {import("./state.js").Camera} Camera */
/** @typedef {{ right: number[], up: number[], to_eye: number[] }} Frame axes of the world at azimuth 0, elevation 0 */

const RADIANS = Math.PI / 180;

/** @param {number[]} a @param {number[]} b */
export const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
/** @param {number[]} a @param {number} k */
export const times = (a, k) => a.map((x) => x * k);
/** @param {number[][]} all */
export const sum = (...all) => [0, 1, 2].map((i) => all.reduce((total, a) => total + a[i], 0));
/** @param {number[]} a */
export const unit = (a) => times(a, 1 / Math.hypot(...a));
/** @param {number[]} a @param {number[]} b */
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];

/** Axes of a camera in the frame: right, up, to the eye. @param {Camera} camera */
export function axes({ azimuth, elevation, roll }) {
  const [a, e, r] = [azimuth, elevation, roll].map((angle) => angle * RADIANS);
  const toEye = [Math.cos(e) * Math.sin(a), Math.sin(e), Math.cos(e) * Math.cos(a)];
  const level = [Math.cos(a), 0, -Math.sin(a)];
  const upright = cross(toEye, level);
  return {
    right: sum(times(level, Math.cos(r)), times(upright, -Math.sin(r))),
    up: sum(times(upright, Math.cos(r)), times(level, Math.sin(r))),
    toEye,
  };
}

/** Angles of axes. At the poles, where azimuth and roll turn about the same axis, the azimuth does it all.
 * @param {{ right: number[], up: number[], toEye: number[] }} axes */
export function angles({ right, up, toEye }) {
  const horizontal = Math.hypot(toEye[0], toEye[2]);
  const a = horizontal > 1e-9 ? Math.atan2(toEye[0], toEye[2]) : Math.atan2(-right[2], right[0]);
  const e = Math.atan2(toEye[1], horizontal);
  const level = [Math.cos(a), 0, -Math.sin(a)];
  const upright = cross(toEye, level);
  const roll = Math.atan2(dot(up, level), dot(up, upright));
  return { azimuth: a / RADIANS, elevation: e / RADIANS, roll: rounded(roll / RADIANS) };
}

/** Rounding errors of a camera that is not rolled would cost it its upright lattice. @param {number} degrees */
const rounded = (degrees) => (Math.abs(degrees) < 1e-9 ? 0 : degrees);

/** Rotates a vector about a unit axis. @param {number[]} v @param {number[]} axis @param {number} radians */
function rotated(v, axis, radians) {
  const [c, s] = [Math.cos(radians), Math.sin(radians)];
  return sum(times(v, c), times(cross(axis, v), s), times(axis, dot(axis, v) * (1 - c)));
}

/** Turns the camera about its own axes: by `x` to the right and `y` upwards on the screen, in radians. What is at the pivot stays where it is.
 * @param {Camera} camera @param {number} x @param {number} y @param {number[] | null} pivot world point; by default the centre
 * @param {Frame} frame @returns {Camera} */
export function turned(camera, x, y, pivot, frame) {
  let own = axes(camera);
  const turn = (/** @type {number[]} */ axis, /** @type {number} */ by) => {
    own = { right: rotated(own.right, axis, by), up: rotated(own.up, axis, by), toEye: rotated(own.toEye, axis, by) };
  };
  turn(own.up, -x);
  turn(own.right, y);
  const toEye = unit(own.toEye);
  const right = unit(cross(own.up, toEye));
  const next = { ...camera, ...angles({ right, up: cross(toEye, right), toEye }) };
  if (!pivot) return next;
  // The centre is where it was in the camera's axes, from the pivot.
  const [before, after] = [worldAxes(camera, frame), worldAxes(next, frame)];
  const from = sum(camera.center, times(pivot, -1));
  const along = [before.right, before.up, before.toEye].map((axis) => dot(from, axis));
  return { ...next, center: sum(pivot, times(after.right, along[0]), times(after.up, along[1]), times(after.toEye, along[2])) };
}

/** Axes of a camera in the world. @param {Camera} camera @param {Frame} frame */
export function worldAxes(camera, frame) {
  const { right, up, toEye } = axes(camera);
  return { right: toWorld(right, frame), up: toWorld(up, frame), toEye: toWorld(toEye, frame) };
}

/** Where a world point is in the picture, in half heights from the middle. `scale`: half heights per world unit there; 0 behind the eye.
 * @param {number[]} point @param {Camera} camera @param {Frame} frame */
export function projected(point, camera, frame) {
  const own = worldAxes(camera, frame);
  const from = sum(point, times(camera.center, -1));
  let scale = 1 / halfHeight(camera);
  if ("perspective" in camera.projection) {
    const distance = camera.projection.perspective[1];
    const left = distance - dot(from, own.toEye);
    scale = left > 0 ? (scale * distance) / left : 0;
  }
  return { x: dot(from, own.right) * scale, y: dot(from, own.up) * scale, scale };
}

/** @param {Camera} camera @param {number} degrees @returns {Camera} */
export function rolled(camera, degrees) {
  const roll = ((((camera.roll + degrees + 180) % 360) + 360) % 360) - 180;
  return { ...camera, roll: rounded(roll) };
}

/** Half the height of the picture in world units, at the centre. @param {Camera} camera */
export function halfHeight({ projection }) {
  if ("parallel_scale" in projection) return projection.parallel_scale;
  const [fieldOfView, distance] = projection.perspective;
  return distance * Math.tan((fieldOfView * RADIANS) / 2);
}

/** A vector of the frame in the world. @param {number[]} v @param {Frame} frame */
export const toWorld = (v, frame) => sum(times(frame.right, v[0]), times(frame.up, v[1]), times(frame.to_eye, v[2]));

/** Moves the centre by a part of half the picture's height, so that the volume follows the hand.
 * @param {Camera} camera @param {number} x to the right @param {number} y upwards @param {Frame} frame @returns {Camera} */
export function panned(camera, x, y, frame) {
  const { right, up } = axes(camera);
  const half = halfHeight(camera);
  const move = sum(times(toWorld(right, frame), -x * half), times(toWorld(up, frame), -y * half));
  return { ...camera, center: sum(camera.center, move) };
}

/** Half heights of a picture, relative to the diagonal of the volume: from less than a voxel to a dot. */
const NEAREST = 1e-5;
const FARTHEST = 50;

/** Magnifies about a place of the picture, which stays where it is, within limits. @param {Camera} camera @param {number} wanted
 * @param {number} x @param {number} y the place, in half heights from the middle @param {Frame} frame @param {number} diagonal of the volume
 * @returns {Camera} */
export function zoomed(camera, wanted, x, y, frame, diagonal) {
  const { projection } = camera;
  const half = halfHeight(camera);
  const within = Math.min(Math.max(half / wanted, NEAREST * diagonal), FARTHEST * diagonal);
  // A camera beyond the limits stays where it is, or comes back.
  const factor = (wanted > 1) === (half / within > 1) ? half / within : 1;
  const nearer = "parallel_scale" in projection
    ? { parallel_scale: projection.parallel_scale / factor }
    : { perspective: /** @type {[number, number]} */ ([projection.perspective[0], projection.perspective[1] / factor]) };
  const moved = panned(camera, -x * (1 - 1 / factor), -y * (1 - 1 / factor), frame);
  return { ...moved, projection: nearer };
}

/** The other projection, of the same size at the centre. @param {Camera} camera @returns {Camera} */
export function otherProjection(camera) {
  const fieldOfView = 30;
  const half = halfHeight(camera);
  const projection = "parallel_scale" in camera.projection
    ? { perspective: /** @type {[number, number]} */ ([fieldOfView, half / Math.tan((fieldOfView * RADIANS) / 2)]) }
    : { parallel_scale: half };
  return { ...camera, projection };
}
