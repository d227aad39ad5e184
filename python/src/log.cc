#include "python/src/log.h"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <cctype>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "identify/logs/formats/header.h"
#include "identify/logs/formats/layout.h"
#include "identify/logs/formats/quantity.h"
#include "identify/logs/inspection.h"
#include "identify/logs/inspection_report.h"
#include "model/core/errors.h"
#include "python/src/convert.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

std::vector<int> WholeNumbers(const char* name, const nb::object& given) {
  std::vector<std::string> words;
  if (nb::isinstance<nb::str>(given) || !nb::hasattr(given, "__iter__")) {
    words.push_back(TextOf(name, given));
  } else {
    for (const nb::handle word : given) words.push_back(TextOf(name, word));
  }
  std::vector<int> numbers;
  for (const std::string& word : words)
    numbers.push_back(options_internal::ParseInt(name, word, Range{}));
  return numbers;
}

PythonLog AsShared(Log log) { return {std::make_shared<const Log>(std::move(log))}; }

// Arrays are asked for, not a gist: every row is kept unless something else is said.
ReadingRequest EveryRow() { return {.most_rows = std::nullopt}; }

ReadOptions ReadingOf(const nb::dict& given, bool of_a_file) {
  Keywords keywords(given);
  ReadOptions options = ReadingOf(keywords, EveryRow(), of_a_file);
  keywords.Finish();
  return options;
}

PythonLog Read(nb::handle file, const nb::dict& given) {
  const std::string path = PathOf(file);
  const ReadOptions options = ReadingOf(given, true);
  Log log;
  {
    const WithoutLock unlocked;
    log = ReadLog(path, options);
  }
  return AsShared(std::move(log));
}

// The table of a binary file: what it is called where the columns are of no vendor.
PythonLog ReadText(const nb::bytes& text,
                   nb::handle file,
                   const std::string& format,
                   const nb::dict& given) {
  const std::string name = PathOf(file);
  const ReadOptions options = ReadingOf(given, true);
  Log log;
  {
    const WithoutLock unlocked;
    log = ReadLogText({text.c_str(), text.size()}, name, options);
  }
  if (log.report.format == kPlainCsv.name) log.report.format = format;
  return AsShared(std::move(log));
}

PythonLog Take(const Input& time_s,
               const Input& current_A,
               const std::optional<Input>& voltage_V,
               const std::optional<Input>& temperature_degC,
               const std::string& name,
               const nb::dict& given) {
  ReadOptions options = ReadingOf(given, false);
  options.voltage_optional = !voltage_V;
  const auto lend = [](const Input& array) {
    return Column::Lent(SpanOf(array), Keep(nb::cast(array)));
  };
  Record record;
  record.file = name;
  record.time_s = lend(time_s);
  record.current_A = lend(current_A);
  if (voltage_V) record.voltage_V = lend(*voltage_V);
  if (temperature_degC) record.temperature_degC = lend(*temperature_degC);
  Log log;
  {
    const WithoutLock unlocked;
    log = TakeLog(std::move(record), options);
  }
  return AsShared(std::move(log));
}

nb::object Inspect(const PythonLog& self) {
  Json json;
  {
    const WithoutLock unlocked;
    json = InspectionToJson(InspectRecord(self.log->record, self.log->report));
  }
  return ToPython(json);
}

nb::object ColumnOf(const PythonLog& self, Column Record::*column) {
  const Column& numbers = self.log->record.*column;
  if (numbers.empty()) return nb::none();
  return nb::cast(ViewOf(numbers, self.log));
}

// Every member of what reading found, each once: a member that is added does not compile until it
// stands here, too.
auto MembersOf(auto& of) requires std::is_same_v<std::remove_cvref_t<decltype(of)>, Gap> {
  auto& [row, start_s, length_s, unknown_C, recharge] = of;
  return std::tie(row, start_s, length_s, unknown_C, recharge);
}

auto MembersOf(auto& of) requires std::is_same_v<std::remove_cvref_t<decltype(of)>, RowLabel> {
  auto& [row, step, cycle] = of;
  return std::tie(row, step, cycle);
}

