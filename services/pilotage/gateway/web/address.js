// Where the gateway is and who we are: one robot, and a token if the gateway wants one.
//
// A token comes in the fragment (#token=...), which browsers send to nobody; it is kept for the
// session and taken out of the address bar.

const KEY = "pilotage-token";

export function takeToken() {
  const match = /[#&]token=([^&]+)/.exec(location.hash);
  if (match) {
    sessionStorage.setItem(KEY, decodeURIComponent(match[1]));
    history.replaceState(null, "", location.pathname + location.search);
  }
  return sessionStorage.getItem(KEY);
}

/** Asks the gateway for JSON. */
export function ask(address, token) {
  return fetch(address, { headers: token ? { authorization: `Bearer ${token}` } : {} });
}

/** Returns the address of the first robot below the API; throws Error with a sentence. */
export async function findRobot(token) {
  const response = await ask("/api/v1/robots", token);
  if (response.status === 401) {
    throw new Error("This gateway wants a token: open the page with #token=… at the end of its address");
  }
  if (!response.ok) throw new Error(`The gateway answered ${response.status}`);
  const [robot] = await response.json();
  return `/api/v1/robots/${robot.id}`;
}

export const withToken = (address, token) =>
  token ? `${address}?token=${encodeURIComponent(token)}` : address;

/** Asks for the cheapest way from a point to a node: {way: [[x, y], ...], nodes: [id, ...]}. */
export async function askWay(robot, token, { x, y }, { id }) {
  const address = `${robot}/topology/route?from=${x.toFixed(3)},${y.toFixed(3)}&to=${id}`;
  const response = await ask(address, token).catch(() => null);
  if (!response) throw new Error("The gateway cannot be reached");
  const answer = await response.json().catch(() => ({}));
  if (!response.ok) throw new Error(answer.detail ?? `The gateway answered ${response.status}`);
  return answer;
}
