// SPDX-License-Identifier: Apache-2.0
// depth.txt and rgb.txt: any text is a list in order of time whose files stay in the folder, or an error that names a line.
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "io/tum_list.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace fransac::io;
  const auto list = parse_tum_list({reinterpret_cast<const char*>(data), size}, "depth.txt");
  if (!list) {
    if (!list.error().message.starts_with("depth.txt:")) __builtin_trap();
    return 0;
  }
  const auto earlier = [](const TumEntry& a, const TumEntry& b) { return a.time_s < b.time_s; };
  if (!std::is_sorted(list->begin(), list->end(), earlier)) __builtin_trap();
  for (const TumEntry& entry : *list) {
    const std::string path = "/" + entry.file + "/";
    if (!std::isfinite(entry.time_s) || entry.file.starts_with('/') || path.find("/../") != std::string::npos) __builtin_trap();
    const TumEntry* const nearest = nearest_entry(*list, entry.time_s);
    if (nearest == nullptr || nearest->time_s != entry.time_s) __builtin_trap();
  }
  return 0;
}