auto MembersOf(auto& of) requires std::is_same_v<std::remove_cvref_t<decltype(of)>, FlightFacts> {
  auto& [vehicle,
         battery,
         batteries,
         cells,
         capacity_Ah,
         voltage_s,
         current_s,
         messages,
         skipped,
         damaged,
         cut] = of;
  return std::tie(vehicle,
                  battery,
                  batteries,
                  cells,
                  capacity_Ah,
                  voltage_s,
                  current_s,
                  messages,
                  skipped,
                  damaged,
                  cut);
}

auto MembersOf(auto& of) requires std::is_same_v<std::remove_cvref_t<decltype(of)>, ThinningFacts> {
  auto& [of_log,
         rows,
         most,
         group,
         tolerance_A,
         shortest_s,
         median_s,
         longest_s,
         millivolts,
         spikes_s] = of;
  return std::tie(of_log,
                  rows,
                  most,
                  group,
                  tolerance_A,
                  shortest_s,
                  median_s,
                  longest_s,
                  millivolts,
                  spikes_s);
}

auto MembersOf(auto& of) requires std::is_same_v<std::remove_cvref_t<decltype(of)>, LogReport> {
  auto& [format,
         column,
         rows,
         repeated,
         unselected,
         cut,
         spikes,
         unknown,
         sign,
         reason,
         others,
         gaps,
         labels,
         flight,
         thinned,
         notes,
         warnings,
         stuck_voltage] = of;
  return std::tie(format,
                  column,
                  rows,
                  repeated,
                  unselected,
                  cut,
                  spikes,
                  unknown,
                  sign,
                  reason,
                  others,
                  gaps,
                  labels,
                  flight,
                  thinned,
                  notes,
                  warnings,
                  stuck_voltage);
}

// Bytes of texts: names of files may be anything but UTF-8.
nb::object Frozen(const std::string& text) { return nb::bytes(text.data(), text.size()); }
void Thaw(nb::handle from, std::string& text) {
  const auto bytes = nb::cast<nb::bytes>(from);
  text.assign(bytes.c_str(), bytes.size());
}

template <class T>
requires std::is_arithmetic_v<T> nb::object Frozen(const T& number) { return nb::cast(number); }
template <class T>
requires std::is_arithmetic_v<T>
void Thaw(nb::handle from, T& number) { number = nb::cast<T>(from); }

template <class T>
nb::object Frozen(const std::optional<T>& one);
template <class T>
nb::object Frozen(const std::vector<T>& several);
template <class T>
void Thaw(nb::handle from, std::optional<T>& one);
template <class T>
void Thaw(nb::handle from, std::vector<T>& several);

template <class T>
requires requires(T& of) { MembersOf(of); }
nb::object Frozen(const T& of) {
  return std::apply([](const auto&... member) { return nb::make_tuple(Frozen(member)...); },
                    MembersOf(of));
}
// A tuple of nanobind is not asked for its length by its operator[].
nb::tuple TupleOf(nb::handle from, std::size_t members) {
  auto state = nb::cast<nb::tuple>(from);
  if (state.size() != members)
    throw nb::value_error(
        "this pickled log is of another version of lipoid; read the log again and pickle it anew");
  return state;
}

template <class T>
requires requires(T& of) { MembersOf(of); }
void Thaw(nb::handle from, T& of) {
  const auto state = TupleOf(from, std::tuple_size_v<decltype(MembersOf(of))>);
  std::apply([&, k = std::size_t{0}](auto&... member) mutable { (Thaw(state[k++], member), ...); },
             MembersOf(of));
}

template <class T>
nb::object Frozen(const std::optional<T>& one) {
  return one ? Frozen(*one) : nb::none();
}
template <class T>
void Thaw(nb::handle from, std::optional<T>& one) {
  if (!from.is_none()) Thaw(from, one.emplace());
}

template <class T>
nb::object Frozen(const std::vector<T>& several) {
  nb::list list;
  for (const T& one : several) list.append(Frozen(one));
  return list;
}
template <class T>
void Thaw(nb::handle from, std::vector<T>& several) {
  for (const nb::handle one : from) Thaw(one, several.emplace_back());
}

