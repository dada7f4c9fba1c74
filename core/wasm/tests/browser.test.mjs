// The page in Chromium: what it shows is what the core says.
//
// PICTURES=FOLDER keeps a picture of each state.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { fileURLToPath } from "node:url";

import { load } from "../js/arboleda.js";
import { shoot } from "../page/photons.js";
import { make } from "../page/scenes.js";
import { factsOf, ready, withPage } from "./browser.mjs";

const groupsFile = fileURLToPath(new URL("../../ffi/examples/groups.obj", import.meta.url));
const arboleda = await load();

const picture = async (page, name) => {
    if (process.env.PICTURES) await page.screenshot({ path: join(process.env.PICTURES, `${name}.png`) });
};
const number = (text) => Number(text.replaceAll(",", ""));
const vector = (text) => text.split(", ").map(Number);

/** Clicks into the scene, at a share of its width and height, and waits for the answer. */
const click = async (page, x, y) => {
    const box = await page.locator("#stage").boundingBox();
    const before = Number(await page.evaluate(() => document.body.dataset.rays ?? 0));
    await page.mouse.click(box.x + box.width * x, box.y + box.height * y);
    await page.waitForFunction((count) => Number(document.body.dataset.rays ?? 0) > count, before);
    return factsOf(page);
};

/** Lets a file fall onto the page. */
const drop = async (page, name, content) => {
    const transfer = await page.evaluateHandle(
        ([name, text]) => {
            const transfer = new DataTransfer();
            transfer.items.add(new File([text], name));
            return transfer;
        },
        [name, content],
    );
    await page.dispatchEvent("body", "dragenter", { dataTransfer: transfer });
    await picture(page, "dragging");
    await page.dispatchEvent("body", "drop", { dataTransfer: transfer });
};

/** The triangles of an OBJ file of triangles and quads, as the page's loader divides them. */
const trianglesOf = (text) => {
    const [vertices, positions] = [[], []];
    for (const line of text.split("\n")) {
        const [word, ...rest] = line.trim().split(/\s+/);
        if (word === "v") vertices.push(rest.map(Number));
        if (word !== "f") continue;
        const corners = rest.map((corner) => vertices[parseInt(corner, 10) - 1]);
        for (let at = 1; at + 1 < corners.length; at += 1)
            positions.push(...corners[0], ...corners[at], ...corners[at + 1]);
    }
    return new Float32Array(positions);
};

