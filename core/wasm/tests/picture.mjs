// Makes page.png, the picture of README.md: `node tests/picture.mjs`, after `./build`.
import { fileURLToPath } from "node:url";

import { ready, withPage } from "./browser.mjs";

await withPage({ width: 1080, height: 600 }, async (page, address) => {
    await page.goto(`${address}/dist/`);
    await ready(page);
    await page.locator("#show-cells").check();
    await page.locator("#level").fill("2");
    const box = await page.locator("#stage").boundingBox();
    const at = (x, y) => [box.x + box.width * x, box.y + box.height * y];
    await page.mouse.click(...at(0.54, 0.66));
    await page.waitForFunction(() => document.body.dataset.rays === "1");
    // From the side, the ray is a line.
    await page.mouse.move(...at(0.5, 0.5));
    await page.mouse.down();
    await page.mouse.move(...at(0.84, 0.46), { steps: 8 });
    await page.mouse.up();
    await page.waitForTimeout(1500);
    await page.screenshot({ path: fileURLToPath(new URL("../page.png", import.meta.url)) });
});
