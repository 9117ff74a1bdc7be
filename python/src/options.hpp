// SPDX-License-Identifier: Apache-2.0
// The library's options as keyword arguments. Their names, types, defaults and help are those of for_each_option and its
// siblings and stand nowhere else: a new option there is a keyword here.
#pragma once

#include <nanobind/nanobind.h>

#include <Eigen/Core>
#include <cstddef>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "errors.hpp"
#include "fransac/obstacles/obstacles.hpp"
#include "fransac/planes/options.hpp"
#include "fransac/track/tracker.hpp"

namespace fransac::python {

/// "leaf-size" is leaf_size.
std::string python_name(std::string_view name);

/// A message of the library with the names of options as Python has them.
std::string in_python_names(std::string message);

template <class Visitor>
void visit_options(SegmentOptions& options, Visitor&& visit) {
  for_each_option(options, visit);
}
template <class Visitor>
void visit_options(ObstacleOptions& options, Visitor&& visit) {
  visit(OptionInfo{"support", "",
                   "the plane that obstacles are above or below; auto: the floor, else as table; table: the surface that things "
                   "stand on; or a plane's label"},
        options.support);
  for_each_obstacle_option(options, visit);
}
template <class Visitor>
void visit_options(TrackOptions& options, Visitor&& visit) {
  for_each_track_option(options, visit);
}

template <class T>
struct IsOptional : std::false_type {};
template <class T>
struct IsOptional<std::optional<T>> : std::true_type {};

// One value each; a TypeError or ValueError names the argument. Ranges are the library's to check.
void read_value(const char* name, nb::handle given, bool& value);
void read_value(const char* name, nb::handle given, int& value);
void read_value(const char* name, nb::handle given, std::uint64_t& value);
void read_value(const char* name, nb::handle given, double& value);
void read_value(const char* name, nb::handle given, Eigen::Vector3d& value);
void read_value(const char* name, nb::handle given, SupportChoice& value);
/// The place of a word in `words`.
int read_word(const char* name, nb::handle given, const std::string_view* words, std::size_t count);

template <class Enum>
requires std::is_enum_v<Enum>
void read_value(const char* name, nb::handle given, Enum& value) {
  value = static_cast<Enum>(read_word(name, given, EnumNames<Enum>::values, std::size(EnumNames<Enum>::values)));
}

template <class T>
void read_value(const char* name, nb::handle given, std::optional<T>& value) {
  if (given.is_none()) {
    value.reset();
    return;
  }
  if constexpr (std::is_same_v<T, int>) {
    if (std::string_view(name) == "planes" && nb::isinstance<nb::str>(given)) {
      constexpr std::string_view kAll[] = {"all"};
      value = read_word(name, given, kAll, 1);
      return;
    }
  }
  read_value(name, given, value.emplace());
  if constexpr (std::is_same_v<T, int>) {
    if (std::string_view(name) == "planes" && *value == 0) raise_value_error("planes: must be at least 1, or 'all', is 0");
  }
}

/// One keyword argument, for documentation.
struct Keyword {
  std::string name;
  std::string type;          ///< As in a stub.
  std::string default_text;  ///< As in Python.
  std::string help;
};

/// The keyword arguments that set the options of one struct, all or those named.
template <class Options>
class Keywords {
 public:
  explicit Keywords(std::initializer_list<std::string_view> only = {}, std::initializer_list<std::string_view> without = {});

  /// Sets what `kwargs` name; returns how many that were.
  std::size_t read(const nb::dict& kwargs, Options& options) const;
  [[nodiscard]] const std::vector<Keyword>& list() const { return list_; }

 private:
  std::vector<nb::object> names_;  // of every visited option, none where it is no keyword
  std::vector<Keyword> list_;
};
extern template class Keywords<SegmentOptions>;
extern template class Keywords<ObstacleOptions>;
extern template class Keywords<TrackOptions>;

/// "threshold: float = 0.01, …", for a signature.
std::string parameters(const std::vector<Keyword>& keywords);
/// A line for each, for a docstring.
std::string descriptions(const std::vector<Keyword>& keywords);
/// "typing.Literal['a', 'b']"
std::string literal(const std::string_view* words, std::size_t count);

/// TypeError for the first of `kwargs` that is in none of the lists; it names the likeliest meant.
[[noreturn]] void reject_unknown(const char* function, const nb::dict& kwargs,
                                 std::initializer_list<const std::vector<Keyword>*> known,
                                 std::initializer_list<std::string_view> others = {});

}  // namespace fransac::python
