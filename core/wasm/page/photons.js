// Photons from a lamp: batches of closest hits, whose answers say where each photon goes on.
//
//     lamp --towards a random point of the scene's box--> surface --reflected, with this share--> surface ...
//
// This is a picture of what batches are good for, and no measurement of light: `arboleda render` of the repository's
// program is that.

import { Numbers } from "./scenes.js";

/** The share of the photons that a surface reflects. */
export const REFLECTED = 0.5;
/** The most surfaces that a photon meets: it stops where the last would reflect it. */
export const MOST_HITS = 8;
/** Photons of a batch. */
const BATCH = 65536;
/** A reflected photon begins off the surface by this share of the scene's diagonal, because its origin is rounded. */
const OFF = 1e-5;

/** The unit normal of a triangle, on the side that a ray comes from; the ray begins at `at` in `rays`. */
const normalAgainst = (positions, triangle, rays, at) => {
    const a = 9 * triangle;
    const side = (corner, axis) => positions[a + 3 * corner + axis] - positions[a + axis];
    const [bx, by, bz, cx, cy, cz] = [side(1, 0), side(1, 1), side(1, 2), side(2, 0), side(2, 1), side(2, 2)];
    const [x, y, z] = [by * cz - bz * cy, bz * cx - bx * cz, bx * cy - by * cx];
    const along = x * rays[at + 3] + y * rays[at + 4] + z * rays[at + 5];
    const length = Math.sqrt(x * x + y * y + z * z) * (along > 0 ? -1 : 1);
    return [x / length, y / length, z / length];
};

/** Shoots photons. `found(x, y, z, bounce)` receives each hit; returns how many there were of what. */
export const shoot = (index, positions, { lamp, box: [lo, hi], count, seed }, found, progress) => {
    const numbers = new Numbers(seed);
    const size = lo.map((x, axis) => hi[axis] - x);
    const off = OFF * Math.sqrt(size.reduce((sum, side) => sum + side * side, 0));
    const sum = { emitted: 0, rays: 0, hits: 0, reflected: 0, absorbed: 0, left: 0, stopped: 0 };
    while (sum.emitted < count) {
        let photons = Math.min(BATCH, count - sum.emitted);
        const rays = new Float32Array(8 * photons);
        for (let at = 0; at < rays.length; at += 8) {
            for (let axis = 0; axis < 3; axis += 1) {
                rays[at + axis] = lamp[axis];
                rays[at + 3 + axis] = lo[axis] + size[axis] * numbers.next() - lamp[axis];
            }
            rays[at + 7] = Infinity;
        }
        sum.emitted += photons;
        for (let bounce = 0; photons > 0; bounce += 1) {
            const { triangles, t } = index.closestHits(rays.subarray(0, 8 * photons));
            sum.rays += photons;
            // Those that are reflected move to the front, where the rays of the next batch begin.
            let to = 0;
            for (let ray = 0, at = 0; ray < photons; ray += 1, at += 8) {
                if (t[ray] === Infinity) {
                    sum.left += 1;
                    continue;
                }
                sum.hits += 1;
                const point = [0, 1, 2].map((axis) => rays[at + axis] + rays[at + 3 + axis] * t[ray]);
                found(...point, bounce);
                if (numbers.next() >= REFLECTED) {
                    sum.absorbed += 1;
                } else if (bounce + 1 >= MOST_HITS) {
                    sum.stopped += 1;
                } else {
                    const normal = normalAgainst(positions, triangles[ray], rays, at);
                    // Lambert's law: the normal, and a point of the unit sphere around its end.
                    const round = numbers.direction();
                    for (let axis = 0; axis < 3; axis += 1) {
                        rays[to + axis] = point[axis] + off * normal[axis];
                        rays[to + 3 + axis] = normal[axis] + round[axis];
                    }
                    // The point may lie at the normal's beginning: then it goes straight up.
                    if (rays[to + 3] === 0 && rays[to + 4] === 0 && rays[to + 5] === 0) rays.set(normal, to + 3);
                    sum.reflected += 1;
                    to += 8;
                }
            }
            photons = to / 8;
        }
        progress(sum.emitted, count);
    }
    return sum;
};
