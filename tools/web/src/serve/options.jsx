// The options of a command as a form: made from what the command itself declares, so that names, words
// of help, choices and defaults are those of the command line.
import { CheckField, LinesField, SelectField, TextField } from "./field.jsx";

const AS_IS = "";

function OptionField({ option, value, onCommit }) {
  const label = `--${option.name}`;
  if (option.value === "")
    return <CheckField label={label} hint={option.help} value={value === true} onCommit={onCommit} />;
  if (option.choices.length > 0) {
    const as_is = option.default ? `${option.default} (default)` : "not given";
    const choices = [[AS_IS, as_is], ...option.choices.filter((each) => each !== option.default).map((each) => [each, each])];
    return <SelectField label={label} hint={option.help} value={value ?? AS_IS} choices={choices} onCommit={onCommit} />;
  }
  if (option.several)
    return (
      <LinesField
        label={label}
        hint={`${option.help}; one on a line`}
        value={value ?? ""}
        placeholder={option.value}
        onCommit={onCommit}
      />
    );
  return (
    <TextField label={label} hint={option.help} value={value ?? ""} placeholder={option.default || option.value} onCommit={onCommit} />
  );
}

function SettingField({ setting, value, onCommit }) {
  const hint = `${setting.help}; ${setting.valid}`;
  const words = setting.valid.split(" | ");
  if (words.length > 1) {
    const choices = [[AS_IS, `${setting.default} (default)`], ...words.filter((each) => each !== setting.default).map((each) => [each, each])];
    return <SelectField label={setting.name} hint={hint} value={value ?? AS_IS} choices={choices} onCommit={onCommit} />;
  }
  return <TextField label={setting.name} hint={hint} value={value ?? ""} placeholder={setting.default} onCommit={onCommit} />;
}

/** The chosen values as a job takes them: [["method", "staged"], ["set", "pulses.terms=20"]]. */
export function optionsOf(command, chosen) {
  const pairs = [];
  for (const option of command.options) {
    const value = chosen[option.name];
    if (value === undefined || value === AS_IS || value === false) continue;
    if (value === true) pairs.push([option.name]);
    else if (option.several)
      for (const line of value.split("\n").filter((each) => each.trim() !== "")) pairs.push([option.name, line.trim()]);
    else pairs.push([option.name, value.trim()]);
  }
  for (const setting of command.settings) {
    const value = chosen[`set ${setting.name}`];
    if (value !== undefined && value.trim() !== AS_IS) pairs.push(["set", `${setting.name}=${value.trim()}`]);
  }
  return pairs;
}

/** And back: what the form shows for the options of a job. */
export function chosenOf(command, pairs) {
  const chosen = {};
  for (const [name, value] of pairs) {
    const option = command.options.find((each) => each.name === name);
    if (name === "set") {
      const equals = value.indexOf("=");
      chosen[`set ${value.slice(0, equals)}`] = value.slice(equals + 1);
    } else if (value === undefined) chosen[name] = true;
    else if (option?.several) chosen[name] = chosen[name] ? `${chosen[name]}\n${value}` : value;
    else chosen[name] = value;
  }
  return chosen;
}

/** `first` names the options that are always shown; the others are behind "More options". */
export function OptionsForm({ command, first, chosen, onChange }) {
  const change = (name) => (value) => onChange((now) => ({ ...now, [name]: value }));
  const field = (option) => (
    <OptionField key={option.name} option={option} value={chosen[option.name]} onCommit={change(option.name)} />
  );
  const shown = command.options.filter(({ name }) => first.includes(name));
  const others = command.options.filter(({ name }) => !first.includes(name) && name !== "set");
  return (
    <>
      <div class="fields">{shown.map(field)}</div>
      <details>
        <summary>More options</summary>
        <div class="fields">{others.map(field)}</div>
      </details>
      {command.settings.length > 0 && (
        <details>
          <summary>All settings (--set)</summary>
          <div class="fields">
            {command.settings.map((setting) => (
              <SettingField
                key={setting.name}
                setting={setting}
                value={chosen[`set ${setting.name}`]}
                onCommit={change(`set ${setting.name}`)}
              />
            ))}
          </div>
        </details>
      )}
    </>
  );
}
