// The package: its types, its files, and the example of its page.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

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
