// Fields of a form.
import { useEffect, useRef, useState } from "preact/hooks";

/**
 * A line of text that is told when it is left or Enter is pressed, not at every key. Where `onCommit` promises false,
 * the text was refused, and what holds is shown again: nothing runs with another value than the one that is seen.
 */
export function TextField({ label, hint, value, placeholder, onCommit, inputMode }) {
  const [text, setText] = useState(value);
  const input = useRef(null);
  useEffect(() => {
    if (document.activeElement !== input.current) setText(value);
  }, [value]);
  const commit = async ({ currentTarget: { value: typed } }) => {
    if (typed !== value && (await onCommit(typed)) === false) setText(value);
  };
  return (
    <label class="field">
      <span class="label">{label}</span>
      <input
        ref={input}
        type="text"
        value={text}
        placeholder={placeholder}
        inputMode={inputMode}
        autoComplete="off"
        spellcheck={false}
        onInput={(event) => setText(event.currentTarget.value)}
        onBlur={commit}
        onKeyDown={(event) => event.key === "Enter" && commit(event)}
      />
      {hint && <span class="hint">{hint}</span>}
    </label>
  );
}

export function SelectField({ label, hint, value, choices, onCommit }) {
  return (
    <label class="field">
      <span class="label">{label}</span>
      <select value={value} onChange={(event) => onCommit(event.currentTarget.value)}>
        {choices.map(([name, shown]) => (
          <option key={name} value={name} selected={name === value}>
            {shown}
          </option>
        ))}
      </select>
      {hint && <span class="hint">{hint}</span>}
    </label>
  );
}

export function CheckField({ label, hint, value, onCommit }) {
  return (
    <label class="field check">
      <input type="checkbox" checked={value} onChange={(event) => onCommit(event.currentTarget.checked)} />
      <span class="label">{label}</span>
      {hint && <span class="hint">{hint}</span>}
    </label>
  );
}

export function LinesField({ label, hint, value, placeholder, onCommit }) {
  return (
    <label class="field">
      <span class="label">{label}</span>
      <textarea
        rows={2}
        value={value}
        placeholder={placeholder}
        spellcheck={false}
        onInput={(event) => onCommit(event.currentTarget.value)}
      />
      {hint && <span class="hint">{hint}</span>}
    </label>
  );
}
