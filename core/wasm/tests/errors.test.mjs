// Errors, memory, and what is free again.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { test } from "node:test";

import { ArboledaError, load } from "../js/arboleda.js";
import { codeOf, namesElement } from "../js/errors.js";
import { Heap } from "../js/memory.js";
import { positions, rays } from "./scene.mjs";

const arboleda = await load();
const mesh = positions();
const one = new Float32Array([0, 0, 0, 1, 0, 0, 0, 1, 0]);

const throws = (code, body, more = {}) => {
    assert.throws(body, (error) => {
        assert.ok(error instanceof ArboledaError, `${error.stack}`);
        assert.equal(error.code, code, error.message);
        assert.ok(error.message.length > 10, error.message);
        for (const [name, value] of Object.entries(more)) {
            if (value instanceof RegExp) assert.match(error[name], value);
            else assert.equal(error[name], value, name);
        }
        return true;
    });
};

test("the module is chosen by what the machine validates, and may come from anywhere", async () => {
    assert.equal(arboleda.simd, true);
    const { validate } = WebAssembly;
    WebAssembly.validate = () => false;
    try {
        assert.equal((await load()).simd, false);
    } finally {
        WebAssembly.validate = validate;
    }
    const url = new URL("../wasm/arboleda.wasm", import.meta.url);
    const bytes = readFileSync(url);
    for (const wasm of [url, String(url), bytes, new Uint8Array(bytes).buffer, new WebAssembly.Module(bytes)]) {
        assert.equal((await load({ wasm })).kinds.length, 19);
    }
    // Whether it uses simd128 is what the module says, whatever was asked for.
    for (const [name, uses] of [
        ["arboleda.wasm", false],
        ["arboleda-simd128.wasm", true],
    ]) {
        for (const simd of [undefined, false, true]) {
            assert.equal((await load({ wasm: `../wasm/${name}`, simd })).simd, uses, `${name}, simd: ${simd}`);
        }
    }
});

const refuses = (options, code, message) =>
    assert.rejects(load(options), (error) => {
        assert.ok(error instanceof ArboledaError, `${error.stack}`);
        assert.equal(error.code, code, error.message);
        assert.match(error.message, message);
        return true;
    });

test("whatever keeps a module from being loaded is an error of the package", async () => {
    const url = new URL("../wasm/arboleda.wasm", import.meta.url);
    const bytes = readFileSync(url);
    await refuses({ wasm: "http://127.0.0.1:9/none.wasm" }, "NOT_LOADED", /none\.wasm could not be fetched/);
    // Relative to `js/`.
    await refuses({ wasm: "none.wasm" }, "NOT_LOADED", /wasm\/js\/none\.wasm could not be read: ENOENT/);
    await refuses({ wasm: "http://" }, "NOT_LOADED", /http:\/\/ is not a URL/);
    for (const wasm of [7, {}, true, []]) await refuses({ wasm }, "INVALID_ARGUMENT", /wasm must be a URL/);
    await refuses({ wasm: bytes.subarray(0, 1000) }, "NOT_LOADED", /does not compile/);
    await refuses({ wasm: new Uint8Array(0) }, "NOT_LOADED", /does not compile/);
    const empty = bytes.slice(0, 8);
    await refuses({ wasm: empty }, "NOT_LOADED", /not of this package: it has no __heap_base/);
    // A module that imports a function that is not there: (import "env" "f" (func)).
    const asks = [1, 4, 1, 96, 0, 0, 2, 9, 1, 3, 101, 110, 118, 1, 102, 0, 0];
    await refuses({ wasm: new Uint8Array([...empty, ...asks]) }, "NOT_LOADED", /does not start/);
    const { validate, Memory } = WebAssembly;
    try {
        WebAssembly.validate = () => false;
        await refuses({ simd: true }, "NOT_LOADED", /does not run simd128/);
        WebAssembly.Memory = class {
            constructor() {
                throw new RangeError("could not allocate memory");
            }
        };
        await refuses({}, "OUT_OF_MEMORY", /64 pages/);
    } finally {
        Object.assign(WebAssembly, { validate, Memory });
    }
});

