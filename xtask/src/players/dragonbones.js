// The DragonBones runtime, with what it asks of its renderer left empty: its meshes' places in every frame.
const fs = require("fs"), path = require("path"), vm = require("vm");
const common = require("./common.js");

// Plain functions: the runtime's classes call them without `new`.
function Display() {
  this.children = [];
  this.transform = {};
  this.uvBuffer = { update: (d) => (this.uvs = d) };
  this.geometry = { addIndex: (d) => (this.indices = d) };
  return this;
}
Display.prototype = {
  addChild(c) { this.children.push(c); },
  addChildAt(c, i) { this.children.splice(i, 0, c); },
  removeChild(c) { this.children = this.children.filter((o) => o !== c); },
  getChildIndex(c) { return this.children.indexOf(c); },
  swapChildren() {}, setTransform() {}, emit() {}, on() {}, off() {}, once() {}, destroy() {}, listenerCount() { return 0; },
};
function Sprite() { return Display.call(this); }
Sprite.prototype = Object.create(Display.prototype);
function SimpleMesh() { return Display.call(this); }
SimpleMesh.prototype = Object.create(Display.prototype);
class Texture { constructor(base) { this.base = base; } destroy() {} }
Texture.EMPTY = new Texture(null);
const PIXI = {
  VERSION: "5.0.0", Sprite, SimpleMesh, Graphics: Display, Texture,
  Rectangle: class {}, BLEND_MODES: {}, Ticker: { shared: { add() {} } }, settings: { TARGET_FPMS: 0.06 },
};
const source = fs.readFileSync(require.resolve("pixi5-dragonbones/dragonBones.js"), "utf8");
const dragonBones = vm.runInNewContext(source + "\ndragonBones", { PIXI, console, window: {}, Float32Array, Uint16Array, Int16Array });

for (const one of common.cases(process.argv[2])) {
  const { truth } = one;
  const factory = new dragonBones.PixiFactory();
  const data = factory.parseDragonBonesData(one.json("dragon.json"), one.name);
  factory.parseTextureAtlasData(one.json("dragon_tex.json"), { resource: {} }, one.name);
  const display = factory.buildArmatureDisplay(data.armatureNames[0], one.name);
  const armature = display.armature;
  armature.animation.play(armature.animation.animationNames[0], 1);
  common.score(`DragonBones, ${one.name}, ${fs.statSync(one.at("dragon.json")).size} bytes`, one, (f) => {
    // A little past the frame, as times are sums of fractions.
    armature.advanceTime(f ? 1 / truth.fps : 1e-6);
    const points = [], uvs = [], base = new Map();
    for (const slot of armature._armatureData.sortedSlots.map((data) => armature.getSlot(data.name))) {
      base.set(slot, points.length / 2);
      points.push(...slot._renderDisplay.vertices);
      uvs.push(...slot._renderDisplay.uvs);
    }
    const drawn = [...base.keys()].sort((a, b) => a._zOrder - b._zOrder);
    const triangles = drawn.flatMap((slot) => Array.from(slot._renderDisplay.indices, (i) => i + base.get(slot)));
    return { points, uvs, triangles };
  });
}
