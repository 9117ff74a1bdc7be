// SPDX-License-Identifier: Apache-2.0
/// A result as files: each writer makes the bytes of one kind out of what is finished.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "../output.hpp"
#include "result.hpp"

namespace fransac::cli {

nlohmann::ordered_json to_json(const SegmentRequest& request, const SegmentResult& result);
/// Points with their labels; `file` says the format. Throws Failure.
std::string encode_points(const std::filesystem::path& file, const SegmentResult& result);

/// All of a frame's outputs or, when one fails, none. Throws Failure.
void write_outputs(const SegmentRequest& request, const Input& input, std::size_t i, const SegmentResult& result);

/// The table of planes that is printed where no output is asked for; with obstacles theirs, too.
class ResultTables {
 public:
  ResultTables(const Input& input, bool obstacles);
  void add(const SegmentResult& result);
  [[nodiscard]] std::string text() const;

 private:
  bool obstacles_;
  Table planes_;
  Table supports_;
  Table obstacle_rows_;
};

/// Says why no plane was found and what to try, and what is in doubt.
void explain(const SegmentRequest& request, const SegmentResult& result);

}  // namespace fransac::cli
