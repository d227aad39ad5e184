#include "identify/identify_request.h"

#include <algorithm>
#include <memory>

#include "identify/joint/held_shape.h"
#include "model/battery/cell_file.h"

namespace lipoid {

IdentifyOptions IdentifyRequest::Resolve() {
  staged.Resolve();
  IdentifyOptions options{
      .method = method, .staged = staged.options, .joint = joint, .given = staged.given};
  if (staged.branches) options.joint.branches = *staged.branches;
  for (const std::string& name : profile) {
    const auto& known = options.profiled;
    if (std::find(known.begin(), known.end(), name) == known.end())
      options.profiled.push_back(name);
  }
  if (reference.given()) {
    HeldShape held{.source = reference.name(),
                   .cell = (reference.cell ? *reference.cell : LoadCell(reference.path)).AsOne()};
    options.given.reference = std::make_shared<const HeldShape>(std::move(held));
  }
  CheckIdentifyOptions(options);
  return options;
}

}  // namespace lipoid
