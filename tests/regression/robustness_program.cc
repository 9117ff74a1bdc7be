// SPDX-License-Identifier: Apache-2.0
// Measures what is left of scores when frames are changed, for scripts/robustness, which makes a table of it:
//   robustness [--only TEXT] [--sensor KIND] [--method METHOD] [--rendered] [DATASET…]
// One line a frame and kind of change, columns separated by tabs; the first line names them. Ends with 2 on wrong usage.
#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "fransac/core/enum_names.hpp"
#include "regression/robustness.hpp"

namespace fransac::testing {
namespace {

struct Arguments {
  std::string only;
  SegmentOptions options;
  bool rendered = false;
  std::vector<std::filesystem::path> datasets;
};

int complain(const std::string& message) {
  std::fprintf(stderr, "robustness: %s\n", message.c_str());
  return 2;
}

/// False where no value of the enum is called that.
template <class Enum>
bool set_by_name(Enum& value, std::string_view name) {
  const auto& names = EnumNames<Enum>::values;
  const auto* const found = std::find(std::begin(names), std::end(names), name);
  if (found == std::end(names)) return false;
  value = static_cast<Enum>(found - std::begin(names));
  return true;
}

/// Nothing where the words are not understood, which standard error then says.
std::optional<Arguments> parse(const std::vector<std::string_view>& words) {
  Arguments arguments;
  arguments.options.method = Method::cells;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::string word(words[i]);
    if (word == "--rendered") {
      arguments.rendered = true;
    } else if (!word.starts_with("--")) {
      arguments.datasets.emplace_back(word);
    } else if (i + 1 == words.size()) {
      complain(word + " needs a value");
      return std::nullopt;
    } else {
      const std::string_view value = words[++i];
      bool known = true;
      if (word == "--only") {
        arguments.only = value;
      } else if (word == "--sensor") {
        known = set_by_name(arguments.options.sensor.kind, value);
      } else {
        known = word == "--method" && set_by_name(arguments.options.method, value);
      }
      if (known) continue;
      complain("what is " + word + ' ' + std::string(value) + '?');
      return std::nullopt;
    }
  }
  return arguments;
}

/// False after an error, which standard error then says.
bool print_comparisons(const Original& original, const Arguments& arguments) {
  const auto comparisons = compare(original, arguments.options,
                                   [&](const Change& change) { return change.kind.find(arguments.only) != std::string::npos; });
  if (!comparisons) {
    complain(comparisons.error().message);
    return false;
  }
  for (const Comparison& c : *comparisons) {
    std::printf("%s\t%s\t%s\t%.2f\t%.2f\t%.4f\t%.4f\t%.4f\t%.4f\t%.4f\t%.4f\n", c.change->kind.c_str(), c.group.c_str(),
                c.frame.c_str(), kBars.of(*c.change), kBars.mean, c.before.f1_50, c.after.f1_50, c.same.f1_50,
                c.before.weighted_iou, c.after.weighted_iou, c.same.weighted_iou);
  }
  return true;
}

int run(const std::vector<std::string_view>& words) {
  const auto arguments = parse(words);
  if (!arguments) return 2;
  std::puts("kind\tgroup\tframe\tbar\tbar_of_mean\tf1_before\tf1_after\tf1_same\twiou_before\twiou_after\twiou_same");
  for (const std::filesystem::path& dataset : arguments->datasets) {
    const auto originals = recorded_frames(dataset);
    if (!originals) return complain(originals.error().message);
    for (const Original& original : *originals) {
      if (!print_comparisons(original, *arguments)) return 1;
    }
  }
  if (!arguments->rendered) return 0;
  for (const Rendering& rendering : renderings()) {
    if (!print_comparisons(rendered_frame(rendering), *arguments)) return 1;
  }
  return 0;
}

}  // namespace
}  // namespace fransac::testing

int main(int count, char** words) { return fransac::testing::run({words + 1, words + count}); }
