// Arboleda in WebAssembly beside three-mesh-bvh, in Node.js: builds, closest hits, and whether the answers agree.
//
// Each contender answers all rays once before anything is timed. Then all take turns; a number is the median of its
// rounds. A build is that of a turn. Both have the mesh as nine numbers a triangle.
import { readFileSync } from "node:fs";
import { cpus } from "node:os";

import { BufferAttribute, BufferGeometry, DoubleSide, Ray, Vector3 } from "three";
import { CENTER, MeshBVH, SAH } from "three-mesh-bvh";

import { load } from "../js/arboleda.js";
import { Numbers, closedSphere, make } from "../page/scenes.js";

const [rayCount = 100000, rounds = 5] = process.argv.slice(2).map(Number);
const SCENES = { groups: "groups", town: "town", million: "a million" };

const median = (values) => values.toSorted((a, b) => a - b)[Math.floor(values.length / 2)];
const timed = (body) => {
    const since = performance.now();
    const value = body();
    return [performance.now() - since, value];
};

/** Rays from points of the scene's box, in all directions: what photons and paths are after their first hit. */
const raysIn = (positions, count) => {
    const [lo, hi] = [
        [Infinity, Infinity, Infinity],
        [-Infinity, -Infinity, -Infinity],
    ];
    positions.forEach((x, at) => {
        lo[at % 3] = Math.min(lo[at % 3], x);
        hi[at % 3] = Math.max(hi[at % 3], x);
    });
    const numbers = new Numbers(3);
    const rays = new Float32Array(8 * count);
    for (let ray = 0; ray < count; ray += 1) {
        const origin = lo.map((x, axis) => numbers.within(x, hi[axis]));
        rays.set([...origin, ...numbers.direction(), 0, Infinity], 8 * ray);
    }
    return rays;
};

/** An index of Arboleda; `batched` for all rays in one call. */
const ours = (arboleda, kind, batched) => ({
    name: `\`${kind}\`, ${batched ? "batch" : "single rays"}${arboleda.simd ? ", SIMD" : ""}`,
    build: (positions) => arboleda.build(kind, positions),
    free: (index) => index.free(),
    bytes: (index) => index.byteCount,
    ask(index, rays) {
        if (batched) {
            const { triangles, t } = index.closestHits(rays);
            return { triangles, t };
        }
        const count = rays.length / 8;
        const [triangles, t] = [new Uint32Array(count).fill(0xffffffff), new Float32Array(count).fill(Infinity)];
        const [origin, direction] = [
            [0, 0, 0],
            [0, 0, 0],
        ];
        for (let ray = 0, at = 0; ray < count; ray += 1, at += 8) {
            for (let axis = 0; axis < 3; axis += 1) {
                origin[axis] = rays[at + axis];
                direction[axis] = rays[at + 3 + axis];
            }
            const hit = index.closestHit(origin, direction);
            if (hit) [triangles[ray], t[ray]] = [hit.triangle, hit.t];
        }
        return { triangles, t };
    },
});

/** three-mesh-bvh. Its directions must have length 1, as these have up to rounding; its `t` is then a distance. */
const theirs = (name, strategy) => ({
    name: `three-mesh-bvh, ${name}`,
    build(positions) {
        const geometry = new BufferGeometry();
        geometry.setAttribute("position", new BufferAttribute(positions, 3));
        return new MeshBVH(geometry, { strategy, setBoundingBox: false });
    },
    free: () => {},
    // The nodes, and the index that it adds to the geometry.
    bytes: (bvh) => bvh._roots.reduce((sum, root) => sum + root.byteLength, 0) + bvh.geometry.index.array.byteLength,
    ask(bvh, rays) {
        const count = rays.length / 8;
        const [triangles, t] = [new Uint32Array(count).fill(0xffffffff), new Float32Array(count).fill(Infinity)];
        const ray = new Ray(new Vector3(), new Vector3());
        const order = bvh.geometry.index.array;
        for (let number = 0, at = 0; number < count; number += 1, at += 8) {
            ray.origin.set(rays[at], rays[at + 1], rays[at + 2]);
            ray.direction.set(rays[at + 3], rays[at + 4], rays[at + 5]);
            const hit = bvh.raycastFirst(ray, DoubleSide);
            if (!hit) continue;
            // The build has sorted the triangles.
            triangles[number] = order[3 * hit.faceIndex] / 3;
            t[number] = hit.distance;
        }
        return { triangles, t };
    },
});

/** A closed sphere, and rays from points inside to its corners and the middles of its edges: none may leave it. */
const edges = () => {
    const positions = closedSphere(24);
    const numbers = new Numbers(6);
    const rays = [];
    for (let at = 0; at < positions.length; at += 3) {
        const next = at % 9 === 6 ? at - 6 : at + 3;
        const origin = numbers.direction().map((part) => Math.fround(0.5 * part));
        for (const share of [0, 0.5]) {
            const to = [0, 1, 2].map((axis) => positions[at + axis] * (1 - share) + positions[next + axis] * share);
            const away = to.map((x, axis) => x - origin[axis]);
            const length = Math.hypot(...away);
            rays.push(...origin, ...away.map((x) => x / length), 0, Infinity);
        }
    }
    return [positions, new Float32Array(rays)];
};

