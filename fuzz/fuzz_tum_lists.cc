// SPDX-License-Identifier: Apache-2.0
// depth.txt, rgb.txt and associations.txt: any text is a list in order of time whose files stay in the folder, or an error that
// names a line.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "io/tum_list.h"
#include "require.hpp"

namespace {

using namespace fransac;
using namespace fransac::io;

using fuzz::require;

void check(const std::vector<TumEntry>& list) {
  const auto earlier = [](const TumEntry& a, const TumEntry& b) { return a.time_s < b.time_s; };
  require(std::is_sorted(list.begin(), list.end(), earlier));
  for (const TumEntry& entry : list) {
    const std::string path = "/" + entry.file + "/";
    require(std::isfinite(entry.time_s) && !entry.file.starts_with('/') && path.find("/../") == std::string::npos);
    const TumEntry* const nearest = nearest_entry(list, entry.time_s);
    require(nearest != nullptr && nearest->time_s == entry.time_s);
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  const auto list = parse_tum_list(text, "list");
  list ? check(*list) : require(list.error().message.starts_with("list:"));
  const auto pairs = parse_tum_associations(text, "list");
  if (!pairs) {
    require(pairs.error().message.starts_with("list:"));
    return 0;
  }
  std::vector<TumEntry> depth;
  for (const TumPair& pair : *pairs) depth.push_back(pair.depth);
  check(depth);
  return 0;
}