// As another process has it: the columns as they are now, and what reading said.
nb::tuple State(const PythonLog& self) {
  const Record& record = self.log->record;
  return nb::make_tuple(ColumnOf(self, &Record::time_s),
                        ColumnOf(self, &Record::current_A),
                        ColumnOf(self, &Record::voltage_V),
                        ColumnOf(self, &Record::temperature_degC),
                        Frozen(record.file),
                        options_internal::ToText(record.hold),
                        Frozen(self.log->report));
}

std::vector<double> Numbers(nb::handle column) {
  if (column.is_none()) return {};
  const auto array = nb::cast<Input>(column);
  const auto span = SpanOf(array);
  return {span.begin(), span.end()};
}

PythonLog FromState(nb::handle from) {
  const nb::tuple state = TupleOf(from, 7);
  Log log;
  log.record.time_s = Numbers(state[0]);
  log.record.current_A = Numbers(state[1]);
  log.record.voltage_V = Numbers(state[2]);
  log.record.temperature_degC = Numbers(state[3]);
  const std::size_t rows = log.record.time_s.size();
  const auto fits = [&](const Column& column) { return column.empty() || column.size() == rows; };
  if (log.record.current_A.size() != rows || !fits(log.record.voltage_V) ||
      !fits(log.record.temperature_degC))
    throw nb::value_error("expected a pickled log whose columns are equally long");
  Thaw(state[4], log.record.file);
  options_internal::FromText("hold", nb::cast<std::string>(state[5]), Names{}, log.record.hold);
  Thaw(state[6], log.report);
  return AsShared(std::move(log));
}

// Which of these columns a file's header would name for a quantity, and its unit where that is not the
// quantity's own; None where no column is.
nb::object LikelyColumn(const std::vector<std::string>& names, const std::string& key) {
  std::vector<HeaderName> header;
  for (const std::string& name : names)
    header.push_back(ParseHeaderName({name, header.size() + 1}));
  for (const Quantity quantity : {Quantity::kTime, Quantity::kCurrent, Quantity::kVoltage}) {
    if (Key(quantity) != key) continue;
    const auto matches = FindColumns(header, quantity, kPlainCsv.Of(quantity));
    const auto best = std::min_element(
        matches.begin(), matches.end(), [](const HeaderMatch& a, const HeaderMatch& b) {
          return a.rank < b.rank;
        });
    if (best == matches.end()) break;
    const auto unit = FindUnit(quantity, best->unit);
    const bool own = best->unit.empty() || (unit && unit->IsSi());
    const std::string& name = names[best->field];
    // As it stands there, which is not in small letters.
    const auto at = std::search(
        name.begin(), name.end(), best->unit.begin(), best->unit.end(), [](char a, char b) {
          return std::tolower(static_cast<unsigned char>(a)) == b;
        });
    const auto length = static_cast<std::ptrdiff_t>(at == name.end() ? 0 : best->unit.size());
    return nb::make_tuple(name, own ? std::string() : std::string(at, at + length));
  }
  return nb::none();
}

nb::list DescribeReading(bool of_a_file) {
  Keywords keywords;
  (void)ReadingOf(keywords, EveryRow(), of_a_file);
  return keywords.Described();
}

}  // namespace

Log PythonLog::Lent() const {
  const auto lend = [this](const Column& column) {
    return column.empty() ? Column() : Column::Lent(column, log);
  };
  Log lent;
  lent.report = log->report;
  lent.record.file = log->record.file;
  lent.record.hold = log->record.hold;
  lent.record.time_s = lend(log->record.time_s);
  lent.record.current_A = lend(log->record.current_A);
  lent.record.voltage_V = lend(log->record.voltage_V);
  lent.record.temperature_degC = lend(log->record.temperature_degC);
  return lent;
}

