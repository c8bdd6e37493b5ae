// Commands to the robot: POST, and what came of it in words.

export class RefusedError extends Error {}

export class Commands {
  /**
   * `robot()` is the robot's address below the API, `token()` the bearer token or null;
   * `onForbidden()` hears when that token turns out to allow no commands.
   */
  constructor(robot, token, onForbidden = () => {}) {
    Object.assign(this, { robot, token, onForbidden });
  }

  /** Returns the reply of a command, or throws RefusedError with the reason as a sentence. */
  async send(name, body = {}) {
    const headers = { "content-type": "application/json" };
    if (this.token()) headers.authorization = `Bearer ${this.token()}`;
    const address = `${this.robot()}/commands/${name}`;
    let response;
    try {
      response = await fetch(address, { method: "POST", headers, body: JSON.stringify(body) });
    } catch {
      throw new RefusedError("The gateway cannot be reached");
    }
    const answer = await response.json().catch(() => ({}));
    if (response.status === 403) this.onForbidden();
    if (!response.ok) throw new RefusedError(answer.detail ?? `The gateway answered ${response.status}`);
    return answer;
  }
}
