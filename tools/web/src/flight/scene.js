// The flights in three dimensions, by three.js: paths over a ground, and vehicles that fly them.
import {
  AmbientLight, BoxGeometry, BufferGeometry, CircleGeometry, Color, ConeGeometry, CylinderGeometry, DirectionalLight,
  DoubleSide, Float32BufferAttribute, Group, Line, LineBasicMaterial, LineSegments, Mesh, MeshBasicMaterial,
  MeshLambertMaterial, PerspectiveCamera, Quaternion, RingGeometry, Scene, Spherical, Vector3, WebGLRenderer,
} from "three";
import { OrbitControls } from "three/addons/controls/OrbitControls.js";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";

import { element } from "../dom.js";
import { significant } from "../format.js";
import { colour, onThemeChange } from "../theme.js";

import { placeIn, placeOf } from "./flights.js";
import { wantsLessMotion } from "./player.js";

// What is drawn of the speed of the rotors: at 2000 rad/s one and a half turns a second.
const SLOWER = 200;

const FIELD_OF_VIEW_DEG = 40;
const FINENESS = 400;
const LABEL_PX = { width: 120, height: 20 };
const TURN_RAD = 0.12;
const ZOOM = 1.15;

// The thesis' axes are x ahead, y to the right, z down; here y is up and z to the right.
const at = (x_m, y_m, altitude_m) => new Vector3(x_m, altitude_m, y_m);

// From the body to the world: yaw about down, then pitch about right, then roll about ahead.
function attitude({ roll_rad, pitch_rad, yaw_rad }, turned) {
  const about = (x, y, z, angle) => new Quaternion().setFromAxisAngle(new Vector3(x, y, z), angle);
  return turned
    .copy(about(0, -1, 0, yaw_rad))
    .multiply(about(0, 0, 1, pitch_rad))
    .multiply(about(1, 0, 0, roll_rad));
}

// A vehicle by its geometry, in m; its materials are coloured by paint().
function vehicleOf({ arm_m, motors }) {
  const body = new MeshLambertMaterial();
  const nose = new MeshLambertMaterial();
  const disc = new MeshBasicMaterial({ transparent: true, opacity: 0.2, side: DoubleSide, depthWrite: false });
  const group = new Group();
  const add = (parent, geometry, material, place) => {
    const mesh = new Mesh(geometry, material);
    if (place) mesh.position.copy(place);
    parent.add(mesh);
    return mesh;
  };
  add(group, new BoxGeometry(0.75 * arm_m, 0.2 * arm_m, 0.4 * arm_m), body);
  const tip = add(group, new ConeGeometry(0.16 * arm_m, 0.4 * arm_m, 16), nose, new Vector3(0.55 * arm_m, 0, 0));
  tip.rotation.z = -Math.PI / 2;
  const places = motors.map(({ ahead_m, right_m }) => at(ahead_m, right_m, 0));
  const apart_m = Math.min(...places.flatMap((a, k) => places.slice(k + 1).map((b) => a.distanceTo(b))));
  const radius_m = 0.46 * apart_m;
  const rotors = places.map((place, k) => {
    const length_m = place.length();
    const arm = add(group, new BoxGeometry(length_m, 0.07 * arm_m, 0.09 * arm_m), body,
      place.clone().multiplyScalar(0.5));
    arm.rotation.y = Math.atan2(-place.z, place.x);
    const top = place.clone().setY(0.08 * arm_m);
    add(group, new CylinderGeometry(0.1 * arm_m, 0.1 * arm_m, 0.2 * arm_m, 16), body, top);
    const rotor = new Group();
    rotor.position.copy(top).setY(0.2 * arm_m);
    add(rotor, new BoxGeometry(2 * radius_m, 0.015 * arm_m, 0.12 * arm_m), nose);
    add(rotor, new CircleGeometry(radius_m, 32), disc).rotation.x = -Math.PI / 2;
    group.add(rotor);
    return { rotor, sense: motors[k].turns === "clockwise" ? -1 : 1 };
  });
  const paint = (own, text) => {
    body.color.copy(own);
    disc.color.copy(own);
    nose.color.copy(text);
  };
  return { group, rotors, paint };
}

function lineThrough(places, settings) {
  const geometry = new LineGeometry();
  geometry.setPositions(places.length > 3 ? places : [...places, ...places]);
  const line = new Line2(geometry, new LineMaterial({ transparent: true, ...settings }));
  line.computeLineDistances();
  line.frustumCulled = false;
  return line;
}

