// touchref in JavaScript: the C interface of the WebAssembly module, as far as locating from a measurement goes.
//
//   import { load } from "./touchref.mjs";
//   const touchref = await load(bytes);                       // of touchref_wasm.wasm
//   const { status, json } = touchref.locate(text);           // a measurement file, TOML or JSON
//
// Where the module itself is at fault the call throws a WebAssembly.RuntimeError; load it anew then.

/** Status of a frame that passed its checks; others are those of touchref.h. */
export const OK = 0;

/** Version of the interface that this file speaks. */
const ABI_VERSION = 1;

/** Loads the module from its bytes, or from whatever WebAssembly.instantiate takes. */
export async function load(module) {
    const made = await WebAssembly.instantiate(module, {});
    return new Touchref((made.instance ?? made).exports);
}

class Touchref {
    #c;

    constructor(exports) {
        this.#c = exports;
        const version = exports.touchref_abi_version();
        if (version !== ABI_VERSION) {
            throw new Error(`this module has version ${version} of the interface, not ${ABI_VERSION}`);
        }
    }

    /** Version of the library. */
    get version() {
        return this.#string(this.#c.touchref_version());
    }

    /** Pages of memory that the module has taken. */
    get pages() {
        return this.#c.memory.buffer.byteLength / 65536;
    }

    /** Names of the kinds of fixtures, of the solvers and of the dialects. */
    get plugins() {
        const names = (name) => {
            const all = [];
            for (let at; (at = name(all.length)) !== 0; ) {
                all.push(this.#string(at));
            }
            return all;
        };
        return {
            fixtures: names(this.#c.touchref_fixture_kind),
            solvers: names(this.#c.touchref_solver_name),
            dialects: names(this.#c.touchref_dialect_name),
        };
    }

    /**
     * Locates from the text of a measurement file. Of the options, `solver` is a name, `solverParameters` are JSON or TOML,
     * `dialects` names of which `literals` has the texts.
     *
     * Returns `{ status, json, literals }`: touchref.solution/1 where status is OK, else touchref.error/1.
     */
    locate(text, { solver, solverParameters, dialects = [] } = {}) {
        return this.#withTexts([text, solver, solverParameters], ([text, solver, solverParameters]) =>
            this.#withBuffer(5 * 4, (at) => {
                // The options, then places for solution and error.
                const [options, solution, error] = [at, at + 12, at + 16];
                this.#words.set([solver, solverParameters, 0], options / 4);
                const status = this.#c.touchref_locate_measurement(text, 0, options, solution, error);
                return this.#taken(status, this.#words[solution / 4], this.#words[error / 4], dialects);
            }),
        );
    }

    /** What a call handed out, freed. */
    #taken(status, solution, error, dialects) {
        try {
            if (status !== OK) {
                return { status, json: this.#string(this.#c.touchref_error_json(error)), literals: {} };
            }
            const literals = {};
            for (const dialect of dialects) {
                const told = this.#tell(solution, dialect);
                if (told.status !== OK) {
                    return told;
                }
                literals[dialect] = told.text;
            }
            return { status, json: this.#string(this.#c.touchref_solution_json(solution)), literals };
        } finally {
            this.#c.touchref_solution_free(solution);
            this.#c.touchref_error_free(error);
        }
    }

    #tell(solution, dialect) {
        return this.#withTexts([dialect], ([dialect]) =>
            this.#withBuffer(2 * 4, (at) => {
                const status = this.#c.touchref_solution_tell(solution, dialect, at, at + 4);
                const [literal, error] = this.#words.slice(at / 4, at / 4 + 2);
                const text = status === OK ? this.#string(this.#c.touchref_literal_text(literal)) : undefined;
                const json = status === OK ? undefined : this.#string(this.#c.touchref_error_json(error));
                this.#c.touchref_literal_free(literal);
                this.#c.touchref_error_free(error);
                return { status, text, json, literals: {} };
            }),
        );
    }

    /** Memory as it is now: it moves when it grows. */
    get #words() {
        return new Uint32Array(this.#c.memory.buffer);
    }

    #string(at) {
        const bytes = new Uint8Array(this.#c.memory.buffer, at);
        return new TextDecoder().decode(bytes.subarray(0, bytes.indexOf(0)));
    }

    /** Hands a piece of zeroed memory to `use`, and takes it back. */
    #withBuffer(size, use) {
        const buffer = this.#c.touchref_buffer_new(size);
        try {
            return use(this.#c.touchref_buffer_bytes(buffer));
        } finally {
            this.#c.touchref_buffer_free(buffer);
        }
    }

    /** Hands texts to `use` as C has them; null where there is none. */
    #withTexts(texts, use, done = []) {
        if (texts.length === done.length) {
            return use(done);
        }
        const text = texts[done.length];
        if (text === undefined) {
            return this.#withTexts(texts, use, [...done, 0]);
        }
        const bytes = new TextEncoder().encode(text);
        if (bytes.includes(0)) {
            throw new TypeError("a text has a zero character");
        }
        return this.#withBuffer(bytes.length + 1, (at) => {
            new Uint8Array(this.#c.memory.buffer, at).set(bytes);
            return this.#withTexts(texts, use, [...done, at]);
        });
    }
}