test("a built-in scene: ray, steps, cells, tree, photons, and every index", { timeout: 120000 }, () =>
    withPage({}, async (page, address) => {
        await page.goto(`${address}/dist/`);
        assert.deepEqual(await ready(page), ["ready", ""]);
        const facts = await factsOf(page);
        assert.ok(number(facts.triangles) > 20000 && number(facts.clusters) > 5);
        assert.equal(number(facts["tree-nodes"]), 2 * number(facts.clusters) - 1);
        await picture(page, "scene");

        const ray = await click(page, 0.5, 0.5);
        assert.ok(number(ray.nodes) > 1, ray.nodes);
        assert.equal(await page.locator("#steps li").count(), number(ray.nodes));
        await picture(page, "ray");
        const tested = await page.locator("#steps li").allTextContents();
        const sum = tested.reduce((sum, text) => sum + Number(text.match(/: (\d+) tested/)?.[1] ?? 0), 0);
        assert.equal(sum, number(ray.tests));
        await page.locator("#step").fill("2");
        assert.match(await page.locator("#step-value").textContent(), /^2 of \d+$/);

        await page.locator("#show-cells").check();
        await page.locator("#show-tree").check();
        await page.locator("#level").fill("5");
        await page.waitForFunction(() => /cells that hold/.test(document.getElementById("cells-note").textContent));
        await picture(page, "cells");

        // Every index gives the same hit.
        await page.locator("#compare").click();
        assert.deepEqual(await ready(page), ["ready", ""]);
        const rows = await page.locator("#comparison tr").count();
        assert.equal(rows, arboleda.kinds.length + 1);
        const hits = await page.locator("#comparison td:last-child").allTextContents();
        assert.deepEqual(new Set(hits), new Set([`${ray.hit} at ${ray.t}`]));
        assert.match(await page.locator("#agreement").textContent(), /^All 19 give the same: triangle/);
        await picture(page, "comparison");

        await page.selectOption("#photon-count", "10000");
        await page.locator("#shoot").click();
        assert.deepEqual(await ready(page), ["ready", ""]);
        const photons = await factsOf(page);
        const of = (name) => number(photons[name]);
        assert.equal(of("emitted"), 10000);
        assert.equal(of("rays"), of("hits") + of("left"));
        assert.equal(of("rays"), of("emitted") + of("reflected"));
        assert.equal(of("hits"), of("reflected") + of("absorbed") + of("stopped"));
        assert.equal(of("emitted"), of("left") + of("absorbed") + of("stopped"));
        assert.ok(of("hits") > 5000);
        // Node.js shoots the same ones.
        const positions = make("groups");
        const [lo, hi] = [0, 1].map(() => [0, 1, 2]);
        for (const axis of [0, 1, 2]) {
            const along = positions.filter((_, at) => at % 3 === axis);
            [lo[axis], hi[axis]] = [along.reduce((a, b) => Math.min(a, b)), along.reduce((a, b) => Math.max(a, b))];
        }
        const lamp = [(lo[0] + hi[0]) / 2, hi[1] + Math.max(hi[0] - lo[0], hi[2] - lo[2]) / 2, (lo[2] + hi[2]) / 2];
        const index = arboleda.build("lean-bvh", positions);
        const job = { lamp, box: [lo, hi], count: 10000, seed: 1 };
        const quiet = () => {};
        const shot = shoot(index, positions, job, quiet, quiet);
        index.free();
        for (const name of Object.keys(shot)) assert.equal(of(name), shot[name], name);
        await picture(page, "photons");

        // Another index answers the same ray.
        await page.selectOption("#kind", "wide-bvh");
        await page.waitForFunction(
            () => document.querySelector('[data-fact="nodes"]') && document.body.dataset.state === "ready",
        );
        await page.waitForFunction(() => document.getElementById("walk").hidden);
        assert.equal((await factsOf(page)).hit, ray.hit);
        assert.equal(await page.locator("#level").isVisible(), false);
        await page.locator("#forget").click();
        assert.equal(await page.locator("#ray").isVisible(), false);

        // In the streets of the town a few photons are stopped: they are not absorbed.
        await page.selectOption("#scene", "town");
        assert.deepEqual(await ready(page), ["ready", ""]);
        await page.locator("#shoot").click();
        assert.deepEqual(await ready(page), ["ready", ""]);
        const inTown = await factsOf(page);
        assert.ok(number(inTown.stopped) > 0, inTown.stopped);
        const ends = [inTown.left, inTown.absorbed, inTown.stopped].map(number);
        assert.equal(
            ends.reduce((a, b) => a + b),
            10000,
        );
        assert.match(await page.locator("#photon-facts").textContent(), /stopped after 7 reflections/);
    }),
);

