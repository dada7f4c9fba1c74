// The panel: numbers, steps of a path, the comparison, and the picture of the cluster tree.

import { colourOf } from "./colours.js";
import { MOST_HITS } from "./photons.js";

export const element = (id) => document.getElementById(id);
export const count = (number) => number.toLocaleString("en");
const time = (seconds) => (seconds < 1 ? `${(seconds * 1000).toFixed(0)} ms` : `${seconds.toFixed(2)} s`);
const bytes = (number) => (number < 1e6 ? `${(number / 1e3).toFixed(1)} kB` : `${(number / 1e6).toFixed(1)} MB`);
/** A number of 32 bits, with no more digits than tell it from its neighbours. */
const float = (number) => {
    for (let digits = 1; digits < 10; digits += 1) {
        const short = Number(number.toPrecision(digits));
        if (Math.fround(short) === number) return String(short);
    }
    return String(number);
};
const vector = (numbers) => [...numbers].map(float).join(", ");

/** Fills a list of names and values. */
const facts = (id, pairs) => {
    element(id).replaceChildren(
        ...pairs.flatMap(([name, value, key]) => {
            const [term, description] = [document.createElement("dt"), document.createElement("dd")];
            term.textContent = name;
            description.textContent = value;
            if (key) description.dataset.fact = key;
            return [term, description];
        }),
    );
};

const STAGES = {
    load: "Loading",
    read: "Reading the file",
    parse: "Finding its triangles",
    make: "Making the scene",
    clusters: "Finding clusters",
    build: "Building the index",
    draw: "Preparing the picture",
    compare: "Building",
    photons: "Shooting photons",
};

/** Shows what is under way, and for how long. */
export class Progress {
    #since = 0;
    #timer = 0;
    #stage = null;
    #detail = "";

