// The package: its types, its files, and the example of its page.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { DoubleSide, Mesh, MeshBasicMaterial, Raycaster, TorusKnotGeometry, Vector3 } from "three";

import { load } from "../js/arboleda.js";
import { codeOf } from "../js/errors.js";

const room = fileURLToPath(new URL("..", import.meta.url));
const read = (name) => readFileSync(join(room, name), "utf8");
/** The strings of a union of the types. */
const union = (name) => {
    const [, body] = read("js/arboleda.d.ts").match(new RegExp(`export type ${name} =(.*?);\n\n`, "s"));
    return [...body.matchAll(/^\s+\| "([^"]+)"/gm)].map(([, value]) => value);
};

test("the types compile, and refuse what is wrong", () => {
    const tsc = join(room, "node_modules/typescript/bin/tsc");
    execFileSync(process.execPath, [tsc, "-p", join(room, "tests/types")], { stdio: "inherit" });
});

test("the types name all kinds and codes", async () => {
    const arboleda = await load();
    assert.deepEqual(union("Kind"), [...arboleda.kinds]);
    const codes = new Set(["INVALID_ARGUMENT", "OUT_OF_MEMORY", "NOT_LOADED"]);
    for (let status = 1; status < 100; status += 1) codes.add(codeOf(status));
    assert.deepEqual(new Set(union("Code")), codes);
});

test("the package has its files and no script that runs on installing", () => {
    const { scripts, files } = JSON.parse(read("package.json"));
    assert.deepEqual(
        Object.keys(scripts).filter((name) => name.includes("install")),
        [],
    );
    const packed = execFileSync("npm", ["pack", "--dry-run", "--json", "--ignore-scripts"], {
        cwd: room,
        encoding: "utf8",
    });
    const names = JSON.parse(packed)[0].files.map(({ path }) => path);
    for (const name of [
        "js/arboleda.js",
        "js/arboleda.d.ts",
        "wasm/arboleda.wasm",
        "wasm/arboleda-simd128.wasm",
        "LICENSE-MIT",
    ]) {
        assert.ok(names.includes(name), `${name} of ${names}`);
    }
    for (const name of names) {
        const [top] = name.split("/");
        assert.ok([...files, "package.json"].includes(top), `${name} is in the package`);
    }
});

test("the example of the page runs with nothing but the package", () => {
    const [, example] = read("README.md").match(/```js\n(.*?)```/s);
    assert.ok(example.split("\n").length <= 15, "the example is short");
    const folder = mkdtempSync(join(tmpdir(), "arboleda-example-"));
    const npm = (...words) => execFileSync("npm", [...words, "--ignore-scripts"], { cwd: folder, encoding: "utf8" });
    try {
        const [{ filename }] = JSON.parse(npm("pack", room, "--json"));
        npm("install", "--offline", "--no-audit", "--no-fund", `./${filename}`);
        writeFileSync(join(folder, "example.mjs"), example);
        const printed = execFileSync(process.execPath, [join(folder, "example.mjs")], { encoding: "utf8" });
        const [, expected] = read("README.md").match(/```text\n(triangle .*?)```/s);
        assert.equal(printed, expected);
    } finally {
        rmSync(folder, { recursive: true });
    }
});

test("a moved mesh of three.js is hit as the page says: by the ray in the coordinates of the mesh", async () => {
    // The three lines of the page, as a function.
    const [, lines] = read("README.md").match(/```js\n(const ray = raycaster.*?)```/s);
    const ask = new Function("index", "mesh", "raycaster", "Vector3", `${lines}return { hit, point };`);
    const geometry = new TorusKnotGeometry();
    const mesh = new Mesh(geometry, new MeshBasicMaterial({ side: DoubleSide }));
    mesh.position.set(7, -3, 2);
    mesh.rotation.set(0.3, 1.1, -0.7);
    mesh.scale.set(2, 0.5, 3);
    mesh.updateMatrixWorld();
    const arboleda = await load();
    const index = arboleda.build("wide-bvh", geometry.attributes.position.array, geometry.index?.array);
    let hits = 0;
    for (let at = 0; at < 200; at += 1) {
        const target = mesh.localToWorld(new Vector3(Math.sin(at), Math.cos(3 * at), Math.sin(5 * at) / 2));
        const origin = new Vector3(20 * Math.cos(at), 15, 20 * Math.sin(2 * at));
        const raycaster = new Raycaster(origin, target.sub(origin).normalize());
        const [expected] = raycaster.intersectObject(mesh);
        const { hit, point } = ask(index, mesh, raycaster, Vector3);
        assert.equal(hit?.triangle, expected?.faceIndex, `ray ${at}`);
        if (!hit) continue;
        hits += 1;
        assert.ok(point.distanceTo(expected.point) < 1e-4, `ray ${at}`);
    }
    assert.ok(hits > 50, `${hits}`);
    index.free();
});
