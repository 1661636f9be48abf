// The scene: deck, sea, vehicle and its ghost, foot forces and the strength of the ground effect. z is up, as in the simulation.

import {
  AmbientLight,
  BufferAttribute,
  Color,
  CylinderGeometry,
  DirectionalLight,
  GridHelper,
  Group,
  Mesh,
  MeshLambertMaterial,
  PerspectiveCamera,
  PlaneGeometry,
  Quaternion,
  BoxGeometry,
  Scene,
  Vector3,
  WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/addons/controls/OrbitControls.js';

/** A landing as it can be watched: what stands in the scene, and how it moves. */
export interface Watched<Rows extends Motion = Motion> {
  deck_half_side_m: number | null;
  rotor_radius_m: number;
  rotor_spacing_m: number;
  rotor_height_m: number;
  /** Distance of the feet from the vertical axis, and their depth. */
  feet_m: [number, number];
  weight_n: number;
  frames: Rows;
}

/** Row by row. */
export interface Motion {
  time_s: number[];
  position_m: [number, number, number][];
  attitude: [number, number, number, number][];
  deck_m: [number, number, number][];
  deck_normal: [number, number, number][];
  height_m: number[];
  feet_n: [number, number, number, number][];
  ground_effect_n: number[];
  phase: string[];
}

/** A landing as the calculations return it. */
export interface Landing extends Watched<Frames> {
  row: [string, string][];
  vehicle: string | null;
}

export interface Frames extends Motion {
  estimated_height_m: number[];
  target_height_m: (number | null)[];
  velocity_mps: number[];
  counted_ground_effect_n: number[];
  deck_mps: number[];
  estimated_deck_mps: number[];
}

/** Colours of the ground effect and of the forces on the feet: none is a vehicle's, and their brightness differs from it and from the deck's. */
export const WAKE = '#e69f00';
export const FOOT = '#f0e442';
/** The sea is darker than every vehicle: a blue one would vanish before a blue of its own brightness. */
const SEA = '#0d3145';
/** Length of a force's arrow, m/N over the weight: a foot that carries the whole weight has an arrow of this length. */
const FORCE_M = 0.5;
/** Side of a deck without an edge, m. */
const WIDE_M = 6;
/** Frames that take longer than this while a landing plays lower the resolution of the next ones, ms. */
const SLOW_MS = 28;
/** Frames between two changes of the resolution. */
const JUDGED = 12;
/** The lowest resolution while a landing plays, as a part of the full one. */
const COARSEST = 0.35;
/** After this time without a new frame the picture stands still, and has its full resolution, ms. */
const STILL_MS = 200;
/** Steps of the camera at a key: pixels, turn (of a whole one, over the view's height in pixels), and zoom factor. */
const KEY_PAN = 20;
const KEY_TURN = 8;
const KEY_ZOOM = 0.9;
const UP = new Vector3(0, 0, 1);
/** Depth of the sea below the deck's mean place, as drawn; the simulation has waves only through the deck's motion. */
const SEA_M = -1.5;

/** What draws in three dimensions here, in the browser's words; null where nothing does. */
function renderer(): string | null {
  const probe = document.createElement('canvas').getContext('webgl2');
  if (!probe) return null;
  const info = probe.getExtension('WEBGL_debug_renderer_info');
  const name: unknown = probe.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : probe.RENDERER);
  probe.getExtension('WEBGL_lose_context')?.loseContext();
  return String(name);
}

/** A view in a box; where the browser cannot draw one, a sentence in the box, and null. */
export function viewIn(box: HTMLElement, wheel = true): View | null {
  const name = renderer();
  if (name === null) {
    box.textContent = 'This browser cannot draw in three dimensions (WebGL 2).';
    return null;
  }
  // Without a graphics card, smooth edges would take more than half of the time of a picture.
  const smooth = !/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name);
  return new View(box, wheel, smooth);
}

/** The phase at a time, in words. */
export function phaseAt({ frames }: Watched, time_s: number): string {
  return (frames.phase[rowAt(frames, time_s)] ?? '').replaceAll('_', ' ');
}

/** The row at a time: the last one that is not later. */
export function rowAt(frames: Motion, time_s: number): number {
  let [low, high] = [0, frames.time_s.length - 1];
  while (low < high) {
    const middle = (low + high + 1) >> 1;
    if (frames.time_s[middle]! <= time_s) low = middle;
    else high = middle - 1;
  }
  return low;
}

class Vehicle {
  readonly group = new Group();
  private readonly feet: Mesh[] = [];

