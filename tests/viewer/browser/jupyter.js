// A Jupyter server with a notebook, and what a user sees of its views.

import { spawn } from "node:child_process";
import { mkdir, mkdtemp, readFile, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import { delimiter, dirname, join } from "node:path";

/** Milliseconds; only a hang reaches it. */
export const PATIENCE = Number(process.env.PATIENCE ?? 180_000);
const JUPYTER = process.env.JUPYTER ?? "jupyter";

/** The sources of a notebook's cells, as a file. @param {string[]} cells */
const notebook = (cells) => JSON.stringify({
  cells: cells.map((source, n) => ({ cell_type: "code", id: `cell-${n}`, source, metadata: {}, outputs: [], execution_count: null })),
  metadata: { kernelspec: { name: "python3", display_name: "Python 3", language: "python" } },
  nbformat: 4,
  nbformat_minor: 5,
});

/** Starts JupyterLab or Notebook 7, whose folder has a notebook. The user's own configuration stays out. @param {"lab" | "notebook"} kind */
export async function serve(kind, cells) {
  const folder = await mkdtemp(join(tmpdir(), "layersplat-jupyter-"));
  await writeFile(join(folder, "view.ipynb"), notebook(cells));
  const own = Object.fromEntries(["CONFIG_DIR", "DATA_DIR", "RUNTIME_DIR"].map((name) => [`JUPYTER_${name}`, join(folder, name)]));
  // JupyterLab would ask whether it may look for news.
  await mkdir(join(folder, "CONFIG_DIR", "labconfig"), { recursive: true });
  const pageConfig = { disabledExtensions: { "@jupyterlab/apputils-extension:announcements": true } };
  await writeFile(join(folder, "CONFIG_DIR", "labconfig", "page_config.json"), JSON.stringify(pageConfig));
  const app = kind === "lab" ? "LabApp" : "JupyterNotebookApp";
  const server = spawn(JUPYTER, [
    kind, "--no-browser", "--allow-root", "--ip=127.0.0.1", "--port=0", `--ServerApp.root_dir=${folder}`, "--IdentityProvider.token=secret",
    `--${app}.expose_app_in_browser=True`,
  ], {
    stdio: ["ignore", "ignore", "pipe"],
    env: { ...process.env, ...own, IPYTHONDIR: join(folder, "ipython"), PATH: `${dirname(JUPYTER)}${delimiter}${process.env.PATH}` },
  });
  const root = await new Promise((resolve, reject) => {
    let text = "";
    server.stderr.on("data", (data) => {
      text += data;
      const found = text.match(/http:\/\/127\.0\.0\.1:(\d+)\//);
      if (found) resolve(found[0]);
    });
    server.on("exit", () => reject(new Error(text)));
  });
  return {
    folder,
    url: kind === "lab" ? `${root}lab/tree/view.ipynb?token=secret` : `${root}notebooks/view.ipynb?token=secret`,
    saved: async () => JSON.parse(await readFile(join(folder, "view.ipynb"), "utf8")),
    end: () => new Promise((resolve) => {
      server.on("exit", resolve);
      server.kill("SIGTERM");
    }),
  };
}

/** Opens the notebook. */
export async function open(browser, url) {
  const context = await browser.newContext({ viewport: { width: 1300, height: 1000 } });
  const page = await context.newPage();
  page.setDefaultTimeout(PATIENCE);
  await page.goto(url);
  await page.locator(".jp-Notebook .jp-Cell").first().waitFor();
  // Before its kernel is there, a notebook that runs would ask for one.
  await page.evaluate(async () => { await globalThis.jupyterapp.shell.currentWidget.sessionContext.ready; });
  return page;
}

/** Runs a command of the application. */
export const command = (page, name) => page.evaluate((id) => globalThis.jupyterapp.commands.execute(id), name);

/** Runs code in the notebook's kernel; waits until it is done, unless told otherwise. */
export function run(page, code, { waits = true } = {}) {
  return page.evaluate(async ([source, isAwaited]) => {
    const { kernel } = globalThis.jupyterapp.shell.currentWidget.sessionContext.session;
    const future = kernel.requestExecute({ code: source, store_history: false });
    if (!isAwaited) return;
    const { content } = await future.done;
    if (content.status !== "ok") throw new Error(`${content.ename}: ${content.evalue}`);
  }, [code, waits]);
}

/** Waits until the newest picture of the n-th view is refined, and returns its pixels, scaled to 96 × 64. */
export async function refined(page, n = 0) {
  await page.waitForFunction((index) => {
    const viewer = document.querySelectorAll(".layersplat")[index]?.layersplat;
    return viewer && viewer.shown.step === "refined" && viewer.shown.id === viewer.requested();
  }, n, { timeout: PATIENCE });
  return pixels(page, n);
}

export async function pixels(page, n = 0) {
  const data = await page.locator(".layersplat").nth(n).locator("#picture").evaluate((picture) => {
    const [width, height] = [96, 64];
    const context = new OffscreenCanvas(width, height).getContext("2d", { willReadFrequently: true });
    context.drawImage(picture, 0, 0, width, height);
    return [...context.getImageData(0, 0, width, height).data];
  });
  return { width: 96, height: 64, data };
}

/** Drags over the picture of the n-th view by pixels. */
export async function drag(page, n, dx, dy) {
  const box = await page.locator(".layersplat").nth(n).locator("#picture").boundingBox();
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let step = 1; step <= 6; step += 1) await page.mouse.move(x + (dx * step) / 6, y + (dy * step) / 6);
  await page.mouse.up();
}