// The path as places one after another, and the row of each; places that are nearer to each other than
// a pixel or two are one.
function pathOf({ column }, apart_m) {
  const places = [];
  const rows = [];
  let last = null;
  for (let k = 0; k < column.x_m.length; ++k) {
    const place = at(column.x_m[k], column.y_m[k], column.altitude_m[k]);
    if (last && k < column.x_m.length - 1 && place.distanceTo(last) < apart_m) continue;
    last = place;
    places.push(place.x, place.y, place.z);
    rows.push(k);
  }
  return { places, rows };
}

function commandedPlaces(flight) {
  const { column } = flight;
  const places = [];
  for (let k = 0; k < flight.time.length; ++k) {
    const place = [column.x_command_m[k], column.altitude_command_m[k], column.y_command_m[k]];
    if (place.some((value, axis) => value !== places[places.length - 3 + axis])) places.push(...place);
  }
  return places;
}

// Squares on the ground, and its x and y through the place of zero.
function groundOf({ x, y, square_m, size_m }) {
  const places = [];
  const reach = (range) => [
    (Math.floor((range.low - 0.15 * size_m) / square_m)) * square_m,
    (Math.ceil((range.high + 0.15 * size_m) / square_m)) * square_m,
  ];
  const [x0, x1] = reach(x);
  const [y0, y1] = reach(y);
  for (let value = x0; value <= x1 + square_m / 2; value += square_m) places.push(value, 0, y0, value, 0, y1);
  for (let value = y0; value <= y1 + square_m / 2; value += square_m) places.push(x0, 0, value, x1, 0, value);
  const geometry = new BufferGeometry();
  geometry.setAttribute("position", new Float32BufferAttribute(places, 3));
  const squares = new LineSegments(geometry, new LineBasicMaterial());
  const axes = lineThrough([x0, 0, 0, x1, 0, 0], { linewidth: 2 });
  const across = lineThrough([0, 0, y0, 0, 0, y1], { linewidth: 2 });
  return { parts: [squares, axes, across], ends: { x: at(x1, 0, 0), y: at(0, y1, 0) },
    paint: (line, text) => {
      squares.material.color.copy(line);
      axes.material.color.copy(text);
      across.material.color.copy(text);
    } };
}

/** How many times larger than it is a vehicle is drawn, so that it can be seen. */
function enlargementOf({ size_m, arm_m }) {
  const wanted = size_m / (24 * arm_m);
  return [1, 2, 3, 5, 10, 20, 50, 100, 200, 500, 1000].find((times) => times >= wanted) ?? 1000;
}

/**
 * The scene, or null where the browser has no WebGL: {picture, tools}, elements, and `shown`, the places
 * of the vehicles as (x, y, up) in m. What it shows follows the player.
 */
