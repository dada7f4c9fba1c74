// The picture: triangles, boxes, the path of a ray, photons. It is drawn only when something has changed.

import * as THREE from "./three/three.module.js";
import { OrbitControls } from "./three/OrbitControls.js";

/** The twelve edges of the unit cube. */
const EDGES = [];
for (let axis = 0; axis < 3; axis += 1) {
    for (const [i, j] of [
        [0, 0],
        [0, 1],
        [1, 0],
        [1, 1],
    ]) {
        for (const end of [0, 1]) {
            const corner = [0, 0, 0];
            corner[axis] = end;
            corner[(axis + 1) % 3] = i;
            corner[(axis + 2) % 3] = j;
            EDGES.push(...corner);
        }
    }
}

const BOX_VERTEX = `
    attribute vec3 lo; attribute vec3 hi; attribute vec3 tint; varying vec3 shade;
    void main() {
        shade = tint;
        gl_Position = projectionMatrix * modelViewMatrix * vec4(mix(lo, hi, position), 1.0);
    }`;
const BOX_FRAGMENT = `
    uniform float opacity; varying vec3 shade;
    void main() { gl_FragColor = vec4(shade, opacity); }`;

export class View {
    #renderer;
    #scene = new THREE.Scene();
    #camera = new THREE.PerspectiveCamera(45, 1, 0.1, 1000);
    #controls;
    #layers = new Map();
    #middle = [0, 0, 0];
    #asked = false;
    #element;

