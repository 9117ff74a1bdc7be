// SPDX-License-Identifier: Apache-2.0
/// What `fransac segment` cannot do is refused before any work is done.
#pragma once

#include "request.hpp"

namespace fransac::cli {

/// What cannot be asked for of any input. Throws UsageError.
void check_request(const SegmentRequest& request);

/// What cannot be asked for of this input; outputs that could not be written, that would replace an input, or each other. Throws
/// Failure or UsageError.
void check_outputs(SegmentRequest& request, const Input& input);

/// What cannot be asked for of this content: images of labels need rows and columns; outlines and maps need a camera. Throws
/// UsageError.
void check_content(const SegmentRequest& request, const Content& content);

}  // namespace fransac::cli
