#include "python/src/cell.h"

#include <fmt/format.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/string_view.h>
#include <nanobind/stl/vector.h>
#include <tbb/parallel_for.h>

#include <nlohmann/json.hpp>
#include <utility>

#include "identify/logs/beyond_curve.h"
#include "identify/logs/cutoff_crossing.h"
#include "identify/logs/discharge.h"
#include "identify/logs/plausibility.h"
#include "identify/pack_request.h"
#include "identify/surroundings_request.h"
#include "model/battery/cell_ensemble.h"
#include "model/battery/cell_file.h"
#include "model/battery/fit_record.h"
#include "model/battery/prediction.h"
#include "model/battery/prediction_band.h"
#include "model/battery/typical_temperature.h"
#include "model/core/errors.h"
#include "model/core/json_text.h"
#include "model/core/run_record.h"
#include "model/core/special_values.h"
#include "model/core/stop.h"
#include "model/statistics/interval_95.h"
#include "python/src/convert.h"
#include "python/src/keywords.h"
#include "python/src/work.h"

namespace lipoid::python {
namespace {

using Table = nb::ndarray<const double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;
using Output = nb::ndarray<double, nb::ndim<2>, nb::c_contig, nb::device::cpu>;

// Where a prediction starts, among what, and between which rows a current holds.
struct PredictionKeywords {
  StartRequest start;
  SurroundingsRequest surroundings;
  Hold hold = Hold::kBackward;
  bool beyond_cutoff = false;

  explicit PredictionKeywords(const nb::dict& given) {
    Keywords keywords(given);
    keywords.Each(start);
    SurroundingsRequest::VisitOfAmbient(surroundings, keywords.EachOne());
    keywords.Option("hold", hold, Names{}, "");
    keywords.Flag("beyond_cutoff", beyond_cutoff, "");
    keywords.Finish();
  }
};

// Finds the rows of a prediction before the one in which the cell is below its cut-off, and when its
// voltage fell to it.
class UpToCutoff {
 public:
  UpToCutoff(const Cell& cell, std::size_t rows, bool beyond_cutoff)
      : cell_(cell),
        crossing_(cell.series * cell.cutoff_V),
        rows_(rows),
        before_(rows),
        beyond_cutoff_(beyond_cutoff) {}

  // Whether the next row is one of them.
  bool Takes(std::size_t row, double time_s, double current_A, double voltage_V) {
    constexpr std::size_t kLook = 4096;  // rows that take less than a millisecond
    if (row % kLook == 0) StopIfAsked();
    if (row > before_) return false;
    crossing_.Row(time_s, current_A, voltage_V);
    if (beyond_cutoff_ || !IsBelowCutoff(cell_, current_A, voltage_V, row, rows_)) return true;
    before_ = row;
    return false;
  }

  [[nodiscard]] std::size_t before() const { return before_; }
  // NaN where no row is below it.
  [[nodiscard]] double cutoff_s() const { return before_ < rows_ ? crossing_.time_s() : kNaN; }

