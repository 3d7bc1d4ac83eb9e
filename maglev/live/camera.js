"use strict";
// From space to the picture: a camera on an orbit, convex bodies drawn from the far ones to the near ones.
//
// In mm: x along the first axis that motors drive, z along the second, away from the viewer who looks along it; y downwards
// from the face of the stators, as the air gap is counted. Bodies are boxes; a camera sees the sides that face it.

const LOWEST = -35, HIGHEST = 80;   // degrees of elevation

class Camera {
  /**
   * @param {number} yaw turn about the vertical, degrees
   * @param {number} pitch elevation over the horizon, degrees
   * @param {{width: number, height: number, radius: number, middle: number, tall: number}} fit of the picture (px), and of
   *   what is in it (mm): its radius on the floor, the height of its middle, and how tall it is
   */
  constructor(yaw, pitch, { width, height, radius, middle, tall }) {
    const [a, b] = [yaw, pitch].map((degrees) => degrees * Math.PI / 180);
    [this.cosYaw, this.sinYaw, this.cosPitch, this.sinPitch] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
    this.middle = middle;
    this.distance = 5 * radius;   // a long lens: what is near is drawn a fifth larger at most
    const high = radius * Math.abs(this.sinPitch) + tall / 2 * this.cosPitch;
    this.scale = Math.min(width / (1.95 * radius), height / (2.1 * high));
    [this.left, this.top] = [width / 2, height / 2];
    const back = this.distance * this.cosPitch;
    this.place = [back * this.sinYaw, middle - this.distance * this.sinPitch, -back * this.cosYaw];
  }

  /** Place on the picture (px) of a point. */
  seen([x, y, z]) {
    const along = x * this.cosYaw + z * this.sinYaw, away = z * this.cosYaw - x * this.sinYaw, down = y - this.middle;
    const near = this.scale * this.distance / (this.distance + away * this.cosPitch + down * this.sinPitch);
    return [this.left + near * along, this.top + near * (down * this.cosPitch - away * this.sinPitch)];
  }

  /** What a way on the picture (px) from its middle is on the upright plane through the middle that faces the camera. */
  moved(dx, dy) {
    const along = dx / this.scale;
    return { x: along * this.cosYaw, z: along * this.sinYaw, y: dy / this.scale / Math.max(0.35, this.cosPitch) };
  }
}

/** A box by its ends along x, y, z (mm), and how its corners are moved: a platform tilts. */
const box = (low, high, moved = (point) => point) => ({ low, high, moved });

const SIDES = [[0, 0], [0, 1], [1, 0], [1, 1], [2, 0], [2, 1]];   // axis across it, and at which end

/** Corners of a part of a side of a box, from shares along the two other axes. */
function cornersOf({ low, high, moved }, [axis, end], from = [0, 0], to = [1, 1]) {
  const [a, b] = [0, 1, 2].filter((each) => each !== axis);
  return [[from[0], from[1]], [to[0], from[1]], [to[0], to[1]], [from[0], to[1]]].map(([s, t]) => {
    const point = [0, 0, 0];
    point[axis] = end ? high[axis] : low[axis];
    point[a] = low[a] + s * (high[a] - low[a]);
    point[b] = low[b] + t * (high[b] - low[b]);
    return moved(point);
  });
}

/** Whether a camera is on the outer side of a side of a box. */
const faces = (camera, { low, high }, [axis, end]) =>
  (end ? camera.place[axis] > high[axis] : camera.place[axis] < low[axis]);

const SHADES = [0.16, 0, 0.26];   // how dark sides are across x, y and z: light comes from above

/** Draw the sides of a box that are seen. */
function drawBox(context, camera, body, colour, shade = "#000") {
  for (const side of SIDES) {
    if (!faces(camera, body, side)) continue;
    polygon(context, cornersOf(body, side).map((point) => camera.seen(point)));
    context.fillStyle = colour;
    context.fill();
    const alpha = context.globalAlpha, dark = side[0] === 1 && side[1] ? 0.4 : SHADES[side[0]];
    if (!dark) continue;
    context.globalAlpha = alpha * dark;
    context.fillStyle = shade;
    context.fill();
    context.globalAlpha = alpha;
  }
}

/** Whether a box has to be drawn before another one that it does not touch: a plane between them has the camera beyond. */
const behind = (camera, one, other) => [0, 1, 2].some((axis) =>
  (one.high[axis] <= other.low[axis] && camera.place[axis] > other.low[axis])
  || (one.low[axis] >= other.high[axis] && camera.place[axis] < other.high[axis]));

/** Boxes in the order in which they are drawn, the farthest first. */
function farFirst(camera, bodies) {
  const left = [...bodies], sorted = [];
  while (left.length) {
    const next = left.findIndex((one) => left.every((other) => one === other || !behind(camera, other, one)
      || behind(camera, one, other)));
    sorted.push(...left.splice(Math.max(0, next), 1));
  }
  return sorted;
}

/** Smallest convex polygon around points (px), for what a finger can take. */
function hull(points) {
  const sorted = [...points].sort(([a, b], [c, d]) => a - c || b - d);
  const half = (list) => {
    const found = [];
    for (const point of list) {
      while (found.length > 1 && turn(found.at(-2), found.at(-1), point) <= 0) found.pop();
      found.push(point);
    }
    return found.slice(0, -1);
  };
  return [...half(sorted), ...half([...sorted].reverse())];
}

const turn = ([ax, ay], [bx, by], [cx, cy]) => (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);

/** Whether a point (px) is in a convex polygon or within a distance (px) of its sides' lines. */
const inside = (corners, point, margin) => corners.every((from, i) => {
  const to = corners[(i + 1) % corners.length];
  return turn(from, to, point) > -margin * Math.hypot(to[0] - from[0], to[1] - from[1]);
});
