// Plays a time from a start to an end, and tells where it is.

export class Playback {
  private frame = 0;

  constructor(
    private readonly play: HTMLButtonElement,
    private readonly time: HTMLInputElement,
    private readonly seek: (at: number) => void,
  ) {
    play.addEventListener('click', () => (this.frame ? this.stop() : this.run()));
    time.addEventListener('input', () => {
      this.stop();
      seek(Number(time.value));
    });
  }

  /** From where it stands; from the start where it stands at the end. */
  run(): void {
    const end = Number(this.time.max);
    const from = Number(this.time.value) >= end ? Number(this.time.min) : Number(this.time.value);
    const since = performance.now();
    this.play.textContent = 'Pause';
    const step = (at: number) => {
      const next = from + (at - since) / 1000;
      this.seek(Math.max(from, Math.min(next, end)));
      if (next < end) this.frame = requestAnimationFrame(step);
      else this.stop();
    };
    this.frame = requestAnimationFrame(step);
  }

  stop(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.play.textContent = 'Play';
  }
}