/** Counts how two lists of answers differ. A tie is another triangle that is hit at the same `t`, by exact numbers. */
const compared = (exact, other, isTie = () => false) => {
    const found = { same: 0, ties: 0, lost: 0, invented: 0, others: 0 };
    exact.triangles.forEach((triangle, ray) => {
        const [t, s] = [exact.t[ray], other.t[ray]];
        if (triangle === other.triangles[ray]) found.same += 1;
        else if (s === Infinity) found.lost += 1;
        else if (t === Infinity) found.invented += 1;
        else if (isTie(ray, t, other.triangles[ray])) found.ties += 1;
        else found.others += 1;
    });
    return found;
};

const [plain, simd] = [await load({ simd: false }), await load({ simd: true })];
const [sah, center] = [theirs("SAH", SAH), theirs("center, its default", CENTER)];
const contenders = [
    ours(simd, "wide-bvh", true),
    ours(simd, "wide-bvh", false),
    ours(plain, "wide-bvh", true),
    ours(plain, "wide-bvh", false),
    ours(simd, "compact-bvh", true),
    ours(simd, "octree-hierarchy", true),
    sah,
    center,
];
const version = (name) =>
    JSON.parse(readFileSync(new URL(`../node_modules/${name}/package.json`, import.meta.url))).version;
console.log(
    `${cpus()[0].model}; Node.js ${process.versions.node}; three-mesh-bvh ${version("three-mesh-bvh")}; ` +
        `${rayCount.toLocaleString("en")} rays, medians of ${rounds} rounds in turns.\n`,
);

/** Builds and asks in turns. Returns a row for each contender, and what is to be said of the answers. */
const measured = (scene) => {
    const positions = make(scene);
    const rays = raysIn(positions, rayCount);
    const rows = contenders.map((contender) => {
        const index = contender.build(positions);
        return {
            contender,
            index,
            bytes: contender.bytes(index),
            answers: contender.ask(index, rays),
            builds: [],
            asks: [],
        };
    });
    for (const { contender, answers } of rows) {
        const isOurs = contender !== sah && contender !== center;
        if (isOurs && compared(rows[0].answers, answers).same !== rayCount) {
            throw new Error(`${contender.name} differs from ${rows[0].contender.name}`);
        }
    }
    for (let round = 0; round < rounds; round += 1) {
        for (const row of rows) {
            const [build, index] = timed(() => row.contender.build(positions));
            row.contender.free(index);
            row.builds.push(build);
            row.asks.push(timed(() => row.contender.ask(row.index, rays))[0]);
        }
    }
    const theirs = rows.find(({ contender }) => contender === sah);
    const found = compared(rows[0].answers, theirs.answers, (ray, t, triangle) => {
        const [origin, direction] = [rays.subarray(8 * ray, 8 * ray + 3), rays.subarray(8 * ray + 3, 8 * ray + 6)];
        return rows[0].index.allHits(origin, direction, t, t).some((hit) => hit.triangle === triangle);
    });
    for (const { contender, index } of rows) contender.free(index);
    const count = positions.length / 9;
    return {
        title: `${SCENES[scene]}, ${count.toLocaleString("en")}`,
        found,
        rows: rows.map(({ contender, bytes, builds, asks }) => {
            const [rate, ratio] = [rayCount / median(asks) / 1000, median(theirs.asks) / median(asks)];
            return { contender, rate, ratio, build: median(builds), bytes: bytes / count };
        }),
        theirs: { build: median(theirs.builds), bytes: theirs.bytes / count },
    };
};

const bold = (text, isBold) => (isBold ? `**${text}**` : text);
/** Prints a table with a column for each scene. `cell` makes the text of a contender in a scene. */
const table = (title, scenes, chosen, cell) => {
    console.log(
        `| ${title} | ${scenes.map(({ title }) => title).join(" | ")} |\n|---|${scenes.map(() => "---:|").join("")}`,
    );
    contenders.forEach((contender, at) => {
        if (chosen(contender))
            console.log(`| ${contender.name} | ${scenes.map((scene) => cell(scene.rows[at], scene)).join(" | ")} |`);
    });
    console.log();
};

const scenes = Object.keys(SCENES).map(measured);
const isTheirs = (contender) => contender === sah || contender === center;
table(
    "million rays a second (times SAH)",
    scenes,
    () => true,
    ({ contender, rate, ratio }) =>
        bold(
            contender === sah ? rate.toFixed(2) : `${rate.toFixed(2)} (${ratio.toFixed(1)})`,
            !isTheirs(contender) && ratio < 1,
        ),
);
table(
    "build in ms; bytes a triangle",
    scenes,
    ({ name }) => !name.includes("single"),
    ({ contender, build, bytes }, { theirs }) =>
        `${bold(build.toFixed(0), !isTheirs(contender) && build > theirs.build)}; ` +
        bold(bytes.toFixed(0), !isTheirs(contender) && bytes > theirs.bytes),
);
for (const {
    title,
    found: { same, ties, lost, invented, others },
} of scenes) {
    console.log(
        `Answers of three-mesh-bvh, ${title}: ${same.toLocaleString("en")} the same triangle, ${ties} another that is hit at ` +
            `the same t, ${lost} no hit where there is one, ${invented} a hit where there is none, ${others} another hit.`,
    );
}

const [positions, rays] = edges();
const index = simd.build("wide-bvh", positions);
const lost = (answers) => answers.t.reduce((sum, t) => sum + (t === Infinity ? 1 : 0), 0).toLocaleString("en");
const exact = index.closestHits(rays);
const bvh = sah.build(positions);
console.log(
    `Of ${(rays.length / 8).toLocaleString("en")} rays from inside a closed sphere to its corners and edges, ` +
        `${lost(exact)} leave it in Arboleda, ${lost(sah.ask(bvh, rays))} in three-mesh-bvh.`,
);
