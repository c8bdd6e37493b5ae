// The page: takes the stream in, lets each part show its share, at its own pace.
//
// The canvas draws when something changes; words and numbers four times a second at the most.

import { Actions } from "./actions.js";
import { ask, askWay, findRobot, takeToken, withToken } from "./address.js";
import { Aim } from "./aim.js";
import { updateBanner } from "./banner.js";
import { Charts } from "./charts.js";
import { Commands } from "./commands.js";
import { Driving } from "./driving.js";
import { find, setText } from "./elements.js";
import { followEvents, followRelocalizations } from "./events.js";
import { startGestures } from "./gestures.js";
import { Graph } from "./graph.js";
import { AgePercentile, Series } from "./history.js";
import { LayerList } from "./layer_list.js";
import { Legend } from "./legend.js";
import { LiveState } from "./live_state.js";
import { Mapping } from "./mapping.js";
import { NextLook } from "./next_look.js";
import { startNotice } from "./notice.js";
import { Panel } from "./panel.js";
import { PlaceCard } from "./place_card.js";
import { Places } from "./places.js";
import { PlacesMaking } from "./places_making.js";
import { Popover } from "./popover.js";
import { Readout } from "./readout.js";
import { Scene } from "./scene.js";
import { ServerClock } from "./server_clock.js";
import { settings } from "./settings.js";
import { startSheet } from "./sheet.js";
import { Staleness } from "./staleness.js";
import { Stop } from "./stop.js";
import { Stream } from "./stream.js";
import { Strip } from "./strip.js";
import { startTheme } from "./theme.js";
import { startTools } from "./tools.js";
import { isOfThisMap, matchCount } from "./topology.js";
import { frameFor, View } from "./view.js";

const TEXT_MS = 250;
const SAMPLE_MS = 500;

const clock = new ServerClock();
const state = new LiveState(clock);
const places = new Places();
const view = new View();
const token = takeToken();
const series = { mass: new Series(), entropy: new Series(), age: new Series(), pairs: new Series() };
const ages = new AgePercentile();
const poses = [];
const marks = [];
let robot = "";
let nextTryAt = 0;
let redraws = 0;

const voices = {
  say: (text) => setText(find("#announce"), text),
  alarm: (text) => setText(find("#alarm"), text),
};
let scene = null;
const layers = new LayerList(state, () => scene?.touch());
const live = find("#live");
scene = new Scene({ floor: find("#floor"), live, view, state, layers, places });
const commands = new Commands(() => robot, () => token, () => {
  state.forbidden = "Your token lets you look only";
});
const aim = new Aim(view, scene, (command, body) => commands.send(command, body));
const tools = startTools({ view, scene, layers, aim });
const legend = new Legend(state, layers, scene);
const readout = new Readout(view, scene, state);
const popover = new Popover();
const strip = new Strip(state, places, popover, voices);
const panel = new Panel(state, places, () => (isOfThisMap(state) ? scene.graph.graph : null), {
  onLight: (number) => {
    scene.lit = number;
    scene.touch();
  },
  onGoTo: (pose) => {
    view.follows = false;
    view.goTo(pose);
    tools.moved();
  },
});
const actions = new Actions(state, commands, aim);
const nextLook = new NextLook(state, voices);
const driving = new Driving(state, commands);
const mapping = new Mapping(state, commands, () => token);
const making = new PlacesMaking(state, commands, () => token);
const card = new PlaceCard(state, view, scene, commands, (start, end) => askWay(robot, token, start, end));
scene.onView = () => card.place();
const staleness = new Staleness(state, view, scene);
const charts = new Charts(series, marks, clock, (at) => showGhost(at));
new Stop(commands, voices, popover);

startGestures(live, view, {
  aim,
  onMove: tools.moved,
  onHover: (point) => {
    readout.point(point);
    scene.point(point);
  },
  onLongPress: (point) => actions.sendGoalAt(point),
  onTap: (point, isTouch) => card.press(point, isTouch),
});
startTheme(find("[data-theme-switch]"), () => {
  scene.recolour();
  charts.palette = scene.palette;
  charts.draw();
});
const frameMap = () => {
  view.inset = frameFor(scene.covered, notice.isShown, find("#layers").offsetHeight);
  if (view.isFitted) view.fit(false);
  scene.touchFloor();
};
const notice = startNotice(state, settings, frameMap);
startSheet((covered) => {
  scene.covered = covered;
  frameMap();
});
// Chips that need a second line must not lie on the map.
new ResizeObserver(frameMap).observe(find("#layers"));