 private:
  const Cell& cell_;
  CutoffCrossing crossing_;
  std::size_t rows_;
  std::size_t before_;
  bool beyond_cutoff_;
};

// What a prediction says that no cell does; one sentence each, or none.
std::vector<std::string> DoubtsAbout(const PredictedSoc& reached) {
  std::vector<std::string> doubts{reached.DoubtAboutCurve()};
  if (reached.is_overfull()) {
    doubts.push_back(fmt::format(
        "the current charges the cell to a soc of {:.3g}, which no cell holds: is it the other way round "
        "(discharge is positive), or does the cell begin emptier (initial_soc)?",
        reached.overfull()));
  }
  return doubts;
}

// Currents in rows, times and measured temperatures once or in rows; the arrays that are filled are
// Python's own, that of temperatures only for a cell that knows it, that of the open-circuit voltage
// only where it is more than v_oc(A). What they hold from the row on in which the cell is below its
// cut-off stays. Returns the rows outside of v_oc(A), of each current the rows before that, when its voltage fell
// to the cut-off, and what is to be said.
nb::tuple Simulate(const PythonCell& self,
                   const Table& time_s,
                   const Table& current_A,
                   const Output& voltage_V,
                   const Output& soc,
                   const std::optional<Output>& open_circuit_V,
                   const std::optional<Output>& temperature_degC,
                   const std::optional<Table>& measured_degC,
                   const nb::dict& given,
                   int threads) {
  const PredictionKeywords asked(given);
  const std::size_t count = current_A.shape(0);
  const std::size_t rows = current_A.shape(1);
  const std::size_t times = time_s.shape(0);
  Require(time_s.shape(1) == rows && (times == 1 || times == count), "as many times as currents");
  const std::size_t measured = measured_degC ? measured_degC->shape(0) : 0;
  Require(
      !measured_degC || (measured_degC->shape(1) == rows && (measured == 1 || measured == count)),
      "as many temperatures as currents");
  const Cell& cell = self.cell;
  std::vector<PredictedSoc> reached(count);
  std::vector<std::size_t> before(count, rows);
  std::vector<double> cutoff_s(count, kNaN);
  const auto one = [&](std::size_t k) {
    StopIfAsked();
    Surroundings among{.ambient_degC = asked.surroundings.ambient_degC,
                       .initial_degC = asked.surroundings.initial_degC};
    if (measured_degC)
      among.measured_degC = {measured_degC->data() + (measured == 1 ? 0 : k * rows), rows};
    const double initial_soc = asked.start.Soc(cell, among);
    double* const warm = temperature_degC ? temperature_degC->data() + k * rows : nullptr;
    double* const rest = open_circuit_V ? open_circuit_V->data() + k * rows : nullptr;
    double* const v = voltage_V.data() + k * rows;
    double* const a = soc.data() + k * rows;
    const std::span<const double> t(time_s.data() + (times == 1 ? 0 : k * rows), rows);
    const std::span<const double> i(current_A.data() + k * rows, rows);
    UpToCutoff up_to(cell, rows, asked.beyond_cutoff);
    const auto keep = [&](std::size_t row, const PredictedRow& of) {
      if (!up_to.Takes(row, t[row], i[row], of.voltage_V)) return;
      v[row] = of.voltage_V;
      if (rest != nullptr) rest[row] = cell.series * of.stepper.OpenCircuit();
      if (warm != nullptr) warm[row] = of.stepper.state().temperature_K - kZeroCelsius_K;
      a[row] = of.soc;
      reached[k].Row(cell.open_circuit_voltage, of.soc);
    };
    PredictRows(cell, t, i, asked.hold, initial_soc, among, keep);
    before[k] = up_to.before();
    cutoff_s[k] = up_to.cutoff_s();
  };
  constexpr std::size_t kShort = 1'000'000;  // rows that take less than a thread to start
  if (count == 1 && rows < kShort) {
    const WithoutLock unlocked;
    one(0);
  } else {
    Work([&](const Tell&) { tbb::parallel_for(std::size_t{0}, count, one); }, nb::none(), threads);
  }
  PredictedSoc all;
  for (const PredictedSoc& each : reached) all.Append(each);
  return nb::make_tuple(all.outside(), std::move(before), std::move(cutoff_s), DoubtsAbout(all));
}

// And what is to be said of the states of charge.
nb::tuple OpenCircuitVoltage(const PythonCell& self, const Input& soc) {
  std::vector<double> voltage_V;
  voltage_V.reserve(soc.shape(0));
  PredictedSoc asked;
  for (const double a : SpanOf(soc)) {
    asked.Row(self.cell.open_circuit_voltage, a);
    voltage_V.push_back(self.cell.series * self.cell.open_circuit_voltage(a));
  }
  return nb::make_tuple(ToArray(std::move(voltage_V)), asked.DoubtAboutCurve());
}

const Cell& WithUncertainty(const PythonCell& self) {
  if (self.cell.uncertainty) return self.cell;
  throw OptionError(fmt::format(
      "cell '{}' has no uncertainty to draw from: identify it with this version of lipoid",
      self.cell.name));
}

// What is to be said of what was drawn; empty: nothing.
std::string DoubtOf(const CellEnsemble& ensemble) {
  return DoubtAboutMoved(static_cast<std::size_t>(ensemble.moved), ensemble.cells.size());
}

nb::tuple Resample(const PythonCell& self, int count, std::uint64_t seed) {
  CellEnsemble ensemble;
  const Cell& cell = WithUncertainty(self);
  Work([&](const Tell&) { ensemble = DrawCells(cell, count, seed); });
  nb::list cells;
  for (Cell& one : ensemble.cells) cells.append(nb::cast(PythonCell{std::move(one)}));
  return nb::make_tuple(std::move(cells), DoubtOf(ensemble));
}

// NaN from the row on in which the cell itself is below its cut-off.
nb::tuple Band(const PythonCell& self,
               const Input& time_s,
               const Input& current_A,
               const std::optional<Input>& measured_degC,
               const nb::dict& given,
               int count,
               std::uint64_t seed) {
  const Cell& cell = WithUncertainty(self);
  const PredictionKeywords asked(given);
  Surroundings among{.ambient_degC = asked.surroundings.ambient_degC,
                     .initial_degC = asked.surroundings.initial_degC};
  if (measured_degC) among.measured_degC = SpanOf(*measured_degC);
  const double initial_soc = asked.start.Soc(cell, among);
  const auto t = SpanOf(time_s);
  const auto i = SpanOf(current_A);
  UpToCutoff up_to(cell, t.size(), asked.beyond_cutoff);
  PredictedSoc reached;
  PredictionBand band;
  CellEnsemble ensemble;
  Work([&](const Tell&) {
    PredictRows(
        cell, t, i, asked.hold, initial_soc, among, [&](std::size_t row, const PredictedRow& of) {
          if (up_to.Takes(row, t[row], i[row], of.voltage_V))
            reached.Row(cell.open_circuit_voltage, of.soc);
        });
    ensemble = DrawCells(cell, count, seed);
    std::vector<double> starts;
    for (const Cell& one : ensemble.cells) starts.push_back(asked.start.SocOfDrawn(one, among));
    const std::size_t rows = up_to.before();
    band = PredictBand(ensemble.cells, starts, t.first(rows), i.first(rows), asked.hold, among);
  });
  for (auto* voltage_V : {&band.voltage_low_V, &band.voltage_high_V})
    voltage_V->resize(t.size(), kNaN);
  return nb::make_tuple(ToArray(std::move(band.voltage_low_V)),
                        ToArray(std::move(band.voltage_high_V)),
                        up_to.before(),
                        up_to.cutoff_s(),
                        DoubtsAbout(reached),
                        DoubtAboutFew(ensemble.cells.size(), "cells"),
                        DoubtOf(ensemble));
}

// Of temperatures in rows, at times that stand once or in rows.
std::string ImpossibleIn(const Table& time_s, const Table& temperature_degC) {
  const std::size_t rows = temperature_degC.shape(1);
  Require(time_s.shape(1) == rows, "as many times as temperatures");
  for (std::size_t k = 0; k < temperature_degC.shape(0); ++k) {
    const double* const t = time_s.data() + (k < time_s.shape(0) ? k * rows : 0);
    std::string impossible =
        ImpossibleTemperature({t, rows}, {temperature_degC.data() + k * rows, rows});
    if (!impossible.empty()) return impossible;
  }
  return "";
}

std::string TextOfCell(const PythonCell& self) { return JsonText(CellToJson(self.cell)); }

PythonCell WithPack(const PythonCell& self, const nb::dict& given) {
  PackRequest request;
  Keywords keywords(given);
  keywords.Each(request);
  keywords.Finish();
  PythonCell pack = self;
  request.ApplyTo(pack.cell);
  return pack;
}

}  // namespace

const Cell* CellBehind(nb::handle argument) {
  const nb::object wrapped = nb::getattr(argument, "_core", nb::none());
  for (const nb::handle one : {argument, nb::handle(wrapped)}) {
    if (nb::isinstance<PythonCell>(one)) return &nb::cast<const PythonCell*>(one)->cell;
  }
  return nullptr;
}

void AddCells(nb::module_& module) {
  nb::class_<PythonCell>(module, "Cell")
      .def_prop_ro("name", [](const PythonCell& self) { return self.cell.name; })
      .def_prop_ro("series", [](const PythonCell& self) { return self.cell.series; })
      .def_prop_ro("parallel", [](const PythonCell& self) { return self.cell.parallel; })
      .def_prop_ro("capacity_Ah", [](const PythonCell& self) { return self.cell.capacity_Ah; })
      .def_prop_ro("cutoff_V", [](const PythonCell& self) { return self.cell.cutoff_V; })
      .def_prop_ro("alpha_C", [](const PythonCell& self) { return self.cell.alpha_C(); })
      .def_prop_ro("knows_temperature",
                   [](const PythonCell& self) { return self.cell.temperature.has_value(); })
      // Whether temperature or history move the voltage at rest away from v_oc(A).
      .def_prop_ro("rests_beside_curve",
                   [](const PythonCell& self) {
                     return self.cell.temperature.has_value() || self.cell.hysteresis.has_value();
                   })
      .def("with_typical_temperature",
           [](const PythonCell& self) { return PythonCell{WithTypicalTemperature(self.cell)}; })
      .def_prop_ro("has_uncertainty",
                   [](const PythonCell& self) { return self.cell.uncertainty.has_value(); })
      .def("to_dict", [](const PythonCell& self) { return ToPython(CellToJson(self.cell)); })
      .def("to_json", &TextOfCell)
      .def(
          "save",
          [](const PythonCell& self, nb::handle file) { WriteCellFile(self.cell, PathOf(file)); },
          nb::arg("file"))
      .def("pack", &WithPack, nb::arg("options"))
      .def("open_circuit_voltage", &OpenCircuitVoltage, nb::arg("soc"))
      .def("simulate",
           &Simulate,
           nb::arg("time_s").noconvert(),
           nb::arg("current_A").noconvert(),
           nb::arg("voltage_V").noconvert(),
           nb::arg("soc").noconvert(),
           nb::arg("open_circuit_V").noconvert().none(),
           nb::arg("temperature_degC").noconvert().none(),
           nb::arg("measured_degC").noconvert().none(),
           nb::arg("options"),
           nb::arg("threads"))
      .def("band",
           &Band,
           nb::arg("time_s").noconvert(),
           nb::arg("current_A").noconvert(),
           nb::arg("measured_degC").noconvert().none(),
           nb::arg("options"),
           nb::arg("count"),
           nb::arg("seed"))
      .def("resample", &Resample, nb::arg("count"), nb::arg("seed"))
      .def("__getstate__", &TextOfCell)
      .def("__setstate__", [](PythonCell& self, const std::string& text) {
        new (&self) PythonCell{ParseCell(text, "cell")};
      });
  module.def(
      "load_cell",
      [](nb::handle name_or_file) {
        const std::string name = PathOf(name_or_file);
        const std::string text = CellText(name);
        return PythonCell{ParseCell(text, name), Sha256OfBytes(text)};
      },
      nb::arg("name_or_file"));
  module.def(
      "parse_cell",
      [](const std::string& text, const std::string& file) {
        return PythonCell{ParseCell(text, file)};
      },
      nb::arg("text"),
      nb::arg("file"));
  module.def(
      "doubt_about_temperature",
      [](const PythonCell& cell, double coldest_degC, double warmest_degC) {
        return DoubtAboutTemperature(cell.cell, coldest_degC, warmest_degC);
      },
      nb::arg("cell"),
      nb::arg("coldest_degC"),
      nb::arg("warmest_degC"));
  module.def("impossible_temperature",
             &ImpossibleIn,
             nb::arg("time_s").noconvert(),
             nb::arg("temperature_degC").noconvert());
  module.def(
      "doubt_about_fit",
      [](const PythonCell& cell) { return DoubtAboutFit(cell.cell); },
      nb::arg("cell"));
  module.def(
      "typical_temperature_text",
      [](const PythonCell& cell, double size_factor) {
        return TypicalTemperatureText(cell.cell, size_factor);
      },
      nb::arg("cell"),
      nb::arg("size_factor"));
  module.def("cell_names", &ShippedCellNames);
}

}  // namespace lipoid::python
