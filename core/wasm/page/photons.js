// Photons from a lamp: batches of closest hits, whose answers say where each photon goes on.
//
//     lamp --towards a random point of the scene's box--> surface --reflected, with this share--> surface ...
//
// This is a picture of what batches are good for, and no measurement of light: `arboleda render` of the repository's
// program is that.

import { Numbers } from "./scenes.js";

/** The share of the photons that a surface reflects. */
export const REFLECTED = 0.5;
/** The most surfaces that a photon meets. */
const MOST_HITS = 8;
/** Photons of a batch. */
const BATCH = 65536;
/** A reflected photon begins off the surface by this share of the scene's diagonal, because its origin is rounded. */
const OFF = 1e-5;

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const moved = (a, d, t) => [a[0] + d[0] * t, a[1] + d[1] * t, a[2] + d[2] * t];

/** The unit normal of a triangle, on the side that a direction comes from. */
const normalAgainst = (positions, triangle, direction) => {
    const corner = (number) => positions.subarray(9 * triangle + 3 * number, 9 * triangle + 3 * number + 3);
    const normal = cross(sub(corner(1), corner(0)), sub(corner(2), corner(0)));
    const length = Math.sqrt(dot(normal, normal)) * (dot(normal, direction) > 0 ? -1 : 1);
    return normal.map((part) => part / length);
};

/** Shoots photons. `found(point, bounce)` receives each hit; returns how many there were of what. */
export const shoot = (index, positions, { lamp, box: [lo, hi], count, seed }, found, progress) => {
    const numbers = new Numbers(seed);
    const size = sub(hi, lo);
    const off = OFF * Math.sqrt(dot(size, size));
    const sum = { emitted: 0, rays: 0, hits: 0, reflected: 0, absorbed: 0, left: 0, stopped: 0 };
    while (sum.emitted < count) {
        const length = Math.min(BATCH, count - sum.emitted);
        sum.emitted += length;
        let photons = Array.from({ length }, () => {
            const target = lo.map((x, axis) => x + size[axis] * numbers.next());
            return { origin: lamp, direction: sub(target, lamp) };
        });
        for (let bounce = 0; photons.length > 0; bounce += 1) {
            const rays = new Float32Array(8 * photons.length);
            photons.forEach(({ origin, direction }, ray) => rays.set([...origin, ...direction, 0, Infinity], 8 * ray));
            const { triangles, t } = index.closestHits(rays);
            sum.rays += photons.length;
            const next = [];
            photons.forEach(({ origin, direction }, ray) => {
                if (t[ray] === Infinity) {
                    sum.left += 1;
                    return;
                }
                sum.hits += 1;
                const point = moved(origin, direction, t[ray]);
                found(point, bounce);
                if (numbers.next() >= REFLECTED) {
                    sum.absorbed += 1;
                } else if (bounce + 1 >= MOST_HITS) {
                    sum.stopped += 1;
                } else {
                    sum.reflected += 1;
                    const normal = normalAgainst(positions, triangles[ray], direction);
                    // Lambert's law: the normal, and a point of the unit sphere around its end.
                    next.push({ origin: moved(point, normal, off), direction: moved(normal, numbers.direction(), 1) });
                }
            });
            photons = next.filter(({ direction }) => dot(direction, direction) > 1e-12);
            sum.left += next.length - photons.length;
        }
        progress(sum.emitted, count);
    }
    return sum;
};
