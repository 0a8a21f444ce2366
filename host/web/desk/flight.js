// A flight in the views: the aircraft, the track flown, and every version of its path.

import { nearest, readPath } from "pathgene-views/scene.js";

// As the aircraft.
const FLOWN = "#d55e00";
// Earlier versions, and versions of circles and ways out.
const [EARLIER, ASIDE] = [0.35, 0.8];
// Greatest distance from the shown path at which the profile marks the aircraft, metres.
const NEAR_M = 150;
// Minimum time between two drawings of the flown track in 3-D.
const TRAIL_MS = 1000;

/** A flight in the views of the desk; `views` has `map`, `view`, `profile` and their `scene`. */
export class Flight {
  constructor(views) {
    this.views = views;
    this.trail = [];
    this.versions = [];
    this.aircraft = null;
    // Time when the 3-D paths were built, which is costly; -Infinity has them built again.
    this.built_ms = -Infinity;
  }

  /**
   * Take the news.
   *
   * @param {object} news `aircraft` {x, y, z, heading_deg}; `trail` [[x, y, z], ...] flown since;
   *     `versions` [[kind, points], ...]; `zones`, `points` and `path` as in a scene, or null.
   */
  take({ aircraft, trail, versions, zones, points, path }) {
    const { map, view, profile, scene } = this.views;
    this.aircraft = aircraft;
    this.trail.push(...trail);
    if (versions.length) this.built_ms = -Infinity;
    this.versions.push(...versions);
    // Also for a 3-D view that is still to come.
    if (zones) scene.zones = zones;
    if (points) scene.points = points;
    if (zones) for (const part of [map, view, profile]) part?.setZones(zones);
    if (points) for (const part of [map, view]) part?.setPoints(points);
    if (path) profile.setTrack(readPath(path).track);
  }

  draw(in3d) {
    const { map, view, profile } = this.views;
    if (!this.aircraft) return;
    map.setAircraft(this.aircraft);
    map.setPaths(this.paths());
    if (in3d && view) {
      const now_ms = performance.now();
      if (now_ms - this.built_ms > TRAIL_MS) {
        this.built_ms = now_ms;
        view.setPaths(this.paths());
      }
      view.setAircraft(this.aircraft);
    }
    if (!profile.track) return;
    const { s, distance_m } = nearest(profile.track, this.aircraft.x, this.aircraft.y);
    profile.mark(distance_m < NEAR_M ? s : null);
  }

  paths() {
    const last = this.versions.length - 1;
    const tracks = this.versions.map(([kind, points], i) => ({
      points,
      colour: kind === "path" ? "path" : "start",
      opacity: i < last ? EARLIER : kind === "path" ? 1 : ASIDE,
    }));
    return [...tracks, { points: this.trail, colour: FLOWN, opacity: 1 }];
  }

  /** Show the views without a flight. */
  end() {
    for (const part of [this.views.map, this.views.view]) part?.setAircraft(null);
  }
}