export function sceneOf(flights, player) {
  const canvas = element("canvas", { tabindex: 0, role: "img", "aria-label": "The flight in three dimensions" });
  const context = canvas.getContext("webgl2", { antialias: true, alpha: true, preserveDrawingBuffer: true });
  if (!context) return null;
  const renderer = new WebGLRenderer({ canvas, context, antialias: true, alpha: true });
  renderer.debug.checkShaderErrors = false;  // three's own shaders; asking would wait for the compiler
  const place = placeOf(flights);
  const scene = new Scene();
  const camera = new PerspectiveCamera(FIELD_OF_VIEW_DEG, 1, place.size_m / 1000, place.size_m * 100);
  const controls = new OrbitControls(camera, canvas);
  controls.enableZoom = false;  // the wheel scrolls the page until the picture was clicked
  controls.maxDistance = place.size_m * 20;
  canvas.addEventListener("pointerdown", () => canvas.focus({ preventScroll: true }));
  canvas.addEventListener("focus", () => (controls.enableZoom = true));
  canvas.addEventListener("blur", () => (controls.enableZoom = false));

  const sun = new DirectionalLight(0xffffff, 2);
  sun.position.set(-1, 3, 2);
  const ground = groundOf(place);
  scene.add(new AmbientLight(0xffffff, 1.4), sun, ...ground.parts);

  const stage = element("div", { class: "stage" }, canvas);
  const labels = [];
  const label = (text, name, where) => {
    const shown = element("span", { class: name }, text);
    stage.append(shown);
    labels.push({ shown, where });
  };
  label("x", "axis", () => ground.ends.x);
  label("y", "axis", () => ground.ends.y);

  let times = enlargementOf(place);
  const actors = flights.map((flight) => {
    const vehicle = vehicleOf(flight.summary.vehicle_geometry);
    const { places, rows } = pathOf(flight, place.size_m / FINENESS);
    const whole = new Line(
      new BufferGeometry().setAttribute("position", new Float32BufferAttribute(places, 3)), new LineBasicMaterial());
    const flown = lineThrough(places, { linewidth: 3 });
    const { square_m } = place;
    const commanded = lineThrough(commandedPlaces(flight),
      { linewidth: 1.5, dashed: true, dashSize: square_m / 10, gapSize: square_m / 10, opacity: 0.8 });
    const foot = new Mesh(new RingGeometry(0.7, 1, 32), new MeshBasicMaterial({ transparent: true, side: DoubleSide }));
    foot.rotation.x = -Math.PI / 2;
    const plumb = new LineSegments(
      new BufferGeometry().setAttribute("position", new Float32BufferAttribute([0, 0, 0, 0, 1, 0], 3)),
      new LineBasicMaterial());
    scene.add(vehicle.group, whole, flown, commanded, foot, plumb);
    const last = flight.pose(flight.end_s);
    if (flights.length > 1) label(flight.name, `name series-${flight.index % 7}`, () => vehicle.group.position);
    if (flight.trouble) {
      label(`✕ ${flight.trouble}`, "trouble", () => at(last.x_m, last.y_m, last.altitude_m));
    }
    return { flight, vehicle, rows, whole, flown, commanded, foot, plumb };
  });

  function paint(where = "page") {
    const colourOf = (name) => new Color(colour(name, where));
    const [line, text] = [colourOf("--line"), colourOf("--text")];
    ground.paint(line, text);
    for (const { flight, vehicle, whole, flown, commanded, foot, plumb } of actors) {
      const own = colourOf(`--series-${flight.index % 7}`);
      vehicle.paint(own, text);
      for (const each of [flown, foot, plumb]) each.material.color.copy(own);
      whole.material.color.copy(own).lerp(colourOf("--page"), 0.4);
      commanded.material.color.copy(text);
    }
  }

  const shown = flights.map(() => [0, 0, 0]);
  function pose(time_s, elapsed_s) {
    actors.forEach(({ flight, vehicle, rows, flown, foot, plumb }, k) => {
      const { row, ...now } = flight.pose(time_s);
      const { group } = vehicle;
      group.position.copy(at(now.x_m, now.y_m, now.altitude_m));
      attitude(now, group.quaternion);
      group.scale.setScalar(times);
      if (!wantsLessMotion()) {
        flight.speeds(time_s).forEach((speed, motor) => {
          const { rotor, sense } = vehicle.rotors[motor];
          rotor.rotation.y += (sense * speed * elapsed_s) / SLOWER;
        });
      }
      const segments = placeIn(rows, row).row;
      flown.visible = segments > 0;
      flown.geometry.instanceCount = segments;
      foot.position.copy(at(now.x_m, now.y_m, 0));
      foot.scale.setScalar(0.5 * times * place.arm_m);
      plumb.position.copy(foot.position);
      plumb.scale.y = Math.max(now.altitude_m, 1e-6);
      shown[k] = [now.x_m, now.y_m, now.altitude_m];
    });
  }

  let asked = false;
  function draw() {
    asked = false;
    if (!canvas.clientWidth) return;
    renderer.render(scene, camera);
    // Labels that would lie over one another stand one under another.
    const places = labels.map(({ shown: text, where }) => {
      const seen = where().clone().project(camera);
      return { text, x: ((seen.x + 1) / 2) * canvas.clientWidth, y: ((1 - seen.y) / 2) * canvas.clientHeight, ahead: seen.z < 1 };
    });
    places.sort((a, b) => a.y - b.y);
    places.forEach((place, k) => {
      const { text, x, ahead } = place;
      for (const above of places.slice(0, k)) {
        if (Math.abs(above.x - x) < LABEL_PX.width && above.ahead) place.y = Math.max(place.y, above.y + LABEL_PX.height);
      }
      const inside = ahead && x >= 0 && x <= canvas.clientWidth && place.y >= 0 && place.y <= canvas.clientHeight;
      text.style.visibility = inside ? "visible" : "hidden";
      text.style.transform = `translate(${x.toFixed(1)}px, ${place.y.toFixed(1)}px)`;
    });
  }
  const ask = () => {
    if (!asked) requestAnimationFrame(draw);
    asked = true;
  };

  // Views: the direction from what is looked at to the camera, as (x, y, up).
  const middle = at((place.x.low + place.x.high) / 2, (place.y.low + place.y.high) / 2,
    (place.up.low + place.up.high) / 2);
  let following = null;
  function look(from, target = middle, size_m = place.size_m) {
    const distance = (0.66 * size_m) / Math.tan((FIELD_OF_VIEW_DEG / 2) * (Math.PI / 180)) /
      Math.min(1, camera.aspect);
    controls.target.copy(target);
    camera.position.copy(at(...from)).normalize().multiplyScalar(distance).add(target);
    controls.update();
    ask();
  }
  const views = [
    { title: "Overview", from: [-1, 0.55, 0.6] },
    { title: "From above", from: [-1e-3, 0, 1] },
    { title: "From the side", from: [0, 1, 0.05] },
    { title: "From behind", from: [-1, 0, 0.25] },
  ];
  const lookFrom = (from) => {
    if (following === null) look(from);
    else look(from, actors[following].vehicle.group.position, 14 * times * place.arm_m);
  };

  function follow(which) {
    following = which;
    const from = camera.position.clone().sub(controls.target);
    lookFrom([from.x, from.z, from.y]);
  }

  player.listen(({ time_s, elapsed_s }) => {
    const before = following === null ? null : actors[following].vehicle.group.position.clone();
    pose(time_s, elapsed_s);
    if (before) {
      const moved = actors[following].vehicle.group.position.clone().sub(before);
      camera.position.add(moved);
      controls.target.add(moved);
      controls.update();
    }
    ask();
  });
  controls.addEventListener("change", ask);
  canvas.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const from = camera.position.clone().sub(controls.target);
    const around = new Spherical().setFromVector3(from);
    const keys = {
      a: () => (around.theta -= TURN_RAD), d: () => (around.theta += TURN_RAD),
      w: () => (around.phi -= TURN_RAD), s: () => (around.phi += TURN_RAD),
      "+": () => (around.radius /= ZOOM), "-": () => (around.radius *= ZOOM),
    };
    const turn = keys[event.key.toLowerCase()];
    if (!turn) return;
    turn();
    around.makeSafe();
    camera.position.setFromSpherical(around).add(controls.target);
    controls.update();
    event.preventDefault();
  });

  let looked = false;
  new ResizeObserver(() => {
    const { clientWidth: width, clientHeight: height } = stage;
    if (!width || !height) return;
    renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    renderer.setSize(width, height, false);
    camera.aspect = width / height;
    camera.updateProjectionMatrix();
    if (!looked) look(views[0].from);
    looked = true;
    draw();
  }).observe(stage);

  onThemeChange(() => {
    paint();
    ask();
  });
  addEventListener("beforeprint", () => {
    paint("paper");
    draw();
  });
  addEventListener("afterprint", () => {
    paint();
    draw();
  });
  paint();

  const size = element(
    "select",
    { onchange: () => {
      times = Number(size.value);
      player.tell();
    } },
    ...[...new Set([1, 2, 5, 10, times, 10 * times])].sort((a, b) => a - b).map((value) =>
      element("option", { value, selected: value === times }, value === 1 ? "as it is" : `${value} × larger`)),
  );
  const followed = element(
    "select",
    { onchange: () => follow(followed.value === "" ? null : Number(followed.value)) },
    element("option", { value: "" }, "stays"),
    ...flights.map(({ name }, k) =>
      element("option", { value: k }, flights.length > 1 ? `follows ${name}` : "follows the vehicle")),
  );
  const buttons = views.map(({ title, from }) =>
    element("button", { type: "button", onclick: () => lookFrom(from) }, title));
  const tools = [
    element("div", { class: "controls camera" }, ...buttons,
      element("label", {}, "camera ", followed), element("label", {}, "vehicle ", size)),
    element("p", { class: "hint" },
      `Squares are ${significant(place.square_m)} m wide; the dashed line is what the maneuver commands. Rotors ` +
        `turn at 1/${SLOWER} of their speed. Drag to turn the view; once it was clicked, the wheel and the keys ` +
        "W A S D, + and − move it too."),
  ];
  return { picture: stage, tools, shown };
}
