// The page: asks the core, which runs in a worker, and shows what it says.

import { colourOf } from "./colours.js";
import { formatOf } from "./files.js";
import {
    Progress,
    count,
    drawTree,
    element,
    markStep,
    showComparison,
    showFacts,
    showPhotons,
    showRay,
    showSteps,
} from "./panel.js";
import { View } from "./view.js";

const TIP = element("tip").textContent;
/** The most boxes that are drawn at once. */
const MOST_CELLS = 100000;
/** Of joins darker, because a path enters many of them, and they are large. */
const COLOURS = { join: [0.16, 0.36, 0.52], cluster: [0.35, 0.72, 1], inner: [0.73, 0.55, 1], leaf: [1, 0.82, 0.29] };

const view = new View(element("stage"));
const progress = new Progress();
/** A tree without nodes, while a scene is opened. */
const NO_TREE = { count: 0 };
/** The scene that is shown, and the ray. */
let scene = null;
let ray = null;
let path = null;

// --- The worker ---

let worker = null;
let waiting = new Map();
let nextId = 0;

const start = () => {
    worker?.terminate();
    document.body.toggleAttribute("data-stoppable", false);
    waiting = new Map();
    const own = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    own.onmessage = ({ data }) => {
        if (own !== worker) return;
        if (data.progress) return progress.step(data.progress);
        const { resolve, reject } = waiting.get(data.id);
        waiting.delete(data.id);
        if (data.error) reject(Object.assign(new Error(data.error.message), { code: data.error.code }));
        else resolve(data.value);
    };
    own.onerror = (event) => fail(new Error(event.message || "the worker could not be started"));
    worker = own;
};

const ask = (call, argument) =>
    new Promise((resolve, reject) => {
        nextId += 1;
        waiting.set(nextId, { resolve, reject });
        worker.postMessage({ id: nextId, call, argument });
    });

// --- What is under way ---

const setState = (state) => {
    document.body.dataset.state = state;
    const isReady = state === "ready";
    for (const id of ["kind", "compare", "forget", "shoot", "level", "step"]) element(id).disabled = !isReady;
};

const fail = (error) => {
    progress.stop();
    element("error").textContent = error.message;
    element("error").hidden = false;
    if (!scene) {
        view.clear("triangles", "clusters", "tree");
        element("facts").replaceChildren();
    }
    setState(scene ? "ready" : "failed");
};

/** Runs what takes a while; the page shows its progress, and says why it has failed. */
const busily = async (body) => {
    const own = worker;
    element("error").hidden = true;
    setState("busy");
    progress.start();
    try {
        await body();
        if (own === worker) setState("ready");
    } catch (error) {
        if (own === worker) fail(error);
    } finally {
        if (own === worker) progress.stop();
    }
};

// --- The scene and its index ---

const up = () => (element("z-up").checked ? "z" : "y");

/** Opens a built-in scene or a file, in a new worker: what was under way ends, and its memory is given back. */
const open = (source) => {
    start();
    return busily(async () => {
        scene = null;
        forgetRay();
        element("panel").scrollTop = 0;
        view.clear("cells", "photons");
        drawTree(NO_TREE);
        element("photon-facts").replaceChildren();
        const found = await ask("open", { ...source, kind: element("kind").value || "octree-hierarchy" });
        if (element("kind").options.length === 0) {
            element("kind").append(...found.kinds.map((kind) => new Option(kind, kind, false, kind === found.kind)));
        }
        scene = found;
        const { drawn, box } = found;
        const half = box[1].map((x, axis) => (x - box[0][axis]) / 2);
        view.setTriangles(drawn.positions, drawn.colours, drawn.middle, [half.map((x) => -x), half], up());
        scene.drawn = null;
        await showIndex(found.times);
    });
};

const showIndex = async (times) => {
    showFacts(scene, times);
    const { tree, clusterCount } = scene;
    view.setBoxes("clusters", tree.bounds.subarray(0, 6 * clusterCount), colourOf);
    const joins = tree.bounds.subarray(6 * clusterCount);
    view.setBoxes("tree", joins, () => COLOURS.cluster, { opacity: 0.45 });
    drawTree(tree);
    await showCells();
    show();
};

const showCells = async () => {
    const has = scene.kind.startsWith("octree");
    element("cells-row").hidden = !has;
    element("level").hidden = !has;
    element("cells-note").textContent = has
        ? ""
        : `The cells of a ${scene.kind} are not shown here, only its counters.`;
    if (!has || !element("show-cells").checked) return view.clear("cells");
    const level = Number(element("level").value);
    const { bounds, clusters, count: drawn, total } = await ask("cells", { level, limit: MOST_CELLS });
    view.setBoxes("cells", bounds, (cell) => colourOf(clusters[cell]).map((part) => 0.85 * part), { opacity: 0.5 });
    element("cells-note").textContent =
        drawn < total
            ? `The first ${count(drawn)} of ${count(total)} cells are drawn.`
            : `${count(total)} cells that hold triangles.`;
};

const show = () => {
    const isChecked = (id) => element(id).checked;
    view.show("triangles", isChecked("show-triangles"));
    view.show("clusters", isChecked("show-clusters"));
    view.show("tree", isChecked("show-tree"));
    view.show("photons", isChecked("show-photons"));
    view.fade(isChecked("see-through"));
    view.dim(isChecked("show-photons") && view.has("photons"));
};

// --- The ray ---

const forgetRay = () => {
    ray = null;
    path = null;
    element("ray").hidden = true;
    element("ray-none").hidden = false;
    element("tip").textContent = TIP;
    view.clear("ray", "path", "step", "tested", "hit");
};

