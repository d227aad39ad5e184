#pragma once

/// @file
/// The only list of export targets: help, `lipoid list targets`, messages, docs and tests are made
/// from it. To add one: a function from ExportRequest to Exported, in model/export where its law is
/// the cell's own, in identify/export where its numbers are fitted, and a row in targets.cc.
/// Tests: tests/identify/export/targets_test.cc.

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "model/export/exported.h"

namespace lipoid {

enum class TargetKind {
  kExact,      ///< its law is the cell's own, up to what a number format rounds
  kProjected,  ///< its law is poorer; its numbers were fitted over the mission
  kData,       ///< a table for other programs
};

constexpr std::array<std::pair<TargetKind, std::string_view>, 3> OptionNames(TargetKind) {
  return {{{TargetKind::kExact, "exact"},
           {TargetKind::kProjected, "projected"},
           {TargetKind::kData, "data"}}};
}

struct ExportTarget {
  std::string_view name;
  std::string_view summary;  ///< one line for help and list
  TargetKind kind = TargetKind::kProjected;
  std::string_view extension;  ///< usual for the first file: ".json"
  std::string_view further;    ///< suffixes of files that may stand beside it, by blanks: ".parm"
  std::string_view versions;   ///< of --target-version, the default first: "2 3"; empty: none
  std::string_view options;    ///< which of "branches precision into" it takes, by blanks
  Exported (*make)(const ExportRequest&) = nullptr;

  [[nodiscard]] std::vector<std::string> Versions() const;
  [[nodiscard]] std::vector<std::string> FurtherSuffixes() const;
  [[nodiscard]] bool Takes(std::string_view option) const;
};

/// In the order of their names.
[[nodiscard]] std::span<const ExportTarget> ExportTargets();

/// OptionError with the nearest name where there is none of it.
[[nodiscard]] const ExportTarget& FindExportTarget(std::string_view name);

/// make() of a request whose target_version is one of the target's or empty (then it is the default
/// one); OptionError where it is another. The comments that say whose numbers these are stand in
/// every file.
[[nodiscard]] Exported Export(const ExportTarget& target, ExportRequest request);

/// A name for the target's file, made of the cell's: what is no letter or digit becomes '_'.
[[nodiscard]] std::string IdentifierOf(std::string_view name);

}  // namespace lipoid
