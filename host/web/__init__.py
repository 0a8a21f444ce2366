"""Views of a plan in a browser: 3-D terrain, map and altitude profile, without network access.

``scene.py`` turns a problem or a plan into plain JSON. The ES modules of this folder draw it, each
in a given element on any page; ``page.py`` combines all of them in one file. The views share their
calls::

    const scene = readScene(json)                       // scene.js: decodes the arrays
    const view = new TerrainView(element, scene)        // view.js: three.js, from "nicegui-scene"
    const map = new TerrainMap(element, scene)          // map.js: canvas with hillshade
    const profile = new Profile(element, scene)         // profile.js: altitude along one track

    view.setPaths([{points, colour, opacity}, ...])     // points: [[x, y, z], ...], metres
    view.setZones(zones)                                // as in scene.zones
    view.setPoints(points)                              // as in scene.points
    view.setAircraft({x, y, z, heading_deg} or null)    // heading clockwise from north
    view.mark({x, y, z} or null)                        // the place that all views show
    view.dispose()

``TerrainMap`` has all of these methods too, and members for drawing on it: ``metresAt(event)``,
``pixelsAt(x, y)``, ``overlays`` (a Set of functions (context, map), called last in each drawing),
``panning`` (false leaves dragging to the page), ``redraw()`` and ``onPoint`` (called with metres,
or null, as the pointer moves). ``Profile`` has ``setTrack(track or null)``, ``setZones(zones)``,
``mark(metres flown or null)``, ``onMark`` (called with a row of ``at(track, s)`` of scene.js, or
null) and ``dispose()``. If a scene has paths, they are drawn from the start.

Colours come from CSS variables of the element (``--path``, ``--nofly``, ``--text`` and so on, see
page.css), with defaults; call ``redraw()`` when they change.
"""
