// Serves dist/ on this machine: node serve.mjs [PORT]
import { createReadStream, readdirSync } from 'node:fs';
import { createServer } from 'node:http';
import { basename, dirname, extname, join } from 'node:path';
import { fileURLToPath, pathToFileURL } from 'node:url';

const dist = join(dirname(fileURLToPath(import.meta.url)), 'dist');
const types = { '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.css': 'text/css' };

/** A server of the folder; port 0 takes any free one. */
export function serve(port) {
  const server = createServer((request, response) => {
    // The path as it came: `//` is no URL, and would end the server.
    const name = basename(request.url.split(/[?#]/, 1)[0]) || 'index.html';
    if (!readdirSync(dist).includes(name)) {
      response.writeHead(404).end();
      return;
    }
    response.writeHead(200, { 'content-type': types[extname(name)] ?? 'text/plain' });
    createReadStream(join(dist, name)).pipe(response);
  });
  return new Promise((resolve, reject) => {
    server.once('error', reject);
    server.listen(port, '127.0.0.1', () => resolve(server));
  });
}

if (import.meta.url === pathToFileURL(process.argv[1]).href) {
  const port = Number(process.argv[2] ?? 8000);
  try {
    const server = await serve(port);
    console.log(`http://127.0.0.1:${server.address().port}/`);
  } catch (error) {
    console.error(`${error.message}. Give a free port: node serve.mjs ${port + 1}`);
    process.exitCode = 1;
  }
}