test("a dropped file: the numbers are those of the core in Node.js", { timeout: 60000 }, () =>
    withPage({}, async (page, address) => {
        await page.goto(`${address}/dist/`);
        await ready(page);
        const text = readFileSync(groupsFile, "utf8");
        await drop(page, "groups.obj", text);
        await page.waitForFunction(() => document.querySelector('[data-fact="triangles"]')?.textContent === "456");
        assert.deepEqual(await ready(page), ["ready", ""]);
        const index = arboleda.build("octree-hierarchy", trianglesOf(text));
        const facts = await factsOf(page);
        assert.deepEqual([facts.triangles, facts.clusters, facts.bytes].map(number), [
            index.triangleCount,
            index.clusterCount,
            index.byteCount,
        ]);
        for (const [x, y] of [
            [0.5, 0.5],
            [0.42, 0.56],
            [0.6, 0.4],
            [0.02, 0.02],
        ]) {
            const shown = await click(page, x, y);
            const expected = index.closestHitCounted(vector(shown.origin), vector(shown.direction));
            assert.deepEqual([shown.nodes, shown.tests].map(number), [expected.nodesVisited, expected.triangleTests]);
            assert.equal(shown.hit, expected.hit ? String(expected.hit.triangle) : "none");
            if (expected.hit) assert.equal(Math.fround(Number(shown.t)), expected.hit.t);
        }
        index.free();
        await picture(page, "dropped");

        // Errors say what and where, and the page goes on.
        for (const [name, content, says] of [
            ["picture.png", "no", /picture\.png: only OBJ, PLY and STL/],
            ["empty.obj", "v 0 0 0\n", /empty\.obj has no triangles/],
            [
                "points.ply",
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n",
                /points\.ply has no triangles/,
            ],
            [
                "broken.obj",
                "v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n",
                /^broken\.obj: triangle 0 has an infinite or NaN coordinate/,
            ],
            ["broken.stl", "nothing", /broken\.stl/],
        ]) {
            await drop(page, name, content);
            await page.waitForFunction(() => !document.getElementById("error").hidden);
            assert.match((await ready(page))[1], says);
            await picture(page, `error-${name}`);
            await page.evaluate(() => (document.getElementById("error").hidden = true));
        }
        const square =
            "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";
        await drop(page, "one.stl", square);
        await page.waitForFunction(() => document.querySelector('[data-fact="triangles"]')?.textContent === "1");
        assert.equal((await ready(page))[0], "ready");
        const ply =
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 1\nproperty list uchar int vertex_index\nend_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
        await drop(page, "square.ply", ply);
        await page.waitForFunction(() => document.querySelector('[data-fact="triangles"]')?.textContent === "2");
        assert.equal((await ready(page))[0], "ready");
    }),
);

test("a phone: nothing is wider than it, and a tap sends a ray", { timeout: 60000 }, () =>
    withPage({ width: 390, height: 780, hasTouch: true, isMobile: true }, async (page, address) => {
        await page.goto(`${address}/dist/`);
        assert.deepEqual(await ready(page), ["ready", ""]);
        const box = await page.locator("#stage").boundingBox();
        await page.touchscreen.tap(box.x + box.width / 2, box.y + box.height / 2);
        await page.waitForFunction(() => document.body.dataset.rays === "1");
        assert.ok(number((await factsOf(page)).nodes) > 0);
        await picture(page, "phone");
        await page.locator("#compare").click();
        await ready(page);
        const widths = await page.evaluate(() => [
            document.documentElement.scrollWidth,
            document.getElementById("panel").scrollWidth,
        ]);
        assert.deepEqual(widths, [390, 390]);
        await page.locator("#shoot").scrollIntoViewIfNeeded();
        await picture(page, "phone-below");
    }),
);

