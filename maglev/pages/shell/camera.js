"use strict";
// From space to the picture: a camera on an orbit, convex bodies drawn from the far ones to the near ones.
//
// In mm: x is along the first axis that motors drive, z along the second, away from the viewer. y is downwards from the
// face of the stators, like the air gap. Bodies are boxes; a camera sees the sides that face it.

const LOWEST = -35, HIGHEST = 80;   // degrees of elevation

class Camera {
  /**
   * @param {{yaw: number, pitch: number, zoom: number?, at: number[]?}} orbit turn about the vertical and elevation over the
   *   horizon, degrees. The zoom is 1 if all is seen; the point (mm) is then in the middle
   * @param {{left: number, top: number, width: number, height: number}} place on the picture (px)
   * @param {number[][]} points (mm) that are all seen
   */
  constructor({ yaw, pitch, zoom = 1, at = null }, { left, top, width, height }, points) {
    const [a, b] = [yaw, pitch].map((degrees) => degrees * Math.PI / 180), depths = points.map(([, y]) => y);
    [this.cosYaw, this.sinYaw, this.cosPitch, this.sinPitch] = [Math.cos(a), Math.sin(a), Math.cos(b), Math.sin(b)];
    this.middle = (Math.min(...depths) + Math.max(...depths)) / 2;
    // a long lens: near bodies are only a little larger
    this.distance = 5 * Math.max(...points.map(([x, , z]) => Math.hypot(x, z)));
    const back = this.distance * this.cosPitch;
    this.place = [back * this.sinYaw, this.middle - this.distance * this.sinPitch, -back * this.cosYaw];
    [this.scale, this.left, this.top] = [1, 0, 0];
    const all = points.map((point) => this.seen(point));
    const [across, up] = [0, 1].map((i) => [Math.min(...all.map((point) => point[i])), Math.max(...all.map((point) => point[i]))]);
    const scale = zoom * Math.min((width - 12) / (across[1] - across[0]), (height - 28) / (up[1] - up[0]));
    // all in the middle, or the point of interest
    const near = at && this.seen(at), share = Math.min(1, Math.max(0, zoom - 1));
    const [x, y] = [across, up].map(([low, high], i) => (low + high) / 2 + (near ? share * (near[i] - (low + high) / 2) : 0));
    Object.assign(this, { scale, left: left + width / 2 - scale * x, top: top + 8 + (height - 8) / 2 - scale * y });
  }

  /** Place on the picture (px) of a point. */
  seen([x, y, z]) {
    const along = x * this.cosYaw + z * this.sinYaw, away = z * this.cosYaw - x * this.sinYaw, down = y - this.middle;
    const near = this.scale * this.distance / (this.distance + away * this.cosPitch + down * this.sinPitch);
    return [this.left + near * along, this.top + near * (down * this.cosPitch - away * this.sinPitch)];
  }

  /** Convert a way on the picture (px) to the upright plane that faces the camera; seen from high above, to the floor.
   * */
  moved(dx, dy) {
    const along = dx / this.scale, flat = this.sinPitch > 0.8, away = flat ? -dy / this.scale / this.sinPitch : 0;
    return { x: along * this.cosYaw - away * this.sinYaw, z: along * this.sinYaw + away * this.cosYaw,
      y: flat ? null : dy / this.scale / Math.max(0.35, this.cosPitch) };
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

/** Return true if a camera is on the outer side of a side of a box. */
const faces = (camera, { low, high }, [axis, end]) =>
  (end ? camera.place[axis] > high[axis] : camera.place[axis] < low[axis]);

const SHADES = [0.16, 0, 0.26];   // how dark sides are across x, y and z: light comes from above

/** Draw the sides of a box that are seen. */
function drawBox(context, camera, body, colour) {
  for (const side of SIDES) {
    if (!faces(camera, body, side)) continue;
    polygon(context, cornersOf(body, side).map((point) => camera.seen(point)));
    fill(context, colour);
    fill(context, "#000", side[0] === 1 && side[1] ? 0.4 : SHADES[side[0]]);
  }
}

/** Return true if a box has to be drawn before another that it does not touch: a plane between them has the camera
 * beyond. */
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

/** Return the smallest convex polygon around points (px), as a target for a finger. */
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

/** Return true if a point (px) is in a convex polygon or within a distance (px) of its sides' lines. */
const inside = (corners, point, margin) => corners.every((from, i) => {
  const to = corners[(i + 1) % corners.length];
  return turn(from, to, point) > -margin * Math.hypot(to[0] - from[0], to[1] - from[1]);
});