  constructor(
    private readonly landing: Watched,
    colour: string,
    ghost: boolean,
  ) {
    const material = () =>
      new MeshLambertMaterial({ color: colour, transparent: true, opacity: ghost ? 0.4 : 1, depthWrite: !ghost });
    const { rotor_radius_m: radius, rotor_spacing_m: spacing, rotor_height_m: up, feet_m } = landing;
    const [foot, depth] = feet_m;
    const body = new Mesh(new BoxGeometry(0.4 * spacing, 0.4 * spacing, 0.2 * spacing), material());
    this.group.add(body);
    for (const [x, y] of [[1, 1], [-1, 1], [-1, -1], [1, -1]] as const) {
      const disc = new Mesh(new CylinderGeometry(radius, radius, 0.01, 32), material());
      disc.material.transparent = true;
      disc.material.opacity = ghost ? 0.25 : 0.6;
      disc.rotation.x = Math.PI / 2;
      disc.position.set((x * spacing) / 2, (y * spacing) / 2, up);
      const arm = new Mesh(new CylinderGeometry(0.012, 0.012, spacing / Math.SQRT2, 8), material());
      arm.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), new Vector3(x, y, 0).normalize());
      arm.position.set((x * spacing) / 4, (y * spacing) / 4, up);
      const at = new Vector3((x * foot) / Math.SQRT2, (y * foot) / Math.SQRT2, -depth);
      const leg = new Mesh(new CylinderGeometry(0.006, 0.006, 1, 6), material());
      const top = new Vector3(at.x * 0.8, at.y * 0.8, up);
      leg.scale.y = top.distanceTo(at);
      leg.quaternion.setFromUnitVectors(new Vector3(0, 1, 0), top.clone().sub(at).normalize());
      leg.position.copy(top.add(at).multiplyScalar(0.5));
      const force = new Mesh(new CylinderGeometry(0.012, 0.012, 1, 8), new MeshLambertMaterial({ color: FOOT }));
      force.rotation.x = Math.PI / 2;
      force.position.copy(at);
      force.visible = false;
      this.feet.push(force);
      this.group.add(disc, arm, leg, force);
    }
  }

  show(row: number): void {
    const { frames, weight_n, feet_m } = this.landing;
    const [w, x, y, z] = frames.attitude[row]!;
    this.group.position.set(...frames.position_m[row]!);
    this.group.quaternion.set(x, y, z, w);
    frames.feet_n[row]!.forEach((force, k) => {
      const length = (FORCE_M * force) / weight_n;
      const mesh = this.feet[k]!;
      mesh.visible = length > 0.005;
      mesh.scale.y = Math.max(length, 1e-6);
      mesh.position.z = -feet_m[1] + length / 2;
    });
  }
}

export class View {
  private readonly renderer: WebGLRenderer;
  private readonly scene = new Scene();
  private readonly camera = new PerspectiveCamera(40, 1, 0.05, 200);
  private readonly controls: OrbitControls;
  private readonly deck = new Group();
  private readonly wake: Mesh<CylinderGeometry, MeshLambertMaterial>;
  private readonly sea: Mesh<PlaneGeometry, MeshLambertMaterial>;
  private vehicles: { body: Vehicle; landing: Watched }[] = [];
  private readonly before = new Vector3();
  /** The resolution of moving pictures, as a part of the full one: a slow renderer keeps pace with it. */
  private coarse = 1;
  private shownAt = 0;
  private judged: number[] = [];
  private still = 0;

  constructor(
    private readonly box: HTMLElement,
    wheel: boolean,
    smooth: boolean,
  ) {
    this.renderer = new WebGLRenderer({ antialias: smooth, powerPreference: 'high-performance' });
    const canvas = this.renderer.domElement;
    canvas.setAttribute('aria-label', 'Vehicle and deck in three dimensions. Arrow keys move the camera, with Shift they turn it, + and - zoom.');
    // An application: screen readers pass its keys on.
    canvas.setAttribute('role', 'application');
    canvas.tabIndex = 0;
    box.append(canvas);
    this.camera.up.copy(UP);
    this.camera.position.set(-2.6, -2.2, 1.4);
    this.controls = new OrbitControls(this.camera, canvas);
    this.controls.keyPanSpeed = KEY_PAN;
    this.controls.keyRotateSpeed = KEY_TURN;
    this.controls.listenToKeyEvents(canvas);
    canvas.addEventListener('keydown', (event) => this.zoomBy(event));
    this.controls.target.set(0, 0, 0.3);
    // Where a page scrolls past the view, the wheel and a finger that moves up or down scroll the page.
    this.controls.enableZoom = wheel;
    if (!wheel) canvas.style.touchAction = 'pan-y';
    this.controls.addEventListener('change', () => this.render());
    const light = new DirectionalLight('#ffffff', 2.2);
    light.position.set(-3, -4, 8);
    this.scene.add(new AmbientLight('#ffffff', 1.1), light, this.deck);
    this.sea = new Mesh(
      new PlaneGeometry(60, 60, 32, 32),
      new MeshLambertMaterial({ color: SEA, flatShading: true }),
    );
    this.sea.position.z = SEA_M;
    this.scene.add(this.sea);
    this.wake = new Mesh(
      new CylinderGeometry(1, 1, 0.012, 48),
      new MeshLambertMaterial({ color: WAKE, transparent: true, opacity: 0 }),
    );
    this.wake.rotation.x = Math.PI / 2;
    new ResizeObserver(() => this.resize()).observe(box);
    matchMedia('(prefers-color-scheme: dark)').addEventListener('change', () => this.render());
  }