    constructor(element) {
        this.#element = element;
        this.#renderer = new THREE.WebGLRenderer({ antialias: true, powerPreference: "high-performance" });
        this.#renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
        // Asking would wait until the graphics card has taken the triangles.
        this.#renderer.debug.checkShaderErrors = false;
        element.prepend(this.#renderer.domElement);
        this.#scene.background = new THREE.Color(0x12151b);
        this.#controls = new OrbitControls(this.#camera, this.#renderer.domElement);
        this.#controls.addEventListener("change", () => this.redraw());
        this.#scene.add(this.#camera, new THREE.HemisphereLight(0xffffff, 0x5a6070, 1.6));
        const lamp = new THREE.DirectionalLight(0xffffff, 1.6);
        lamp.position.set(0.4, 0.8, 1);
        // From the eye, so that no side of a scene is dark.
        this.#camera.add(lamp);
        new ResizeObserver(() => this.#fit()).observe(element);
    }

    /** Draws in the next frame. */
    redraw() {
        if (this.#asked) return;
        this.#asked = true;
        requestAnimationFrame(() => {
            this.#asked = false;
            this.#renderer.render(this.#scene, this.#camera);
        });
    }

    #fit() {
        const { clientWidth: width, clientHeight: height } = this.#element;
        if (width === 0 || height === 0) return;
        this.#renderer.setSize(width, height);
        this.#camera.aspect = width / height;
        this.#camera.updateProjectionMatrix();
        this.redraw();
    }

    /** Shows or hides a layer. */
    show(name, visible) {
        const layer = this.#layers.get(name);
        if (layer) layer.visible = visible;
        this.redraw();
    }

    /** Puts an object into a layer, instead of what was there; or nothing. */
    #put(name, object) {
        const before = this.#layers.get(name);
        const visible = before?.visible ?? true;
        before?.traverse((part) => {
            part.geometry?.dispose();
            part.material?.dispose();
        });
        before?.removeFromParent();
        this.#layers.delete(name);
        if (object) {
            object.visible = visible;
            this.#layers.set(name, object);
            this.#scene.add(object);
        }
        this.redraw();
    }

    clear(...names) {
        for (const name of names) this.#put(name, null);
    }

    /** The scene's triangles, nine numbers and nine bytes of colour each, and a place for the eye. */
    setTriangles(positions, colours, middle, [lo, hi], up) {
        const geometry = new THREE.BufferGeometry();
        geometry.setAttribute("position", new THREE.BufferAttribute(positions, 3));
        geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3, true));
        geometry.boundingSphere = new THREE.Sphere(new THREE.Vector3(), Infinity);
        const material = new THREE.MeshLambertMaterial({
            vertexColors: true,
            flatShading: true,
            side: THREE.DoubleSide,
            polygonOffset: true,
            polygonOffsetFactor: 1,
            polygonOffsetUnits: 1,
        });
        this.#middle = middle;
        this.#put("triangles", new THREE.Mesh(geometry, material));
        this.look(lo, hi, up);
    }

    /** Looks at the whole of a box, from above and the side. */
    look(lo, hi, up) {
        const radius = Math.hypot(...hi.map((x, axis) => x - lo[axis])) / 2 || 1;
        const [upward, away] =
            up === "z"
                ? [
                      [0, 0, 1],
                      [0.55, -0.75, 0.45],
                  ]
                : [
                      [0, 1, 0],
                      [0.55, 0.45, 0.75],
                  ];
        // The narrower side of the picture has to hold the scene.
        const distance = (radius * 1.95) / Math.min(1, this.#camera.aspect);
        this.#camera.up.set(...upward);
        this.#camera.near = radius / 500;
        this.#camera.far = distance + radius * 60;
        this.#camera.updateProjectionMatrix();
        this.#camera.position.set(...away.map((part) => part * distance * 0.97));
        this.#controls.target.set(0, 0, 0);
        this.#controls.maxDistance = radius * 50;
        this.#controls.update();
        this.redraw();
    }

    /** Makes the triangles see-through, or solid. */
    fade(isFaded) {
        const material = this.#layers.get("triangles")?.material;
        if (!material) return;
        Object.assign(material, { transparent: isFaded, opacity: isFaded ? 0.16 : 1, depthWrite: !isFaded });
        material.needsUpdate = true;
        this.redraw();
    }

    /** Makes the triangles dark, so that photons on them are seen. */
    dim(isDim) {
        this.#layers.get("triangles")?.material.color.setScalar(isDim ? 0.07 : 1);
        this.redraw();
    }

    /** Tells whether a layer has something in it. */
    has(name) {
        return this.#layers.has(name);
    }

    /** Boxes: six numbers each, in the colours that a function gives for each. */
    setBoxes(name, bounds, colour, { opacity = 1, inFront = false } = {}) {
        const count = bounds.length / 6;
        if (count === 0) return this.#put(name, null);
        const [corners, tints] = [new Float32Array(bounds.length), new Float32Array(3 * count)];
        for (let at = 0; at < bounds.length; at += 1) corners[at] = bounds[at] - this.#middle[at % 3];
        for (let box = 0; box < count; box += 1) tints.set(colour(box), 3 * box);
        const geometry = new THREE.InstancedBufferGeometry();
        geometry.instanceCount = count;
        geometry.setAttribute("position", new THREE.Float32BufferAttribute(EDGES, 3));
        const both = new THREE.InstancedInterleavedBuffer(corners, 6);
        geometry.setAttribute("lo", new THREE.InterleavedBufferAttribute(both, 3, 0));
        geometry.setAttribute("hi", new THREE.InterleavedBufferAttribute(both, 3, 3));
        geometry.setAttribute("tint", new THREE.InstancedBufferAttribute(tints, 3));
        const material = new THREE.ShaderMaterial({
            vertexShader: BOX_VERTEX,
            fragmentShader: BOX_FRAGMENT,
            uniforms: { opacity: { value: opacity } },
            transparent: opacity < 1,
            depthTest: !inFront,
            depthWrite: false,
        });
        const lines = new THREE.LineSegments(geometry, material);
        lines.frustumCulled = false;
        lines.renderOrder = inFront ? 2 : 1;
        return this.#put(name, lines);
    }

    /** Lines from point to point, six numbers each. */
    setLines(name, points, colour, inFront = true) {
        const material = new THREE.LineBasicMaterial({ color: colour, depthTest: !inFront });
        const lines = new THREE.LineSegments(this.#geometry(points), material);
        lines.renderOrder = 4;
        lines.frustumCulled = false;
        this.#put(name, lines);
    }

    /** Triangles in one colour, in front of everything. */
    setMarked(name, corners, colour, isFilled) {
        if (corners.length === 0) return this.#put(name, null);
        const material = new THREE.MeshBasicMaterial({
            color: colour,
            side: THREE.DoubleSide,
            wireframe: !isFilled,
            depthTest: false,
            transparent: true,
            opacity: isFilled ? 0.9 : 0.75,
        });
        const mesh = new THREE.Mesh(this.#geometry(corners), material);
        mesh.renderOrder = 3;
        mesh.frustumCulled = false;
        return this.#put(name, mesh);
    }

    /** Points, in a colour by their number of bounces. */
    setPoints(name, points, bounces) {
        const shades = [
            [1, 0.93, 0.62],
            [1, 0.62, 0.25],
            [0.95, 0.36, 0.3],
            [0.72, 0.3, 0.62],
        ];
        const colours = new Float32Array(points.length);
        bounces.forEach((bounce, at) => colours.set(shades[Math.min(bounce, shades.length - 1)], 3 * at));
        const geometry = this.#geometry(points);
        geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
        const size = bounces.length > 300000 ? 1.2 : 2.2;
        const material = new THREE.PointsMaterial({ size, sizeAttenuation: false, vertexColors: true });
        const cloud = new THREE.Points(geometry, material);
        cloud.frustumCulled = false;
        this.#put(name, cloud);
    }

    #geometry(points) {
        const drawn = new Float32Array(points.length);
        for (let at = 0; at < points.length; at += 1) drawn[at] = points[at] - this.#middle[at % 3];
        return new THREE.BufferGeometry().setAttribute("position", new THREE.BufferAttribute(drawn, 3));
    }

    /** The ray through a point of the picture, in numbers of 32 bits. */
    rayAt(clientX, clientY) {
        const { left, top, width, height } = this.#renderer.domElement.getBoundingClientRect();
        const at = new THREE.Vector2(((clientX - left) / width) * 2 - 1, 1 - ((clientY - top) / height) * 2);
        const caster = new THREE.Raycaster();
        this.#camera.updateMatrixWorld();
        caster.setFromCamera(at, this.#camera);
        const { origin, direction } = caster.ray;
        return {
            origin: origin.toArray().map((x, axis) => Math.fround(x + this.#middle[axis])),
            direction: direction.toArray().map(Math.fround),
        };
    }

    /** Calls a function with each ray that is clicked or tapped; not where the picture is turned. */
    onRay(call) {
        const canvas = this.#renderer.domElement;
        let pressed = null;
        canvas.addEventListener("pointerdown", (event) => {
            pressed = event.isPrimary ? [event.clientX, event.clientY] : null;
        });
        canvas.addEventListener("pointerup", (event) => {
            if (!pressed || event.button !== 0) return;
            const moved = Math.hypot(event.clientX - pressed[0], event.clientY - pressed[1]);
            if (moved < 5) call(this.rayAt(event.clientX, event.clientY));
            pressed = null;
        });
    }
}
