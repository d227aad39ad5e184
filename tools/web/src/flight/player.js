// The clock of a flight: plays, pauses, goes to a time, and tells whoever listens.

const TIMES_REAL = [0.25, 0.5, 1, 2, 4, 8];
const LONG = [60, 600, 6000];

// A flight is over within about a minute.
const PATIENCE_S = 90;

/** Whether the reader has asked for less motion. */
export function wantsLessMotion() {
  return matchMedia("(prefers-reduced-motion: reduce)").matches;
}

/**
 * Time in s from 0 to end_s. Listeners get ({time_s, playing, elapsed_s}); elapsed_s is real time since
 * the last call while it plays, else 0.
 */
export class Player {
  constructor(end_s) {
    this.end_s = end_s;
    this.time_s = 0;
    this.playing = false;
    this.held = false;  // a cursor in a chart has the say
    this.rates = [...TIMES_REAL, ...LONG.filter((rate) => end_s / rate > PATIENCE_S / 10)];
    this.rate = this.rates.find((rate) => rate >= 1 && end_s / rate <= PATIENCE_S) ?? this.rates.at(-1);
    this.listeners = [];
    this.last_ms = null;
  }

  listen(listener) {
    this.listeners.push(listener);
  }

  tell(elapsed_s = 0) {
    for (const listener of this.listeners) listener({ time_s: this.time_s, playing: this.playing, elapsed_s });
  }

  seek(time_s) {
    this.time_s = Math.min(Math.max(time_s, 0), this.end_s);
    this.tell();
  }

  play() {
    if (this.playing) return;
    if (this.time_s >= this.end_s) this.time_s = 0;
    this.playing = true;
    this.last_ms = null;
    requestAnimationFrame((now_ms) => this.tick(now_ms));
    this.tell();
  }

  pause() {
    this.playing = false;
    this.tell();
  }

  toggle() {
    if (this.playing) this.pause();
    else this.play();
  }

  /** Shows a time until release(), from where playing goes on. */
  hold(time_s) {
    this.held = true;
    this.seek(time_s);
  }

  release() {
    this.held = false;
    this.last_ms = null;
    this.tell();
  }

  tick(now_ms) {
    if (!this.playing) return;
    // A page that was not shown for a while goes on where it was.
    const elapsed_s = this.last_ms === null ? 0 : Math.min((now_ms - this.last_ms) / 1000, 0.25);
    this.last_ms = now_ms;
    if (!this.held) {
      this.time_s = Math.min(this.time_s + elapsed_s * this.rate, this.end_s);
      if (this.time_s >= this.end_s) this.playing = false;
      this.tell(elapsed_s);
    }
    if (this.playing) requestAnimationFrame((next_ms) => this.tick(next_ms));
  }
}
