// SPDX-License-Identifier: Apache-2.0
// Results as bytes and back: what pickle and copy keep of them. For the same version on a machine of the same kind.
#pragma once

#include <nanobind/nanobind.h>

#include <Eigen/Core>
#include <array>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "errors.hpp"
#include "fransac/version.hpp"

namespace fransac::python {

/// Appends values to bytes.
class Saver {
 public:
  static constexpr bool kLoads = false;
  void bytes(const void* data, std::size_t size) { bytes_.append(static_cast<const char*>(data), size); }
  [[nodiscard]] std::string_view bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// Reads them in the same order; ValueError where they end too early.
class Loader {
 public:
  static constexpr bool kLoads = true;
  explicit Loader(std::string_view bytes) : rest_(bytes) {}
  void bytes(void* data, std::size_t size) {
    require(size);
    std::memcpy(data, rest_.data(), size);
    rest_.remove_prefix(size);
  }
  void require(std::size_t size) const {
    if (size > rest_.size()) raise_value_error("state: cut short");
  }
  [[nodiscard]] bool at_end() const { return rest_.empty(); }

 private:
  std::string_view rest_;
};

template <class Archive, class T>
requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void archive(Archive& a, T& value) { a.bytes(&value, sizeof value); }

template <class Archive, class Scalar, int kRows, int kColumns, int kOptions>
void archive(Archive& a, Eigen::Matrix<Scalar, kRows, kColumns, kOptions>& matrix) {
  static_assert(kRows > 0 && kColumns > 0);
  a.bytes(matrix.data(), sizeof(Scalar) * kRows * kColumns);
}

template <class Archive, class T, std::size_t kSize>
void archive(Archive& a, std::array<T, kSize>& values) {
  for (T& value : values) archive(a, value);
}

template <class Archive, class T>
void archive(Archive& a, std::optional<T>& value) {
  bool has_value = value.has_value();
  archive(a, has_value);
  if constexpr (Archive::kLoads) {
    value.reset();
    if (has_value) archive(a, value.emplace());
  } else if (has_value) {
    archive(a, *value);
  }
}

template <class Archive, class T>
void archive(Archive& a, std::vector<T>& values) {
  std::size_t size = values.size();
  archive(a, size);
  if constexpr (Archive::kLoads) {
    a.require(size);  // an element takes a byte or more
    values.resize(size);
  }
  if constexpr (std::is_arithmetic_v<T>) {
    if constexpr (Archive::kLoads) a.require(size * sizeof(T));
    a.bytes(values.data(), size * sizeof(T));
  } else {
    for (T& value : values) archive(a, value);
  }
}

template <class Archive>
void archive(Archive& a, std::string& text) {
  std::vector<char> values(text.begin(), text.end());
  archive(a, values);
  text.assign(values.begin(), values.end());
}

/// Calls archive() for each.
template <class Archive, class... Values>
void archive_all(Archive& a, Values&... values) {
  (archive(a, values), ...);
}

/// The state of a value, the version before it.
template <class T>
nb::bytes saved(const T& value) {
  Saver saver;
  std::string version = kVersion;
  T copy = value;
  archive_all(saver, version, copy);
  return nb::bytes(saver.bytes().data(), saver.bytes().size());
}

template <class T>
T loaded(const nb::bytes& state) {
  Loader loader(std::string_view(state.c_str(), state.size()));
  std::string version;
  archive(loader, version);
  if (version != kVersion) raise_value_error("state: of fransac " + version + ", this is " + kVersion);
  T value;
  archive(loader, value);
  if (!loader.at_end()) raise_value_error("state: too long");
  return value;
}

}  // namespace fransac::python