    start() {
        this.#since = performance.now();
        this.#stage = null;
        element("stages").replaceChildren();
        this.step({ stage: "load" });
        clearInterval(this.#timer);
        this.#timer = setInterval(() => this.#show(), 200);
    }

    step({ stage, detail = "" }) {
        if (this.#stage && this.#stage !== stage && this.#stage !== "load") {
            const done = document.createElement("li");
            done.textContent = `✓ ${STAGES[this.#stage]} ${this.#detail}`;
            element("stages").append(done);
        }
        [this.#stage, this.#detail] = [stage, detail];
        this.#show();
    }

    #show() {
        element("stage-name").textContent = STAGES[this.#stage];
        const passed = (performance.now() - this.#since) / 1000;
        element("stage-detail").textContent = [this.#detail, passed > 1 ? `${passed.toFixed(0)} s` : ""]
            .filter(Boolean)
            .join(" · ");
    }

    stop() {
        clearInterval(this.#timer);
    }
}

/** The scene and its index. */
export const showFacts = (scene, times) => {
    const { triangleCount, clusterCount, byteCount, memoryBytes, simd, tree } = scene;
    const took = Object.fromEntries(times.map(({ stage, seconds }) => [stage, time(seconds)]));
    const more = [
        ["make", "made in"],
        ["read", "read in"],
        ["parse", "parsed in"],
        ["clusters", "clusters found in"],
    ];
    facts("facts", [
        ["triangles", count(triangleCount), "triangles"],
        ["clusters", count(clusterCount), "clusters"],
        ["nodes of the cluster tree", count(tree.count), "tree-nodes"],
        ["bytes of the index", count(byteCount), "bytes"],
        ["bytes a triangle", (byteCount / triangleCount).toFixed(1)],
        ["memory of WebAssembly", `${bytes(memoryBytes)}${simd ? ", with SIMD" : ", without SIMD"}`, "memory"],
        ...more.filter(([stage]) => took[stage]).map(([stage, name]) => [name, took[stage]]),
        ["index built in", took.build, "build"],
    ]);
};

/** A ray, its hit and its counters. */
export const showRay = ({ origin, direction }, { hit, nodesVisited, triangleTests, steps }) => {
    element("ray-none").hidden = true;
    element("ray").hidden = false;
    facts("ray-facts", [
        ["nodes entered", count(nodesVisited), "nodes"],
        ["triangles tested", count(triangleTests), "tests"],
        ["triangle hit", hit ? String(hit.triangle) : "none", "hit"],
        ...(hit
            ? [
                  ["distance", float(hit.t), "t"],
                  ["weights u, v", `${float(hit.u)}, ${float(hit.v)}`],
              ]
            : []),
        ["from", vector(origin), "origin"],
        ["towards", vector(direction), "direction"],
    ]);
    element("walk").hidden = steps.length === 0;
    const answer = hit ? `hits triangle ${hit.triangle} at ${float(hit.t)}` : "hits nothing";
    element("tip").textContent =
        `${count(nodesVisited)} nodes, ${count(triangleTests)} tests: ${answer}. Turn the scene to see the ray.`;
    element("comparison").hidden = true;
    element("agreement").textContent = "";
    element("ray-section").scrollIntoView({ block: "start" });
};

const NAMES = { join: "join", cluster: "cluster", inner: "cell", leaf: "leaf" };

/** The steps of a path. `chosen` receives the number of the one that is clicked. */
export const showSteps = (steps, chosen) => {
    const items = steps.map(({ what, id, level, testCount }, number) => {
        const item = document.createElement("li");
        item.className = what;
        const isCell = what === "inner" || what === "leaf";
        item.style.paddingLeft = `${8 + 10 * (isCell ? level + 1 : 0)}px`;
        const tests = testCount > 0 ? `: ${testCount} tested` : what === "leaf" ? ": empty" : "";
        item.textContent = `${number + 1}. ${NAMES[what]} ${isCell ? `of level ${level}` : id}${tests}`;
        item.addEventListener("click", () => chosen(number + 1));
        return item;
    });
    element("steps").replaceChildren(...items);
    const slider = element("step");
    slider.max = String(Math.max(steps.length, 1));
    slider.value = slider.max;
};

/** Marks the current step, and those after it. */
export const markStep = (current, total) => {
    element("step-value").textContent = `${current} of ${total}`;
    element("step").value = String(current);
    const items = element("steps").children;
    for (let at = 0; at < items.length; at += 1) {
        items[at].classList.toggle("later", at >= current);
        items[at].toggleAttribute("aria-current", at === current - 1);
    }
    const item = items[current - 1];
    const list = element("steps");
    if (item) list.scrollTop = item.offsetTop - list.offsetTop - list.clientHeight / 2;
};

/** The same ray in every kind of index. */
export const showComparison = (rows, all) => {
    if (rows.length === 0) return;
    const cells = (kind, values) => {
        const row = document.createElement("tr");
        row.append(
            ...values.map((value) => {
                const cell = document.createElement(kind);
                cell.textContent = value;
                return cell;
            }),
        );
        return row;
    };
    const hitOf = ({ hit }) => (hit ? `${hit.triangle} at ${float(hit.t)}` : "none");
    element("comparison").replaceChildren(
        cells("th", ["index", "nodes", "tests", "bytes", "built", "hit"]),
        ...rows.map((row) => {
            const { kind, nodesVisited, triangleTests, byteCount, seconds } = row;
            const values = [
                kind,
                count(nodesVisited),
                count(triangleTests),
                bytes(byteCount),
                time(seconds),
                hitOf(row),
            ];
            return cells("td", values);
        }),
    );
    const [first, ...others] = rows.map(hitOf);
    const those = `${rows.length === all ? "All" : "The"} ${rows.length}`;
    element("agreement").textContent = others.every((hit) => hit === first)
        ? `${those} give the same: ${first === "none" ? "no hit" : `triangle ${first}`}.`
        : "They differ: this is an error, please report it.";
    element("comparison").hidden = false;
};

export const showPhotons = ({ emitted, rays, hits, reflected, absorbed, left, stopped }, seconds) => {
    facts("photon-facts", [
        ["photons emitted", count(emitted), "emitted"],
        ["rays of them", count(rays), "rays"],
        ["hits", count(hits), "hits"],
        ["reflected", count(reflected), "reflected"],
        ["absorbed", count(absorbed), "absorbed"],
        [`stopped after ${MOST_HITS - 1} reflections`, count(stopped), "stopped"],
        ["left the scene", count(left), "left"],
        ["time", time(seconds)],
        ["rays a second", count(Math.round(rays / seconds / 1000) * 1000)],
    ]);
};

/** Where each node of the cluster tree is drawn: clusters in the order of the tree, joins above their middle. */
const placesOf = ({ count, children }) => {
    const [x, y] = [new Float32Array(count), new Float32Array(count)];
    const heights = new Int32Array(count);
    for (let node = 0; node < count; node += 1) {
        const [left, right] = [children[2 * node], children[2 * node + 1]];
        if (left >= 0) heights[node] = 1 + Math.max(heights[left], heights[right]);
    }
    let next = 0;
    const waiting = [[count - 1, false]];
    while (waiting.length > 0) {
        const [node, areChildrenDone] = waiting.pop();
        const [left, right] = [children[2 * node], children[2 * node + 1]];
        if (left < 0) {
            x[node] = next;
            next += 1;
        } else if (areChildrenDone) {
            x[node] = (x[left] + x[right]) / 2;
        } else {
            waiting.push([node, true], [right, false], [left, false]);
        }
        y[node] = heights[node];
    }
    return { x, y, width: Math.max(next - 1, 1), height: Math.max(heights[count - 1] ?? 1, 1) };
};

/** Draws the cluster tree, and in it the nodes that a ray has entered. */
export const drawTree = (tree, entered = new Set()) => {
    const canvas = element("tree");
    const ratio = Math.min(devicePixelRatio, 2);
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [width * ratio, height * ratio];
    const context = canvas.getContext("2d");
    context.scale(ratio, ratio);
    context.clearRect(0, 0, width, height);
    element("tree-note").textContent = "";
    if (tree.count === 0) return;
    const places = placesOf(tree);
    const x = (node) => 8 + ((width - 16) * places.x[node]) / places.width;
    const y = (node) => height - 10 - ((height - 20) * places.y[node]) / places.height;
    const edges = (isChosen, style, line) => {
        context.strokeStyle = style;
        context.lineWidth = line;
        context.beginPath();
        for (let node = 0; node < tree.count - 1; node += 1) {
            if (entered.has(node) !== isChosen) continue;
            const parent = tree.parents[node];
            context.moveTo(x(node), y(node));
            context.lineTo(x(node), y(parent));
            context.lineTo(x(parent), y(parent));
        }
        context.stroke();
    };
    edges(false, "#56607099", 1);
    edges(true, "#58b7ff", 2);
    const clusters = (tree.count + 1) / 2;
    const size = Math.max(1, Math.min(5, width / clusters - 1));
    for (let node = 0; node < clusters; node += 1) {
        const [red, green, blue] = colourOf(node).map((part) => Math.round(part * 255));
        const tall = entered.has(node) ? 2 * size : size;
        context.fillStyle = `rgb(${red} ${green} ${blue})`;
        context.fillRect(x(node) - size / 2, y(node) - tall / 2, size, tall);
    }
    const joins = (tree.count - 1) / 2;
    const visited = entered.size > 0 ? ` The ray has entered ${count(entered.size)} of its nodes, in blue.` : "";
    element("tree-note").textContent =
        `${count(clusters)} clusters below, in their colours; ${count(joins)} joins above, ${places.height} high.${visited}`;
    if (joins === 0) element("tree-note").textContent = `One cluster, so there is nothing to join.${visited}`;
};
