// Builds the page into the Python package, and writes beside it two hashes, of its sources and of
// the bundle: the tests compare them with what is at hand, so that a stale or edited bundle is
// noticed without node.
import { createHash } from "node:crypto";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { defineConfig, type Plugin } from "vite";

const OUT = "../src/rangeface/app/page";
const SOURCES = ["index.html", "package.json", "package-lock.json", "tsconfig.json", "vite.config.ts"];
const FOLDERS = ["src", "public"];

function hashOf(root: string, names: string[]): string {
  const hash = createHash("sha256");
  for (const name of names.sort()) {
    hash.update(`${name}\n`).update(readFileSync(join(root, name))).update("\n");
  }
  return hash.digest("hex");
}

function within(root: string, folders: string[]): string[] {
  return folders.flatMap((folder) => readdirSync(join(root, folder)).map((name) => `${folder}/${name}`));
}

function stampText(): string {
  const sources = hashOf(".", [...SOURCES, ...within(".", FOLDERS)]);
  return `${sources}\n${hashOf(OUT, ["index.html", ...within(OUT, ["assets"])])}\n`;
}

const stamp: Plugin = {
  name: "stamp",
  closeBundle: () => writeFileSync(join(OUT, "SOURCE"), stampText()),
};

export default defineConfig({
  base: "./",
  plugins: [stamp],
  build: {
    outDir: OUT,
    emptyOutDir: true,
    target: "es2022",
    assetsInlineLimit: 0, // no data: URL; the Content-Security-Policy allows files of this host only
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 800,
    rolldownOptions: {
      output: {
        entryFileNames: "assets/page.js",
        chunkFileNames: "assets/[name].js",
        assetFileNames: "assets/page[extname]",
      },
    },
  },
});
