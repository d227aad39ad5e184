#pragma once

/// @file
/// What a person may ask of an identification, declared once: the options of `lipoid identify` and the
/// keywords of lipoid.identify(). As identify/stages/staged_request.h for what the methods share.

#include <string>
#include <vector>

#include "identify/identification.h"
#include "identify/stages/staged_request.h"

namespace lipoid {

struct IdentifyRequest {
  IdentifyMethod method = IdentifyOptions{}.method;
  StagedRequest staged = {};
  JointOptions joint = {};
  CellSource reference = {};
  std::vector<std::string> profile = {};

  template <class Self, class Visitor>
  static void Visit(Self& self, Visitor&& v) {
    v("method", self.method, Names(), "all logs at once (joint), or stage by stage (staged)");
    StagedRequest::Visit(self.staged, v);
    v("reference",
      self.reference,
      Word{"CELL"},
      "the same cell at another age: its v_oc(A), time constants and shapes are held, so that a "
      "short test gives its capacity, beta and resistances now");
    v("profile",
      self.profile,
      Word{.text = "NAME,...", .several = true},
      "hold each of these parameters at values around its estimate, refit the others, show the errors");
  }

  template <class Visitor>
  void EachGroup(Visitor&& v) {
    staged.EachGroup(v);
    v("solver", staged.options.solver);
    v("joint", joint);
  }

  /// Reads the files that are named. LoadError where one is not right, OptionError where the options
  /// contradict each other.
  [[nodiscard]] IdentifyOptions Resolve();
};

}  // namespace lipoid
