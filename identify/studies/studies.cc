#include "identify/studies/studies.h"

#include "model/core/nearest_name.h"

namespace lipoid {

const Study& FindStudy(std::string_view name) { return FindNamed("study", name, kStudies); }

}  // namespace lipoid