test("a memory has one module, and is what a module can use", async () => {
    await refuses({ memory: new WebAssembly.Memory({ initial: 31 }) }, "INVALID_ARGUMENT", /32 pages/);
    await refuses({ memory: {} }, "INVALID_ARGUMENT", /WebAssembly\.Memory/);
    const shared = new WebAssembly.Memory({ initial: 64, maximum: 64, shared: true });
    await refuses({ memory: shared }, "INVALID_ARGUMENT", /shared/);
    const memory = new WebAssembly.Memory({ initial: 32 });
    // A load that fails leaves the memory free for another.
    await refuses({ memory, wasm: "none.wasm" }, "NOT_LOADED", /ENOENT/);
    const [first, ...others] = await Promise.allSettled([load({ memory }), load({ memory })]);
    assert.ok(first.value.build("bvh", one));
    assert.equal(others[0].reason.code, "INVALID_ARGUMENT");
    await refuses({ memory }, "INVALID_ARGUMENT", /give each module its own; it uses all of it/);
    await refuses({ memory: arboleda.memory }, "INVALID_ARGUMENT", /has a module/);
});

test("codes are the names of the C interface", () => {
    const header = readFileSync(new URL("../../ffi/include/arboleda.h", import.meta.url), "utf8");
    const [, statuses] = header.match(/enum arb_status[^{]*\{(.*?)\n\}/s);
    const found = [...statuses.matchAll(/^\s+ARB_([A-Z_]+) = (\d+),$/gm)].map(([, name, number]) => [
        name,
        Number(number),
    ]);
    assert.ok(found.length >= 34, `${found.length}`);
    for (const [name, number] of found) if (number > 0) assert.equal(codeOf(number), name);
});

test("an error has an element where the C interface says so, and else null", () => {
    const header = readFileSync(new URL("../../ffi/include/arboleda.h", import.meta.url), "utf8");
    const [, statuses] = header.match(/enum arb_status[^{]*\{(.*?)\n\}/s);
    const described = [...statuses.matchAll(/\/\*\*(.*?)\*\/\s+ARB_([A-Z_]+) = \d+,/gs)];
    assert.ok(described.length >= 34, `${described.length}`);
    for (const [, text, code] of described) {
        // The five of rays share a sentence.
        const names = text.includes("arb_error.element") || code.startsWith("RAY_");
        assert.equal(namesElement(code), names, code);
        assert.equal(new ArboledaError(code, "text", 0).element, names ? 0 : null, code);
    }
    throws("TOO_MUCH_WORK", () => arboleda.build("octree", mesh, null, { workLimit: 5 }), { element: null });
    throws("TRUNCATED", () => arboleda.open(new Uint8Array(0)), { element: null });
    throws("UNKNOWN_KIND", () => arboleda.build("bhv", one), { element: null });
    const index = arboleda.build("wide-bvh", mesh);
    throws("INVALID_OPTION", () => index.cells(3), { element: null });
    throws("RAY_DIRECTION_ZERO", () => index.closestHit([0, 0, 0], [0, 0, 0]), { element: 0 });
    throws("RAY_DIRECTION_ZERO", () => index.closestHits(new Float32Array(8)), { element: 0 });
    const bytes = index.save();
    index.free();
    throws("NOT_OPEN", () => index.save(), { element: null });
    throws("MESH_NOT_WANTED", () => arboleda.open(bytes, mesh), { element: null });
});

test("bad meshes are refused by name", () => {
    throws("UNKNOWN_KIND", () => arboleda.build("bhv", one), { message: /bhv.*wide-bvh/ });
    throws("INVALID_ARGUMENT", () => arboleda.build("bvh", [0, 0, 0]), { message: /positions/ });
    throws("INVALID_ARGUMENT", () => arboleda.build("bvh", one.slice(1)), { message: /9 numbers.*8/ });
    throws("INVALID_ARGUMENT", () => arboleda.build("bvh", one, new Uint32Array(4)), { message: /corners/ });
    throws("INVALID_ARGUMENT", () => arboleda.build("bvh", one, [0, 1, 2]), { message: /corners/ });
    throws("CORNER_OUT_OF_RANGE", () => arboleda.build("bvh", one, new Uint32Array([0, 1, 2, 0, 1, 3])), {
        element: 1,
    });
    for (const bad of [NaN, Infinity]) {
        const broken = mesh.slice();
        broken[9 * 17 + 4] = bad;
        throws("NON_FINITE_VERTEX", () => arboleda.build("octree", broken), { element: 17 });
        throws("NON_FINITE_VERTEX", () => arboleda.clusters(broken), { element: 17 });
    }
    throws("INVALID_ARGUMENT", () => arboleda.build("bvh", one, null, { objects: new Uint32Array(2) }));
    throws("OBJECT_OUT_OF_RANGE", () => arboleda.build("bvh-hierarchy", one, null, { objects: new Uint32Array([1]) }));
    throws("HOLDS_TRIANGLES", () => arboleda.build("wide-bvh", one, null, { beside: true }));
});

test("bad options are refused by name", () => {
    const build = (options) => () => arboleda.build("octree", one, null, options);
    throws("INVALID_ARGUMENT", build({ leafSize: 3 }), { message: /leafSize.*leafCapacity/ });
    throws("INVALID_ARGUMENT", build({ leafCapacity: -1 }), { message: /leafCapacity/ });
    throws("INVALID_ARGUMENT", build({ leafCapacity: "4" }), { message: /leafCapacity/ });
    throws("INVALID_OPTION", build({ leafCapacity: 0 }), { message: /leaf_capacity/ });
    throws("INVALID_OPTION", build({ leastSide: 2 }), { message: /least_side/ });
    throws("INVALID_OPTION", build({ proximity: NaN }), { message: /proximity/ });
    throws("INVALID_OPTION", build({ level: 21 }), { message: /level/ });
    throws("INVALID_ARGUMENT", build({ resolution: 3 }), { message: /resolution/ });
    throws("INVALID_ARGUMENT", build({ bvhBuild: "fast" }), { message: /bvhBuild/ });
    throws("INVALID_ARGUMENT", build({ toString: 3 }), { message: /toString/ });
});

test("bad rays are refused, with their number in a batch", () => {
    const index = arboleda.build("wide-bvh", mesh);
    throws("RAY_DIRECTION_ZERO", () => index.closestHit([0, 0, 0], [0, 0, 0]));
    throws("RAY_ORIGIN_NOT_FINITE", () => index.occluded([NaN, 0, 0], [0, 0, 1]));
    throws("RAY_INTERVAL_EMPTY", () => index.allHits([0, 0, 0], [0, 0, 1], 2, 1));
    throws("RAY_INTERVAL_NAN", () => index.closestHitCounted([0, 0, 0], [0, 0, 1], NaN));
    throws("INVALID_ARGUMENT", () => index.closestHit([0, 0], [0, 0, 1]), { message: /origin/ });
    throws("INVALID_ARGUMENT", () => index.closestHits(new Float32Array(9)), { message: /8 numbers/ });
    throws("INVALID_ARGUMENT", () => index.closestHits([1]), { message: /Float32Array/ });
    // Also beyond the rays that are in the memory at once.
    const batch = new Float32Array(8 * 140000).map((_, at) => (at % 8 === 5 ? 1 : 0));
    for (const bad of [3, 139999]) {
        const broken = batch.slice();
        broken[8 * bad + 3] = Infinity;
        throws("RAY_DIRECTION_NOT_FINITE", () => index.closestHits(broken), {
            element: bad,
            message: new RegExp(`ray ${bad}`),
        });
    }
    assert.equal(index.closestHits(new Float32Array(0)).count, 0);
    index.free();
});

test("kinds without cells say so", () => {
    const index = arboleda.build("wide-bvh", mesh);
    throws("INVALID_OPTION", () => index.cells(3), { message: /octree/ });
    throws("INVALID_OPTION", () => index.path([0, 0, -200], [0, 0, 1]), { message: /octree/ });
    index.free();
});

test("a number that WebAssembly would take modulo 2^32 is refused", () => {
    const index = arboleda.build("octree", mesh);
    const { total } = index.cells(20);
    assert.ok(total > 296, `${total}`);
    for (const bad of [-4294967000, -1, 0.5, NaN, 4294967296, 4294967300, -Infinity, "3", null, 3n, Symbol("3")]) {
        throws("INVALID_ARGUMENT", () => index.cells(20, bad), { message: /^limit must be a whole number/ });
        throws("INVALID_ARGUMENT", () => index.cells(bad), { message: /^level must be a whole number/ });
    }
    throws("INVALID_ARGUMENT", () => index.cells(Infinity), { message: /level/ });
    throws("INVALID_ARGUMENT", () => index.cells(), { message: /level/ });
    assert.equal(index.cells(4294967295, 4294967295).count, total);
    assert.equal(index.cells(20, Infinity).count, total);
    assert.equal(index.cells(20, 0).count, 0);
    // What queries take their room from cannot be changed from outside.
    for (const name of ["clusterCount", "byteCount", "triangleCount", "kind", "beside"]) {
        assert.throws(() => (index[name] = -4294967000), TypeError, name);
    }
    for (const bad of [null, "1", 1n, Symbol("1"), {}]) {
        throws("INVALID_ARGUMENT", () => index.closestHit([0, bad, 0], [0, 0, 1]), { message: /origin/ });
        throws("INVALID_ARGUMENT", () => index.occluded([0, 0, 0], [0, 0, bad]), { message: /direction/ });
        throws("INVALID_ARGUMENT", () => index.allHits([0, 0, 0], [0, 0, 1], bad), { message: /tMin/ });
        throws("INVALID_ARGUMENT", () => index.path([0, 0, 0], [0, 0, 1], 0, bad), { message: /tMax/ });
    }
    for (const bad of [-4294967295, 4294967297, 0.5]) {
        for (const options of [{ leafCapacity: bad }, { sizeClasses: bad }, { resolution: { cells: [1, bad, 1] } }]) {
            throws("INVALID_ARGUMENT", () => arboleda.build("octree", one, null, options));
        }
        throws("INVALID_ARGUMENT", () => arboleda.build("octree", one, null, { level: bad - 2147483648 }));
    }
    index.free();
});

test("forged bytes do no harm", () => {
    const before = arboleda.usedBytes;
    const batch = rays(20);
    throws("TRUNCATED", () => arboleda.open(new Uint8Array(0)));
    throws("NOT_AN_INDEX", () => arboleda.open(new Uint8Array(100)));
    throws("INVALID_ARGUMENT", () => arboleda.open("bytes"));
    let refused = 0;
    let opened = 0;
    let state = 1;
    for (const kind of arboleda.kinds) {
        const index = arboleda.build(kind, mesh);
        const bytes = index.save();
        index.free();
        throws("TRUNCATED", () => arboleda.open(bytes.slice(0, bytes.length - 1)));
        for (let forgery = 0; forgery < 60; forgery += 1) {
            const forged = bytes.slice();
            for (let change = 0; change < 3; change += 1) {
                state = (Math.imul(state, 1664525) + 1013904223) >>> 0;
                forged[(state >>> 4) % forged.length] = state >>> 24;
            }
            try {
                const found = arboleda.open(forged);
                found.closestHits(batch);
                found.occludedEach(batch);
                if (kind.startsWith("octree")) found.cells(20).count + found.path([0, 0, -200], [0, 0, 1]).tests.length;
                found.free();
                opened += 1;
            } catch (error) {
                assert.ok(error instanceof ArboledaError, `${kind}: ${error.stack}`);
                refused += 1;
            }
        }
    }
    assert.ok(refused > 50 && opened > 50, `${refused} refused, ${opened} opened`);
    assert.equal(arboleda.usedBytes, before);
});

test("an index is free after free, and all memory is used again", () => {
    const before = arboleda.usedBytes;
    const index = arboleda.build("octree-hierarchy", mesh);
    assert.ok(arboleda.usedBytes > before + index.byteCount);
    assert.ok(arboleda.usedBytes < before + index.byteCount + 1024, "scratch and mesh were given back");
    index.free();
    index.free();
    assert.equal(index.isFree, true);
    assert.equal(arboleda.usedBytes, before);
    for (const query of [
        () => index.closestHit([0, 0, 0], [0, 0, 1]),
        () => index.occluded([0, 0, 0], [0, 0, 1]),
        () => index.closestHits(rays(2)),
        () => index.cells(1),
        () => index.clusterTree(),
        () => index.save(),
    ]) {
        throws("NOT_OPEN", query);
    }
    const size = arboleda.memory.buffer.byteLength;
    for (let turn = 0; turn < 30; turn += 1) arboleda.build("wide-bvh", mesh).free();
    assert.equal(arboleda.memory.buffer.byteLength, size);
    throws("INVALID_ARGUMENT", () => arboleda.build("octree", mesh.slice(1)));
    throws("TOO_MUCH_WORK", () => arboleda.build("octree", mesh, null, { workLimit: 5 }));
    assert.equal(arboleda.usedBytes, before);
});

test("blocks do not overlap, and neighbours that are free become one", () => {
    const memory = new WebAssembly.Memory({ initial: 8, maximum: 8 });
    const heap = new Heap(memory, 1000);
    const whole = 8 * 65536 - 1024;
    let state = 3;
    const next = (below) => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0), (state >>> 8) % below);
    for (let round = 0; round < 20; round += 1) {
        const blocks = [];
        for (let turn = 0; turn < 200; turn += 1) {
            if (blocks.length > 0 && next(5) < 2) {
                heap.give(blocks.splice(next(blocks.length), 1)[0][0]);
            } else {
                const bytes = next(3000);
                const first = heap.take(bytes);
                assert.equal(first % 64, 0);
                assert.ok(first >= 1000 && first + bytes <= 8 * 65536);
                for (const [other, length] of blocks) assert.ok(first + bytes <= other || other + length <= first);
                blocks.push([first, bytes]);
                if (next(4) === 0) heap.shrink(first, (blocks.at(-1)[1] = bytes >> 1));
            }
        }
        for (const [first] of blocks) heap.give(first);
        assert.equal(heap.usedBytes, 0);
        heap.give(heap.take(whole));
    }
    throws("OUT_OF_MEMORY", () => heap.take(whole + 1));
});

