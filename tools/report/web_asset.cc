#include "tools/report/web_asset.h"

#include "tools/report/web_assets.h"  // written by the build

namespace lipoid {

const std::string_view* FindWebAsset(std::string_view name) {
  for (const auto& asset : kWebAssets) {
    if (asset.name == name) return &asset.text;
  }
  return nullptr;
}

}  // namespace lipoid
