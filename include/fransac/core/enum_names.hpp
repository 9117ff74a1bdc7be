// SPDX-License-Identifier: Apache-2.0
/// The names of enums' values, each at one place: beside the enum, or beside the options that hold it.
#pragma once

#include <string_view>

namespace fransac {

/// The names of an enum's values, in order of the values: `values[] = {"auto", "fransac", …}`. Specialised for every enum that a
/// user can choose from or is shown.
template <class Enum>
struct EnumNames;

/// The name of a value, as the command line and JSON have it.
template <class Enum>
constexpr std::string_view enum_name(Enum value) {
  return EnumNames<Enum>::values[static_cast<int>(value)];
}

}  // namespace fransac