state.on("map", ({ message }) => {
  const before = scene.walls.grid?.map_id;
  if (before === message.map_id && !message.in_progress) return;
  // A map that grows is sent whole now and then: to who looks at it, it is the same map.
  const isGrown = message.in_progress && scene.walls.grid?.in_progress;
  if (before && !isGrown) scene.trail.clear();
  scene.takeMap(message);
  if (!isGrown || view.isFitted) view.fit(false);
});
state.on("map_patch", ({ message }) => {
  if (scene.takePatch(message) && view.isFitted) view.fit(false);
});
state.on("mapped_path", () => scene.touch());
state.on("mapping_status", ({ message }) => {
  if (message.redraws !== redraws) scene.trail.clear();
  redraws = message.redraws;
  if (state.isMapping() && places.list.length) {
    places.update([], performance.now());
    scene.takeBelief(null);
  }
});
state.on("belief", ({ message }) => {
  if (state.isMapping()) return;
  places.update(message.modes, performance.now());
  scene.takeBelief(message);
});
state.on("pose", ({ message }) => {
  const now = clock.unixMs();
  scene.takePose(message, now);
  poses.push({ at: now, pose: message.pose });
  while (now - poses[0].at > 120_000) poses.shift();
  if (state.isRealTime()) ages.add(now, state.age("pose") * 1000);
});
state.on("topology", ({ message }) => {
  scene.takeGraph(new Graph(message));
  card.renew();
});
followRelocalizations(state, () => scene.graph.graph, marks);
for (const topic of ["matched_lines", "matched_features"]) {
  state.on(topic, () => {
    charts.show("pairs");
    series.pairs.add(clock.unixMs(), matchCount(state));
    scene.touch();
  });
}
for (const topic of ["node_arrival", "relocalization", "landmarks", "vertical_edges", "gaze_command"]) state.on(topic, () => scene.touch());
state.on("potential", ({ message }) => scene.takePotential(message));
for (const topic of ["scan", "sonar", "ground_truth", "plan", "path", "goal", "planning_status"]) state.on(topic, () => scene.touch());

function sample() {
  const now = clock.unixMs();
  const age = state.age("pose");
  const isLive = state.isLinked() && age !== null && age < 1;
  const belief = state.isMapping() ? undefined : state.message("belief");
  series.mass.add(now, isLive && belief ? (belief.modes[0]?.mass ?? 0) : null);
  series.entropy.add(now, isLive && belief ? belief.entropy : null);
  series.age.add(now, isLive && state.isRealTime() ? ages.p99() : null);
  if (matchCount(state) === null) series.pairs.add(now, null);
  charts.draw();
}

function showGhost(at) {
  const near = at === null ? null : poses.findLast((entry) => entry.at <= at);
  scene.ghost = near && at - near.at < 2000 ? near.pose : null;
  scene.touch();
}

function showWords() {
  if (document.hidden) return;
  strip.update();
  panel.update();
  nextLook.update();
  actions.update();
  driving.update();
  mapping.update();
  making.update();
  card.update();
  legend.update();
  layers.update();
  staleness.update();
  readout.update();
  notice.update();
  updateBanner(state, nextTryAt);
}

const stream = new Stream(
  () => withToken(`${location.origin.replace(/^http/, "ws")}${robot}/stream`, token),
  clock,
  {
    onMessage: (envelope) => state.take(envelope),
    onRefused: (topic, reason) => console.warn(`${topic}: ${reason}`),
    onState: (link, retryS) => {
      if (link === "connecting" && state.link === "lost") return;
      state.link = link;
      nextTryAt = performance.now() + retryS * 1000;
      showWords();
    },
  },
);

async function recallTrail() {
  const response = await ask(`${robot}/trajectory`, token);
  if (response.ok && state.isRealTime()) scene.trail.seed(await response.json());
}

async function start() {
  try {
    robot = await findRobot(token);
  } catch (error) {
    staleness.waitFor(`${error.message}.`);
    setTimeout(start, 2000);
    return;
  }
  staleness.waitFor(null);
  stream.open();
  await recallTrail();
  followEvents(withToken(`${robot}/events`, token), marks, clock);
}

setInterval(showWords, TEXT_MS);
setInterval(sample, SAMPLE_MS);
showWords();
start();
