#include "tools/commands/poles_json.h"

#include <nlohmann/json.hpp>

namespace lipoid {
namespace {

Json ToJson(const Poles& poles) {
  Json list = Json::array();
  for (const auto& pole : poles) list.push_back({pole.real(), pole.imag()});
  return list;
}

}  // namespace

Json PolesRowToJson(const PolesRow& row) {
  return {{"xi", row.xi},
          {"kappa", row.kappa},
          {"poles", ToJson(row.closed_form)},
          {"poles_quasistatic", ToJson(row.quasistatic)},
          {"poles_full", ToJson(row.full)}};
}

}  // namespace lipoid
