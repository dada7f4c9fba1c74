// The front's answers: against the digests of the native build, and against a linear scan.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { hasSimd128, load } from "../js/arboleda.js";
import { digests, positions, rays } from "./scene.mjs";

const modules = [await load({ simd: false }), await load({ simd: true })];
const expected = readFileSync(new URL("digests.txt", import.meta.url), "utf8")
    .trim()
    .split("\n");
const mesh = positions();

test("both modules give the bytes, hits and counters of the native build", () => {
    assert.ok(hasSimd128(), "this machine has simd128");
    assert.ok(expected.length >= 19);
    for (const arboleda of modules) assert.deepEqual(digests(arboleda), expected);
});

test("single rays, batches and all hits agree with a linear scan", () => {
    const batch = rays(400);
    for (const arboleda of modules) {
        const scan = arboleda.build("linear", mesh);
        for (const kind of arboleda.kinds) {
            const index = arboleda.build(kind, mesh);
            const [hits, occluded] = [index.closestHits(batch), index.occludedEach(batch)];
            assert.deepEqual(hits, scan.closestHits(batch), kind);
            for (let ray = 0; ray < 400; ray += 1) {
                const [origin, direction] = [batch.slice(8 * ray, 8 * ray + 3), batch.slice(8 * ray + 3, 8 * ray + 6)];
                const hit = index.closestHit(origin, direction);
                assert.deepEqual(hit, scan.closestHit(origin, direction));
                assert.equal(hit?.triangle ?? 0xffffffff, hits.triangles[ray]);
                assert.equal(hit?.t ?? Infinity, hits.t[ray]);
                assert.equal(index.occluded(origin, direction), hit !== null);
                assert.equal(occluded[ray], hit ? 1 : 0);
                const all = index.allHits(origin, direction);
                assert.deepEqual(all, scan.allHits(origin, direction));
                assert.deepEqual(all[0] ?? null, hit);
                if (hit) {
                    assert.equal(index.occluded(origin, direction, 0, hit.t), true);
                    assert.equal(index.closestHit(origin, direction, hit.t, hit.t).triangle, hit.triangle);
                    const { hit: counted, ...counters } = index.closestHitCounted(origin, direction);
                    assert.deepEqual(counted, hit);
                    assert.ok(kind === "linear" ? counters.triangleTests === 1202 : counters.nodesVisited > 0);
                    assert.equal(index.occludedCounted(origin, direction).occluded, true);
                }
            }
            index.free();
        }
        scan.free();
    }
});

test("more than 64 hits of a ray are all found", () => {
    const [arboleda] = modules;
    const stack = new Float32Array(9 * 300);
    for (let at = 0; at < 300; at += 1) stack.set([0, 0, at, 1, 0, at, 0, 1, at], 9 * at);
    const index = arboleda.build("wide-bvh", stack);
    const hits = index.allHits([0.25, 0.25, -1], [0, 0, 1]);
    assert.deepEqual(
        hits.map((hit) => hit.triangle),
        Array.from({ length: 300 }, (_, at) => at),
    );
    index.free();
});

test("an indexed mesh gives the same bytes, with corners of 16 or 32 bits", () => {
    const [arboleda] = modules;
    const corners = Uint32Array.from({ length: mesh.length / 3 }, (_, vertex) => vertex);
    const plain = arboleda.build("octree-hierarchy", mesh);
    for (const given of [corners, Uint16Array.from(corners)]) {
        const index = arboleda.build("octree-hierarchy", mesh, given);
        assert.deepEqual(index.save(), plain.save());
        index.free();
    }
    plain.free();
});

