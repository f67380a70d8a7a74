// three.js and lottie-web in a headless Chromium.
const fs = require("fs"), path = require("path");
const puppeteer = require("puppeteer-core");
const { PNG } = require("pngjs");
const common = require("./common.js");

const modules = path.join(__dirname, "node_modules");
// three.js plays a file: where it puts every vertex in every frame, in the picture's pixels.
const gltfPage = (bytes, height, frames, fps) => `
<script type="importmap">{"imports": {"three": "file://${modules}/three/build/three.module.js"}}</script>
<script type="module">
import * as THREE from "three";
import { GLTFLoader } from "file://${modules}/three/examples/jsm/loaders/GLTFLoader.js";
const bytes = Uint8Array.from(atob("${bytes}"), (c) => c.charCodeAt(0)).buffer;
new GLTFLoader().parse(bytes, "", (gltf) => {
  let mesh;
  gltf.scene.traverse((o) => { if (o.isSkinnedMesh) mesh = o; });
  const mixer = new THREE.AnimationMixer(gltf.scene);
  gltf.animations.forEach((clip) => { const action = mixer.clipAction(clip); action.setLoop(THREE.LoopOnce); action.clampWhenFinished = true; action.play(); });
  const all = [], p = new THREE.Vector3(), count = mesh.geometry.attributes.position.count;
  for (let f = 0; f < ${frames}; f++) {
    mixer.setTime(f / ${fps});
    gltf.scene.updateMatrixWorld(true);
    const points = [];
    for (let v = 0; v < count; v++) { mesh.getVertexPosition(v, p); points.push(p.x, ${height} - p.y, p.z); }
    all.push(points);
  }
  window.result = { frames: all, uvs: Array.from(mesh.geometry.attributes.uv.array), triangles: Array.from(mesh.geometry.index.array),
    bones: mesh.skeleton.bones.length, targets: (mesh.morphTargetInfluences || []).length };
}, (e) => { window.result = { error: String(e) }; });
</script>`;

const lottiePage = (file) => `
<style>body { margin: 0 }</style><div id="a"></div><script src="file://${modules}/lottie-web/build/player/lottie.js"></script>
<script>
const data = ${fs.readFileSync(file, "utf8")};
const div = document.getElementById("a");
div.style.width = data.w + "px"; div.style.height = data.h + "px";
window.player = lottie.loadAnimation({ container: div, renderer: "svg", loop: false, autoplay: false, animationData: data });
window.player.addEventListener("DOMLoaded", () => (window.result = { frames: data.op, w: data.w, h: data.h, layers: data.layers.length }));
</script>`;

const { premultiplied } = common;

// The launcher wants to know where the program is, not what it is called.
const onPath = (name) => process.env.PATH.split(path.delimiter).map((d) => path.join(d, name)).find((f) => fs.existsSync(f)) ?? name;

(async () => {
  const [folder, chromium] = process.argv.slice(2);
  const browser = await puppeteer.launch({ executablePath: onPath(chromium), headless: true, protocolTimeout: 600000,
    args: ["--no-sandbox", "--allow-file-access-from-files", "--disable-gpu", "--force-color-profile=srgb", "--hide-scrollbars"] });
  const open = async (html) => {
    const file = path.join(folder, "page.html");
    fs.writeFileSync(file, html);
    const page = await browser.newPage();
    page.on("pageerror", (e) => console.log("page:", e.message));
    await page.goto("file://" + path.resolve(file));
    await page.waitForFunction("window.result", { timeout: 600000 });
    return page;
  };
  for (const one of process.env.ONLY === "lottie" ? [] : common.cases(folder)) {
    const { truth } = one, glb = fs.readFileSync(one.at("take.glb"));
    const page = await open(gltfPage(glb.toString("base64"), truth.size[1], truth.frames.length, truth.fps));
    const own = await page.evaluate("window.result");
    await page.close();
    if (own.error) throw new Error(own.error);
    const name = `glTF, ${one.name}, ${glb.length} bytes, ${own.bones} bones, ${own.targets} morph targets`;
    common.score(name, one, (f) => {
      const points = own.frames[f].filter((_, i) => i % 3 < 2), z = (v) => own.frames[f][3 * v + 2];
      // The depth buffer, by triangles: a region lies within a layer.
      const triangles = Array.from({ length: own.triangles.length / 3 }, (_, t) => own.triangles.slice(3 * t, 3 * t + 3));
      const height = (t) => z(t[0]) + z(t[1]) + z(t[2]);
      triangles.sort((a, b) => height(a) - height(b));
      return { points, uvs: own.uvs, triangles: triangles.flat() };
    });
  }
  for (const one of common.cases(folder)) {
    const { truth } = one;
    const page = await open(lottiePage(one.at("lottie.json")));
    const { frames, w, h, layers } = await page.evaluate("window.result");
    await page.setViewport({ width: w, height: h });
    let worst = { shown: 0, all: 0 };
    const every = Math.max(1, Math.floor(frames / 6));
    for (let f = 0; f < frames; f += every) {
      await page.evaluate((f) => new Promise((done) => {
        window.player.goToAndStop(f, true);
        requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 20)));
      }), f);
      const shot = PNG.sync.read(Buffer.from(await page.screenshot({ omitBackground: true, clip: { x: 0, y: 0, width: w, height: h } })));
      const file = one.at(`frames/${String(f).padStart(5, "0")}.png`);
      const mine = fs.existsSync(file) ? premultiplied(PNG.sync.read(fs.readFileSync(file))) :
        common.smooth(one.texture(), truth.frames[f], truth.rest.map((v, i) => v / truth.size[i % 2]), truth.orders[truth.order_of[f]], truth.size);
      const theirs = premultiplied(shot), difference = common.difference(mine, theirs);
      if (process.env.KEEP) {
        for (const [what, data] of [["ours", mine], ["theirs", theirs]]) {
          const png = new PNG({ width: w, height: h });
          png.data = Buffer.from(data.map((v, i) => (i % 4 < 3 ? (data[i - (i % 4) + 3] ? (v * 255) / data[i - (i % 4) + 3] : 0) : v)));
          fs.writeFileSync(one.at(`${what}${f}.png`), PNG.sync.write(png));
        }
      }
      if (difference.shown > worst.shown) worst = difference;
    }
    await page.close();
    const good = worst.shown <= 2;
    console.log(`${good ? "ok  " : "FAIL"} Lottie, ${one.name}, ${fs.statSync(one.at("lottie.json")).size} bytes, ${layers} layers: ${frames} frames, ` +
      `pictures off by ${worst.shown.toFixed(2)} of 255 where there is a drawing, ${worst.all.toFixed(2)} overall`);
    if (!good) process.exitCode = 1;
  }
  await require("./sketches.js").run(folder, open);
  await browser.close();
})().catch((e) => { console.error(e); process.exit(1); });
