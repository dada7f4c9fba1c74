// Builds in steps: the bytes are those of a build at once, and the event loop runs meanwhile.
import assert from "node:assert/strict";
import { test } from "node:test";

import { ArboledaError, load } from "../js/arboleda.js";
import { make } from "../page/scenes.js";
import { positions, rays } from "./scene.mjs";

const modules = [await load({ simd: false }), await load({ simd: true })];
const mesh = positions();

const rejects = (promise, code, message) =>
    assert.rejects(promise, (error) => {
        assert.ok(error instanceof ArboledaError, `${error.stack}`);
        assert.equal(error.code, code, error.message);
        assert.match(error.message, message);
        return true;
    });

/** Counts the turns of the event loop until `promise` is settled. */
const turnsUntil = async (promise) => {
    let turns = 0;
    let isOver = false;
    const count = () => {
        turns += 1;
        if (!isOver) setImmediate(count);
    };
    setImmediate(count);
    try {
        return { value: await promise, turns };
    } finally {
        isOver = true;
    }
};

test("both modules give the bytes of a build at once, for steps of any length", async () => {
    const corners = Uint32Array.from({ length: mesh.length / 3 }, (_, vertex) => vertex);
    const batch = rays(300);
    for (const arboleda of modules) {
        const before = arboleda.usedBytes;
        for (const given of [[mesh], [mesh, corners], [new Float32Array(0)]]) {
            const atOnce = arboleda.build("wide-bvh", ...given);
            for (const looksPerStep of [1, 50, 4000, 0xffffffff]) {
                const [positions, corners = null] = given;
                const pace = { looksPerStep, millisecondsPerTurn: 0 };
                const { value: index, turns } = await turnsUntil(
                    arboleda.buildInSteps("wide-bvh", positions, corners, pace),
                );
                assert.deepEqual(index.save(), atOnce.save(), `${looksPerStep}`);
                assert.deepEqual(index.closestHits(batch), atOnce.closestHits(batch));
                if (looksPerStep === 1 && positions === mesh) assert.ok(turns > 1000, `${turns} turns`);
                index.free();
            }
            const index = await arboleda.buildInSteps("wide-bvh", ...given);
            assert.deepEqual(index.save(), atOnce.save());
            index.free();
            atOnce.free();
        }
        assert.equal(arboleda.usedBytes, before);
    }
});

test("between the steps the module is used for other work, and its memory grows", async () => {
    for (const simd of [false, true]) {
        const arboleda = await load({ simd, memory: new WebAssembly.Memory({ initial: 32 }) });
        const before = arboleda.usedBytes;
        const batch = rays(50);
        const atOnce = arboleda.build("wide-bvh", mesh);
        const bytes = arboleda.memory.buffer.byteLength;
        // What is given may be changed as soon as the call has returned.
        const [given, options] = [mesh.slice(), { looksPerStep: 100, millisecondsPerTurn: 0, leafCapacity: 4 }];
        const building = Promise.all([0, 1].map(() => arboleda.buildInSteps("wide-bvh", given, null, options)));
        given.fill(NaN);
        let indices = null;
        building.then((built) => (indices = built));
        const others = [];
        for (let turn = 0; !indices; turn += 1) {
            await new Promise((resolve) => setImmediate(resolve));
            if (turn % 10 === 0) others.push(arboleda.build("octree", mesh, null, { leafCapacity: 1 + (turn % 7) }));
            assert.deepEqual(others[0].closestHits(batch), atOnce.closestHits(batch));
            assert.equal(arboleda.clusters(mesh).clusterOf.length, 1202);
        }
        assert.ok(others.length > 5 && arboleda.memory.buffer.byteLength > bytes, `${others.length} others`);
        for (const index of indices) assert.deepEqual(index.save(), atOnce.save());
        for (const index of [...indices, ...others, atOnce]) index.free();
        assert.equal(arboleda.usedBytes, before);
    }
});

test("progress rises to 1, and is close to the share that is done", async () => {
    const [, arboleda] = modules;
    for (const positions of [mesh, make("groups"), make("town"), new Float32Array(0)]) {
        const shares = [];
        const onProgress = (share) => shares.push(share);
        const pace = { looksPerStep: 5000, millisecondsPerTurn: 0, onProgress };
        (await arboleda.buildInSteps("wide-bvh", positions, null, pace)).free();
        assert.equal(shares.at(-1), 1);
        assert.equal(shares.indexOf(1), shares.length - 1, "1 is said once");
        for (let at = 1; at < shares.length; at += 1) assert.ok(shares[at] >= shares[at - 1]);
        // Each step says where it is: as many are behind it as it says, within a fifth of all.
        if (shares.length > 50) {
            shares.forEach((share, at) =>
                assert.ok(Math.abs(share - (at + 1) / shares.length) < 0.2, `${at} ${share}`),
            );
        }
    }
});