test("a saved index opens, also in the other module, and beside a mesh", () => {
    const [plain, simd] = modules;
    const batch = rays(200);
    for (const beside of [false, true]) {
        const built = plain.build("lean-bvh", mesh, null, { beside });
        assert.equal(built.beside, beside);
        const bytes = built.save();
        assert.equal(bytes.length, built.byteCount);
        const opened = simd.open(bytes, beside ? mesh : undefined);
        assert.deepEqual(opened.closestHits(batch), built.closestHits(batch));
        assert.deepEqual([opened.kind, opened.triangleCount], ["lean-bvh", 1202]);
        if (beside) {
            assert.throws(() => simd.open(bytes), { code: "MESH_MISSING" });
            assert.throws(() => simd.open(bytes, mesh.slice(9)), { code: "OTHER_MESH" });
        } else {
            assert.throws(() => simd.open(bytes, mesh), { code: "MESH_NOT_WANTED" });
        }
        built.free();
        opened.free();
    }
});

test("clusters, their tree, the cells and the path of a ray fit together", () => {
    for (const arboleda of modules) {
        const { count, clusterOf } = arboleda.clusters(mesh);
        const index = arboleda.build("octree-hierarchy", mesh);
        assert.equal(index.clusterCount, count);
        assert.equal(new Set(clusterOf).size, count);
        const tree = index.clusterTree();
        assert.equal(tree.count, 2 * count - 1);
        assert.equal(tree.parents[tree.count - 1], -1);
        // Each triangle lies in the box of its cluster.
        clusterOf.forEach((cluster, triangle) => {
            for (let at = 0; at < 9; at += 1) {
                const x = mesh[9 * triangle + at];
                const axis = at % 3;
                assert.ok(tree.bounds[6 * cluster + axis] <= x && x <= tree.bounds[6 * cluster + 3 + axis]);
            }
        });
        const roots = index.cells(0);
        assert.deepEqual([roots.count, roots.total], [count, count]);
        assert.deepEqual(roots.bounds, tree.bounds.slice(0, 6 * count));
        const few = index.cells(20, 5);
        assert.equal(few.count, 5);
        assert.ok(few.total > count);
        const batch = rays(300);
        for (let ray = 0; ray < 300; ray += 1) {
            const given = [batch.slice(8 * ray, 8 * ray + 3), batch.slice(8 * ray + 3, 8 * ray + 6)];
            const path = index.path(...given);
            const { hit, nodesVisited, triangleTests } = index.closestHitCounted(...given);
            assert.deepEqual(path.hit, hit);
            assert.deepEqual([path.steps.length, path.tests.length], [nodesVisited, triangleTests]);
            if (hit) assert.ok(path.tests.includes(hit.triangle));
        }
        index.free();
    }
});

test("options reach the build", () => {
    const [arboleda] = modules;
    const cells = (options) => {
        const index = arboleda.build("octree", mesh, null, options);
        const { total, levels } = index.cells(20);
        index.free();
        return { total, deepest: Math.max(...levels) };
    };
    assert.equal(cells({ level: 0 }).total, 1);
    assert.equal(cells({ level: 2 }).deepest, 2);
    assert.ok(cells({ level: 6, leafCapacity: 1 }).total > cells({ level: 6, leafCapacity: 100 }).total);
    const whole = arboleda.clusters(mesh, null, { objects: new Uint32Array(1202) });
    assert.equal(whole.count, 1);
    assert.ok(arboleda.clusters(mesh, null, { proximity: 0 }).count > arboleda.clusters(mesh).count);
    const grid = arboleda.build("uniform-grid", mesh, null, { resolution: { cells: [1, 1, 1] } });
    assert.equal(grid.closestHitCounted([0, 0, -200], [0, 0, 1]).triangleTests, 1202);
    grid.free();
    for (const options of [
        { bvhBuild: "insertion" },
        { cost: { traversal: 1, intersection: 1 } },
        { sizeClasses: 1 },
    ]) {
        arboleda.build("bvh-hierarchy", mesh, null, options).free();
    }
    assert.throws(() => arboleda.build("bvh", mesh, null, { workLimit: 10 }), { code: "TOO_MUCH_WORK" });
});