  /** Shows landings side by side in one scene; the second is a ghost. */
  load(landings: Watched[], colours: string[]): void {
    for (const { body } of this.vehicles) this.scene.remove(body.group);
    this.deck.clear();
    const [first] = landings;
    if (!first) return;
    const side = 2 * (first.deck_half_side_m ?? WIDE_M / 2);
    const plate = new Mesh(new BoxGeometry(side, side, 0.06), new MeshLambertMaterial({ color: '#8a8f98' }));
    plate.position.z = -0.03;
    const pad = new Mesh(new CylinderGeometry(0.25, 0.25, 0.004, 48), new MeshLambertMaterial({ color: '#f4f4f4' }));
    pad.rotation.x = Math.PI / 2;
    const grid = new GridHelper(side, Math.round(4 * side), '#5b6068', '#6d727b');
    grid.rotation.x = Math.PI / 2;
    grid.position.z = 0.002;
    this.deck.add(plate, pad, grid, this.wake);
    this.vehicles = landings.map((landing, k) => ({
      body: new Vehicle(landing, colours[k] ?? '#888', k > 0),
      landing,
    }));
    for (const { body } of this.vehicles) this.scene.add(body.group);
    this.before.set(0, 0, 0);
    this.show(0);
  }

  show(time_s: number): void {
    const first = this.vehicles[0];
    if (!first) return;
    this.keepPace();
    const { frames, weight_n, rotor_spacing_m } = first.landing;
    const row = rowAt(frames, time_s);
    const normal = new Vector3(...frames.deck_normal[row]!);
    this.deck.position.set(...frames.deck_m[row]!);
    this.deck.quaternion.copy(new Quaternion().setFromUnitVectors(UP, normal));
    // The camera travels along with a deck under way, but not with its heave.
    const [x, y] = frames.deck_m[row]!;
    const shift = new Vector3(x, y, 0).sub(this.before);
    this.before.set(x, y, 0);
    this.camera.position.add(shift);
    this.controls.target.add(shift);
    const lift = Math.max(frames.ground_effect_n[row]! / weight_n, 0);
    this.wake.material.opacity = Math.min(4 * lift, 0.85);
    this.wake.scale.set(1.2 * rotor_spacing_m, 1, 1.2 * rotor_spacing_m);
    const place = this.deck.worldToLocal(new Vector3(...frames.position_m[row]!));
    this.wake.position.set(place.x, place.y, 0.012);
    for (const { body, landing } of this.vehicles) body.show(rowAt(landing.frames, time_s));
    this.swell(time_s, frames.deck_m[row]![2]);
    this.render();
  }

  /** The keys + and - zoom; the controls have the other keys. */
  private zoomBy(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey) return;
    if (event.key === '+' || event.key === '=') this.controls.dollyIn(KEY_ZOOM);
    else if (event.key === '-') this.controls.dollyOut(KEY_ZOOM);
    else return;
    event.preventDefault();
  }

  /** Lowers the resolution of moving pictures until they keep pace; a picture that stands still has the full one. */
  private keepPace(): void {
    const now = performance.now();
    const took = now - this.shownAt;
    this.shownAt = now;
    clearTimeout(this.still);
    this.still = window.setTimeout(() => {
      this.sharpen(1);
      this.render();
    }, STILL_MS);
    if (took > STILL_MS) return;
    this.judged.push(took);
    if (this.judged.length === JUDGED) {
      const median = this.judged.sort((a, b) => a - b)[JUDGED >> 1]!;
      if (median > SLOW_MS) this.coarse = Math.max(0.75 * this.coarse, COARSEST);
      this.judged = [];
    }
    this.sharpen(this.coarse);
  }

  /** Sets the resolution, as a part of the full one. */
  private sharpen(part: number): void {
    const ratio = part * Math.min(devicePixelRatio, 2);
    if (Math.abs(this.renderer.getPixelRatio() - ratio) > 1e-9) this.renderer.setPixelRatio(ratio);
  }

  /** Waves for the eye: they rise and fall with the deck, and are not those of the simulation. */
  private swell(time_s: number, heave_m: number): void {
    const places = this.sea.geometry.attributes.position as BufferAttribute;
    for (let k = 0; k < places.count; k++) {
      const along = 0.5 * places.getX(k) + 0.2 * places.getY(k);
      places.setZ(k, heave_m * Math.cos(along) + 0.08 * Math.sin(2.3 * along + 1.5 * time_s));
    }
    places.needsUpdate = true;
    this.sea.geometry.computeVertexNormals();
  }

  /** Draws one frame; what it took is for tests. */
  render(): void {
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    this.scene.background = new Color(dark ? '#10151c' : '#dfeaf2');
    this.renderer.render(this.scene, this.camera);
  }

  private resize(): void {
    const { clientWidth: width, clientHeight: height } = this.box;
    if (width === 0 || height === 0) return;
    this.sharpen(1);
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    this.render();
  }
}