test("a million triangles: with progress, and the page is not blocked", { timeout: 120000 }, () =>
    withPage({}, async (page, address) => {
        await page.goto(`${address}/dist/`);
        await ready(page);
        await page.evaluate(() => {
            const seen = (window.seen = { stages: new Set(), longest: 0, last: performance.now() });
            window.timer = setInterval(() => {
                const now = performance.now();
                seen.longest = Math.max(seen.longest, now - seen.last);
                seen.last = now;
                seen.stages.add(document.getElementById("stage-name").textContent);
            }, 20);
        });
        await page.selectOption("#scene", "million");
        await page.waitForFunction(() => document.body.dataset.state === "busy");
        assert.deepEqual(await ready(page, 100000), ["ready", ""]);
        // What comes after the last stage counts too: the first picture.
        await page.evaluate(() => new Promise((resolve) => requestAnimationFrame(() => setTimeout(resolve, 100))));
        const seen = await page.evaluate(() => ({ stages: [...window.seen.stages], longest: window.seen.longest }));
        for (const stage of ["Making the scene", "Finding clusters", "Building the index"])
            assert.ok(seen.stages.includes(stage), `${seen.stages}`);
        console.log(`the page waited at most ${seen.longest.toFixed(0)} ms`);
        assert.ok(seen.longest < 1500, `the page was blocked for ${seen.longest} ms`);
        assert.equal(number((await factsOf(page)).triangles), 1000188);
        const ray = await click(page, 0.5, 0.5);
        assert.ok(number(ray.nodes) > 10);
        await picture(page, "million");
        // A wide BVH is built in steps, of which the page says how many are done.
        await page.evaluate(() => {
            const detail = document.getElementById("stage-detail");
            window.said = [];
            new MutationObserver(() => window.said.push(detail.textContent)).observe(detail, { childList: true });
        });
        await page.selectOption("#kind", "wide-bvh");
        await page.waitForFunction(() => document.getElementById("walk").hidden);
        assert.deepEqual(await ready(page), ["ready", ""]);
        const shares = (await page.evaluate(() => window.said)).map((text) => Number(text.match(/^(\d+) %/)?.[1] ?? 0));
        assert.ok(new Set(shares).size > 5 && shares.at(-1) === 100, `${shares}`);
        assert.deepEqual(
            shares,
            [...shares].sort((a, b) => a - b),
        );
        assert.equal((await factsOf(page)).hit, ray.hit);
        // What takes long can be stopped.
        await page.locator("#compare").click();
        await page.locator("#stop").click();
        assert.deepEqual(await ready(page), ["ready", ""]);
        const rows = (await page.locator("#comparison tr").count()) - 1;
        assert.ok(rows >= 0 && rows < arboleda.kinds.length, `${rows}`);
    }),
);

test("the modules in the browser give the digests of the native build", { timeout: 60000 }, () =>
    withPage({}, async (page, address) => {
        await page.goto(`${address}/dist/`);
        await ready(page);
        const expected = readFileSync(new URL("digests.txt", import.meta.url), "utf8")
            .trim()
            .split("\n");
        for (const simd of [false, true]) {
            const found = await page.evaluate(async (simd) => {
                const [{ load }, { digests }] = await Promise.all([
                    import("/js/arboleda.js"),
                    import("/tests/scene.mjs"),
                ]);
                const arboleda = await load({ simd });
                return { simd: arboleda.simd, lines: digests(arboleda) };
            }, simd);
            assert.deepEqual(found, { simd, lines: expected });
        }
    }),
);

test("a build in steps lets the page go on, and has the bytes of a build at once", { timeout: 60000 }, () =>
    withPage({}, async (page, address) => {
        await page.goto(`${address}/dist/`);
        await ready(page);
        for (const simd of [false, true]) {
            const found = await page.evaluate(async (simd) => {
                const [{ load }, { make }] = await Promise.all([import("/js/arboleda.js"), import("/page/scenes.js")]);
                const arboleda = await load({ simd });
                const positions = make("town");
                let isOver = false;
                let timers = 0;
                const count = () => {
                    timers += 1;
                    if (!isOver) setTimeout(count);
                };
                setTimeout(count);
                const index = await arboleda.buildInSteps("wide-bvh", positions, null, { looksPerStep: 1000 });
                isOver = true;
                const atOnce = arboleda.build("wide-bvh", positions).save();
                const bytes = index.save();
                const isSame = bytes.length === atOnce.length && bytes.every((byte, at) => byte === atOnce[at]);
                return { timers, isSame, length: bytes.length };
            }, simd);
            assert.ok(found.isSame && found.length > 5e6, `${found.length}`);
            // Timers that call each other come every 4 ms at best, and a turn takes 8.
            assert.ok(found.timers > 3, `${found.timers} timers`);
        }
    }),
);
