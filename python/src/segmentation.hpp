// SPDX-License-Identifier: Apache-2.0
// What segment() returns to Python.
#pragma once

#include <nanobind/nanobind.h>

#include <memory>
#include <optional>
#include <string>

#include "arrays.hpp"
#include "fransac/core/camera.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/segment.hpp"

namespace fransac::python {

/// A segmentation and the memory it is in.
struct Found {
  fransac::Segmentation planes;
  Obstacles obstacles;
  bool obstacles_asked = false;
  std::optional<Camera> camera;  ///< Of a depth image.
  Shape shape;                   ///< Of the labels.
  std::string note;              ///< Why there is no plane; empty where there are.
};

/// Owns a result; its memory goes to a later result when Python lets go of it and of its arrays.
class PySegmentation {
 public:
  PySegmentation();
  ~PySegmentation();
  PySegmentation(PySegmentation&&) noexcept = default;
  PySegmentation& operator=(PySegmentation&&) noexcept = default;

  [[nodiscard]] Found& found() { return *found_; }
  [[nodiscard]] const Found& found() const { return *found_; }

 private:
  std::unique_ptr<Found> found_;
};

}  // namespace fransac::python
