// A state and changes to it go in; whoever watches a part of it is told once per change.

/**
 * @template {Record<string, any>} State
 * @param {State} initial
 */
export function createStore(initial) {
  let state = { ...initial };
  /** @type {Set<{keys: string[], tell: (state: State) => void}>} */
  const watchers = new Set();
  return {
    get: () => state,
    /** @param {Partial<State>} patch */
    set(patch) {
      const changed = new Set(Object.keys(patch).filter((key) => patch[key] !== state[key]));
      if (!changed.size) return;
      state = { ...state, ...patch };
      for (const watcher of [...watchers]) {
        if (watchers.has(watcher) && watcher.keys.some((key) => changed.has(key))) watcher.tell(state);
      }
    },
    /**
     * Calls back now and after every change of one of the keys, until the returned function is called.
     * @param {string[]} keys
     * @param {(state: State) => void} tell
     * @returns {() => void}
     */
    watch(keys, tell) {
      const watcher = { keys, tell };
      watchers.add(watcher);
      tell(state);
      return () => watchers.delete(watcher);
    },
  };
}
