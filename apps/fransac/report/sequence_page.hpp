// SPDX-License-Identifier: Apache-2.0
/// The page of a sequence.
#pragma once

#include <string>

#include "../machine.hpp"
#include "sequence.hpp"

namespace fransac::cli::report {

/// "60 frames in 2.0 s, 7 planes, median 1.24 ms and p99 2.10 ms a frame"
std::string gist(const SequenceReport& sequence);

/// `index`: the report's first page, beside it.
std::string sequence_page(const SequenceReport& sequence, const FollowRequest& request, const Machine& machine,
                          const std::string& index);

}  // namespace fransac::cli::report
