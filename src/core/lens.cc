// SPDX-License-Identifier: Apache-2.0
#include "fransac/core/lens.hpp"

namespace fransac {

std::string_view to_string(LensModel model) {
  switch (model) {
    case LensModel::plumb_bob: return "plumb_bob";
    case LensModel::rational_polynomial: return "rational_polynomial";
    case LensModel::equidistant: return "equidistant";
  }
  return "unknown";
}

}  // namespace fransac
