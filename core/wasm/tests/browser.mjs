// A browser with the page, and a server of its files.
import { createReadStream, existsSync, mkdtempSync, rmSync } from "node:fs";
import { createServer } from "node:http";
import { tmpdir } from "node:os";
import { extname, join, normalize } from "node:path";
import { fileURLToPath } from "node:url";

import { chromium } from "playwright-core";

const room = fileURLToPath(new URL("..", import.meta.url));
const TYPES = {
    ".html": "text/html",
    ".js": "text/javascript",
    ".mjs": "text/javascript",
    ".css": "text/css",
    ".wasm": "application/wasm",
};

/** Serves the files of this room: the page is at /dist/. */
export const serve = () =>
    new Promise((resolve) => {
        const server = createServer((request, response) => {
            const path = join(room, normalize(decodeURIComponent(new URL(request.url, "http://x").pathname)));
            const file = path.endsWith("/") ? join(path, "index.html") : path;
            if (!file.startsWith(room) || !existsSync(file)) return response.writeHead(404).end();
            response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" });
            createReadStream(file).pipe(response);
        });
        server.listen(0, "127.0.0.1", () => resolve({ server, address: `http://127.0.0.1:${server.address().port}` }));
    });

const FLAGS = [
    "--no-sandbox",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
];

/** Runs `body` with a page of a new browser, and fails if the page says anything in its console. */
export const withPage = async ({ width = 1000, height = 640, ...more }, body) => {
    const profile = mkdtempSync(join(tmpdir(), "arboleda-browser-"));
    const { server, address } = await serve();
    const context = await chromium.launchPersistentContext(profile, {
        executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
        headless: true,
        args: FLAGS,
        viewport: { width, height },
        ...more,
    });
    try {
        const page = context.pages()[0] ?? (await context.newPage());
        const said = [];
        page.on("console", (message) => {
            // The graphics of this machine are computed, and chromium says so.
            if (
                ["error", "warning"].includes(message.type()) &&
                !/GPU stall|swiftshader|GL Driver/i.test(message.text())
            ) {
                said.push(message.text());
            }
        });
        page.on("pageerror", (error) => said.push(error.stack));
        page.on("requestfailed", (request) => said.push(`${request.url()}: ${request.failure().errorText}`));
        page.on(
            "response",
            (response) => response.status() >= 400 && said.push(`${response.url()}: ${response.status()}`),
        );
        const result = await body(page, address);
        if (said.length > 0) throw new Error(`the page says: ${said.join("\n")}`);
        return result;
    } finally {
        await context.close();
        server.close();
        rmSync(profile, { recursive: true, force: true });
    }
};

/** Waits until the page has done what it was asked. */
export const ready = async (page, timeout = 60000) => {
    await page.waitForFunction(() => document.body.dataset.state !== "busy", null, { timeout });
    return page.evaluate(() => [document.body.dataset.state, document.getElementById("error").textContent]);
};

/** The values that the panel shows, by name. */
export const factsOf = (page) =>
    page.evaluate(() =>
        Object.fromEntries(
            [...document.querySelectorAll("[data-fact]")].map((one) => [one.dataset.fact, one.textContent]),
        ),
    );
