// The WebAssembly module beside the command line: the same plugins, the same answers.
//
//   node test.mjs MODULE TOUCHREF EXAMPLES

import assert from "node:assert/strict";
import { spawnSync } from "node:child_process";
import { readFileSync, readdirSync } from "node:fs";
import { join } from "node:path";
import { test } from "node:test";
import { OK, load } from "./touchref.mjs";

const [, , module, command, examples] = process.argv;

// Sine, cosine and the like come with Rust here, and natively from the C library; they differ in the last bit. How far the numbers of
// a result may then differ, in parts of the larger of themselves and 1: measured are 2.4e-11, in the misfit of a frame that does not
// fit. No touch tells as much.
const TOLERANCE = 1e-9;

const touchref = await load(readFileSync(module));

function native(text, ...options) {
    const { status, stdout } = spawnSync(command, ["locate", "-", "--format", "json", ...options], {
        cwd: examples,
        input: text,
        encoding: "utf8",
    });
    return { status, json: stdout };
}

let largest = { off: 0 };

/** The same keys, words and numbers, these to the tolerance. */
function compare(ours, theirs, path) {
    if (typeof theirs === "number" && typeof ours === "number") {
        const off = Math.abs(ours - theirs) / Math.max(1, Math.abs(theirs));
        largest = off > largest.off ? { off, path } : largest;
        assert(off <= TOLERANCE, `${path}: ${ours} is not ${theirs}`);
    } else if (typeof theirs === "string" && typeof ours === "string") {
        // Words tell numbers, too, at odd places of the split.
        const number = /([-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?)/;
        const [our, their] = [ours.split(number), theirs.split(number)];
        assert.equal(our.length, their.length, `${path}: ${ours}`);
        our.forEach((part, i) => {
            if (i % 2 === 0) {
                assert.equal(part, their[i], path);
            } else {
                compare(Number(part), Number(their[i]), path);
            }
        });
    } else if (theirs !== null && typeof theirs === "object") {
        assert.deepEqual(Object.keys(ours), Object.keys(theirs), path);
        for (const key of Object.keys(theirs)) {
            compare(ours[key], theirs[key], `${path}.${key}`);
        }
    } else {
        assert.equal(ours, theirs, path);
    }
}

function same(name, text, solver) {
    const ours = touchref.locate(text, { solver });
    const theirs = native(text, ...(solver ? ["--solver", solver] : []));
    assert.equal(ours.status, theirs.status, `${name}: ${ours.json}`);
    // A text has no name of its own.
    const named = ours.json.replaceAll('"file": "measurement"', '"file": "standard input"');
    compare(JSON.parse(named), JSON.parse(theirs.json), name);
    return ours.status;
}

const paper = readFileSync(join(examples, "nederbragt-ravani.toml"), "utf8");

test("every plugin is there", () => {
    const listed = JSON.parse(spawnSync(command, ["list", "--format", "json"], { encoding: "utf8" }).stdout);
    for (const kind of ["fixtures", "solvers", "dialects"]) {
        const names = listed[kind].map((plugin) => plugin.name);
        assert(names.length > 0);
        assert.deepEqual(touchref.plugins[kind], names);
    }
});

test("the paper's example", () => {
    const { status, json, literals } = touchref.locate(paper, { dialects: ["kuka"] });
    assert.equal(status, OK);
    const { origin, z_axis } = JSON.parse(json).frame;
    [2.9, 3.8, 4.2249].forEach((value, i) => assert(Math.abs(origin[i] - value) < 2e-4));
    [0.3, 0.6, 0.7416].forEach((value, i) => assert(Math.abs(z_axis[i] - value) < 2e-4));
    assert.match(literals.kuka, /X 2\.900/);
});

test("answers and refusals are those of the command line", () => {
    const statuses = new Set();
    for (const file of readdirSync(examples).filter((file) => file.endsWith(".toml"))) {
        const text = readFileSync(join(examples, file), "utf8");
        // There are no files in a module.
        if (!/^touches *=/m.test(text)) {
            statuses.add(same(file, text));
        }
    }
    for (const solver of touchref.plugins.solvers) {
        statuses.add(same(`paper by ${solver}`, paper, solver));
    }
    for (const [what, by] of [
        [/^sigma = .*/m, "sigma = 0.1"],
        [/^radius = .*/m, "radius = 1.2"],
        [/"plane"/, '"plain"'],
        [/^kind = .*/m, 'kind = "cylinderplane"'],
        ["4.0395", "nan"],
    ]) {
        assert.notEqual(paper.replace(what, by), paper);
        statuses.add(same(by, paper.replace(what, by)));
    }
    assert.deepEqual([...statuses].sort(), [0, 1, 2]);
    console.log(`numbers differ by at most ${largest.off.toExponential(1)} (${largest.path})`);
});

test("wrong calls are told, and memory is given back", () => {
    assert.equal(touchref.locate("units = \"mm\"\ntouches = \"t.csv\"\n[fixture]\nkind = \"cube\"\nedge = 80").status, 2);
    assert.equal(touchref.locate(paper, { dialects: ["kuca"] }).status, 2);
    assert.equal(touchref.locate(paper, { solver: "none" }).status, 2);
    assert.throws(() => touchref.locate("\0"), TypeError);
    touchref.locate(paper);
    const before = touchref.pages;
    for (let i = 0; i < 200; i++) {
        assert.equal(touchref.locate(paper, { solver: "closed-form" }).status, OK);
    }
    assert.equal(touchref.pages, before);
});
