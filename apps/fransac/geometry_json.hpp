// SPDX-License-Identifier: Apache-2.0
/// Points, polygons and boxes in JSON.
#pragma once

#include <nlohmann/json.hpp>
#include <vector>

#include "fransac/planes/outline.hpp"

namespace fransac::cli {

template <class Vector>
nlohmann::ordered_json vector_to_json(const Vector& vector) {
  return std::vector<double>(vector.data(), vector.data() + vector.size());
}

template <class Vector>
nlohmann::ordered_json vectors_to_json(const std::vector<Vector>& vectors) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const Vector& vector : vectors) json.push_back(vector_to_json(vector));
  return json;
}

/// Row by row.
template <class Matrix>
nlohmann::ordered_json matrix_to_json(const Matrix& matrix) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const auto& row : matrix.rowwise()) json.push_back(vector_to_json(row.eval()));
  return json;
}

nlohmann::ordered_json outlines_to_json(const std::vector<Outline>& outlines);

}  // namespace fransac::cli
