#include "identify/studies/studies.h"

#include <string>
#include <vector>

#include "model/core/errors.h"
#include "model/core/nearest_name.h"

namespace lipoid {

const Study& FindStudy(std::string_view name) {
  std::vector<std::string> known;
  for (const Study& study : kStudies) {
    if (study.name == name) return study;
    known.emplace_back(study.name);
  }
  throw OptionError(UnknownName("study", name, known));
}

}  // namespace lipoid