const shootRay = async (given) => {
    if (document.body.dataset.state !== "ready") return;
    const found = await ask("ray", given);
    ray = given;
    path = found;
    showRay(ray, path);
    const far = 2 * Math.hypot(...scene.box[1].map((x, axis) => x - scene.box[0][axis]));
    const end = ray.origin.map((x, axis) => x + ray.direction[axis] * (path.hit?.t ?? far + distanceTo(ray.origin)));
    view.setLines("ray", [...ray.origin, ...end], 0xffffff);
    view.setMarked("hit", path.hitCorners ?? [], 0xff5470, true);
    showSteps(path.steps, showStep);
    showStep(path.steps.length);
    const joins = path.steps.filter(({ what }) => what === "join" || what === "cluster");
    drawTree(scene.tree, new Set(joins.map(({ id }) => id)));
    document.body.dataset.rays = String(Number(document.body.dataset.rays ?? 0) + 1);
};

const distanceTo = (origin) =>
    Math.hypot(...origin.map((x, axis) => x - (scene.box[0][axis] + scene.box[1][axis]) / 2));

/** Shows the path up to a step. */
const showStep = (number) => {
    const steps = path.steps.slice(0, number);
    const bounds = new Float32Array(6 * steps.length);
    steps.forEach((step, at) => bounds.set(step.bounds, 6 * at));
    view.setBoxes("path", bounds, (at) => COLOURS[steps[at].what], { opacity: 0.6, inFront: true });
    view.setBoxes("step", steps.at(-1)?.bounds ?? [], () => [1, 1, 1], { inFront: true });
    const last = steps.at(-1);
    view.setMarked(
        "tested",
        path.corners.subarray(0, 9 * (last ? last.firstTest + last.testCount : 0)),
        0xff9a3c,
        false,
    );
    markStep(number, path.steps.length);
};

// --- What the reader does ---

view.onRay((given) => shootRay(given).catch(fail));

element("scene").addEventListener("change", () => open({ scene: element("scene").value }));

const openFile = (file) => {
    if (!file) return;
    try {
        formatOf(file.name);
    } catch (error) {
        return fail(error);
    }
    const last = element("scene").options[element("scene").options.length - 1];
    last.textContent = file.name;
    last.hidden = false;
    last.selected = true;
    last.disabled = true;
    // Files of machines and scanners mostly have z upwards.
    element("z-up").checked = !/\.obj$/i.test(file.name);
    open({ file });
};

element("file").addEventListener("change", () => {
    openFile(element("file").files[0]);
    element("file").value = "";
});

let drags = 0;
const dragging = (change) => {
    drags = Math.max(0, drags + change);
    document.body.toggleAttribute("data-dragging", drags > 0);
};
addEventListener("dragenter", () => dragging(1));
addEventListener("dragleave", () => dragging(-1));
addEventListener("dragover", (event) => event.preventDefault());
addEventListener("drop", (event) => {
    event.preventDefault();
    dragging(-drags);
    openFile(event.dataTransfer.files[0]);
});

element("kind").addEventListener("change", () =>
    busily(async () => {
        const { times, ...described } = await ask("build", { kind: element("kind").value });
        Object.assign(scene, described);
        await showIndex(times);
        if (ray) {
            setState("ready");
            await shootRay(ray);
        }
    }),
);

element("z-up").addEventListener("change", () => {
    if (!scene) return;
    const half = scene.box[1].map((x, axis) => (x - scene.box[0][axis]) / 2);
    view.look(
        half.map((x) => -x),
        half,
        up(),
    );
});

for (const id of ["show-triangles", "see-through", "show-clusters", "show-tree", "show-photons"]) {
    element(id).addEventListener("change", show);
}
element("show-cells").addEventListener("change", () => showCells().catch(fail));
element("level").addEventListener("input", () => {
    element("level-value").textContent = element("level").value;
    element("show-cells").checked = true;
    showCells().catch(fail);
});
element("step").addEventListener("input", () => showStep(Number(element("step").value)));

element("compare").addEventListener("click", () =>
    busily(async () => {
        document.body.toggleAttribute("data-stoppable", true);
        try {
            showComparison(await ask("compare", ray), scene.kinds.length);
        } finally {
            document.body.toggleAttribute("data-stoppable", false);
        }
    }),
);

element("forget").addEventListener("click", () => {
    forgetRay();
    drawTree(scene.tree);
});

element("stop").addEventListener("click", () => {
    progress.step({ stage: "compare", detail: "the last one" });
    ask("stop", null);
});

element("shoot").addEventListener("click", () =>
    busily(async () => {
        const [lo, hi] = scene.box;
        const lamp = lo.map((x, axis) => (x + hi[axis]) / 2);
        // Above the scene by as much as it is wide.
        const axis = up() === "z" ? 2 : 1;
        lamp[axis] = hi[axis] + Math.max(...hi.map((x, at) => (at === axis ? 0 : x - lo[at]))) / 2;
        const { sum, seconds, points, bounces } = await ask("photons", {
            count: Number(element("photon-count").value),
            lamp,
            seed: 1,
        });
        view.setPoints("photons", points, bounces);
        showPhotons(sum, seconds);
        show();
    }),
);

addEventListener("resize", () => {
    if (!scene) return;
    const joins = path?.steps.filter(({ what }) => what === "join" || what === "cluster") ?? [];
    drawTree(scene.tree, new Set(joins.map(({ id }) => id)));
});

open({ scene: element("scene").value });