test("a build in steps is aborted, fails, and gives its memory back", async () => {
    for (const arboleda of modules) {
        const before = arboleda.usedBytes;
        const build = (options, given = mesh, kind = "wide-bvh") => arboleda.buildInSteps(kind, given, null, options);
        const controller = new AbortController();
        const told = [];
        const onProgress = (share) => {
            told.push(share);
            if (told.length === 3) controller.abort();
        };
        const pace = { looksPerStep: 100, millisecondsPerTurn: 0, onProgress, signal: controller.signal };
        await assert.rejects(build(pace), { name: "AbortError" });
        assert.equal(told.length, 3, "no step after the abortion");
        await assert.rejects(build({ signal: AbortSignal.abort(new Error("enough")) }), { message: "enough" });
        const thrown = new Error("of the caller");
        const throws = () => {
            throw thrown;
        };
        await assert.rejects(build({ ...pace, signal: undefined, onProgress: throws }), thrown);

        await rejects(build({}, mesh, "bvh"), "INVALID_ARGUMENT", /only "wide-bvh" is built in steps, and bvh is not/);
        await rejects(build({}, mesh, "quadtree"), "UNKNOWN_KIND", /quadtree/);
        await rejects(build({}, mesh.slice(1)), "INVALID_ARGUMENT", /9 numbers for each triangle/);
        await rejects(build({ looksPerStep: 0 }), "INVALID_ARGUMENT", /looksPerStep must be 1 or more/);
        await rejects(build({ looksPerStep: 2 ** 32 }), "INVALID_ARGUMENT", /looksPerStep must be a whole number/);
        await rejects(build({ millisecondsPerTurn: -1 }), "INVALID_ARGUMENT", /millisecondsPerTurn/);
        await rejects(build({ millisecondsPerTurn: NaN }), "INVALID_ARGUMENT", /millisecondsPerTurn/);
        await rejects(build({ millisecondsPerTurn: "8" }), "INVALID_ARGUMENT", /millisecondsPerTurn/);
        await rejects(build({ onProgress: 7 }), "INVALID_ARGUMENT", /onProgress must be a function/);
        await rejects(build({ signal: {} }), "INVALID_ARGUMENT", /signal must be an AbortSignal/);
        await rejects(build({ looks: 7 }), "INVALID_ARGUMENT", /there is no option looks/);
        await rejects(build({ beside: true }), "HOLDS_TRIANGLES", /./);
        await rejects(build({ workLimit: 5 }), "TOO_MUCH_WORK", /./);
        await rejects(build({ workLimit: 10000 }), "TOO_MUCH_WORK", /./);
        const broken = mesh.slice();
        broken[9 * 700 + 4] = Infinity;
        await assert.rejects(build({ looksPerStep: 10 }, broken), { code: "NON_FINITE_VERTEX", element: 700 });
        assert.equal(arboleda.usedBytes, before);
    }
});

test("a memory that cannot hold the build is an error, and a later build finds room", async () => {
    const small = await load({ memory: new WebAssembly.Memory({ initial: 64, maximum: 100 }) });
    const large = new Float32Array(9 * 60000).map((_, at) => mesh[at % mesh.length] + Math.floor(at / mesh.length));
    const before = small.usedBytes;
    await rejects(small.buildInSteps("wide-bvh", large), "OUT_OF_MEMORY", /cannot grow/);
    assert.equal(small.usedBytes, before);
    const index = await small.buildInSteps("wide-bvh", mesh);
    assert.equal(index.triangleCount, 1202);
    index.free();
    assert.equal(small.usedBytes, before);
});

test("an index that needs more than was likely is built all the same", async () => {
    const [, arboleda] = modules;
    // Each is twice as far away, and twice as large, as the one before.
    const far = new Float32Array(9 * 20000);
    for (let at = 0; at < 20000; at += 1) {
        const x = 2 ** ((at % 200) - 100) * ((at >> 8) + 1);
        far.set([x, 0, 0, 1.01 * x, 0, 0, x, 0.01 * x, 0], 9 * at);
    }
    const before = arboleda.usedBytes;
    const shares = [];
    const given = far.slice();
    const building = arboleda.buildInSteps("wide-bvh", given, null, { onProgress: (share) => shares.push(share) });
    given.fill(0);
    const [index, atOnce] = [await building, arboleda.build("wide-bvh", far)];
    assert.ok(index.byteCount > 80 * 20000 + 65536, `${index.byteCount}`);
    assert.deepEqual(index.save(), atOnce.save());
    for (let at = 1; at < shares.length; at += 1) assert.ok(shares[at] >= shares[at - 1]);
    index.free();
    atOnce.free();
    assert.equal(arboleda.usedBytes, before);
});
