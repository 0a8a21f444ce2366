// The views of the desk, linked with each other: 3-D, map with its tools, profile and fitness.

import { TerrainMap } from "pathgene-views/map.js";
import { Profile } from "pathgene-views/profile.js";
import { at, drawnPaths, metres, nearest, readPath, readScene } from "pathgene-views/scene.js";
import { Curve, KEPT } from "pathgene-views/desk/curve.js";
import { Flight } from "pathgene-views/desk/flight.js";
import { CHECKING, FLYING, HINTS, Tools } from "pathgene-views/desk/tools.js";

// Distance in pixels from which the pointer on the map marks the track.
const NEAR_PIXELS = 30;
// Best paths that fade out after the latest, and the share of the queue shown with a frame.
const TRAIL = 7;
const SHARE = 1 / 12;
// Where frames come more slowly, as without a graphics card, 3-D shows fewer of the paths.
const SMOOTH_MS = 40;
const REST = 5;

const TOOLS = [
  ["pan", "Move"],
  ["start", "Start"],
  ["goal", "Goal"],
  ["via", "Via"],
  ["circle", "Circle"],
  ["polygon", "Polygon"],
];

export default {
  props: { uploader: Number },

  template: `
    <div class="stage" :data-big="big">
      <section data-part="relief">
        <header><h2>3-D</h2><button type="button" class="plain" @click="enlarge('relief')"
          :aria-pressed="big === 'relief'" aria-label="Enlarge the 3-D view">⤢</button></header>
        <div class="view" ref="relief"></div>
        <p v-if="failure" class="failure">{{ failure }}</p>
      </section>
      <section data-part="plan">
        <header>
          <h2>Map</h2>
          <div role="toolbar" aria-label="Tools of the map" class="tools">
            <button v-for="[name, label] in shown" type="button" :key="name" :data-tool="name"
              :aria-pressed="tool === name" @click="take(name)">{{ label }}</button>
          </div>
          <button type="button" class="plain" @click="enlarge('plan')" :aria-pressed="big === 'plan'"
            aria-label="Enlarge the map">⤢</button>
        </header>
        <p class="hint" aria-live="polite" :title="hint">{{ hint }}</p>
        <div class="view" ref="plan"></div>
      </section>
      <section data-part="altitude">
        <header><h2>Profile</h2><p class="readout">{{ readout }}</p></header>
        <div class="view" ref="altitude"></div>
      </section>
      <section data-part="fitness">
        <header><h2>Fitness</h2><p class="readout" data-role="generation">{{ counted }}</p></header>
        <div class="view" ref="fitness"></div>
      </section>
    </div>`,

  data: () => ({
    tools: TOOLS,
    tool: "pan",
    flying: false,
    checking: false,
    big: null,
    failure: "",
    readout: "",
    counted: "",
  }),

  computed: {
    hint() {
      return this.own()?.[this.tool] ?? HINTS[this.tool];
    },
    shown() {
      const own = this.own();
      return own ? this.tools.filter(([name]) => name in own) : this.tools;
    },
  },

  created() {
    // Not reactive: the views are large and change themselves.
    Object.assign(this, { map: null, view: null, profile: null, scene: null });
    Object.assign(this, { flight: null, mission: null, problem: null, opened: null });
    Object.assign(this, { rows: [], queue: [], trail: [], plan: null, kept: null, coming: null });
    this.frame = 0;
    [this.stepped_ms, this.waited_ms, this.shown_ms] = [0, 0, 0];
    this.calm = matchMedia("(prefers-reduced-motion: reduce)");
  },

  mounted() {
    this.curve = new Curve(this.$refs.fitness);
    this.$nextTick(() => this.$emit("ready", { fragment: location.hash.slice(1) }));
    addEventListener("dragover", allow);
    addEventListener("drop", this.dropped);
  },

  unmounted() {
    removeEventListener("dragover", allow);
    removeEventListener("drop", this.dropped);
    cancelAnimationFrame(this.frame);
    for (const part of [this.map, this.view, this.profile, this.curve]) part?.dispose();
  },

  methods: {
    /** Show another terrain, which is fetched from `url`, with the problem on it. */
    async setTerrain(url, problem) {
      this.opened = this.open(url, problem);
      await this.opened;
      await this.openView();
      this.$el.dataset.ready = this.scene.terrain.name;
      // For scripts and for tests.
      globalThis.pathgene = { map: this.map, view: this.view, profile: this.profile };
    },

    /** Fetch the terrain, and show all views but 3-D. */
    async open(url, problem) {
      const terrain = await (await fetch(url)).json();
      this.scene = readScene({ terrain, zones: [], points: [], paths: [], ceilings: [], ...problem });
      for (const part of [this.map, this.view, this.profile]) part?.dispose();
      delete this.$el.dataset.ready;
      [this.view, this.mission, this.plan, this.kept, this.coming] = [null, null, null, null, null];
      [this.rows, this.queue, this.trail] = [[], [], []];
      this.problem = problem;
      this.map = new TerrainMap(this.$refs.plan, this.scene);
      this.tool_ = new Tools(this.map, (name, value) => this.drawn(name, value));
      this.profile = new Profile(this.$refs.altitude, this.scene);
      this.profile.onMark = (row) => this.mark(row);
      this.map.onPoint = (place) => this.pointed(place);
      this.setChecking(false);
      this.showPlan();
    },

    /** Open the 3-D view: last, as three.js is large. */
    async openView() {
      try {
        const { TerrainView } = await import("pathgene-views/view.js");
        this.view?.dispose();
        this.view = new TerrainView(this.$refs.relief, this.scene);
        this.failure = "";
      } catch (error) {
        this.failure = `This browser draws nothing in 3-D (${error.message}); the map shows the same.`;
      }
      this.drawPaths();
    },

    /** Show the points and zones of a changed problem. */
    setProblem(problem) {
      this.problem = problem;
      // A flight has its own.
      if (!this.map || this.flight) return;
      const { zones, ceilings } = problem;
      const points = this.mission?.points ?? problem.points;
      Object.assign(this.scene, { points, zones, ceilings });
      for (const part of [this.map, this.view]) {
        part?.setPoints(points);
        part?.setZones(zones);
      }
      this.profile.setZones(zones);
    },

    /** Begin to show the generations of a plan, once its terrain is loaded. */
    async begin() {
      await this.opened;
      [this.rows, this.queue, this.trail, this.plan, this.coming] = [[], [], [], null, null];
      this.showPlan();
    },

    /** Take generations [generation, best, mean, path or null] as they come. */
    async progress(rows) {
      await this.opened;
      this.queue.push(...rows);
      this.request();
    },

    /** Show a finished plan once all its generations are shown; null shows none. */
    async setPlan(plan) {
      await this.opened;
      this.coming = { plan: plan && { ...plan, path: readPath(plan.path) } };
      this.request();
    },

    /** Show a kept plan alongside the plan; null shows none. */
    setKept(plan) {
      this.kept = plan && { ...plan, path: readPath(plan.path) };
      this.showPlan();
    },

    /** Begin to show a flight of the plan. */
    async fly() {
      await this.opened;
      if (!this.map) return;
      this.flight = new Flight(this);
      this.setFlying(true);
      this.mark(null);
    },

    /** Show the news of the flight; see Flight.take. */
    async flown(news) {
      await this.opened;
      this.flight?.take(news);
      this.request();
    },

    /** Show the plan and its problem again. */
    async land() {
      await this.opened;
      if (!this.flight) return;
      this.flight.end();
      this.flight = null;
      this.setFlying(false);
      this.setProblem(this.problem);
      this.showPlan();
    },

    /** Show a mission with its faults instead of points and plans; null shows these again. */
    async setMission(mission) {
      await this.opened;
      if (!this.map) return;
      const before = this.mission;
      const read = (path) => path && { path: readPath(path) };
      this.mission = mission && { ...mission, plan: read(mission.path), kept: read(mission.kept) };
      this.scene.faults = mission?.faults ?? [];
      this.map.setFaults(this.scene.faults);
      if (!before !== !mission) this.setChecking(mission !== null);
      this.setProblem(this.problem);
      this.showPlan();
      if (mission?.path && mission.name !== before?.name) this.map.frame(this.mission.plan.path.track);
      else if (!mission && before) this.map.fit();
    },

    setChecking(checking) {
      this.checking = checking;
      this.tool_.checking = checking;
      this.take("pan");
    },

    /** Return the hints of the tools that a flight or a mission has; null for all tools. */
    own() {
      return this.flying ? FLYING : this.checking ? CHECKING : null;
    },

    /** Return the shown plan and kept plan: of the mission, if there is one. */
    shownPlans() {
      return this.mission ?? this;
    },

    setFlying(flying) {
      this.flying = flying;
      this.tool_.flying = flying;
      this.take("pan");
    },

    /** Show the handles of a zone on the map, or none for null. */
    pick(number) {
      this.tool_?.pick(number);
    },

    /** Open a file that is dropped anywhere on the page. */
    dropped(event) {
      event.preventDefault();
      const files = [...event.dataTransfer.files];
      if (files.length) getElement(this.uploader).$refs.qRef.addFiles(files);
    },

    /** Put the problem into the address, so that it survives a reload. */
    setLink(fragment) {
      history.replaceState(null, "", `${location.pathname}${location.search}#${fragment}`);
    },

    request() {
      this.frame ||= requestAnimationFrame((now_ms) => {
        this.frame = 0;
        this.waited_ms = Math.min(now_ms - this.stepped_ms, 1000);
        this.stepped_ms = now_ms;
        this.step();
      });
    },

    step() {
      const count = this.calm.matches ? this.queue.length : Math.ceil(this.queue.length * SHARE);
      const shown = this.queue.splice(0, count);
      for (const [generation, best, mean, path] of shown) {
        this.rows.push([generation, best, mean]);
        if (path) this.trail.push(path);
      }
      this.trail.splice(0, this.trail.length - TRAIL);
      if (shown.length) {
        this.curve.show(this.rows);
        const [generation, best] = this.rows.at(-1);
        this.counted = `generation ${generation.toLocaleString("en")} · ${best.toFixed(3)}`;
        if (shown.some(([, , , path]) => path)) this.drawPaths(this.isSmooth());
      }
      this.flight?.draw(this.isSmooth());
      if (this.queue.length) this.request();
      else if (this.coming) {
        this.plan = this.coming.plan;
        this.coming = null;
        this.trail = [];
        if (this.plan) this.rows = this.plan.rows;
        this.showPlan();
      }
    },

    /** Show the finished plan, and the kept one, in all views. */
    showPlan() {
      this.curve.show(this.rows, this.kept?.rows ?? null);
      const { plan, kept } = this.shownPlans();
      const track = (plan ?? kept)?.path.track ?? null;
      this.profile?.setTrack(track, this.mission?.kept?.path.track ?? null);
      if (!this.rows.length) this.counted = "";
      this.mark(null);
      this.drawPaths();
    },

    /** Return whether 3-D has the time to show another path. */
    isSmooth() {
      const rested_ms = this.stepped_ms - this.shown_ms;
      if (this.waited_ms > SMOOTH_MS && rested_ms < REST * this.waited_ms) return false;
      this.shown_ms = this.stepped_ms;
      return true;
    },

    drawPaths(in3d = true) {
      if (this.flight) return;
      const paths = [];
      const { plan, kept } = this.shownPlans();
      if (kept) paths.push(...drawnPaths({ paths: [{ ...kept.path, mission: null }] }).map(asKept));
      if (plan) paths.push(...drawnPaths({ paths: [plan.path] }));
      if (!this.mission) this.trail.forEach((points, i) => {
        const age = this.trail.length - 1 - i;
        paths.push({ points, colour: "path", opacity: age ? 0.55 * 0.72 ** age : 1 });
      });
      this.map?.setPaths(paths);
      if (in3d) this.view?.setPaths(paths);
    },

    /** Mark a row of the shown track in all views; null marks nothing. */
    mark(row) {
      for (const part of [this.view, this.map]) part?.mark(row);
      this.profile?.mark(row ? row.s : null);
      this.readout = row
        ? `${metres(row.s)} · altitude ${metres(row.z, Infinity)} · ` +
          `clear by ${metres(row.clearance, Infinity)}`
        : "";
    },

    /** Mark the place of the shown track at `s` metres flown. */
    markAt(s) {
      const track = this.shownPlans().plan?.path.track;
      if (track) this.mark(at(track, s));
    },

    pointed(place) {
      const { plan, kept } = this.shownPlans();
      const track = (plan ?? kept)?.path.track;
      if (!place || !track || this.tool !== "pan" || this.flight) return;
      const { s, distance_m } = nearest(track, place.x, place.y);
      if (distance_m * this.map.scale() < NEAR_PIXELS) this.mark(at(track, s));
    },

    take(tool) {
      this.tool = tool;
      this.tool_?.take(tool);
    },

    drawn(name, value) {
      if (name === "tool") this.take(value.name);
      else this.$emit("drawn", { what: name, ...value });
    },

    enlarge(part) {
      this.big = this.big === part ? null : part;
    },
  },
};

function allow(event) {
  event.preventDefault();
}

function asKept(path) {
  return { ...path, colour: path.colour === "path" ? KEPT : path.colour, curtain: false, opacity: 0.85 };
}
