// How the page talks to lipoid serve. All addresses are relative: the key stands before them.
import { useEffect, useRef, useState } from "preact/hooks";

// A header that no form of another page can send.
const HEADERS = { "X-Lipoid": "1" };
const BUSY_MS = 400;
const IDLE_MS = 2500;

const UNREACHABLE = "lipoid serve has ended, or cannot be reached";

/** As fetch; where no answer comes, its error is a sentence ("Failed to fetch" says nothing to a reader). */
async function reach(path, options) {
  try {
    return await fetch(path, { cache: "no-store", ...options });
  } catch (error) {
    if (error instanceof TypeError) throw new Error(`${UNREACHABLE}.`, { cause: error });
    throw error;
  }
}

async function answerOf(response) {
  if (response.ok) return response.json();
  throw new Error((await response.text()).trim() || `the server answered ${response.status}`);
}

export async function get(path) {
  return answerOf(await reach(path));
}

export async function getText(path) {
  const response = await reach(path);
  if (!response.ok) throw new Error((await response.text()).trim());
  return response.text();
}

export async function post(path, json) {
  return answerOf(await reach(path, { method: "POST", headers: HEADERS, body: JSON.stringify(json) }));
}

export async function remove(path) {
  return answerOf(await reach(path, { method: "DELETE", headers: HEADERS }));
}

/** Sends a file as it is; `sent` is told how many bytes are on their way. */
export function upload(file, sent) {
  return new Promise((done, failed) => {
    const request = new XMLHttpRequest();
    request.open("POST", `api/files?name=${encodeURIComponent(file.name)}`);
    request.setRequestHeader("X-Lipoid", "1");
    request.upload.onprogress = (event) => sent(event.loaded);
    request.onload = () => {
      if (request.status === 201) done(JSON.parse(request.responseText));
      else failed(new Error(request.responseText.trim()));
    };
    request.onerror = () => failed(new Error("the connection to lipoid serve broke off"));
    request.send(file);
  });
}

function isBusy(state) {
  return state.inspecting || state.jobs.some(({ status }) => status === "queued" || status === "running");
}

/** The state of the workbench, asked for again and again; and what was wrong with the last time. */
export function useWorkbench() {
  const [state, setState] = useState(null);
  const [lost, setLost] = useState("");
  const ask = useRef(() => {});
  useEffect(() => {
    let known = null;
    let etag = null;
    let timer = null;
    let asking = false;
    let once_more = false;
    const look = async () => {
      if (asking) {
        once_more = true;
        return;
      }
      asking = true;
      clearTimeout(timer);
      try {
        const response = await reach("api/state", {
          headers: etag ? { "If-None-Match": etag } : {},
        });
        if (response.status !== 304) {
          known = await answerOf(response);
          etag = response.headers.get("ETag");
          setState(known);
        }
        setLost("");
      } catch (error) {
        setLost(
          error.cause instanceof TypeError
            ? `${UNREACHABLE}. What is shown here is what it said last.`
            : error.message,
        );
      }
      asking = false;
      timer = setTimeout(look, once_more ? 0 : known && isBusy(known) ? BUSY_MS : IDLE_MS);
      once_more = false;
    };
    ask.current = look;
    const shown = () => document.visibilityState === "visible" && look();
    document.addEventListener("visibilitychange", shown);
    look();
    return () => {
      clearTimeout(timer);
      document.removeEventListener("visibilitychange", shown);
    };
  }, []);
  return { state, lost, ask: () => ask.current() };
}

/** What a person chose in this tab, kept over a reload; `change` takes the value now to the next. */
export function useKept(name, initial) {
  const key = `${location.pathname}${name}`;
  const [value, setValue] = useState(() => {
    const kept = sessionStorage.getItem(key);
    return kept === null ? initial : JSON.parse(kept);
  });
  return [
    value,
    (change) =>
      setValue((now) => {
        const next = change(now);
        sessionStorage.setItem(key, JSON.stringify(next));
        return next;
      }),
  ];
}
