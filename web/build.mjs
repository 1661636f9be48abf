// Builds the lab: the calculations as a WASI program, the page, a folder (dist/) and a single file (dist/touchdown-lab.html).
// `--page` leaves the program as it was built before; `--player` builds nothing but the player of landings in reports, and
// `--player --check` tells whether the one that the reports carry is of these sources.
import { execFileSync, spawnSync } from 'node:child_process';
import { createHash } from 'node:crypto';
import { copyFileSync, mkdirSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import { dirname, join } from 'node:path';
import { fileURLToPath } from 'node:url';
import { gzipSync } from 'node:zlib';
import * as esbuild from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const root = dirname(here);
const target = process.env.CARGO_TARGET_DIR ?? join(root, 'target');
const program = join(target, 'wasm32-wasip1', 'web', 'touchdown-lab.wasm');

const options = {
  bundle: true,
  minify: true,
  write: false,
  format: 'iife',
  target: ['chrome110', 'firefox115', 'safari16.4'],
  legalComments: 'eof',
  absWorkingDir: here,
};

if (process.argv.includes('--player')) {
  await player(process.argv.includes('--check'));
  process.exit();
}

if (!process.argv.includes('--page')) {
  // A fresh machine lacks the target. Without rustup or a network cargo tells what it misses.
  spawnSync('rustup', ['target', 'add', 'wasm32-wasip1'], { stdio: 'ignore' });
  const args = ['build', '--profile', 'web', '--target', 'wasm32-wasip1', '-p', 'touchdown-web'];
  execFileSync('cargo', args, { cwd: root, stdio: 'inherit' });
}

/** The player of landings that reports carry, `crates/report/watch/watch.min.js`. */
async function player(check) {
  const place = join(root, 'crates', 'report', 'watch', 'watch.min.js');
  const { outputFiles } = await esbuild.build({ ...options, legalComments: 'none', entryPoints: ['src/watch.ts'] });
  const text = outputFiles[0].text.replaceAll('</script', '<\\/script');
  if (!check) {
    writeFileSync(place, text);
  } else if (readFileSync(place, 'utf8') !== text) {
    console.error(`${place} is not of these sources: run 'node build.mjs --player'`);
    process.exit(1);
  }
}

/** `import source from 'worker:./x.ts'` is the text of a bundle. */
const workers = {
  name: 'workers',
  setup(build) {
    build.onResolve({ filter: /^worker:/ }, ({ path, resolveDir }) => ({
      path: join(resolveDir, path.slice('worker:'.length)),
      namespace: 'worker',
    }));
    build.onLoad({ filter: /.*/, namespace: 'worker' }, async ({ path }) => {
      const { outputFiles } = await esbuild.build({ ...options, entryPoints: [path] });
      return { contents: outputFiles[0].text, loader: 'text' };
    });
  },
};

const page = await esbuild.build({
  ...options,
  entryPoints: ['src/main.ts'],
  outdir: 'dist',
  plugins: [workers],
});
const text = (extension) => page.outputFiles.find((file) => file.path.endsWith(extension)).text;
const script = text('.js').replaceAll('</script', '<\\/script');
const style = text('.css');
const packed = gzipSync(readFileSync(program), { level: 9 }).toString('base64');
const data = `window.touchdownProgram="${packed}"`;

/** No connection to anywhere: nothing that the page reads can leave it. */
function policy(scripts, styles) {
  return [
    "default-src 'none'",
    `script-src ${scripts} 'wasm-unsafe-eval'`,
    `style-src ${styles}`,
    'worker-src blob:',
    'img-src data: blob:',
    "connect-src 'none'",
    "form-action 'none'",
    "base-uri 'none'",
  ].join('; ');
}

const hash = (of) => `'sha256-${createHash('sha256').update(of).digest('base64')}'`;
const template = readFileSync(join(here, 'index.html'), 'utf8');
const fill = (of) =>
  template
    .replace('%POLICY%', () => of.policy)
    .replace('%STYLE%', () => of.style)
    .replace('%SCRIPTS%', () => of.scripts);

const dist = join(here, 'dist');
rmSync(dist, { recursive: true, force: true });
mkdirSync(dist);
writeFileSync(join(dist, 'lab.css'), style);
writeFileSync(join(dist, 'lab.js'), script);
writeFileSync(join(dist, 'program.js'), data);
writeFileSync(
  join(dist, 'index.html'),
  fill({
    policy: policy("'self'", "'self'"),
    style: '<link rel="stylesheet" href="lab.css">',
    scripts: '<script src="lab.js" defer></script><script src="program.js" defer></script>',
  }),
);
writeFileSync(
  join(dist, 'touchdown-lab.html'),
  fill({
    policy: policy(`${hash(script)} ${hash(data)}`, hash(style)),
    style: `<style>${style}</style>`,
    scripts: `<script>${script}</script><script>${data}</script>`,
  }),
);
copyFileSync(join(root, 'LICENSE-MIT'), join(dist, 'LICENSE-MIT'));
const size = (name) => `${name} ${Math.round(readFileSync(join(dist, name)).length / 1000)} kB`;
console.log(['index.html', 'lab.css', 'lab.js', 'program.js', 'touchdown-lab.html'].map(size).join(', '));
