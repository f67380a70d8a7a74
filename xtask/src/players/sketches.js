// Sketches: lottie-web and the animated SVG in a headless Chromium, against the frames we draw ourselves.
const fs = require("fs"), path = require("path");
const { PNG } = require("pngjs");
const common = require("./common.js");

const modules = path.join(__dirname, "node_modules");
const lottiePage = (text) => `
<style>body { margin: 0 }</style><div id="a"></div><script src="file://${modules}/lottie-web/build/player/lottie.js"></script>
<script>
const data = ${text};
const div = document.getElementById("a");
div.style.width = data.w + "px"; div.style.height = data.h + "px";
const player = lottie.loadAnimation({ container: div, renderer: "svg", loop: false, autoplay: false, animationData: data });
window.show = (f) => player.goToAndStop(f, true);
player.addEventListener("DOMLoaded", () => (window.result = { w: data.w, h: data.h }));
</script>`;

const svgPage = (text, fps) => `
<style>body { margin: 0 } svg { display: block }</style>${text}
<script>
const svg = document.querySelector("svg");
svg.pauseAnimations();
// A little past the frame, as times are rounded.
window.show = (f) => svg.setCurrentTime(f / ${fps} + 1e-4);
window.result = { w: svg.width.baseVal.value, h: svg.height.baseVal.value };
</script>`;

exports.run = async (folder, open) => {
  const file = path.join(folder, "sketches.json");
  if (!fs.existsSync(file)) return;
  for (const name of JSON.parse(fs.readFileSync(file))) {
    const at = (f) => path.join(folder, name, f);
    const { fps, frames, strokes } = JSON.parse(fs.readFileSync(at("sketch-truth.json")));
    for (const [format, source, page] of [["Lottie", "sketch.json", lottiePage], ["SVG", "sketch.svg", svgPage]]) {
      const text = fs.readFileSync(at(source), "utf8");
      const player = await open(page(text, fps));
      const { w, h } = await player.evaluate("window.result");
      await player.setViewport({ width: w, height: h });
      let sum = 0, count = 0, worst = { shown: 0, all: 0 };
      for (let f = 0; f < frames; f += Math.max(1, Math.floor(frames / 12))) {
        await player.evaluate((f) => new Promise((done) => {
          window.show(f);
          requestAnimationFrame(() => requestAnimationFrame(() => setTimeout(done, 20)));
        }), f);
        const shot = PNG.sync.read(Buffer.from(await player.screenshot({ omitBackground: true, clip: { x: 0, y: 0, width: w, height: h } })));
        const own = PNG.sync.read(fs.readFileSync(at(`frames/${String(f).padStart(5, "0")}.png`)));
        if (own.width !== shot.width || own.height !== shot.height) throw new Error(`${name}: ${own.width}x${own.height} and ${shot.width}x${shot.height}`);
        const difference = common.difference(common.premultiplied(own), common.premultiplied(shot));
        if (difference.all > worst.all) worst = difference;
        sum += difference.all;
        count++;
        if (process.env.KEEP) fs.writeFileSync(at(`${format}${f}.png`), PNG.sync.write(shot));
      }
      await player.close();
      const good = worst.all <= 2;
      console.log(`${good ? "ok  " : "FAIL"} ${format}, sketch ${name}, ${strokes} strokes, ${frames} frames, ${text.length} bytes: ` +
        `pictures off by ${(sum / count).toFixed(3)} of 255 on average, ${worst.all.toFixed(3)} at most (${worst.shown.toFixed(2)} where there is a drawing)`);
      if (!good) process.exitCode = 1;
    }
  }
};