test("the memory is the caller's: it grows, and other indices stay", async () => {
    const memory = new WebAssembly.Memory({ initial: 32, maximum: 700 });
    const small = await load({ memory });
    assert.equal(small.memory, memory);
    const batch = rays(50);
    const first = small.build("wide-bvh", mesh);
    const expected = first.closestHits(batch);
    const bytes = memory.buffer.byteLength;
    const large = new Float32Array(9 * 60000).map((_, at) => mesh[at % mesh.length] + Math.floor(at / mesh.length));
    const second = small.build("wide-bvh", large);
    assert.ok(memory.buffer.byteLength > bytes, "the memory has grown");
    assert.deepEqual(first.closestHits(batch), expected);
    const used = small.usedBytes;
    throws("OUT_OF_MEMORY", () => small.build("octree", new Float32Array(9 * 1000000)), { message: /cannot grow/ });
    assert.equal(small.usedBytes, used);
    assert.deepEqual(first.closestHits(batch), expected);
    second.free();
    first.free();
});

test("an index that needs more than was likely is built all the same", () => {
    // Long thin triangles that cross: each is filed in many cells.
    const long = new Float32Array(9 * 4000);
    let state = 5;
    const next = () => ((state = (Math.imul(state, 1664525) + 1013904223) >>> 0), (state >>> 8) / 16777216);
    for (let at = 0; at < 4000; at += 1) {
        const [a, b] = [0, 1].map(() => [next(), next(), next()]);
        long.set([...a, ...b, b[0], b[1] + 0.001, b[2]], 9 * at);
    }
    const index = arboleda.build("octree", long, null, { level: 6, leafCapacity: 2 });
    assert.ok(index.byteCount > 80 * 4000 + 65536, `${index.byteCount}`);
    const scan = arboleda.build("linear", long);
    const batch = rays(100).map((x, at) => (at % 8 < 3 ? x / 128 : x));
    assert.deepEqual(index.closestHits(batch), scan.closestHits(batch));
    index.free();
    scan.free();
});