ReadOptions ReadingOf(Keywords& keywords, ReadingRequest request, bool of_a_file) {
  if (of_a_file) {
    keywords.Each(request);
  } else {
    ReadingRequest::VisitOfColumns(request, keywords.EachOne());
  }
  ReadOptions options = request.Resolve();
  keywords.Option(
      "start_s", options.start_s, Range{}, "only rows from this time on; time then starts at 0");
  keywords.Option("end_s", options.end_s, Range{}, "only rows up to this time");
  keywords.Option("lead_resistance_Ohm",
                  options.lead_resistance_Ohm,
                  Range{},
                  "resistance of leads, whose drop is added to the voltage");
  if (!of_a_file) return options;
  if (const auto steps =
          keywords.Take("steps", "int | Sequence[int]", "only rows of these steps of the cycler"))
    options.steps = WholeNumbers("steps", *steps);
  if (const auto cycles =
          keywords.Take("cycles", "int | Sequence[int]", "only rows of these cycles of the cycler"))
    options.cycles = WholeNumbers("cycles", *cycles);
  keywords.Flag("voltage_optional",
                options.voltage_optional,
                "whether a log without a voltage is taken too: a current for a simulation");
  return options;
}

void AddLogs(nb::module_& module) {
  nb::class_<PythonLog>(module, "Log")
      .def_prop_ro("time_s", [](const PythonLog& self) { return ColumnOf(self, &Record::time_s); })
      .def_prop_ro("current_A",
                   [](const PythonLog& self) { return ColumnOf(self, &Record::current_A); })
      .def_prop_ro("voltage_V",
                   [](const PythonLog& self) { return ColumnOf(self, &Record::voltage_V); })
      .def_prop_ro("temperature_degC",
                   [](const PythonLog& self) { return ColumnOf(self, &Record::temperature_degC); })
      .def_prop_ro("file", [](const PythonLog& self) { return ToPython(self.log->record.file); })
      .def_prop_ro(
          "hold",
          [](const PythonLog& self) { return options_internal::ToText(self.log->record.hold); })
      .def_prop_ro("format", [](const PythonLog& self) { return self.log->report.format; })
      .def_prop_ro("sign", [](const PythonLog& self) { return self.log->report.current_sign; })
      .def_prop_ro("sign_reason",
                   [](const PythonLog& self) { return self.log->report.current_sign_reason; })
      .def_prop_ro("rows_of_source",
                   [](const PythonLog& self) {
                     return self.log->report.rows + self.log->report.dropped_rows();
                   })
      // Those that reading kept, of which a thinned log has fewer.
      .def_prop_ro("rows_kept", [](const PythonLog& self) { return self.log->report.rows; })
      // The same log under another name; its columns are not copied.
      .def(
          "named",
          [](const PythonLog& self, const std::string& name) {
            Log log = self.Lent();
            log.record.file = name;
            return AsShared(std::move(log));
          },
          nb::arg("name"))
      .def("reading",
           [](const PythonLog& self) { return ToPython(ReadingToJson(self.log->report)); })
      .def("inspect", &Inspect)
      .def("__len__", [](const PythonLog& self) { return self.log->record.size(); })
      .def("__getstate__", &State)
      .def("__setstate__",
           [](PythonLog& self, const nb::tuple& from) { new (&self) PythonLog(FromState(from)); });
  module.attr("most_rows_kept") = kMostRowsKept;
  module.def("read_log", &Read, nb::arg("file"), nb::arg("options"));
  module.def("read_log_text",
             &ReadText,
             nb::arg("text"),
             nb::arg("file"),
             nb::arg("format"),
             nb::arg("options"));
  module.def("take_log",
             &Take,
             nb::arg("time_s").noconvert(),
             nb::arg("current_A").noconvert(),
             nb::arg("voltage_V").noconvert().none(),
             nb::arg("temperature_degC").noconvert().none(),
             nb::arg("name"),
             nb::arg("options"));
  module.def(
      "check_reading",
      [](const nb::dict& given) { (void)ReadingOf(given, true); },
      nb::arg("options"));
  module.def("likely_column", &LikelyColumn, nb::arg("names"), nb::arg("key"));
  module.def("describe_reading", &DescribeReading, nb::arg("of_a_file"));
}

}  // namespace lipoid::python
